//! The build of a structure as data.

use crate::number::finite;
use boxwood::build::{
    BuildStep, BuildWalk, Choice, CurvePlace, GridTry, MergeStep, NodeMove, Plane, SetStep,
    Topology, Why,
};
use boxwood::query::Query;
use boxwood::{Aabb, BuildError, Scene, Structure};
use serde::{Deserialize, Serialize};

/// How a structure came to be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BuildTrace {
    /// [`VERSION`](crate::VERSION).
    pub boxwood_trace: u32,
    /// `build`.
    pub kind: String,
    /// The structure and what was chosen: `bvh2 (binned, aabb)`.
    pub structure: String,
    /// Who built the tree; `None` without a tree.
    pub builder: Option<String>,
    /// Primitives in the scene.
    pub primitives: usize,
    /// Those of them that can never be hit, and are left out.
    pub skipped: usize,
    /// The box around all others; `None` if there are none.
    pub bounds: Option<Bounds>,
    /// What was done, in order, as far as it is told.
    pub steps: Vec<StepTrace>,
    /// How many steps there are.
    pub steps_total: usize,
    /// Slot to primitive as splits and merges left it; empty unless all steps are told.
    pub order: Vec<u32>,
    /// Primitives along the curve of `morton`; empty for other builders.
    pub curve: Vec<CurveTrace>,
    /// The binary tree in the end; `None` unless all steps are told, and without a tree.
    pub tree: Option<TreeTrace>,
    /// The nodes of the structure with the numbers that walks have, parents first, as far as they are told; of a grid the
    /// cells that are not empty.
    pub nodes: Vec<NodeTrace>,
    /// How many nodes there are.
    pub nodes_total: usize,
    /// The structure in numbers.
    pub stats: StatsTrace,
}

/// A box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Smallest corner.
    pub min: [f32; 3],
    /// Largest corner.
    pub max: [f32; 3],
}

/// One step of a build.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "step", rename_all = "lowercase")]
pub enum StepTrace {
    /// A set of primitives was split in two.
    Split(SplitTrace),
    /// A set of primitives became a leaf.
    Leaf(LeafTrace),
    /// Two clusters became one.
    Merge(MergeTrace),
    /// A node was moved.
    Move(MoveTrace),
    /// A grid was tried.
    Grid(GridTrace),
}

/// A set of primitives, and what was weighed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetTrace {
    /// Its number, as in `tree` if no node is moved later.
    pub node: u32,
    /// The set that it was split from; `None` for the root.
    pub parent: Option<u32>,
    /// 0 for the root.
    pub depth: u32,
    /// Its first place in `order`.
    pub first: u32,
    /// How many primitives.
    pub count: u32,
    /// The box around it.
    pub bounds: Bounds,
    /// The box around the centres of its primitives' boxes.
    pub centers: Bounds,
    /// Where it might be split, axis by axis.
    pub planes: Vec<PlaneTrace>,
    /// How many planes were weighed; more than are told for large sets of `sweep`.
    pub weighed: u32,
    /// Cost as a leaf, where a node costs 1 (`wide`: a wide node); `None` if the builder weighs no costs.
    pub leaf_cost: Option<f32>,
    /// Why it became what it did.
    pub why: WhyTrace,
}

/// A set that was split.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SplitTrace {
    /// The set.
    #[serde(flatten)]
    pub set: SetTrace,
    /// Where it was split.
    pub plane: PlaneTrace,
    /// The nodes of both sides, left and right.
    pub children: [u32; 2],
}

/// A set that became a leaf.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeafTrace {
    /// The set.
    #[serde(flatten)]
    pub set: SetTrace,
    /// Its primitives.
    pub prims: Vec<u32>,
}

/// A plane that parts a set by the centres of boxes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaneTrace {
    /// Across which axis.
    pub axis: Axis,
    /// Its coordinate.
    pub at: f32,
    /// Primitives on the left.
    pub left: u32,
    /// Primitives on the right.
    pub right: u32,
    /// Cost of the split, in the unit of `leaf_cost`.
    pub cost: Option<f32>,
}

/// An axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// 0.
    X,
    /// 1.
    Y,
    /// 2.
    Z,
}

/// Why a set is split or is a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WhyTrace {
    /// Leaf: so few that the builder does not look further.
    Few,
    /// Leaf: few enough, and the best split costs no less.
    Cheaper,
    /// Split: the builder's own rule.
    Rule,
    /// The rule does not tell the primitives apart: a leaf if they are few enough, else halved.
    Alike,
    /// So deep that sets are only halved from here on.
    Deep,
}

