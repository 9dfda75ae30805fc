//! The lecture's practical solution, by space: the middle of the centres' extent along an axis.

use super::top_down::{Set, Split, top_down};
use super::{AxisRule, BuildOptions, Topology};
use crate::geom::Aabb;

pub(super) fn build(boxes: &[Aabb], options: &BuildOptions) -> Topology {
    top_down(
        boxes,
        options,
        &Midpoint {
            axis: options.axis,
            leaf_limit: options.leaf_limit(),
        },
    )
}

struct Midpoint {
    axis: AxisRule,
    leaf_limit: usize,
}

impl Split for Midpoint {
    /// One side may stay empty (equal centres, or a round-robin axis without extent); the frame then halves.
    fn split(&self, set: &mut Set<'_>) -> Option<usize> {
        if set.refs.len() <= self.leaf_limit {
            return None;
        }
        let centers = set.bounds().1;
        let axis = set.axis(self.axis, &centers);
        let middle = centers.center()[axis];
        Some(set.partition(|r| r.center2_along(axis) < middle))
    }
}
