//! Points, rays and shapes: what a ray is, what a hit is, and the exact tests between them.
//!
//! This module imports nothing from the rest of the crate.

mod aabb;
mod float;
mod hit;
#[cfg(feature = "distances")]
mod nearest;
mod obb;
mod ray;
mod slab;
mod sphere;
mod transform;
mod triangle;

pub use aabb::Aabb;
pub(crate) use float::{max, min};
pub use hit::{Candidate, Hit};
#[cfg(feature = "distances")]
pub use nearest::{Foot, Nearest};
pub use obb::Obb;
pub(crate) use ray::{LEAST_PAD, LIFT, MAX_DIR, MIN_DIR, PAD_PER_DIR};
pub use ray::{PreparedRay, Ray};
pub use slab::{AabbPair, Interval, SlabRay, slab_1d};
pub(crate) use slab::{OWN_PAD, filter_pad};
pub use sphere::Sphere;
pub use transform::{Affine, Transform};
pub(crate) use transform::{Placement, Slack};
pub use triangle::{EdgeTrace, Triangle};

/// Coordinates beyond this magnitude (2^100, about 1.27e30) are outside the domain: a primitive that has one is
/// never hit, a ray whose origin has one hits nothing. Inside it no difference of two coordinates overflows.
pub const MAX_COORDINATE: f32 = 1_267_650_600_228_229_401_496_703_205_376.0;
