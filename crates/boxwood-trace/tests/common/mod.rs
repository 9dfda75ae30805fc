//! Scenes and rays of the tests.

#![allow(dead_code, reason = "each test binary uses a part")]

use boxwood::{BUILDERS, BuildOptions, Builder, Ray, STRUCTURES, Scene, VOLUMES};

/// A heap of small triangles on a crooked lattice, with a large one below.
pub(crate) fn heap(builder: SceneChoice) -> Scene {
    let mut positions = vec![[-9.0, -9.0, 4.5], [9.0, -8.0, 4.0], [0.5, 9.0, 4.25]];
    for i in 0..60_u16 {
        let [x, y, z] = [i % 5, i / 5 % 4, i / 20].map(f32::from);
        let at = [x * 1.5 - 3.0 + 0.1 * y, y * 1.25 - 2.0 + 0.07 * z, z * 0.75];
        positions.push(at);
        positions.push([at[0] + 1.0, at[1] + 0.125, at[2] + 0.25]);
        positions.push([at[0] + 0.25, at[1] + 0.875, at[2] + 0.5]);
    }
    let indices: Vec<[u32; 3]> = (0..61).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let SceneChoice {
        structure,
        builder,
        volume,
    } = builder;
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
