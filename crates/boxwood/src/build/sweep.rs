//! The surface area heuristic, tried between all neighbours along all axes: the best that a greedy top-down builder can
//! do, and slow.
//!
//! MacDonald and Booth, "Heuristics for Ray Tracing Using Space Subdivision", The Visual Computer 1990.

use super::input::filled;
use super::top_down::{
    Look, Reference, Set, Split, between, explain as explain_top_down, top_down,
};
use super::{BuildInput, BuildOptions, BuildWalk, Plane, Topology};
use crate::error::BuildError;
use crate::geom::Aabb;

pub(super) fn build(
    input: &BuildInput<'_>,
    options: &BuildOptions,
) -> Result<Topology, BuildError> {
    top_down(input, options, &Sweep::new(input, options))
}

pub(super) fn explain(
    input: &BuildInput<'_>,
    options: &BuildOptions,
    limit: usize,
) -> Result<BuildWalk, BuildError> {
    explain_top_down(input, options, &Sweep::new(input, options), limit)
}

struct Sweep {
    leaf_limit: usize,
    primitive_cost: f64,
}

impl Sweep {
    fn new(input: &BuildInput<'_>, options: &BuildOptions) -> Self {
        Self {
            leaf_limit: input.leaf_limit(options),
            primitive_cost: f64::from(options.primitive_cost),
        }
    }

    /// Calls `weigh` with the sorted set, the axis, the length of the left part, and the sum of half area times count over
    /// both parts, for every split; returns half the area of the set.
    #[inline]
    fn try_all(
        refs: &mut [Reference],
        mut weigh: impl FnMut(&[Reference], usize, usize, f64),
    ) -> Result<f64, BuildError> {
        let count = refs.len();
        let mut right_areas = filled(0.0, count)?;
        let mut area = 0.0;
        for axis in 0..3 {
            sort(refs, axis);
            let mut bounds = Aabb::EMPTY;
            for i in (1..count).rev() {
                bounds = bounds.union(&refs[i].bounds);
                right_areas[i] = bounds.half_area();
            }
            bounds = Aabb::EMPTY;
            for middle in 1..count {
                bounds = bounds.union(&refs[middle - 1].bounds);
                let cost = bounds.half_area() * middle as f64
                    + right_areas[middle] * (count - middle) as f64;
                weigh(refs, axis, middle, cost);
            }
            area = bounds.union(&refs[count - 1].bounds).half_area();
        }
        Ok(area)
    }

    /// From such a sum to the cost of a split, where a node costs 1.
    fn split_cost(&self, cost: f64, area: f64) -> f64 {
        1.0 + cost * self.primitive_cost / area
    }
}

/// Planes along an axis that are told, about.
const TOLD: usize = 64;

impl Split for Sweep {
    fn split(&self, set: &mut Set<'_>) -> Result<Option<usize>, BuildError> {
        let count = set.refs.len();
        let mut best: Option<(f64, usize, usize)> = None;
        let area = Self::try_all(set.refs, |_, axis, middle, cost| {
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, middle));
            }
        })?;
        let Some((cost, axis, middle)) = best else {
            return Ok(None);
        };
        let split_cost = self.split_cost(cost, area);
        // Not `>=`: a NaN of two areas of 0 makes a leaf.
        if count <= self.leaf_limit && !(split_cost < count as f64 * self.primitive_cost) {
            return Ok(None);
        }
        sort(set.refs, axis);
        Ok(Some(middle))
    }

    fn look(&self, set: &mut Set<'_>) -> Result<Look, BuildError> {
        let count = set.refs.len();
        let stride = count.div_ceil(TOLD);
        let mut told: Vec<(f64, Plane)> = Vec::new();
        let mut best: Option<(f64, Plane)> = None;
        let area = Self::try_all(set.refs, |refs, axis, middle, cost| {
            let is_better = best.is_none_or(|(least, _)| cost < least);
            if is_better || middle % stride == 0 {
                let plane = Plane {
                    axis,
                    // Sorted: the centres beside the border are those of the neighbours.
                    at: between(&refs[middle - 1..=middle], axis, 1),
                    left: middle as u32,
                    cost: None,
                };
                best = if is_better { Some((cost, plane)) } else { best };
                if middle % stride == 0 {
                    told.push((cost, plane));
                }
            }
        })?;
        let weighed = |(cost, plane): (f64, Plane)| Plane {
            cost: Some(self.split_cost(cost, area) as f32).filter(|cost| cost.is_finite()),
            ..plane
        };
        let best = best.map(weighed);
        let mut planes: Vec<Plane> = told.into_iter().map(weighed).collect();
        if let Some(best) = best.filter(|best| !planes.contains(best)) {
            let at = planes.partition_point(|p| (p.axis, p.left) < (best.axis, best.left));
            planes.insert(at, best);
        }
        Ok(Look {
            planes,
            weighed: 3 * (count - 1),
            best,
            leaf_cost: Some((count as f64 * self.primitive_cost) as f32),
        })
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
