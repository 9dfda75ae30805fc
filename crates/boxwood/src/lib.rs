//! **Boxwood** answers *what does this ray hit?* - exactly: one answer, bit for bit the same in every structure,
//! on every machine, for one thread or many.
//!
//! ```
//! let positions = [[0.0, 0.0, 5.0], [4.0, 0.0, 5.0], [0.0, 4.0, 5.0]];
//! let scene = boxwood::Scene::new(&positions, &[[0, 1, 2]])?;
//! let hit = scene.closest_hit(&boxwood::Ray::new([1.0, 2.0, 0.0], [0.0, 0.0, 2.0])).unwrap();
//! assert_eq!((hit.t, hit.u, hit.v, hit.prim), (2.5, 0.25, 0.5, 0));
//! # Ok::<(), boxwood::BuildError>(())
//! ```
//!
//! # Words
//!
//! A *ray* is `origin + t * dir` over a closed range of `t`; `dir` is not normalised. A *primitive* is what can be hit,
//! a *volume* is a simple shape around primitives, a *structure* decides which primitives a ray need not be asked about.
//! A *builder* makes the tree of a hierarchy. `closest_hit`, `occluded`, `all_hits` are the three questions; we never say
//! "any hit", which means three different things in this field.
//!
//! # One answer
//!
//! The answer is defined without any structure: of all primitives that the exact test accepts ([`geom`]), the hit with
//! the smallest `(t, instance, geometry, primitive)`. Structures are filters: they may only skip work. The structure
//! `list` is brute force and the oracle of all tests.
//!
//! # The lecture
//!
//! The library grew out of a lecture on acceleration structures, and each of its slides is here under its own name:
//! [`lecture`] has the formulas, [`volume`] the bounding volumes, [`structure`] `BoundedObject`, the hierarchy and the
//! uniform grid, [`build`] the partition along an axis.
//!
//! # Cargo features
//!
//! All on by default, and none changes an answer. `rayon`: builds and slices of rays on all threads of the caller's pool.
//! `shapes`: structures over spheres, shapes of your own and instances; `volumes`: trees of spheres and of oriented boxes.
//! `file`: scenes saved, and opened again without a build ([`Scene::save`]).
//! Without `shapes` and `volumes` a program holds little more than triangles in axis-aligned boxes, and is about half a megabyte smaller.
#![cfg_attr(
    not(feature = "shapes"),
    allow(
        dead_code,
        unused_imports,
        reason = "what holds other primitives than triangles"
    )
)]

pub mod build;
pub mod check;
pub mod geom;
pub mod lecture;
pub mod prims;
pub mod query;
pub mod structure;
pub mod volume;

mod error;
#[cfg(feature = "file")]
mod file;
mod observe;
mod scene;
mod simd;
mod stats;
mod tables;
#[cfg(test)]
mod testing;

pub use build::{
    AxisRule, BUILDERS, BuildOptions, BuildStep, BuildWalk, Builder, PRESETS, Preset, Progress,
};
pub use error::BuildError;
#[cfg(feature = "file")]
pub use file::{AlignedBytes, FileCause, FileError};
#[cfg(feature = "distances")]
pub use geom::Nearest;
pub use geom::{Aabb, Affine, Hit, Interval, Obb, Ray, Sphere, Transform, Triangle};
pub use query::{Counts, Query, Step, Walk};
#[cfg(feature = "file")]
pub use scene::ContentHash;
pub use scene::{Census, Instance, Placed, Scene, SceneBuilder};
pub use simd::InstructionSet;
pub use stats::Stats;
pub use structure::{BoundedObject, Object};
pub use tables::{STRUCTURES, Structure, VOLUMES, Volume};
