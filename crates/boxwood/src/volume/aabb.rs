//! The axis-aligned box as a bounding volume.

use super::BoundingVolume;
use crate::geom::{Aabb, AabbPair, Interval, PreparedRay, SlabRay, Sphere};

impl BoundingVolume for Aabb {
    const NAME: &'static str = "aabb";
    /// Per axis 2 subtractions, 2 products, 2 minima and maxima to order; 4 to intersect the slabs, 2 to cut with the ray's
    /// range.
    const FLOPS: u32 = 24;
    const UNION_IS_TIGHT: bool = true;

    type Ray = SlabRay;
    type Pair = AabbPair;

    fn of_points(points: &[[f32; 3]]) -> Self {
        Self::of_points(points)
    }

    fn of_sphere(sphere: &Sphere) -> Self {
        Self::of_sphere(sphere)
    }

    fn of_volumes(volumes: &[Self]) -> Self {
        Self::of_boxes(volumes)
    }

    fn of_aabb(bounds: &Aabb) -> Self {
        *bounds
    }

    #[inline]
    fn prepare(ray: &PreparedRay, bounds: &Aabb) -> SlabRay {
        SlabRay::new(ray, bounds)
    }

    #[inline]
    fn interval(&self, ray: &SlabRay) -> Interval {
        ray.interval(self)
    }

    fn pair(a: &Self, b: &Self) -> AabbPair {
        AabbPair::new(a, b)
    }

    fn of_pair(pair: &AabbPair) -> [Self; 2] {
        pair.boxes()
    }

    #[inline]
    fn pair_intervals(pair: &AabbPair, ray: &SlabRay) -> [Interval; 2] {
        let [near, far] = ray.pair(pair);
        [
            Interval {
                near: near.x,
                far: far.x,
            },
            Interval {
                near: near.y,
                far: far.y,
            },
        ]
    }

    fn surface_area(&self) -> f64 {
        self.surface_area()
    }

    fn volume(&self) -> f64 {
        self.volume()
    }

    fn bounds(&self) -> Aabb {
        *self
    }

    fn contains(&self, point: [f32; 3], slack: f32) -> bool {
        (0..3).all(|k| self.min[k] - slack <= point[k] && point[k] <= self.max[k] + slack)
    }
}
