//! What goes over the border by value. `include/boxwood.h` asserts the sizes for C, the end of this file for Rust.

use boxwood::{Aabb, Hit, Nearest, Ray};

/// What does not exist: the geometry of a miss, the instance of a hit on triangles that stand in no instance.
pub const BW_INVALID_ID: u32 = u32::MAX;

/// How much a build may cost for how good a structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum BwQuality {
    /// For scenes that are built again all the time.
    Fast = 0,
    /// Rays dear, builds cheap.
    Default = 1,
    /// For scenes that meet many rays.
    High = 2,
}

/// A ray: the points `origin + t * dir` for `t_min <= t <= t_max`, both ends included.
///
/// `dir` need not have unit length; `t` counts in units of `dir`. A negative `t_min` counts as 0, `t_max` may be INFINITY. A ray with
/// NaN anywhere, an infinite origin or direction, a zero direction, an origin beyond 2^100, or a direction whose largest component
/// is outside 2^-80..2^80 hits nothing: see `bw_ray_is_valid`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct BwRay {
    /// Where `t` is 0.
    pub origin: [f32; 3],
    /// Smallest accepted `t`.
    pub t_min: f32,
    /// Any length but zero.
    pub dir: [f32; 3],
    /// Largest accepted `t`.
    pub t_max: f32,
}

/// Where a ray meets a triangle: the point is `(1 - u - v) * v0 + u * v1 + v * v2`.
///
/// A miss has `geom == BW_INVALID_ID`, as well as `prim` and `inst`, `t` is INFINITY, the rest 0.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct BwHit {
    /// Ray parameter, in units of the ray's `dir`.
    pub t: f32,
    /// Weight of the second vertex, 0 to 1.
    pub u: f32,
    /// Weight of the third vertex, 0 to 1.
    pub v: f32,
    /// Triangle within its geometry.
    pub prim: u32,
    /// Geometry within its scene, as `bw_attach_triangles` numbered it.
    pub geom: u32,
    /// Instance, as `bw_attach_instance` numbered it, or BW_INVALID_ID. Where instances hold instances, the ways to scenes of
    /// triangles are numbered in the order of the instances, depth first.
    pub inst: u32,
    /// Normal by the order of the vertices (counter-clockwise in front), in the world; its length is twice the triangle's area.
    pub ng: [f32; 3],
}

/// The place of a surface that is nearest to a point: `(1 - u - v) * v0 + u * v1 + v * v2`.
///
/// For a point that is not finite and in an empty scene `geom` and `prim` are BW_INVALID_ID, `point` and `distance` NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct BwNearest {
    /// The place.
    pub point: [f32; 3],
    /// From the point to the place, never negative.
    pub distance: f32,
    /// Weight of the second vertex, 0 to 1.
    pub u: f32,
    /// Weight of the third vertex, 0 to 1.
    pub v: f32,
    /// Triangle within its geometry.
    pub prim: u32,
    /// Geometry within the scene.
    pub geom: u32,
}

/// A box along the axes; `min > max` for a scene in which nothing can be hit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct BwBounds {
    /// Smallest corner.
    pub min: [f32; 3],
    /// Largest corner.
    pub max: [f32; 3],
}

/// What a committed scene holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct BwStats {
    /// Triangles, with every instance multiplied out.
    pub triangles: u64,
    /// Triangles as stored, each scene once.
    pub stored: u64,
    /// Triangles, or instances in a scene of these, that can never be hit: coordinates that are not finite or beyond 2^100, a
    /// matrix that cannot be undone. They keep their numbers.
    pub skipped: u64,
    /// Memory, in bytes: structures and triangles, all scenes inside instances included, each once.
    pub bytes: u64,
}

impl From<BwRay> for Ray {
    #[inline]
    fn from(ray: BwRay) -> Self {
        let BwRay {
            origin,
            t_min,
            dir,
            t_max,
        } = ray;
        Self {
            origin,
            t_min,
            dir,
            t_max,
        }
    }
}

impl BwHit {
    pub(crate) const MISS: Self = Self {
        t: f32::INFINITY,
        u: 0.0,
        v: 0.0,
        prim: BW_INVALID_ID,
        geom: BW_INVALID_ID,
        inst: BW_INVALID_ID,
        ng: [0.0; 3],
    };

    #[inline]
    pub(crate) fn new(hit: Hit, ng: [f32; 3]) -> Self {
        let Hit {
            t,
            u,
            v,
            prim,
            geom,
            inst,
        } = hit;
        Self {
            t,
            u,
            v,
            prim,
            geom,
            inst,
            ng,
        }
    }
}

impl BwNearest {
    pub(crate) const NOWHERE: Self = Self {
        point: [f32::NAN; 3],
        distance: f32::NAN,
        u: 0.0,
        v: 0.0,
        prim: BW_INVALID_ID,
        geom: BW_INVALID_ID,
    };
}

impl From<Nearest> for BwNearest {
    fn from(nearest: Nearest) -> Self {
        let Nearest {
            point,
            distance,
            u,
            v,
            prim,
            geom,
        } = nearest;
        Self {
            point,
            distance,
            u,
            v,
            prim,
            geom,
        }
    }
}

impl From<Aabb> for BwBounds {
    fn from(Aabb { min, max }: Aabb) -> Self {
        Self { min, max }
    }
}

const _: () = assert!(size_of::<BwRay>() == 32 && align_of::<BwRay>() == 4);
const _: () = assert!(size_of::<BwHit>() == 36 && align_of::<BwHit>() == 4);
const _: () = assert!(size_of::<BwNearest>() == 32 && align_of::<BwNearest>() == 4);
const _: () = assert!(size_of::<BwBounds>() == 24 && align_of::<BwBounds>() == 4);
const _: () = assert!(size_of::<BwStats>() == 32);
const _: () = assert!(Hit::NO_INSTANCE == BW_INVALID_ID);
