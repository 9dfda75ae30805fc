//! Rays, and the constants that every exact test needs of one.

use super::MAX_COORDINATE;
use super::float::max;

/// A half-line with a closed range: the points `origin + t * dir` for `t_min <= t <= t_max`.
///
/// `dir` need not have unit length; `t` counts in units of `dir`, so it is a distance only if `dir` is unit.
/// A negative `t_min` counts as 0. A ray that is not a ray hits nothing: a NaN anywhere, an infinite origin or
/// direction, a zero direction, an origin beyond [`MAX_COORDINATE`], or a direction whose largest component is
/// outside 2^-80..=2^80 (about 8e-25 to 1.2e24).
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Ray {
    /// Where `t` is 0.
    pub origin: [f32; 3],
    /// Smallest accepted `t`.
    pub t_min: f32,
    /// Any length but zero.
    pub dir: [f32; 3],
    /// Largest accepted `t`; infinity is fine.
    pub t_max: f32,
}

impl Ray {
    /// The whole half-line from `origin`: `t` from 0 to infinity.
    pub const fn new(origin: [f32; 3], dir: [f32; 3]) -> Self {
        Self {
            origin,
            t_min: 0.0,
            dir,
            t_max: f32::INFINITY,
        }
    }

    /// From `from` (`t = 0`) up to and including `to` (`t = 1`): the question of a shadow ray.
    pub fn between(from: [f32; 3], to: [f32; 3]) -> Self {
        let dir = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
        Self {
            origin: from,
            t_min: 0.0,
            dir,
            t_max: 1.0,
        }
    }

    /// The same line with another closed range.
    pub const fn with_range(self, t_min: f32, t_max: f32) -> Self {
        Self {
            t_min,
            t_max,
            ..self
        }
    }

    /// False for a ray that hits nothing by definition.
    pub fn is_valid(&self) -> bool {
        PreparedRay::new(self).is_some()
    }

    /// The point at `t`, in floating point.
    pub fn at(&self, t: f32) -> [f32; 3] {
        std::array::from_fn(|k| self.origin[k] + t * self.dir[k])
    }
}

/// A valid [`Ray`] with the constants of the exact test (Woop, Benthin, Wald, "Watertight Ray/Triangle
/// Intersection", JCGT 2013): space is sheared so that the ray runs along one axis from the origin.
///
/// Made once per ray, used for every primitive and every box.
#[derive(Clone, Copy, Debug)]
pub struct PreparedRay {
    /// As in the ray.
    pub origin: [f32; 3],
    /// As in the ray.
    pub dir: [f32; 3],
    /// `max(ray.t_min, 0)`.
    pub t_min: f32,
    /// As in the ray.
    pub t_max: f32,
    /// Nothing beyond this matters any more: `t_max`, or the closest hit that nested objects have found so far.
    pub limit: f32,
    /// Instances whose mask shares no bit with this are not there for the ray; all bits set unless asked otherwise.
    pub mask: u32,
    /// The axis of the largest `|dir|`, after the two others in cyclic order: `[kx, ky, kz]`.
    pub axes: [usize; 3],
    /// `dir[kx] / dir[kz]` and `dir[ky] / dir[kz]`.
    pub shear: [f32; 2],
    /// `1 / dir[kz]` in double precision: turns a depth along `kz` into `t`.
    pub t_per_depth: f64,
    /// `1 / dir` with components of `dir` below 2^-40 of the largest one lifted to that, so that it is finite
    /// and a product with it is never NaN. The lift moves the ray far less than the padding of any box.
    pub recip: [f32; 3],
    /// Padding below which no box is padded: covers underflow in tiny scenes.
    pub pad_floor: f32,
}

impl PreparedRay {
    /// `None` if the ray is not a ray (see [`Ray`]).
    #[inline(always)]
    pub fn new(ray: &Ray) -> Option<Self> {
        let [x, y, z] = [ray.dir[0].abs(), ray.dir[1].abs(), ray.dir[2].abs()];
        let largest = max(x, max(y, z));
        let [a, b, c] = [
            ray.origin[0].abs(),
            ray.origin[1].abs(),
            ray.origin[2].abs(),
        ];
        // Every comparison is false on NaN. No branch but one, which is always guessed.
        let valid = (a <= MAX_COORDINATE)
            & (b <= MAX_COORDINATE)
            & (c <= MAX_COORDINATE)
            & (x <= MAX_DIR)
            & (y <= MAX_DIR)
            & (z <= MAX_DIR)
            & (largest >= MIN_DIR)
            & !ray.t_min.is_nan()
            & !ray.t_max.is_nan();
        if !valid {
            return None;
        }
        // Looked up, not branched on: the main axis cannot be guessed, and boxes can be tested before it is known.
        let order = usize::from(x >= y) | usize::from(x >= z) << 1 | usize::from(y >= z) << 2;
        let axes = AXES[order];
        let [kx, ky, kz] = axes;
        let lift = largest * LIFT;
        let steep = (x < lift) | (y < lift) | (z < lift);
        let recip = if steep {
            lifted(ray.dir, lift)
        } else {
            ray.dir.map(|d| 1.0 / d)
        };
        Some(Self {
            origin: ray.origin,
            dir: ray.dir,
            t_min: if ray.t_min > 0.0 { ray.t_min } else { 0.0 },
            t_max: ray.t_max,
            limit: ray.t_max,
            mask: u32::MAX,
            axes,
            shear: [ray.dir[kx] / ray.dir[kz], ray.dir[ky] / ray.dir[kz]],
            t_per_depth: 1.0 / f64::from(ray.dir[kz]),
            recip,
            pad_floor: max(largest * PAD_PER_DIR[0] * PAD_PER_DIR[1], LEAST_PAD),
        })
    }

