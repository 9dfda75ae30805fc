//! Traces: what a build or a ray did, step by step, as data that programs read and people can print.
//!
//! ```
//! # let positions = [[0.0, 0.0, 5.0], [4.0, 0.0, 5.0], [0.0, 4.0, 5.0]];
//! let scene = boxwood::Scene::new(&positions, &[[0, 1, 2]])?;
//! let walk = boxwood_trace::walk(&scene, &boxwood::Ray::new([1.0, 2.0, 0.0], [0.0, 0.0, 2.0]));
//! assert_eq!(walk.hit.as_ref().map(|hit| hit.t), Some(2.5));
//! println!("{}", walk.text(200));
//!
//! let build = boxwood_trace::build(&scene, 200)?;
//! assert_eq!((build.steps.len(), build.steps_total), (1, 1));
//! println!("{}", build.text());
//! # Ok::<(), boxwood::BuildError>(())
//! ```
//!
//! All types are plain data with `serde`; `docs/trace.md` describes the JSON field by field. A number that is infinite or not
//! a number is `None`, `null` in JSON. Nothing here is computed a second time: the numbers are those of the structure's own
//! code, and texts print the same data.

mod build;
mod build_text;
mod narrator;
mod number;
mod walk;
mod walk_text;

pub use build::{
    Axis, Bounds, BuildTrace, CurveTrace, GridTrace, LeafTrace, MergeTrace, MoveTrace, NodeTrace,
    PlaneTrace, SetTrace, SplitTrace, StatsTrace, StepTrace, TreeNodeTrace, TreeTrace, WhyTrace,
};
pub use number::{counted, grouped};
pub use walk::{
    BoxTrace, BoxVerdict, CellTrace, CountsTrace, Event, HitTrace, InstanceTrace, InstanceVerdict,
    PrimitiveTrace, PrimitiveVerdict, RayTrace, WalkStep, WalkTrace,
};

use boxwood::{BuildError, Ray, Scene};

/// Version of the schema, in every trace as `boxwood_trace`. New fields may come within a version; one that goes or changes its
/// meaning makes a new one.
pub const VERSION: u32 = 1;

/// How the scene finds the closest hit of a ray: every box, cell and primitive, with the stack around each.
///
/// Looks at every node of the scene once, besides walking.
pub fn walk(scene: &Scene, ray: &Ray) -> WalkTrace {
    narrator::narrate(scene, ray)
}

/// How the scene's structure came to be, up to `limit` steps and as many nodes. `usize::MAX` tells all.
///
/// The structure is built once more, several times as slowly: for small scenes and lessons.
///
/// # Errors
/// As [`Scene::explain_build`].
pub fn build(scene: &Scene, limit: usize) -> Result<BuildTrace, BuildError> {
    BuildTrace::of(scene, limit)
}

/// `bvh2 (binned, aabb)`.
fn label(scene: &Scene) -> String {
    let name = scene.structure();
    let choices = boxwood::Structure::named(name).map(|s| s.choices(scene.options()));
    match choices {
        Ok(choices) if !choices.is_empty() => format!("{name} ({})", choices.join(", ")),
        _ => name.to_owned(),
    }
}
