//! Times that can be compared: contestants take turns, medians count. The timing itself is `boxwood-measure`'s.

use std::time::Duration;

pub(crate) use boxwood_measure::{Clock, Peak, Task, interleaved};

/// Nanoseconds of one piece of work.
pub(crate) fn nanoseconds(time: Duration, pieces: usize) -> f64 {
    time.as_secs_f64() * 1e9 / pieces.max(1) as f64
}

/// Runs `work` where rayon has a single thread.
pub(crate) fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> anyhow::Result<T> {
    Ok(boxwood_measure::with_threads(1, work)?)
}
