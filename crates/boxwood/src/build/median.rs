//! The lecture's practical solution, by count: half of the primitives on each side of an axis.

use super::top_down::{Look, Set, Split, between, explain as explain_top_down, top_down};
use super::{AxisRule, BuildInput, BuildOptions, BuildWalk, Topology};
use crate::error::BuildError;

pub(super) fn build(
    input: &BuildInput<'_>,
    options: &BuildOptions,
) -> Result<Topology, BuildError> {
    top_down(input, options, &Median::new(input, options))
}

pub(super) fn explain(
    input: &BuildInput<'_>,
    options: &BuildOptions,
    limit: usize,
) -> Result<BuildWalk, BuildError> {
    explain_top_down(input, options, &Median::new(input, options), limit)
}

struct Median {
    axis: AxisRule,
    leaf_limit: usize,
}

impl Median {
    fn new(input: &BuildInput<'_>, options: &BuildOptions) -> Self {
        Self {
            axis: options.axis,
            leaf_limit: input.leaf_limit(options),
        }
    }
}

impl Split for Median {
    fn split(&self, set: &mut Set<'_>) -> Result<Option<usize>, BuildError> {
        if set.refs.len() <= self.leaf_limit {
            return Ok(None);
        }
        let axis = set.axis(self.axis, &set.centers);
        Ok(Some(set.halve(axis)))
    }

    fn look(&self, set: &mut Set<'_>) -> Result<Look, BuildError> {
        let Some(middle) = self.split(set)? else {
            return Ok(Look::NONE);
        };
        let axis = set.axis(self.axis, &set.centers);
        Ok(Look::at(axis, between(set.refs, axis, middle), middle))
    }
}