    /// The ray that this was made of, but for a negative `t_min`.
    #[inline]
    pub fn ray(&self) -> Ray {
        Ray {
            origin: self.origin,
            t_min: self.t_min,
            dir: self.dir,
            t_max: self.t_max,
        }
    }

    /// True if `t` is finite and in the ray's closed range.
    #[inline]
    pub fn contains(&self, t: f32) -> bool {
        t >= self.t_min && t <= self.t_max && t < f32::INFINITY
    }
}

/// `1 / d`, with each `d` lifted to at least `lift` in size.
#[cold]
fn lifted(dir: [f32; 3], lift: f32) -> [f32; 3] {
    dir.map(|d| 1.0 / if d.abs() < lift { lift.copysign(d) } else { d })
}

/// The axes by the comparisons x >= y, x >= z, y >= z (bits 0, 1, 2): the largest component last, the first of equals.
const AXES: [[usize; 3]; 8] = {
    let (x, y, z) = ([1, 2, 0], [2, 0, 1], [0, 1, 2]);
    [z, z, z, x, y, y, y, x]
};

/// Largest component of a direction.
pub(crate) const MAX_DIR: f32 = 1_208_925_819_614_629_174_706_176.0; // 2^80
/// Smallest that the largest component of a direction may be.
pub(crate) const MIN_DIR: f32 = 1.0 / MAX_DIR;
/// Smaller components than this times the largest are lifted before they are divided by.
pub(crate) const LIFT: f32 = 1.0 / (1u64 << 40) as f32;
/// [`PreparedRay::pad_floor`] is the largest component times 2^-145, and not below [`LEAST_PAD`]. As two factors: the product is
/// denormal, which a host may have told the processor to take for 0.
pub(crate) const PAD_PER_DIR: [f32; 2] = [1.0 / (1u128 << 100) as f32, 1.0 / (1u64 << 45) as f32];
/// 2^-110.
pub(crate) const LEAST_PAD: f32 = LIFT * LIFT / (1u64 << 30) as f32;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_direction_component_is_the_last_axis() {
        let axes = |dir| PreparedRay::new(&Ray::new([0.0; 3], dir)).unwrap().axes;
        assert_eq!(axes([3.0, -2.0, 1.0]), [1, 2, 0]);
        assert_eq!(axes([3.0, -4.0, 1.0]), [2, 0, 1]);
        assert_eq!(axes([3.0, -4.0, 5.0]), [0, 1, 2]);
    }

    #[test]
    fn what_is_not_a_ray_is_refused() {
        let (nan, inf) = (f32::NAN, f32::INFINITY);
        let refused = |ray: Ray| assert!(PreparedRay::new(&ray).is_none(), "{ray:?}");
        for bad in [nan, inf, -inf] {
            for axis in 0..3 {
                let (mut origin, mut dir) = ([1.0, 2.0, 3.5], [0.5, -1.0, 2.0]);
                origin[axis] = bad;
                refused(Ray::new(origin, [0.5, -1.0, 2.0]));
                dir[axis] = bad;
                refused(Ray::new([1.0, 2.0, 3.5], dir));
            }
        }
        refused(Ray::new([0.0; 3], [0.0, -0.0, 0.0]));
        refused(Ray::new([0.0; 3], [1e-30, 0.0, 0.0]));
        refused(Ray::new([0.0; 3], [1e30, 0.0, 0.0]));
        refused(Ray::new([2e30, 0.0, 0.0], [1.0, 0.0, 0.0]));
        refused(Ray::new([0.0; 3], [1.0, 0.0, 0.0]).with_range(nan, 1.0));
        refused(Ray::new([0.0; 3], [1.0, 0.0, 0.0]).with_range(0.0, nan));
    }

    #[test]
    fn reciprocals_are_finite_for_zero_components_of_either_sign() {
        let ray = PreparedRay::new(&Ray::new([0.0; 3], [0.0, -0.0, 2.0])).unwrap();
        assert!(ray.recip.into_iter().all(f32::is_finite));
        assert!(ray.recip[0] > 0.0 && ray.recip[1] < 0.0);
    }
}
