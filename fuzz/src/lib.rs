//! What every fuzz target does with its bytes.
#![forbid(unsafe_code)]

use boxwood::{Ray, Scene};
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

/// Loads `bytes` as a saved scene whose length and hash are right, opens them, and asks whatever opens. It saves as it was, and every hit is one that
/// brute force has, too. (A forger can leave out a part of a triangle that a builder split: that is a wrong answer, and no more.)
///
/// # Panics
/// If one of these does not hold, which is what the fuzzer looks for.
pub fn open(bytes: &[u8]) {
    let Some(sealed) = sealed(bytes) else { return };
    load("bwx", &sealed);
    let scene = match Scene::open_bytes(sealed.clone()) {
        Ok(scene) => scene,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return;
        }
    };
    let mut again = Vec::new();
    scene.save(&mut again).expect("what was opened is saved");
    assert_eq!(again, sealed);
    let triangles: Vec<_> = (0..scene.len() as u32)
        .filter_map(|number| scene.triangle_in_scene(number))
        .collect();
    let list = Scene::builder().structure("list").mesh(
        triangles
            .iter()
            .map(|t| t.0)
            .collect::<Vec<_>>()
            .as_flattened(),
        &(0..triangles.len() as u32)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect::<Vec<_>>(),
    );
    let list = list.build().expect("triangles of a scene are one");
    let rays = rays(&triangles);
    let mut hits = vec![None; rays.len()];
    scene.query().closest_hits(&rays, &mut hits);
    for (ray, batched) in rays.iter().zip(hits) {
        let (mut all, mut known) = (Vec::new(), Vec::new());
        list.query().all_hits(ray, &mut known);
        scene.query().all_hits(ray, &mut all);
        let single = scene.query().closest_hit(ray);
        for hit in single.iter().chain(&batched).chain(&all) {
            assert!(known.contains(hit), "{ray:?} {hit:?}");
        }
        assert!(!scene.occluded(ray) || !known.is_empty(), "{ray:?}");
        scene.closest_point(ray.origin);
        scene.closest_hit(ray);
    }
    scene.stats();
}

/// The bytes with the length and the hash that they should have: a checksum is no defence.
fn sealed(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut sealed = bytes.to_vec();
    sealed
        .get_mut(24..32)?
        .copy_from_slice(&(bytes.len() as u64).to_le_bytes());
    let mut hasher = blake3::Hasher::new();
    hasher.update(sealed.get(..32)?).update(sealed.get(64..)?);
    sealed[32..64].copy_from_slice(hasher.finalize().as_bytes());
    Some(sealed)
}

/// At corners and middles of some triangles, from some places.
fn rays(triangles: &[boxwood::Triangle]) -> Vec<Ray> {
    let origins = [[0.3, 9.0, -5.0], [-7.0, 0.1, 0.2], [1e4, 3.0, 2e3]];
    let targets = triangles.iter().step_by(triangles.len() / 8 + 1);
    let targets = targets.flat_map(|t| [t.0[0], t.point(0.3, 0.4)]);
    let towards = |target: [f32; 3]| origins.map(|origin| Ray::between(origin, target));
    let with_range = |ray: Ray| ray.with_range(0.0, f32::INFINITY);
    targets.flat_map(towards).map(with_range).collect()
}
