//! The slab test: where is a ray between two parallel planes, and where between three pairs of them at once?
//!
//! Kay and Kajiya, "Ray Tracing Complex Scenes", SIGGRAPH 1986. Two forms share one argument:
//!
//! * [`Aabb::own_interval`] belongs to the *definition* of a hit: a primitive's `t` lies in the padded interval of
//!   its own box.
//! * [`SlabRay::interval`] is the *filter* of the structures. Its padding is larger and its boxes contain the
//!   primitive's box, and rounding is monotone; so a box that contains a hit primitive is never missed.
//!
//! # Why the paddings suffice
//!
//! Let `u = 2^-24` and `A` be [`Aabb::reach`]: no vertex is farther than `A` from the origin in any axis. The
//! exact triangle test moves vertices by at most `6 u A` (translation, shear). The plane distances here err by
//! `4 u A` (subtraction, padding, reciprocal, product). The own box is padded by `16 u A`, so its interval is not
//! empty for an accepted triangle. Filters pad by `32 u A'` with `A'` of the whole scene, hence `A' >= A`; that is at
//! least `16 u A'` more than the definition, and covers the `4 u A'` by which each of the two may err. Both multiply by
//! the same reciprocals, so these are no source of difference; folding the padding into the origin rounds relative to
//! the origin's size and not to `A'`, which the slack of [`SlabRay::new`] makes up for.
//!
//! The kernels of the wide tree have a third form, `plane * r + (-(o * r) -+ pad * |r|)` (`structure/wide/ray.rs`): two
//! products and a sum rounded beforehand, each relative to at most `(|o| + pad) |r|`, and one fused product and sum relative to at
//! most `A' |r|`. That is `4 u A' |r|` at most, as for the other forms, within the `16 u A' |r|` between filter and definition.

use super::float::{max, min};
use super::{Aabb, PreparedRay};
use glam::{Vec3A, Vec4, Vec4Swizzles};

/// A closed range of the ray parameter; empty if `near > far`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Where the ray goes in.
    pub near: f32,
    /// Where it comes out.
    pub far: f32,
}

impl Interval {
    /// The whole line.
    pub const ALL: Self = Self {
        near: f32::NEG_INFINITY,
        far: f32::INFINITY,
    };
    /// Nothing.
    pub const EMPTY: Self = Self {
        near: f32::INFINITY,
        far: f32::NEG_INFINITY,
    };

    /// What is in both.
    #[inline]
    pub fn intersect(self, other: Self) -> Self {
        Self {
            near: max(self.near, other.near),
            far: min(self.far, other.far),
        }
    }

    /// True if something of it lies in `t_min..=t_max`.
    #[inline]
    pub fn meets(self, t_min: f32, t_max: f32) -> bool {
        max(self.near, t_min) <= min(self.far, t_max)
    }
}

/// The 1D slab: where `origin + t / recip` is between `lo - pad` and `hi + pad`. With a finite `recip` the answer
/// is never NaN: not for a ray in the plane, not for a zero direction (see [`PreparedRay::recip`]).
#[inline]
pub fn slab_1d(lo: f32, hi: f32, pad: f32, origin: f32, recip: f32) -> Interval {
    let (a, b) = (((lo - origin) - pad) * recip, ((hi - origin) + pad) * recip);
    Interval {
        near: min(a, b),
        far: max(a, b),
    }
}

impl Aabb {
    /// The 3D slab test as the slides have it: the intersection of three slabs, each padded by `pad`.
    #[inline]
    pub fn slab(&self, ray: &PreparedRay, pad: f32) -> Interval {
        let axis = |k: usize| slab_1d(self.min[k], self.max[k], pad, ray.origin[k], ray.recip[k]);
        axis(0).intersect(axis(1)).intersect(axis(2))
    }

    /// The padded interval of a primitive's own box, to which its `t` is bound. Part of the definition of a hit.
    #[inline]
    pub fn own_interval(&self, ray: &PreparedRay) -> Interval {
        self.slab(ray, own_pad(self.reach(ray.origin), ray))
    }

    /// Binds `t` to [`Aabb::own_interval`]; `None` if that is empty (outside the domain of the exact test only).
    #[inline]
    pub fn bind(&self, ray: &PreparedRay, t: f32) -> Option<f32> {
        let own = self.own_interval(ray);
        (own.near <= own.far && t.is_finite()).then(|| max(own.near, min(own.far, t)))
    }
}

/// Padding of the definition, `16 u A`.
#[inline]
fn own_pad(reach: f32, ray: &PreparedRay) -> f32 {
    reach * OWN_PAD + ray.pad_floor
}

/// Padding of every filter, `32 u A`, for a structure whose whole content reaches `reach` from the ray's origin.
#[inline]
pub(crate) fn filter_pad(reach: f32, ray: &PreparedRay) -> f32 {
    2.0 * own_pad(reach, ray)
}

/// A ray made ready for many boxes of one structure: the padding is folded into the origin, so that it costs
/// nothing per box. Lanes are as in [`AabbPair`].
#[derive(Clone, Copy, Debug)]
pub struct SlabRay {
    origin: [Vec4; 3],
    recip: [Vec4; 3],
}

/// Two boxes side by side for one test: along each axis `[min, min, max, max]` of the first and the second.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct AabbPair([[f32; 4]; 3]);

impl AabbPair {
    /// Puts two boxes side by side.
    pub fn new(a: &Aabb, b: &Aabb) -> Self {
        Self(std::array::from_fn(|k| {
            [a.min[k], b.min[k], a.max[k], b.max[k]]
        }))
    }

    /// Takes them apart again.
    pub fn boxes(&self) -> [Aabb; 2] {
        [0, 1].map(|i| Aabb {
            min: self.0.map(|axis| axis[i]),
            max: self.0.map(|axis| axis[2 + i]),
        })
    }
}

