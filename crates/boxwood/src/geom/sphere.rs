//! The sphere: a primitive and a bounding volume.

use super::{Candidate, PreparedRay};

/// All points at most `radius` from `center`. A negative or NaN radius is an empty sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Sphere {
    /// Middle.
    pub center: [f32; 3],
    /// In the units of the scene.
    pub radius: f32,
}

impl Sphere {
    /// Operations of [`Sphere::roots`] that finds some: to the centre 3, `a` 5, the nearest point 6, its offset 6, the
    /// rest 7, half the chord 2, both ends 2. (4 fewer without.)
    pub const ROOTS_FLOPS: u32 = 31;

    /// Where the line enters and leaves, in double precision: the roots of `|origin + t dir - center|^2 = radius^2`.
    ///
    /// The discriminant is taken from the point nearest to the centre instead of `b^2 - a c`, which cancels for far
    /// origins (Haines et al., "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, 2019).
    #[inline]
    pub fn roots(&self, origin: [f64; 3], dir: [f64; 3]) -> Option<(f64, f64)> {
        let to_center: [f64; 3] = std::array::from_fn(|k| f64::from(self.center[k]) - origin[k]);
        let radius = f64::from(self.radius);
        let a = dot(dir, dir);
        let nearest = dot(to_center, dir) / a;
        let offset: [f64; 3] = std::array::from_fn(|k| to_center[k] - nearest * dir[k]);
        let rest = radius * radius - dot(offset, offset);
        if !(rest >= 0.0 && radius >= 0.0) {
            return None;
        }
        let half = (rest / a).sqrt();
        Some((nearest - half, nearest + half))
    }

    /// The first crossing of the surface in the ray's range: the entry, or the exit for a ray that starts inside.
    /// `u` and `v` are 0.
    pub fn intersect(&self, ray: &PreparedRay) -> Option<Candidate> {
        let (near, far) = self.roots(ray.origin.map(f64::from), ray.dir.map(f64::from))?;
        let t = [near as f32, far as f32]
            .into_iter()
            .find(|&t| ray.contains(t))?;
        Some(Candidate {
            t: t + 0.0,
            u: 0.0,
            v: 0.0,
        })
    }

    /// True if the point is inside or on the surface.
    pub fn contains(&self, point: [f32; 3]) -> bool {
        let d: [f64; 3] = std::array::from_fn(|k| f64::from(point[k]) - f64::from(self.center[k]));
        dot(d, d) <= f64::from(self.radius) * f64::from(self.radius)
    }
}

#[inline]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Ray;

    const BALL: Sphere = Sphere {
        center: [1.0, 2.0, 3.5],
        radius: 0.5,
    };

    fn hit(ray: Ray) -> Option<f32> {
        BALL.intersect(&PreparedRay::new(&ray).unwrap())
            .map(|c| c.t)
    }

    #[test]
    fn entry_from_outside_exit_from_inside() {
        assert_eq!(hit(Ray::new([1.0, 2.0, 0.0], [0.0, 0.0, 2.0])), Some(1.5));
        assert_eq!(hit(Ray::new([1.0, 2.0, 3.5], [0.0, 0.0, 2.0])), Some(0.25));
        assert_eq!(hit(Ray::new([1.0, 2.0, 9.0], [0.0, 0.0, 2.0])), None);
        assert_eq!(hit(Ray::new([1.0, 2.51, 0.0], [0.0, 0.0, 2.0])), None);
    }

    #[test]
    fn the_range_is_closed() {
        assert_eq!(
            hit(Ray::new([1.0, 2.0, 0.0], [0.0, 0.0, 2.0]).with_range(1.5, 1.5)),
            Some(1.5)
        );
        assert_eq!(
            hit(Ray::new([1.0, 2.0, 0.0], [0.0, 0.0, 2.0]).with_range(0.0, 1.4999)),
            None
        );
    }
}
