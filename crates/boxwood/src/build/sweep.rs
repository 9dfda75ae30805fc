//! The surface area heuristic, tried between all neighbours along all axes: the best that a greedy top-down builder can
//! do, and slow.
//!
//! MacDonald and Booth, "Heuristics for Ray Tracing Using Space Subdivision", The Visual Computer 1990.

use super::input::filled;
use super::top_down::{Reference, Set, Split, top_down};
use super::{BuildInput, BuildOptions, Topology};
use crate::error::BuildError;
use crate::geom::Aabb;

pub(super) fn build(
    input: &BuildInput<'_>,
    options: &BuildOptions,
) -> Result<Topology, BuildError> {
    let split = Sweep {
        leaf_limit: input.leaf_limit(options),
        primitive_cost: f64::from(options.primitive_cost),
    };
    top_down(input, options, &split)
}

struct Sweep {
    leaf_limit: usize,
    primitive_cost: f64,
}

impl Split for Sweep {
    fn split(&self, set: &mut Set<'_>) -> Result<Option<usize>, BuildError> {
        let count = set.refs.len();
        let mut right_areas = filled(0.0, count)?;
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
        let Some((cost, axis, middle)) = best else {
            return Ok(None);
        };
        let split_cost = 1.0 + cost * self.primitive_cost / area;
        // Not `>=`: a NaN of two areas of 0 makes a leaf.
        if count <= self.leaf_limit && !(split_cost < count as f64 * self.primitive_cost) {
            return Ok(None);
        }
        sort(set.refs, axis);
        Ok(Some(middle))
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
