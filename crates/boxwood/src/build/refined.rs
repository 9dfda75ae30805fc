//! The slow build of the best trees: binned, with more of what improves it than by default.

use super::{BuildInput, BuildOptions, BuildWalk, Topology, binned};
use crate::error::BuildError;

/// At least so much is spent, more if the options say so.
fn refined(options: &BuildOptions) -> BuildOptions {
    BuildOptions {
        rounds: options.rounds.max(8),
        round_share: options.round_share.max(0.25),
        split_budget: options.split_budget.max(0.3),
        ..options.clone()
    }
}

pub(super) fn build(
    input: &BuildInput<'_>,
    options: &BuildOptions,
) -> Result<Topology, BuildError> {
    binned::build(input, &refined(options))
}

pub(super) fn explain(
    input: &BuildInput<'_>,
    options: &BuildOptions,
    limit: usize,
) -> Result<BuildWalk, BuildError> {
    binned::explain(input, &refined(options), limit)
}

pub(super) fn memory(count: usize, options: &BuildOptions) -> usize {
    binned::memory(count, &refined(options))
}