impl SlabRay {
    /// For boxes inside `bounds`.
    #[inline]
    pub fn new(ray: &PreparedRay, bounds: &Aabb) -> Self {
        let pad = filter_pad(bounds.reach(ray.origin), ray);
        let origin = Vec3A::from_array(ray.origin);
        // The origin as seen by the faces: ahead by at least `pad` for `min`, behind for `max`. The slack makes up for the
        // two roundings here.
        let slack = (origin.abs() + pad) * TWO_POW_MINUS_22;
        let (for_min, for_max) = ((origin + pad) + slack, (origin - pad) - slack);
        let [x, y, z] = ray.recip;
        Self {
            origin: [
                Vec4::new(for_min.x, for_min.x, for_max.x, for_max.x),
                Vec4::new(for_min.y, for_min.y, for_max.y, for_max.y),
                Vec4::new(for_min.z, for_min.z, for_max.z, for_max.z),
            ],
            recip: [Vec4::splat(x), Vec4::splat(y), Vec4::splat(z)],
        }
    }

    /// Where the ray is in both padded boxes: `near` and `far`, the first two lanes of each. Per box 6 subtractions, 6
    /// products, 10 minima and maxima.
    #[inline]
    pub(crate) fn pair(&self, pair: &AabbPair) -> [Vec4; 2] {
        let axis = |k: usize| {
            let t = (Vec4::from_array(pair.0[k]) - self.origin[k]) * self.recip[k];
            let swapped = t.zwxy();
            [t.min(swapped), t.max(swapped)]
        };
        let [x, y, z] = [axis(0), axis(1), axis(2)];
        [x[0].max(y[0]).max(z[0]), x[1].min(y[1]).min(z[1])]
    }

    /// Where the ray is in the padded box.
    #[inline]
    pub fn interval(&self, bounds: &Aabb) -> Interval {
        let [near, far] = self.pair(&AabbPair::new(bounds, bounds));
        Interval {
            near: near.x,
            far: far.x,
        }
    }
}

/// Padding of the definition, of the reach: `16 u`.
pub(crate) const OWN_PAD: f32 = 1.0 / (1 << 20) as f32;
const TWO_POW_MINUS_22: f32 = 1.0 / (1 << 22) as f32;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Ray;

    const BOX: Aabb = Aabb {
        min: [1.0, -2.0, 0.5],
        max: [2.0, 1.5, 4.5],
    };

    fn both(origin: [f32; 3], dir: [f32; 3]) -> [Interval; 2] {
        let ray = PreparedRay::new(&Ray::new(origin, dir)).unwrap();
        [
            BOX.own_interval(&ray),
            SlabRay::new(&ray, &BOX).interval(&BOX),
        ]
    }

    #[test]
    fn a_ray_through_the_box_goes_in_and_out_at_its_faces() {
        for i in both([-1.0, 0.0, 1.0], [2.0, 0.0, 0.0]) {
            assert!(
                (i.near - 1.0).abs() < 1e-4 && (i.far - 1.5).abs() < 1e-4,
                "{i:?}"
            );
        }
    }

    #[test]
    fn a_ray_along_a_face_hits_the_box_for_both_signs_of_zero() {
        for zero in [0.0, -0.0] {
            for (axis, plane) in [(1, -2.0), (1, 1.5), (2, 0.5), (2, 4.5)] {
                let (mut origin, mut dir) = ([-1.0, 0.25, 1.0], [1.0, zero, zero]);
                origin[axis] = plane;
                for i in both(origin, dir) {
                    assert!(i.meets(0.0, f32::INFINITY), "{origin:?} {dir:?} {i:?}");
                }
                dir[0] = -1.0;
                for i in both(origin, dir) {
                    assert!(
                        !i.meets(0.0, f32::INFINITY),
                        "behind the ray: {origin:?} {dir:?} {i:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_parallel_ray_beside_the_box_misses() {
        for i in both([-1.0, 1.6, 1.0], [1.0, 0.0, 0.0]) {
            assert!(!i.meets(0.0, f32::INFINITY), "{i:?}");
        }
    }

    #[test]
    fn an_edge_grazed_by_a_diagonal_ray_is_hit() {
        for i in both([0.0, -3.0, 1.0], [1.0, 1.0, 0.0]) {
            assert!(i.meets(0.0, f32::INFINITY), "{i:?}");
        }
    }

    #[test]
    fn the_filter_interval_contains_the_definition_s() {
        let mut seed = 9u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32
        };
        for round in 0..200_000 {
            let scale = 2.0_f32.powi(round % 60 - 30);
            let corner: [f32; 3] = std::array::from_fn(|_| (random() - 0.5) * scale);
            let small = Aabb::of_points(&[corner, corner.map(|c| c + random() * 0.01 * scale)]);
            let parent = small.union(&Aabb::of_points(&[[scale * random(); 3]]));
            let origin = std::array::from_fn(|_| (random() - 0.5) * scale * 4.0);
            let at = if round % 3 == 0 {
                small.min
            } else {
                small.center()
            };
            let dir: [f32; 3] = std::array::from_fn(|k| at[k] - origin[k]);
            let Some(ray) = PreparedRay::new(&Ray::new(origin, dir)) else {
                continue;
            };
            let (own, filter) = (
                small.own_interval(&ray),
                SlabRay::new(&ray, &parent).interval(&parent),
            );
            assert!(own.near <= own.far, "aimed at the box: {ray:?} {small:?}");
            assert!(
                filter.near <= own.near && own.far <= filter.far,
                "{ray:?} {small:?} {parent:?}"
            );
        }
    }
}
