//! The surface area heuristic, tried between all neighbours along all axes: the best that a greedy top-down builder can
//! do, and slow.
//!
//! MacDonald and Booth, "Heuristics for Ray Tracing Using Space Subdivision", The Visual Computer 1990.

use super::top_down::{Reference, Set, Split, top_down};
use super::{BuildOptions, Topology};
use crate::geom::Aabb;

pub(super) fn build(boxes: &[Aabb], options: &BuildOptions) -> Topology {
    let split = Sweep {
        leaf_limit: options.leaf_limit(),
        primitive_cost: f64::from(options.primitive_cost),
    };
    top_down(boxes, options, &split)
}

struct Sweep {
    leaf_limit: usize,
    primitive_cost: f64,
}

impl Split for Sweep {
    fn split(&self, set: &mut Set<'_>) -> Option<usize> {
        let count = set.refs.len();
        let mut right_areas = vec![0.0; count];
        let mut best: Option<(f64, usize, usize)> = None;
        let mut area = 0.0;
        for axis in 0..3 {
            sort(set.refs, axis);
            let mut bounds = Aabb::EMPTY;
            for i in (1..count).rev() {
                bounds = bounds.union(&set.refs[i].bounds);
                right_areas[i] = bounds.half_area();
            }
            bounds = Aabb::EMPTY;
            for middle in 1..count {
                bounds = bounds.union(&set.refs[middle - 1].bounds);
                let cost = bounds.half_area() * middle as f64
                    + right_areas[middle] * (count - middle) as f64;
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, axis, middle));
                }
            }
            area = bounds.union(&set.refs[count - 1].bounds).half_area();
        }
        let (cost, axis, middle) = best?;
        let split_cost = 1.0 + cost * self.primitive_cost / area;
        // Not `>=`: a NaN of two areas of 0 makes a leaf.
        if count <= self.leaf_limit && !(split_cost < count as f64 * self.primitive_cost) {
            return None;
        }
        sort(set.refs, axis);
        Some(middle)
    }
}

/// By centre; equal centres by number, so that the tree does not depend on the order before.
fn sort(refs: &mut [Reference], axis: usize) {
    refs.sort_unstable_by(|a, b| {
        a.center2_along(axis)
            .total_cmp(&b.center2_along(axis))
            .then(a.prim.cmp(&b.prim))
    });
}
