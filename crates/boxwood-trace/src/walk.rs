//! The walk of a ray as data.

use crate::number::finite;

use boxwood::{Counts, Hit, Ray, query};
use serde::{Deserialize, Serialize};

/// How a ray found its answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WalkTrace {
    /// [`VERSION`](crate::VERSION).
    pub boxwood_trace: u32,
    /// `walk`.
    pub kind: String,
    /// The structure and what was chosen: `bvh2 (binned, aabb)`.
    pub structure: String,
    /// Primitives in the scene, those that can never be hit included.
    pub primitives: usize,
    /// What was asked.
    pub ray: RayTrace,
    /// What was done, in order.
    pub steps: Vec<WalkStep>,
    /// The answer.
    pub hit: Option<HitTrace>,
    /// The steps added up.
    pub counts: CountsTrace,
}

/// A ray.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RayTrace {
    /// Where `t` is 0.
    pub origin: [Option<f32>; 3],
    /// Not normalised: `t` counts in its length.
    pub dir: [Option<f32>; 3],
    /// Begin of the range.
    pub t_min: Option<f32>,
    /// End of the range; `None` without end.
    pub t_max: Option<f32>,
    /// False for what is no ray, and hits nothing: no direction, or numbers out of range.
    pub is_valid: bool,
}

/// The closest hit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HitTrace {
    /// Where on the ray.
    pub t: f32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
    /// Primitive, counted in its mesh.
    pub prim: u32,
    /// Mesh.
    pub geom: u32,
    /// Path to the instance; `None` in a scene of primitives.
    pub inst: Option<u32>,
}

/// What the steps cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CountsTrace {
    /// Nodes and cells entered.
    pub nodes: u64,
    /// Tests of bounding volumes.
    pub box_tests: u64,
    /// Tests of primitives.
    pub primitive_tests: u64,
    /// Instances entered.
    pub instances: u64,
    /// Floating-point operations.
    pub flops: u64,
    /// Bytes read.
    pub bytes: u64,
}

/// One step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WalkStep {
    /// How deep in the tree; the root is at 0, what stands in a leaf one deeper than the leaf.
    pub depth: u32,
    /// What happened.
    #[serde(flatten)]
    pub event: Event,
    /// The closest hit after the step, in `t`; `None` as long as there is none.
    pub best_t: Option<f32>,
    /// Nodes that were entered and still had to wait for their turn before the step, the next one last. (Nested objects
    /// have no stack but calls: those that are open, the innermost last.)
    pub stack_before: Vec<u32>,
    /// The same after the step.
    pub stack_after: Vec<u32>,
}

/// What happens in a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "step", rename_all = "lowercase")]
pub enum Event {
    /// A bounding volume was tested, or dropped without a test.
    Box(BoxTrace),
    /// A cell of a grid was entered.
    Cell(CellTrace),
    /// A primitive was tested.
    Primitive(PrimitiveTrace),
    /// An instance was come to, or left. The steps between are inside it, with numbers of their own.
    Instance(InstanceTrace),
}

/// A bounding volume against the ray.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoxTrace {
    /// Number of the node.
    pub node: u32,
    /// The node that it stands in; `None` for the root, and for the box around a grid.
    pub parent: Option<u32>,
    /// Primitives of a leaf; `None` for an inner node.
    pub leaf_of: Option<u32>,
    /// Where the ray enters the volume, in `t`.
    pub near: Option<f32>,
    /// Where it leaves; before `near` for a miss.
    pub far: Option<f32>,
    /// What follows.
    pub verdict: BoxVerdict,
    /// Operations spent.
    pub flops: u32,
    /// Bytes read.
    pub bytes: u32,
}

/// Why a node is looked into or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BoxVerdict {
    /// The ray meets it: it waits for its turn.
    Enter,
    /// The line misses it, or meets it only outside the ray's range.
    Miss,
    /// It begins behind the closest hit so far.
    Farther,
    /// It was entered, but by its turn a closer hit was known.
    Dropped,
}

