//! Times and peaks, measured so that they can be compared: contestants take turns, medians count.

use std::{
    hint::black_box,
    time::{Duration, Instant},
};

/// A piece of work, told the number of the round.
pub(crate) type Task<'a> = Box<dyn FnMut(usize) + 'a>;

/// How long each task takes: the median over `rounds`. All tasks take their turn in each round, so that a machine that
/// slows down does so for all. Turns shorter than a time slice of the system, some milliseconds, are the steadiest.
pub(crate) fn interleaved(rounds: usize, tasks: &mut [Task<'_>]) -> Vec<Duration> {
    let mut times = vec![Vec::with_capacity(rounds); tasks.len()];
    for round in 0..rounds {
        for (task, times) in tasks.iter_mut().zip(&mut times) {
            let start = Instant::now();
            task(round);
            times.push(start.elapsed());
        }
    }
    times.into_iter().map(median).collect()
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort_unstable();
    times.get(times.len() / 2).copied().unwrap_or_default()
}

/// Nanoseconds of one piece of work.
pub(crate) fn nanoseconds(time: Duration, pieces: usize) -> f64 {
    time.as_secs_f64() * 1e9 / pieces.max(1) as f64
}

/// Runs `work` where rayon has a single thread.
pub(crate) fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> anyhow::Result<T> {
    Ok(rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()?
        .install(work))
}

/// What this machine can add and multiply.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peak {
    /// 10^9 operations a second on one thread.
    pub(crate) one_thread: f64,
    /// On all threads of the pool.
    pub(crate) all_threads: f64,
    /// Of the pool.
    pub(crate) threads: usize,
}

impl Peak {
    /// What is measured, to be printed beside the numbers.
    pub(crate) const HOW: &str = "single-precision products and sums in a loop over registers, not fused, \
                                  vectorised as the rest of this program";

    /// Measures for some hundredths of a second.
    pub(crate) fn measure() -> Self {
        let threads = rayon::current_num_threads();
        let each = || interleaved(15, &mut [Box::new(|_| multiply_and_add(ROUNDS))])[0];
        let rate = |time: Duration, threads: usize| {
            flops(ROUNDS) * threads as f64 / time.as_secs_f64() / 1e9
        };
        let together = rayon::broadcast(|_| each())
            .into_iter()
            .max()
            .unwrap_or_default();
        Self {
            one_thread: rate(each(), 1),
            all_threads: rate(together, threads),
            threads,
        }
    }
}

/// Enough independent sums to hide the latency of the units, few enough to stay in 16 registers of 4 numbers.
const LANES: usize = 48;
const ROUNDS: usize = 100_000;

fn flops(rounds: usize) -> f64 {
    (2 * LANES * rounds) as f64
}

/// `x = x * a + b`, which tends to `b / (1 - a)` and never overflows.
fn multiply_and_add(rounds: usize) {
    let mut x: [f32; LANES] = black_box(std::array::from_fn(|i| i as f32));
    let (a, b) = (black_box(0.999_f32), black_box(0.001_f32));
    for _ in 0..rounds {
        for x in &mut x {
            *x = *x * a + b;
        }
    }
    black_box(x);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_not_moved_by_an_outlier() {
        let ms = |times: &[u64]| times.iter().map(|t| Duration::from_millis(*t)).collect();
        assert_eq!(median(ms(&[5, 900, 4, 6, 5])), Duration::from_millis(5));
        assert_eq!(median(Vec::new()), Duration::ZERO);
    }

    #[test]
    fn tasks_take_turns() {
        let order = std::cell::RefCell::new(String::new());
        let note = |name: char, round| order.borrow_mut().push_str(&format!("{name}{round} "));
        let mut tasks: [Task<'_>; 2] = [
            Box::new(|round| note('a', round)),
            Box::new(|round| note('b', round)),
        ];
        assert_eq!(interleaved(3, &mut tasks).len(), 2);
        drop(tasks);
        assert_eq!(order.into_inner(), "a0 b0 a1 b1 a2 b2 ");
    }

    #[test]
    fn the_peak_is_one_of_a_computer() {
        let peak = Peak::measure();
        assert!(peak.one_thread > 0.05 && peak.one_thread < 1e4, "{peak:?}");
        assert!(
            peak.all_threads > 0.5 * peak.one_thread && peak.threads > 0,
            "{peak:?}"
        );
    }
}
