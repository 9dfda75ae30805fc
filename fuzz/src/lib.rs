//! What every fuzz target does with its bytes.
#![forbid(unsafe_code)]

use boxwood_scene::{Limits, load_bytes};

/// Loads `bytes` as `format`. A model must keep its promises: it flattens, to as many triangles as it says, with
/// finite vertices and indices in range. An error must say something.
///
/// # Panics
/// If one of these does not hold, which is what the fuzzer looks for.
pub fn load(format: &str, bytes: &[u8]) {
    let limits = Limits {
        max_triangles: 1 << 20,
        max_texture_pixels: 1 << 20,
        ..Limits::default()
    };
    let model = match load_bytes("fuzz", Some(format), bytes, limits) {
        Ok(model) => model,
        Err(error) => {
            assert!(!error.cause.is_empty());
            return;
        }
    };
    assert!(
        model.triangle_count() > 0 || !model.warnings.is_empty(),
        "an empty scene without a word"
    );
    // Instances may multiply a small file beyond any memory; that is refused here as it is in use, only earlier.
    if model.triangle_count() > 1 << 20 {
        return;
    }
    let Ok(flat) = model.flatten() else { return };
    assert_eq!(flat.indices.len() as u64, model.triangle_count());
    assert!(
        flat.indices
            .iter()
            .flatten()
            .all(|&v| (v as usize) < flat.positions.len())
    );
    assert!(flat.positions.iter().flatten().all(|x| x.is_finite()));
}
