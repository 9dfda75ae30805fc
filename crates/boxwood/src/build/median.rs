//! The lecture's practical solution, by count: half of the primitives on each side of an axis.

use super::top_down::{Set, Split, top_down};
use super::{AxisRule, BuildInput, BuildOptions, Topology};
use crate::error::BuildError;

pub(super) fn build(
    input: &BuildInput<'_>,
    options: &BuildOptions,
) -> Result<Topology, BuildError> {
    top_down(
        input,
        options,
        &Median {
            axis: options.axis,
            leaf_limit: input.leaf_limit(options),
        },
    )
}

struct Median {
    axis: AxisRule,
    leaf_limit: usize,
}

impl Split for Median {
    fn split(&self, set: &mut Set<'_>) -> Result<Option<usize>, BuildError> {
        if set.refs.len() <= self.leaf_limit {
            return Ok(None);
        }
        let axis = set.axis(self.axis, &set.centers);
        Ok(Some(set.halve(axis)))
    }
}
