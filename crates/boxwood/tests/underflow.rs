//! Scenes so small that products of their coordinates underflow: the kernels' bounds of `t` must say so.

mod common;

use boxwood::{BuildOptions, InstructionSet, Ray, Scene};
use common::{Mesh, Random, code};

fn scene(mesh: &Mesh, structure: &str, instructions: InstructionSet) -> Scene {
    let options = BuildOptions {
        instructions,
        ..BuildOptions::default()
    };
    Scene::builder()
        .mesh(&mesh.0, &mesh.1)
        .structure(structure)
        .options(options)
        .build()
        .unwrap()
}

/// Every instruction set, both forms, one by one and in slices, against the list. Returns how many rays hit.
fn agree(what: &str, mesh: &Mesh, rays: &[Ray]) -> usize {
    let list = scene(mesh, "list", InstructionSet::default());
    let expected: Vec<_> = rays.iter().map(|ray| list.closest_hit(ray)).collect();
    for set in InstructionSet::available() {
        for structure in ["wide", "compact"] {
            let scene = scene(mesh, structure, set);
            let mut closest = vec![None; rays.len()];
            let mut occluded = vec![false; rays.len()];
            scene.closest_hits(rays, &mut closest);
            scene.occluded_each(rays, &mut occluded);
            for (k, ray) in rays.iter().enumerate() {
                let place = || format!("{what}, {structure}, {}, {}", set.name(), code(ray));
                assert_eq!(scene.closest_hit(ray), expected[k], "{}", place());
                assert_eq!(closest[k], expected[k], "slice, {}", place());
                assert_eq!(scene.occluded(ray), expected[k].is_some(), "{}", place());
                assert_eq!(occluded[k], expected[k].is_some(), "slice, {}", place());
            }
        }
    }
    expected.iter().flatten().count()
}

/// Triangles side by side across the z axis, nearly at one depth.
fn stack(extent: f32, depth: f32, random: &mut Random) -> Mesh {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for k in 0..6 {
        let z = depth * (1.0 + 1e-5 * random.unit());
        positions.extend([
            [
                -extent * (1.0 + random.unit()),
                -extent * (1.0 + random.unit()),
                z,
            ],
            [3.0 * extent, -extent * (1.0 + random.unit()), z],
            [0.1 * extent * random.unit(), 3.0 * extent, z],
        ]);
        indices.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    (positions, indices)
}

#[test]
fn triangles_at_nearly_one_depth_are_told_apart_at_every_scale() {
    let mut random = Random::new(4);
    let mut hits = 0;
    for extent in (-48..=-30).step_by(2).chain([-43, -45, -20]) {
        for depth in (-62..=-26).step_by(4) {
            let (size, far) = (2f32.powi(extent), 2f32.powi(depth));
            let mesh = stack(size, far, &mut random);
            let rays: Vec<Ray> = (0..64)
                .map(|k| {
                    let [x, y, _] = random.point(0.01 * size);
                    let ray = Ray::new([x, y, 0.0], [0.0, 0.0, if k % 2 == 0 { 1.0 } else { far }]);
                    match k % 8 {
                        3 => ray.with_range(1.0, f32::INFINITY),
                        5 => ray.with_range(0.0, 1.0),
                        _ => ray,
                    }
                })
                .collect();
            hits += agree(&format!("2^{extent} by 2^{depth}"), &mesh, &rays);
        }
    }
    assert!(hits > 3000, "{hits}");
}

#[test]
fn a_scene_scaled_down_is_hit_where_the_list_hits_it() {
    let mut random = Random::new(8);
    let mut unit = |size: f32| [0; 3].map(|_| size * random.unit());
    let cloud: Vec<[f32; 3]> = (0..60)
        .flat_map(|_| {
            let corner = unit(1.0);
            [0; 3].map(|_| {
                let by = unit(0.5);
                std::array::from_fn(|k| corner[k] + by[k])
            })
        })
        .collect();
    let indices: Vec<[u32; 3]> = (0..60).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let mut hits = 0;
    for step in 0..24 {
        let scale = 10f32.powf(-9.0 - 0.35 * step as f32);
        let positions: Vec<[f32; 3]> = cloud.iter().map(|p| p.map(|x| x * scale)).collect();
        let rays: Vec<Ray> = (0..400)
            .map(|_| {
                let first = 3 * random.below(60);
                let corners = [0, 1, 2].map(|k| positions[first + k]);
                let target: [f32; 3] = std::array::from_fn(|k| {
                    0.4 * corners[0][k] + 0.3 * corners[1][k] + 0.3 * corners[2][k]
                });
                let near = [0.5, 0.005][random.below(2)];
                let away = random.point(scale * near);
                Ray::between(std::array::from_fn(|k| target[k] + away[k]), target)
            })
            .collect();
        hits += agree(
            &format!("scale {scale:e}"),
            &(positions, indices.clone()),
            &rays,
        );
    }
    assert!(hits > 2000, "{hits}");
}
