//! Small files with flipped, lost and repeated bytes: every outcome is a sound model or an error, never a panic.

#[path = "support/mutate.rs"]
mod mutate;
#[path = "support/seeds.rs"]
mod seeds;

use boxwood_scene::{Limits, load_bytes};
use mutate::{Random, mutate};
use seeds::seeds;

#[test]
fn mutated_files_never_panic() {
    let limits = Limits {
        max_triangles: 100_000,
        ..Limits::default()
    };
    for (format, seed) in seeds() {
        assert!(
            load_bytes("seed", Some(format), &seed, limits).is_ok(),
            "{:?}",
            load_bytes("seed", Some(format), &seed, limits)
        );
        let mut random = Random(2026);
        let mut accepted = 0;
        for _ in 0..20_000 {
            let mut bytes = seed.clone();
            mutate(&mut bytes, &mut random);
            if let Ok(model) = load_bytes("mutant", Some(format), &bytes, limits) {
                accepted += 1;
                let flat = model.flatten().unwrap();
                assert_eq!(flat.indices.len() as u64, model.triangle_count());
            }
        }
        println!("{format}: {accepted} of 20,000 mutants are still scenes");
        assert!(
            accepted > 100,
            "{format}: only {accepted} mutants were accepted, the test proves little"
        );
    }
}

#[test]
fn a_scene_that_shows_none_of_its_meshes_says_so() {
    let gltf =
        br#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}]}"#;
    let model = load_bytes("a.gltf", None, gltf, Limits::default()).unwrap();
    assert_eq!(
        (model.unique_triangle_count(), model.triangle_count()),
        (1, 0)
    );
    assert!(
        model
            .warnings
            .iter()
            .any(|warning| warning.contains("shows no triangles")),
        "{:?}",
        model.warnings
    );
}