/// A place on the curve of `morton`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CurveTrace {
    /// The primitive.
    pub prim: u32,
    /// 11 bits for each axis in turn, x first: the cell of its centre in a grid of 2048 along each axis.
    pub code: u64,
}

/// Two neighbours on the curve become one cluster.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MergeTrace {
    /// Merges of one round know nothing of each other.
    pub round: u32,
    /// Number of the cluster; those below the number of places on the curve are single primitives.
    pub cluster: u32,
    /// What it is made of.
    pub parts: [u32; 2],
    /// The box around both.
    pub bounds: Bounds,
    /// Primitives in it.
    pub count: u32,
    /// True if it had better be one leaf.
    pub is_leaf: bool,
    /// Its number in `tree`; `None` inside of a leaf.
    pub node: Option<u32>,
}

/// A node is put beside another one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MoveTrace {
    /// Pass over the tree, from 0.
    pub round: u32,
    /// Place of the node, as the moves before left it.
    pub node: u32,
    /// Place of the one that it is put beside.
    pub to: u32,
    /// By how much the half areas of all boxes shrink, in squares of the scene's longest side.
    pub gain: f32,
}

/// A resolution that a grid tries.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GridTrace {
    /// Cells per primitive that are aimed at.
    pub density: f64,
    /// Cells along each axis.
    pub cells: [u32; 3],
    /// The box of all cells; `None` without primitives.
    pub bounds: Option<Bounds>,
    /// References from cells to primitives; `None` if there would be more than `limit`, and the next try is coarser.
    pub references: Option<usize>,
    /// Most references that are taken.
    pub limit: usize,
}

/// A binary tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TreeTrace {
    /// The root first; children side by side, after their parent.
    pub nodes: Vec<TreeNodeTrace>,
    /// Slot to primitive.
    pub order: Vec<u32>,
}

/// A node of a binary tree.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TreeNodeTrace {
    /// The box around everything below.
    pub bounds: Bounds,
    /// Leaf: its first slot. Inner node: its first child; the second is the next node.
    pub first: u32,
    /// Primitives of a leaf; 0 for an inner node.
    pub count: u32,
}

/// A node of a structure, as walks have it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NodeTrace {
    /// Its number; of a grid the number of the cell, x fastest.
    pub node: u32,
    /// The node that it stands in; `None` for the root and for cells.
    pub parent: Option<u32>,
    /// 0 for the root.
    pub depth: u32,
    /// The box around its volume.
    pub bounds: Bounds,
    /// Primitives of a leaf or cell; `None` for an inner node.
    pub prims: Option<u32>,
}

/// A structure in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StatsTrace {
    /// Inner nodes and leaves; of a grid cells that are not empty.
    pub nodes: usize,
    /// Nodes with primitives.
    pub leaves: usize,
    /// Depth of the deepest leaf.
    pub max_depth: u32,
    /// Primitives in leaves, those in several counted several times.
    pub references: usize,
    /// Work of a random line that meets the root: nodes and primitive tests; `None` where it says nothing (grids, and
    /// scenes without area).
    pub sah_cost: Option<f64>,
    /// Memory.
    pub bytes: usize,
}

impl BuildTrace {
    pub(crate) fn of(scene: &Scene, limit: usize) -> Result<Self, BuildError> {
        let walk = scene.explain_build(limit)?;
        let is_whole = walk.step_count <= limit;
        let is_tree = Structure::named(scene.structure()).is_ok_and(|s| s.is_tree);
        let (nodes, nodes_total) = nodes(scene.query(), limit);
        let BuildWalk {
            steps,
            step_count,
            order,
            curve,
            tree,
        } = walk;
        Ok(Self {
            boxwood_trace: crate::VERSION,
            kind: "build".to_owned(),
            structure: crate::label(scene),
            builder: is_tree.then(|| scene.options().builder.name.to_owned()),
            primitives: scene.len(),
            skipped: scene.skipped(),
            bounds: Bounds::of(&scene.bounds()),
            steps: steps
                .iter()
                .map(|step| StepTrace::of(step, &order))
                .collect(),
            steps_total: step_count,
            curve: curve.iter().map(CurveTrace::of).collect(),
            tree: (is_tree && is_whole).then(|| TreeTrace::of(&tree)),
            order: if is_whole { order } else { Vec::new() },
            nodes,
            nodes_total,
            stats: StatsTrace::of(scene, is_tree),
        })
    }
}

fn nodes(query: &dyn Query, limit: usize) -> (Vec<NodeTrace>, usize) {
    let (mut nodes, mut total) = (Vec::new(), 0);
    let mut path: Vec<u32> = Vec::new();
    query.for_each_node(&mut |info| {
        path.truncate(info.depth as usize);
        if total < limit {
            nodes.push(NodeTrace {
                node: info.node,
                parent: path.last().copied(),
                depth: info.depth,
                bounds: info.bounds.into(),
                prims: info.prims,
            });
        }
        path.push(info.node);
        total += 1;
    });
    (nodes, total)
}

