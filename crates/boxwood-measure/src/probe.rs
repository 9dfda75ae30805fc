//! What this machine can do at best, found out in a second or two.

use crate::{clock::Clock, machine::Machine, rounds::interleaved};
use serde::{Deserialize, Serialize};
use std::{hint::black_box, time::Duration};

/// The constants of the floor model ([`crate::floor`]). Times are of one thread while it has a processor, the shortest of several
/// tries; what others do to shared caches and to the clock is in them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Probe {
    /// Nanoseconds of a clock cycle: half of an exclusive or and a sum that wait for each other.
    pub cycle_ns: f64,
    /// Nanoseconds of a load that the next one waits for, from the first cache.
    pub l1_ns: f64,
    /// From the second.
    pub l2_ns: f64,
    /// From the third; from memory where there is none.
    pub l3_ns: f64,
    /// From memory, on small pages.
    pub dram_ns: f64,
    /// Nanoseconds per line from memory, eight chains of loads at once.
    pub dram_parallel_ns: f64,
    /// 10^9 products and sums a second, not fused, vectorised as this program was compiled.
    pub gflops: f64,
    /// Bytes of the second cache.
    pub l2_bytes: u64,
    /// Bytes of the third.
    pub l3_bytes: u64,
    /// Bits of a vector that kernels work on.
    pub vector_bits: u32,
}

/// As on most processors of the last ten years, where the system does not say.
const USUAL_CACHES: [u64; 3] = [32 << 10, 512 << 10, 8 << 20];
/// Bytes of a cache line.
pub(crate) const LINE: u64 = 64;
/// Chains of loads that run at once.
const CHAINS: usize = 8;
/// Of each walk along them. Who shares the caches with us comes and goes.
const TRIES: usize = 9;

impl Probe {
    /// Measures for a second or two.
    pub fn measure(machine: &Machine) -> Self {
        let [l1, l2, l3] = [0, 1, 2].map(|k| machine.caches[k].unwrap_or(USUAL_CACHES[k]));
        // Well inside of a cache, but well outside of the one below it.
        let in_l3 = Chain::new((l3 / 4).max(l2 * 2));
        let memory = Chain::new((l3 * 4).clamp(64 << 20, 256 << 20));
        Self {
            cycle_ns: cycle(),
            l1_ns: Chain::new(l1 / 2).latency(),
            l2_ns: Chain::new(l2 / 2).latency(),
            l3_ns: in_l3.latency(),
            dram_ns: memory.latency(),
            dram_parallel_ns: memory.latency_at_once(),
            gflops: Peak::measure_one_thread(),
            l2_bytes: l2,
            l3_bytes: l3,
            vector_bits: machine.vector_bits(),
        }
    }

    /// Nanoseconds of so many cycles.
    pub(crate) fn cycles(&self, cycles: f64) -> f64 {
        cycles * self.cycle_ns
    }
}

/// The shortest of several tries, while this thread has a processor: what disturbs only makes things slower.
fn shortest(tries: usize, mut work: impl FnMut()) -> f64 {
    let mut time = || {
        let start = Clock::Thread.now();
        work();
        (Clock::Thread.now() - start).as_secs_f64()
    };
    (0..tries).map(|_| time()).fold(f64::INFINITY, f64::min)
}

fn cycle() -> f64 {
    const STEPS: usize = 1 << 20;
    let (a, b) = (black_box(0x5BD1_E995_u64), black_box(0x9E37_79B9_u64));
    let time = shortest(32, || {
        let mut x = black_box(1_u64);
        for _ in 0..STEPS {
            // Each a cycle, and no two of them can be made one.
            x = (x ^ a).wrapping_add(b);
        }
        black_box(x);
    });
    time * 1e9 / (2 * STEPS) as f64
}

/// Lines of memory, each naming the next, in one cycle that visits all in random order.
struct Chain(Vec<[u32; LINE as usize / 4]>);

