//! Parts of primitives, for builders that split them.

use crate::geom::{Aabb, Triangle};

/// Primitives that can be taken apart.
pub trait Parts: Sync {
    /// A box around the part of a primitive that lies in a box: at least that part, at most the box; empty if there is
    /// none. The exact test of the primitive must be such that `t` is right for the place where it is hit, however grazing
    /// the ray.
    fn clip(&self, index: u32, cell: &Aabb) -> Aabb;

    /// Half the area of its boxes if it were split without end: the sum of its projections along the axes.
    fn least_area(&self, index: u32) -> f32;
}

/// [`Parts::clip`] of a triangle: Sutherland and Hodgman, "Reentrant Polygon Clipping", CACM 1974, in double precision and
/// rounded outward.
pub(super) fn clip_triangle(triangle: &Triangle, cell: &Aabb) -> Aabb {
    // Each of six planes adds at most one corner.
    let mut corners = [[0.0f64; 3]; 9];
    let mut count = 3;
    for (to, from) in corners.iter_mut().zip(&triangle.0) {
        *to = from.map(f64::from);
    }
    for axis in 0..3 {
        for (sign, plane) in [(1.0, cell.min[axis]), (-1.0, cell.max[axis])] {
            count = clip_at(&mut corners, count, |p| sign * (p[axis] - f64::from(plane)));
        }
    }
    let mut bounds = Aabb::EMPTY;
    for corner in &corners[..count] {
        for k in 0..3 {
            bounds.min[k] = bounds.min[k].min((corner[k] as f32).next_down());
            bounds.max[k] = bounds.max[k].max((corner[k] as f32).next_up());
        }
    }
    for k in 0..3 {
        bounds.min[k] = bounds.min[k].max(cell.min[k]);
        bounds.max[k] = bounds.max[k].min(cell.max[k]);
    }
    bounds
}

/// Keeps what of a polygon is on the side where `distance` is not negative; returns its new number of corners.
fn clip_at(
    corners: &mut [[f64; 3]; 9],
    count: usize,
    distance: impl Fn(&[f64; 3]) -> f64,
) -> usize {
    let old = *corners;
    let mut kept = 0;
    let mut keep = |corner: [f64; 3]| {
        if let Some(place) = corners.get_mut(kept) {
            *place = corner;
            kept += 1;
        }
    };
    for i in 0..count {
        let (a, b) = (old[i], old[(i + 1) % count]);
        let (da, db) = (distance(&a), distance(&b));
        if da >= 0.0 {
            keep(a);
        }
        if (da < 0.0) != (db < 0.0) {
            let s = da / (da - db);
            keep(std::array::from_fn(|k| a[k] + s * (b[k] - a[k])));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slanted_triangle_fills_only_a_part_of_the_cell() {
        let triangle = Triangle([[0.0, 0.0, 0.0], [8.0, 0.0, 4.0], [0.0, 8.0, 4.0]]);
        let cell = Aabb {
            min: [2.0, -1.0, -1.0],
            max: [4.0, 9.0, 9.0],
        };
        let part = clip_triangle(&triangle, &cell);
        let expected = Aabb {
            min: [2.0, 0.0, 1.0],
            max: [4.0, 6.0, 4.0],
        };
        assert!(part.contains_box(&expected));
        for k in 0..3 {
            assert!((part.min[k] - expected.min[k]).abs() < 1e-6);
            assert!((part.max[k] - expected.max[k]).abs() < 1e-6);
        }
        let beside = Aabb {
            min: [7.0, 7.0, 0.0],
            max: [8.0, 8.0, 4.0],
        };
        assert!(clip_triangle(&triangle, &beside).is_empty());
    }
}
