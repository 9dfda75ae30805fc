//! The answer to *what does this ray hit?*

use std::cmp::Ordering;

/// Where a ray meets a primitive.
///
/// For triangles the point is `(1 - u - v) * v0 + u * v1 + v * v2`, as in Embree. Ids are the caller's own: `prim`
/// counts within its mesh, in the order given.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Hit {
    /// Ray parameter, in units of the ray's `dir`.
    pub t: f32,
    /// Weight of the second vertex, 0..=1.
    pub u: f32,
    /// Weight of the third vertex, 0..=1.
    pub v: f32,
    /// Primitive within its geometry.
    pub prim: u32,
    /// Geometry (mesh) within the scene, in the order added.
    pub geom: u32,
    /// Instance, or [`Hit::NO_INSTANCE`].
    pub inst: u32,
}

impl Hit {
    /// The `inst` of a hit on geometry that is not instanced.
    pub const NO_INSTANCE: u32 = u32::MAX;

    /// The order that defines the closest hit: by `t`, then by instance, geometry and primitive.
    pub fn order(&self, other: &Self) -> Ordering {
        let ids = |hit: &Self| (hit.inst, hit.geom, hit.prim);
        // `t` is never NaN, and -0 must equal +0, so `total_cmp` would be wrong here.
        let by_t = self.t.partial_cmp(&other.t).unwrap_or(Ordering::Equal);
        by_t.then_with(|| ids(self).cmp(&ids(other)))
    }
}

/// What a primitive's own test answers, before the range of the ray and the ids are looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Ray parameter.
    pub t: f32,
    /// First surface parameter.
    pub u: f32,
    /// Second surface parameter.
    pub v: f32,
}
