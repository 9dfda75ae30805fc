//! Mutated glTF files: never a panic, never more memory than 6 times the file and 64 MiB.
//!
//! A binary of its own, with one test, since it counts every allocation of the process.
#![expect(
    unsafe_code,
    reason = "a global allocator that counts can't be written without"
)]

#[path = "support/allocator.rs"]
mod allocator;
#[path = "support/mutate.rs"]
mod mutate;
#[path = "support/tiny_gltf.rs"]
mod tiny_gltf;

use std::sync::atomic::Ordering::Relaxed;

use allocator::{HELD, PEAK};
use boxwood_scene::{Limits, load_bytes};
use mutate::{Random, mutate};
use tiny_gltf::everything;

#[test]
fn mutants_never_panic_and_never_cost_more_than_their_size_allows() {
    let (tiny, rest) = everything();
    for (name, seed) in [("a.gltf", tiny.gltf(&rest)), ("a.glb", tiny.glb(&rest))] {
        let mut random = Random(2027);
        let mut accepted = 0;
        for round in 0..20_000 {
            let mut bytes = seed.clone();
            mutate(&mut bytes, &mut random);
            let before = HELD.load(Relaxed);
            PEAK.store(before, Relaxed);
            let outcome = load_bytes(name, Some("gltf"), &bytes, Limits::default());
            let peak = PEAK.load(Relaxed) - before;
            assert!(
                peak <= 6 * bytes.len() + (64 << 20),
                "round {round}: {peak} bytes"
            );
            if let Ok(model) = outcome {
                accepted += 1;
                // A transform may still leave f32 when it meets the vertices: an error, not a panic.
                drop(model.flatten());
            }
        }
        assert!(
            accepted > 500,
            "only {accepted} mutants of {name} were accepted, the test proves little"
        );
    }
}