/// A cell of a grid on the ray's way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellTrace {
    /// Column, row, layer.
    pub cell: [u32; 3],
    /// Where the ray enters, in `t`.
    pub enter: Option<f64>,
    /// `t` of the next face of each axis (tMax on the slides); `None` where there is none.
    pub t_next: [Option<f64>; 3],
    /// `t` between two faces of each axis (tDelta on the slides), the same in every cell.
    pub t_delta: [Option<f64>; 3],
    /// References in the cell.
    pub prims: u32,
    /// Operations of the step.
    pub flops: u32,
    /// Bytes read.
    pub bytes: u32,
}

/// A primitive against the ray.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PrimitiveTrace {
    /// Number, counted through all meshes.
    pub prim: u32,
    /// The leaf that it stands in; `None` in a list or a cell.
    pub leaf: Option<u32>,
    /// The edge functions opposite to each corner of a triangle; `None` inside instances and for other shapes.
    pub edges: Option<[f64; 3]>,
    /// Their signs, ties settled: all equal for a hit.
    pub signs: Option<[i8; 3]>,
    /// Where the line hits, also outside the ray's range; `None` for a miss.
    pub t: Option<f32>,
    /// Weight of the second corner there.
    pub u: Option<f32>,
    /// Weight of the third corner there.
    pub v: Option<f32>,
    /// What follows.
    pub verdict: PrimitiveVerdict,
    /// Operations spent.
    pub flops: u32,
    /// Bytes read.
    pub bytes: u32,
}

/// What a test means for the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PrimitiveVerdict {
    /// The new best.
    Closest,
    /// Hit, but behind the best.
    Farther,
    /// The line hits it outside the ray's range.
    #[serde(rename = "out of range")]
    OutOfRange,
    /// Not hit.
    Miss,
}

/// An instance on the ray's way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InstanceTrace {
    /// Number in the scene that it stands in.
    pub instance: u32,
    /// What follows.
    pub verdict: InstanceVerdict,
    /// Operations spent on turning the ray.
    pub flops: u32,
    /// Bytes read.
    pub bytes: u32,
}

/// What becomes of the ray at an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InstanceVerdict {
    /// It goes on inside, turned into the instance's own space.
    Enter,
    /// The two have no bit of their masks in common.
    Masked,
    /// In the instance's space it would not be a ray.
    Miss,
    /// It comes out again.
    Leave,
}

impl RayTrace {
    pub(crate) fn of(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.map(finite),
            dir: ray.dir.map(finite),
            t_min: finite(ray.t_min),
            t_max: finite(ray.t_max),
            is_valid: ray.is_valid(),
        }
    }
}

impl HitTrace {
    pub(crate) fn of(hit: &Hit) -> Self {
        let Hit {
            t,
            u,
            v,
            prim,
            geom,
            inst,
        } = *hit;
        Self {
            t,
            u,
            v,
            prim,
            geom,
            inst: (inst != Hit::NO_INSTANCE).then_some(inst),
        }
    }
}

impl CountsTrace {
    pub(crate) fn of(counts: &Counts) -> Self {
        let Counts {
            nodes,
            boxes,
            prims,
            instances,
            flops,
            bytes,
            ..
        } = *counts;
        Self {
            nodes,
            box_tests: boxes,
            primitive_tests: prims,
            instances,
            flops,
            bytes,
        }
    }
}

impl From<query::VolumeVerdict> for BoxVerdict {
    fn from(verdict: query::VolumeVerdict) -> Self {
        match verdict {
            query::VolumeVerdict::Enter => Self::Enter,
            query::VolumeVerdict::Miss => Self::Miss,
            query::VolumeVerdict::Farther => Self::Farther,
            query::VolumeVerdict::Dropped => Self::Dropped,
        }
    }
}

impl From<query::InstanceVerdict> for InstanceVerdict {
    fn from(verdict: query::InstanceVerdict) -> Self {
        match verdict {
            query::InstanceVerdict::Enter => Self::Enter,
            query::InstanceVerdict::Masked => Self::Masked,
            query::InstanceVerdict::Miss => Self::Miss,
            query::InstanceVerdict::Leave => Self::Leave,
        }
    }
}
