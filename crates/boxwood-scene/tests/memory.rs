//! No bad file costs more than two seconds and six times its size plus 64 MiB, and no good one more memory than that.
//!
//! A binary of its own, with one test, since it counts every allocation of the process.
#![expect(
    unsafe_code,
    reason = "a global allocator that counts can't be written without"
)]

#[path = "support/allocator.rs"]
mod allocator;
mod support;

use std::path::Path;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

use allocator::{HELD, PEAK};
use boxwood_scene::load;
use support::{Manifest, scenes};

#[test]
fn time_and_memory_are_bounded() {
    let Some(folder) = scenes() else { return };
    let mut failures = Vec::new();
    for (manifest, seconds) in [("bad/MANIFEST.tsv", 2), ("MANIFEST.tsv", 20)] {
        Manifest::read(folder.join(manifest)).for_each_row(|cell| {
            let file = cell("file");
            if file.starts_with("generate:") {
                return;
            }
            let size: usize = cell("bytes").parse().unwrap();
            let (peak, time) = cost(&folder.join(&file));
            println!("{file}: {size} bytes, peak {peak} bytes, {time:?}");
            if peak > 6 * size + (64 << 20) || time > Duration::from_secs(seconds) {
                failures.push(format!("{file}: {size} bytes, peak {peak} bytes, {time:?}"));
            }
        });
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Peak bytes and time of loading one file.
fn cost(path: &Path) -> (usize, Duration) {
    let before = HELD.load(Relaxed);
    PEAK.store(before, Relaxed);
    let start = Instant::now();
    drop(load(path));
    (PEAK.load(Relaxed) - before, start.elapsed())
}
