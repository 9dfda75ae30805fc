//! The axis-aligned bounding box.

use super::float::{max, min};
use super::{MAX_COORDINATE, Sphere, Triangle};

/// A box with sides along the axes. Closed: its faces belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Aabb {
    /// Smallest corner.
    pub min: [f32; 3],
    /// Largest corner.
    pub max: [f32; 3],
}

impl Default for Aabb {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Aabb {
    /// Contains nothing; the neutral element of [`Aabb::union`].
    pub const EMPTY: Self = Self {
        min: [f32::INFINITY; 3],
        max: [f32::NEG_INFINITY; 3],
    };

    /// The lecture's "AABB for a triangle", for any number of points. NaN coordinates are ignored.
    pub fn of_points(points: &[[f32; 3]]) -> Self {
        points.iter().fold(Self::EMPTY, |bounds, &p| {
            bounds.union(&Self { min: p, max: p })
        })
    }

    /// The lecture's "AABB for a triangle".
    #[inline]
    pub fn of_triangle(triangle: &Triangle) -> Self {
        let [a, b, c] = triangle.0;
        Self {
            min: [0, 1, 2].map(|k| min(min(a[k], b[k]), c[k])),
            max: [0, 1, 2].map(|k| max(max(a[k], b[k]), c[k])),
        }
    }

    /// The lecture's "AABB for a sphere": centre minus and plus radius, rounded outward. Empty for an empty sphere.
    pub fn of_sphere(sphere: &Sphere) -> Self {
        if !(sphere.radius >= 0.0) {
            return Self::EMPTY;
        }
        Self {
            min: sphere.center.map(|c| (c - sphere.radius).next_down()),
            max: sphere.center.map(|c| (c + sphere.radius).next_up()),
        }
    }

    /// The lecture's "AABB for a collection of AABBs".
    pub fn of_boxes<'a>(boxes: impl IntoIterator<Item = &'a Self>) -> Self {
        boxes.into_iter().fold(Self::EMPTY, |all, b| all.union(b))
    }

    /// The smallest box around both.
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: [0, 1, 2].map(|k| min(self.min[k], other.min[k])),
            max: [0, 1, 2].map(|k| max(self.max[k], other.max[k])),
        }
    }

    /// True if no point is inside, also when a bound is NaN.
    #[inline]
    pub fn is_empty(&self) -> bool {
        !(0..3).all(|k| self.min[k] <= self.max[k])
    }

    /// True if there is something inside and nothing beyond [`MAX_COORDINATE`]: what can be hit.
    pub fn is_in_domain(&self) -> bool {
        let corners = self.min.iter().chain(&self.max);
        !self.is_empty() && corners.into_iter().all(|x| x.abs() <= MAX_COORDINATE)
    }

    /// True if the point is inside or on a face.
    pub fn contains(&self, point: [f32; 3]) -> bool {
        (0..3).all(|k| self.min[k] <= point[k] && point[k] <= self.max[k])
    }

    /// True if `other` lies inside, faces included.
    pub fn contains_box(&self, other: &Self) -> bool {
        (0..3).all(|k| self.min[k] <= other.min[k] && other.max[k] <= self.max[k])
    }

    /// Midpoint.
    #[inline]
    pub fn center(&self) -> [f32; 3] {
        std::array::from_fn(|k| 0.5 * self.min[k] + 0.5 * self.max[k])
    }

    /// Side lengths; negative for the empty box.
    #[inline]
    pub fn extent(&self) -> [f32; 3] {
        std::array::from_fn(|k| self.max[k] - self.min[k])
    }

    /// Half the surface area, which is what the surface area heuristic compares. 0 for the empty box. Double
    /// precision, so that boxes of 1e30 do not overflow.
    #[inline]
    pub fn half_area(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let [x, y, z] = self.extent().map(f64::from);
        x * y + y * z + z * x
    }

    /// Surface area.
    pub fn surface_area(&self) -> f64 {
        2.0 * self.half_area()
    }

    /// Volume; 0 for the empty box.
    pub fn volume(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let [x, y, z] = self.extent().map(f64::from);
        x * y * z
    }

    /// Length of the space diagonal; 0 for the empty box.
    pub fn diagonal(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        self.extent()
            .map(|x| f64::from(x) * f64::from(x))
            .iter()
            .sum::<f64>()
            .sqrt()
    }

    /// All eight corners.
    pub fn corners(&self) -> [[f32; 3]; 8] {
        let bounds = [self.min, self.max];
        std::array::from_fn(|i| std::array::from_fn(|k| bounds[i >> k & 1][k]))
    }

    /// Largest coordinate distance from `point` to a corner: the scale of rounding errors of anything in this
    /// box as seen from there. Monotone: never smaller for a box around this one.
    #[inline]
    pub fn reach(&self, point: [f32; 3]) -> f32 {
        let mut reach = 0.0_f32;
        for k in 0..3 {
            reach = reach
                .max((self.min[k] - point[k]).abs())
                .max((self.max[k] - point[k]).abs());
        }
        reach
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CROOKED: Aabb = Aabb {
        min: [1.0, -2.0, 0.5],
        max: [2.0, 1.5, 4.5],
    };

    #[test]
    fn area_and_volume_of_a_crooked_box() {
        assert_eq!(
            CROOKED.surface_area(),
            2.0 * (1.0 * 3.5 + 3.5 * 4.0 + 4.0 * 1.0)
        );
        assert_eq!(CROOKED.volume(), 14.0);
        assert_eq!(Aabb::EMPTY.surface_area(), 0.0);
    }

    #[test]
    fn box_of_a_sphere_contains_its_poles() {
        let sphere = Sphere {
            center: [1e6, -3.3, 0.1],
            radius: 0.7,
        };
        let bounds = Aabb::of_sphere(&sphere);
        for k in 0..3 {
            assert!(
                f64::from(bounds.min[k]) <= f64::from(sphere.center[k]) - f64::from(sphere.radius)
            );
            assert!(
                f64::from(bounds.max[k]) >= f64::from(sphere.center[k]) + f64::from(sphere.radius)
            );
        }
    }

    #[test]
    fn union_contains_both_and_empty_is_neutral() {
        let other = Aabb::of_points(&[[5.0, 0.0, 1.0], [6.0, 1.0, -1.0]]);
        let both = Aabb::of_boxes([&CROOKED, &other]);
        assert!(both.contains_box(&CROOKED) && both.contains_box(&other));
        assert_eq!(CROOKED.union(&Aabb::EMPTY), CROOKED);
    }

    #[test]
    fn corners_are_eight_different_points_of_the_box() {
        let corners = CROOKED.corners();
        for (i, a) in corners.iter().enumerate() {
            assert!(CROOKED.contains(*a));
            assert!(corners[..i].iter().all(|b| a != b));
        }
    }
}