impl Chain {
    /// By the algorithm of Sattolo (1986).
    fn new(bytes: u64) -> Self {
        let count = (bytes / LINE).max(16) as usize;
        let mut lines: Vec<_> = (0..count as u32).map(|i| [i; LINE as usize / 4]).collect();
        let mut state = 1_u64;
        for i in (1..count).rev() {
            state = state
                .wrapping_mul(0x5851_F42D_4C95_7F2D)
                .wrapping_add(0x1405_7B7E_F767_814F);
            lines.swap(i, (state >> 33) as usize % i);
        }
        Self(lines)
    }

    /// Nanoseconds of a load that the next one waits for.
    fn latency(&self) -> f64 {
        let steps = self.steps();
        let mut at = 0;
        self.walk(&mut [at], steps / 4);
        let time = shortest(TRIES, || {
            let mut chain = [at];
            self.walk(&mut chain, steps);
            at = chain[0];
        });
        time * 1e9 / steps as f64
    }

    /// Nanoseconds per load, [`CHAINS`] of them at once.
    fn latency_at_once(&self) -> f64 {
        let steps = self.steps();
        let mut chains: [u32; CHAINS] = std::array::from_fn(|i| (i * self.0.len() / CHAINS) as u32);
        let time = shortest(TRIES, || self.walk(&mut chains, steps));
        time * 1e9 / (steps * CHAINS) as f64
    }

    /// All lines of a small chain several times, of a large one a part.
    fn steps(&self) -> usize {
        (self.0.len() * 4).clamp(1 << 16, 1 << 18)
    }

    fn walk<const N: usize>(&self, chains: &mut [u32; N], steps: usize) {
        let mut at = black_box(*chains);
        for _ in 0..steps {
            for at in &mut at {
                *at = self.0[*at as usize][0];
            }
        }
        *chains = black_box(at);
    }
}

/// What this machine can add and multiply.
#[derive(Clone, Copy, Debug)]
pub struct Peak {
    /// 10^9 operations a second on one thread.
    pub one_thread: f64,
    /// On all threads of the pool.
    pub all_threads: f64,
    /// Of the pool.
    pub threads: usize,
}

impl Peak {
    /// What is measured, to be printed beside the numbers.
    pub const HOW: &str = "single-precision products and sums in a loop over registers, not fused, \
                           vectorised as the rest of this program";

    /// Measures for some hundredths of a second, on the threads of the caller's rayon pool.
    pub fn measure() -> Self {
        let threads = rayon::current_num_threads();
        let together = rayon::broadcast(|_| each(Clock::Wall))
            .into_iter()
            .max()
            .unwrap_or_default();
        Self {
            one_thread: Self::measure_one_thread(),
            all_threads: rate(together, threads),
            threads,
        }
    }

    fn measure_one_thread() -> f64 {
        rate(each(Clock::Thread), 1)
    }
}

fn each(clock: Clock) -> Duration {
    interleaved(clock, 15, &mut [Box::new(|_| multiply_and_add(ROUNDS))])[0]
}

fn rate(time: Duration, threads: usize) -> f64 {
    (2 * LANES * ROUNDS * threads) as f64 / time.as_secs_f64() / 1e9
}

/// Enough independent sums to hide the latency of the units, few enough to stay in 16 registers of 4 numbers.
const LANES: usize = 48;
const ROUNDS: usize = 100_000;

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
    fn a_chain_visits_every_line_once() {
        let chain = Chain::new(100 * LINE);
        let mut seen = [false; 100];
        let mut at = [0];
        for _ in 0..100 {
            assert!(!std::mem::replace(&mut seen[at[0] as usize], true));
            chain.walk(&mut at, 1);
        }
        assert_eq!(at, [0]);
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

    #[test]
    fn the_farther_the_memory_the_longer_the_wait() {
        let probe = Probe::measure(&Machine::seen());
        assert!(probe.cycle_ns > 0.05 && probe.cycle_ns < 10.0, "{probe:?}");
        assert!(
            probe.l1_ns < probe.dram_ns && probe.l2_ns < probe.dram_ns,
            "{probe:?}"
        );
        assert!(probe.dram_parallel_ns < probe.dram_ns, "{probe:?}");
    }
}
