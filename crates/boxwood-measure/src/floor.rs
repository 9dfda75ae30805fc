//! The floor: an estimate of what a ray must cost on this machine, given the nodes and leaves that it visits.
//!
//! A figure alone does not say whether there is more to win; as a part of the floor it does. The floor is a bound by
//! arithmetic, by waiting and by memory, whichever is highest. It counts no bookkeeping and little of what branches cost: well-made
//! batches come to a third or half of it. It is no proof: it assumes what a core can do in a cycle, which part of the lines a cache
//! misses, and how many lines of memory are fetched at once. Whoever fetches more of them than that, or finds more in the caches,
//! comes out above 1, which says that the estimate is too high there.
//!
//! Costs are in clock cycles of a core with two 256-bit loads and two 256-bit products per cycle, as most have had since 2015
//! (Fog, "Instruction tables", 2024); vectors of half the width take twice as long. One node test is of eight boxes, one leaf
//! block is of up to eight triangles by the exact test.
//!
//! | bound | cycles | holds for |
//! |---|---|---|
//! | throughput | 5 n + 13 l + 30 | batches: other rays fill every gap |
//! | shared throughput | 6 n / 64 + 2.2 n / 8 + 7 p / 8 + 15 | batches whose rays go the same way, 64 at a time, 8 to a test |
//! | latency, the way foreseen | 6 n + 20 l + 40 | single rays that go the way of the one before |
//! | latency, half of it foreseen | 6 n + 20 l + 40 + 21 n / 2 | single rays that go their own way: a mispredicted branch every other node |
//! | memory | missed lines times their latency, 2 (single) or 10 (batch) at once | rays that go their own way |
//!
//! with n node tests, l leaf blocks, p primitive tests per ray. Missed lines: every level of a tree is met about once by a
//! ray, so that the part of the lines that miss a cache of C bytes is log(B / C) / log(B / line) for a structure of B bytes.

use crate::{contender::Mode, probe::LINE, probe::Probe};
use boxwood::Counts;
use serde::{Deserialize, Serialize};

/// What a ray costs on average, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Work {
    /// Tests of nodes; a test of fewer than four boxes counts as half of one, as two fit a vector.
    pub nodes: f64,
    /// Blocks of up to eight primitives.
    pub leaves: f64,
    /// Bounding volumes.
    pub boxes: f64,
    /// Primitives.
    pub prims: f64,
    /// Bytes read, cached or not.
    pub bytes: f64,
}

impl Work {
    /// Per ray, where a leaf has `leaf_size` primitives on average.
    pub fn of(counts: &Counts, leaf_size: f64) -> Self {
        let per_ray = |sum: u64| sum as f64 / counts.rays.max(1) as f64;
        let [nodes, boxes, prims] = [counts.nodes, counts.boxes, counts.prims].map(per_ray);
        let leaves = prims / leaf_size.max(1.0);
        // Entered nodes are inner ones and leaves; a grid has cells instead, and tests no boxes.
        let inner = (nodes - leaves).max(0.0);
        Self {
            nodes: if boxes > 0.0 {
                inner.min(boxes / 4.0)
            } else {
                inner
            },
            leaves: (prims / 8.0).max(leaves.min(prims)),
            boxes,
            prims,
            bytes: per_ray(counts.bytes),
        }
    }
}

/// How rays are asked, as far as the floor knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct How {
    /// One or many at a time.
    pub mode: Mode,
    /// Whether neighbours go the same way.
    pub coherent: bool,
}

/// Nanoseconds per ray on one thread that a program must take for this work, by estimate; of `structure` bytes in memory.
pub fn floor(work: &Work, structure: u64, how: How, probe: &Probe) -> f64 {
    let compute = probe.cycles(cycles(work, how) * 256.0 / f64::from(probe.vector_bits.min(256)));
    compute.max(memory(work, structure, how, probe))
}

fn cycles(work: &Work, how: How) -> f64 {
    let Work {
        nodes: n,
        leaves: l,
        prims: p,
        ..
    } = *work;
    match (how.mode, how.coherent) {
        (Mode::Batch, false) => 5.0 * n + 13.0 * l + 30.0,
        (Mode::Batch, true) => 6.0 * n / 64.0 + 2.2 * n / 8.0 + 7.0 * p / 8.0 + 15.0,
        (Mode::Single, true) => 6.0 * n + 20.0 * l + 40.0,
        (Mode::Single, false) => 6.0 * n + 20.0 * l + 40.0 + 21.0 * n / 2.0,
    }
}