impl Bounds {
    /// `None` if nothing is inside.
    fn of(bounds: &Aabb) -> Option<Self> {
        (!bounds.is_empty()).then(|| (*bounds).into())
    }
}

impl From<Aabb> for Bounds {
    fn from(Aabb { min, max }: Aabb) -> Self {
        // The sign of a zero depends on the instruction set, and means nothing: -0 + 0 is 0.
        let plain = |corner: [f32; 3]| corner.map(|x| x + 0.0);
        Self {
            min: plain(min),
            max: plain(max),
        }
    }
}

impl StepTrace {
    /// `order` is that of the walk.
    fn of(step: &BuildStep, order: &[u32]) -> Self {
        match step {
            BuildStep::Set(set) => Self::of_set(set, order),
            BuildStep::Merge(merge) => Self::Merge(MergeTrace::of(merge)),
            BuildStep::Move(NodeMove {
                round,
                node,
                to,
                gain,
            }) => Self::Move(MoveTrace {
                round: *round,
                node: *node,
                to: *to,
                gain: *gain,
            }),
            BuildStep::Grid(grid) => Self::Grid(GridTrace::of(grid)),
        }
    }

    fn of_set(step: &SetStep, order: &[u32]) -> Self {
        match step.choice {
            Choice::Leaf(why) => Self::Leaf(LeafTrace {
                set: SetTrace::of(step, why),
                prims: order[step.slots.start as usize..step.slots.end as usize].to_vec(),
            }),
            Choice::Split {
                plane,
                why,
                children,
            } => Self::Split(SplitTrace {
                set: SetTrace::of(step, why),
                plane: PlaneTrace::of(&plane, step),
                children,
            }),
        }
    }
}

impl SetTrace {
    fn of(step: &SetStep, why: Why) -> Self {
        Self {
            node: step.node,
            parent: step.parent,
            depth: step.depth,
            first: step.slots.start,
            count: step.slots.len() as u32,
            bounds: step.bounds.into(),
            centers: step.centers.into(),
            planes: step
                .planes
                .iter()
                .map(|p| PlaneTrace::of(p, step))
                .collect(),
            weighed: step.weighed,
            leaf_cost: step.leaf_cost.and_then(finite),
            why: match why {
                Why::Few => WhyTrace::Few,
                Why::Cheaper => WhyTrace::Cheaper,
                Why::Rule => WhyTrace::Rule,
                Why::Alike => WhyTrace::Alike,
                Why::Deep => WhyTrace::Deep,
            },
        }
    }
}

impl PlaneTrace {
    fn of(plane: &Plane, set: &SetStep) -> Self {
        Self {
            axis: [Axis::X, Axis::Y, Axis::Z][plane.axis],
            at: plane.at,
            left: plane.left,
            right: set.slots.len() as u32 - plane.left,
            cost: plane.cost.and_then(finite),
        }
    }
}

impl CurveTrace {
    fn of(place: &CurvePlace) -> Self {
        Self {
            prim: place.prim,
            code: place.code,
        }
    }
}

impl MergeTrace {
    fn of(merge: &MergeStep) -> Self {
        Self {
            round: merge.round,
            cluster: merge.cluster,
            parts: merge.parts,
            bounds: merge.bounds.into(),
            count: merge.count,
            is_leaf: merge.is_leaf,
            node: merge.node,
        }
    }
}

impl GridTrace {
    fn of(grid: &GridTry) -> Self {
        Self {
            density: grid.density,
            cells: grid.cells,
            bounds: Bounds::of(&grid.bounds),
            references: grid.references,
            limit: grid.limit,
        }
    }
}

impl TreeTrace {
    fn of(tree: &Topology) -> Self {
        let nodes = tree.nodes.iter().map(|node| TreeNodeTrace {
            bounds: node.bounds.into(),
            first: node.first,
            count: node.count,
        });
        Self {
            nodes: nodes.collect(),
            order: tree.order.clone(),
        }
    }
}

impl StatsTrace {
    fn of(scene: &Scene, is_tree: bool) -> Self {
        let stats = scene.stats();
        Self {
            nodes: stats.nodes,
            leaves: stats.leaves,
            max_depth: stats.max_depth,
            references: stats.references,
            sah_cost: Some(stats.sah_cost).filter(|cost| is_tree && cost.is_finite()),
            bytes: stats.bytes,
        }
    }
}
