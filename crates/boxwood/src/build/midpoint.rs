//! The lecture's practical solution, by space: the middle of the centres' extent along an axis.

use super::top_down::{Look, Set, Split, explain as explain_top_down, top_down};
use super::{AxisRule, BuildInput, BuildOptions, BuildWalk, Topology};
use crate::error::BuildError;

pub(super) fn build(
    input: &BuildInput<'_>,
    options: &BuildOptions,
) -> Result<Topology, BuildError> {
    top_down(input, options, &Midpoint::new(input, options))
}

pub(super) fn explain(
    input: &BuildInput<'_>,
    options: &BuildOptions,
    limit: usize,
) -> Result<BuildWalk, BuildError> {
    explain_top_down(input, options, &Midpoint::new(input, options), limit)
}

struct Midpoint {
    axis: AxisRule,
    leaf_limit: usize,
}

impl Midpoint {
    fn new(input: &BuildInput<'_>, options: &BuildOptions) -> Self {
        Self {
            axis: options.axis,
            leaf_limit: input.leaf_limit(options),
        }
    }
}

impl Split for Midpoint {
    /// One side may stay empty (equal centres, or a round-robin axis without extent); the frame then halves.
    fn split(&self, set: &mut Set<'_>) -> Result<Option<usize>, BuildError> {
        if set.refs.len() <= self.leaf_limit {
            return Ok(None);
        }
        let centers = set.centers;
        let axis = set.axis(self.axis, &centers);
        let middle = centers.center()[axis];
        let middle = set.partition(|r| r.center2_along(axis) < middle);
        Ok(Some(middle))
    }

    fn look(&self, set: &mut Set<'_>) -> Result<Look, BuildError> {
        let Some(left) = self.split(set)? else {
            return Ok(Look::NONE);
        };
        let axis = set.axis(self.axis, &set.centers);
        Ok(Look::at(axis, 0.5 * set.centers.center()[axis], left))
    }
}