/// Neighbours on the same way find what they need in the first caches.
fn memory(work: &Work, structure: u64, how: How, probe: &Probe) -> f64 {
    if how.coherent {
        return 0.0;
    }
    let lines = work.bytes / LINE as f64;
    let far = lines * missing(structure, probe.l3_bytes);
    let near = lines * missing(structure, probe.l2_bytes) - far;
    match how.mode {
        // A processor looks ahead of a single ray a little.
        Mode::Single => (far * probe.dram_ns + near * probe.l3_ns) / 2.0,
        Mode::Batch => far * probe.dram_parallel_ns + near * probe.l3_ns / 10.0,
    }
}

/// The part of the lines that a cache of `cache` bytes misses.
fn missing(structure: u64, cache: u64) -> f64 {
    let log = |bytes: u64| (bytes.max(1) as f64).log2();
    let (levels, beyond) = (log(structure) - log(LINE), log(structure) - log(cache));
    if beyond > 0.0 { beyond / levels } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A Zen 4 virtual machine of 3.7 GHz.
    const PROBE: Probe = Probe {
        cycle_ns: 0.27,
        l1_ns: 1.1,
        l2_ns: 4.3,
        l3_ns: 14.9,
        dram_ns: 224.0,
        dram_parallel_ns: 20.0,
        gflops: 50.0,
        l2_bytes: 1 << 20,
        l3_bytes: 4 << 20,
        vector_bits: 256,
    };
    const BATCH: How = How {
        mode: Mode::Batch,
        coherent: false,
    };
    const SINGLE: How = How {
        mode: Mode::Single,
        coherent: false,
    };

    /// The prototype's random rays through 300,000 triangles, which took 1576 cycles as a sorted batch.
    const SOUP: Work = Work {
        nodes: 17.5,
        leaves: 7.5,
        boxes: 140.0,
        prims: 40.0,
        bytes: 64.0 * 112.0,
    };

    #[test]
    fn the_prototype_that_the_model_was_made_from_stays_above_its_floor() {
        assert!((cycles(&SOUP, BATCH) - 215.0).abs() < 1.0);
        let floor = floor(&SOUP, 23 << 20, BATCH, &PROBE) / PROBE.cycle_ns;
        assert!((900.0..1576.0).contains(&floor), "{floor} cycles");
    }

    #[test]
    fn in_cache_it_is_arithmetic_and_beyond_it_is_memory() {
        let small = floor(&SOUP, 1 << 19, BATCH, &PROBE);
        assert!((small / PROBE.cycle_ns - 215.0).abs() < 1.0);
        assert!(floor(&SOUP, 64 << 20, BATCH, &PROBE) > 3.0 * small);
        assert!(floor(&SOUP, 1 << 19, SINGLE, &PROBE) > 2.0 * small);
    }

    #[test]
    fn half_the_vector_is_twice_the_time() {
        let narrow = Probe {
            vector_bits: 128,
            ..PROBE
        };
        let wide = floor(&SOUP, 1000, BATCH, &PROBE);
        assert!((floor(&SOUP, 1000, BATCH, &narrow) - 2.0 * wide).abs() < 1e-9);
    }

    #[test]
    fn counts_become_nodes_and_leaf_blocks_per_ray() {
        let counts = Counts {
            rays: 10,
            nodes: 200,
            boxes: 1200,
            prims: 150,
            flops: 0,
            bytes: 64_000,
            ..Counts::default()
        };
        // An eight-wide tree: 1.5 primitives to a leaf, so 10 leaves and 10 inner nodes of 12 boxes.
        let wide = Work::of(&counts, 1.5);
        assert_eq!((wide.nodes, wide.leaves, wide.bytes), (10.0, 10.0, 6400.0));
        // A binary one: two boxes to a node.
        let binary = Work::of(
            &Counts {
                boxes: 20 * 10,
                ..counts
            },
            1.5,
        );
        assert_eq!(binary.nodes, 5.0);
        // Brute force: all in blocks of eight.
        let list = Work::of(
            &Counts {
                nodes: 0,
                boxes: 0,
                ..counts
            },
            150.0,
        );
        assert_eq!((list.nodes, list.leaves), (0.0, 15.0 / 8.0));
        assert_eq!(Work::of(&Counts::default(), 1.0), Work::default());
    }
}
