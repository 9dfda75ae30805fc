//! Scenes and rays of the tests.

#![allow(dead_code, reason = "each test binary uses a part")]

use boxwood::{BUILDERS, BuildOptions, Builder, Ray, STRUCTURES, Scene, VOLUMES};

/// Triangles of all sizes that lie about, the same ones each time.
pub(crate) fn heap(choice: SceneChoice) -> Scene {
    let mut state = 77_u64;
    let mut signed = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
    };
    let mut positions = Vec::new();
    for i in 0..150 {
        let size = if i % 9 == 0 { 3.0 } else { 0.5 };
        let at = [4.0 * signed(), 3.0 * signed(), 2.0 * signed()];
        for _ in 0..3 {
            positions.push(at.map(|x| x + size * signed()));
        }
    }
    let indices: Vec<[u32; 3]> = (0..150).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let SceneChoice {
        structure,
        builder,
        volume,
    } = choice;
    let options = BuildOptions {
        volume,
        round_share: 0.3,
        ..BuildOptions::with(builder)
    };
    Scene::builder()
        .mesh(&positions, &indices)
        .structure(structure)
        .options(options)
        .build()
        .unwrap()
}

/// A row of the tables.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SceneChoice {
    pub(crate) structure: &'static str,
    pub(crate) builder: Builder,
    pub(crate) volume: &'static str,
}

/// Every structure with every builder and volume that it can have.
pub(crate) fn choices() -> Vec<SceneChoice> {
    let mut all = Vec::new();
    for structure in STRUCTURES {
        let builders = if structure.is_tree {
            BUILDERS
        } else {
            &BUILDERS[..1]
        };
        let volumes = match structure.volumes() {
            [] => &VOLUMES[..1],
            volumes => volumes,
        };
        for builder in builders {
            all.extend(volumes.iter().map(|volume| SceneChoice {
                structure: structure.name,
                builder: *builder,
                volume: volume.name,
            }));
        }
    }
    all
}

/// Down on the heap, past it, slanted, and one that is no ray.
pub(crate) fn rays() -> Vec<Ray> {
    let mut rays = vec![
        Ray::new([0.1, 0.2, -5.0], [0.01, 0.02, 1.0]),
        Ray::new([-6.0, -4.0, -2.0], [2.0, 1.5, 1.0]),
        Ray::new([50.0, 50.0, 50.0], [1.0, 0.0, 0.0]),
        Ray::new([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        Ray::new([-3.0, 0.25, 0.5], [1.0, 0.0, 0.0]),
    ];
    for i in 0..40_u16 {
        let x = f32::from(i) * 0.31 - 6.0;
        rays.push(Ray::new([x, -7.0, -3.0], [-0.3 * x, 7.1 - 0.2 * x, 4.0]));
    }
    rays.push(Ray {
        t_max: 4.0,
        ..rays[0]
    });
    rays
}
