//! The lecture's practical solution, by count: half of the primitives on each side of an axis.

use super::top_down::{Set, Split, top_down};
use super::{AxisRule, BuildOptions, Topology};
use crate::geom::Aabb;

pub(super) fn build(boxes: &[Aabb], options: &BuildOptions) -> Topology {
    top_down(
        boxes,
        options,
        &Median {
            axis: options.axis,
            leaf_limit: options.leaf_limit(),
        },
    )
}

struct Median {
    axis: AxisRule,
    leaf_limit: usize,
}

impl Split for Median {
    fn split(&self, set: &mut Set<'_>) -> Option<usize> {
        if set.refs.len() <= self.leaf_limit {
            return None;
        }
        let axis = set.axis(self.axis, &set.bounds().1);
        Some(set.halve(axis))
    }
}
