//! A grove on a hill: three trees and a rock, stored once and shown a thousand times.

use std::f64::consts::TAU;

use glam::{DMat4, DQuat, DVec3};

use super::random::Random;
use super::shape::{Shape, any_orthonormal, smooth_curve};
use super::{Builtin, Params, Size, matte};
use crate::{Camera, Instance, Material, Mesh, Model};

pub(super) const BUILTIN: Builtin = Builtin {
    name: "instanced_grove",
    about: "three trees and a rock a thousand times: 2,746,000 triangles shown, 21,820 stored",
    size: Size::Fixed,
    seeded: true,
    build,
};

/// Triangles of each kind of tree, and how often it stands there.
const TREES: [(usize, usize); 3] = [(6_300, 139), (6_300, 139), (5_700, 138)];
/// Of 320 triangles each.
const ROCKS: usize = 640;
/// Half the side of the ground.
const REACH: f64 = 60.0;
/// No tree stands nearer to the middle.
const GLADE: f64 = 13.0;

const BARK: u32 = 0;
const STONE: u32 = 1;
const EARTH: u32 = 2;
/// The first of [`GREENS`].
const LEAF: u32 = 3;
const GREENS: [[f32; 3]; 4] = [
    [0.070, 0.185, 0.034],
    [0.105, 0.262, 0.046],
    [0.165, 0.352, 0.062],
    [0.330, 0.400, 0.080],
];

/// Which of the greens the leaves of each kind of tree have.
const HUES: [[u32; 3]; 3] = [[0, 1, 2], [0, 0, 1], [1, 2, 3]];

fn build(params: &Params) -> Model {
    let mut random = Random::new(params.seed ^ 0x0067_023e);
    let mut meshes: Vec<Mesh> = (0..)
        .zip(TREES)
        .map(|(kind, (triangles, _))| tree(kind, triangles, &mut random))
        .collect();
    meshes.extend([rock(&mut random), ground()]);
    let (rock, ground) = (TREES.len() as u32, TREES.len() as u32 + 1);

    let mut instances = vec![Instance {
        mesh: ground,
        world_from_mesh: glam::Mat4::IDENTITY,
    }];
    let kinds: Vec<u32> = (0..)
        .zip(TREES)
        .flat_map(|(kind, (_, count))| std::iter::repeat_n(kind, count))
        .collect();
    let mut places = apart(kinds.len(), &mut random);
    for kind in kinds {
        // Any of the places that are left, so that the kinds are mixed.
        let place = places.swap_remove(random.below(places.len()));
        instances.push(stand(kind, place, random.between(0.75, 1.3), &mut random));
    }
    for _ in 0..ROCKS {
        let place = [(); 2].map(|()| random.between(-REACH, REACH) * 0.98);
        let size = 0.12 + 0.75 * random.unit() * random.unit() * random.unit();
        instances.push(stand(rock, place, size, &mut random));
    }

    let mut materials = vec![
        matte("bark", [0.20, 0.135, 0.085]),
        matte("stone", [0.38, 0.37, 0.35]),
        matte("earth", [0.215, 0.225, 0.085]),
    ];
    materials.extend(GREENS.iter().map(|&green| Material {
        roughness: 0.6,
        ..matte("leaf", green)
    }));
    Model {
        meshes,
        instances,
        materials,
        cameras: vec![Camera {
            eye: [6.0, 27.0, 74.0],
            target: [0.0, 1.0, -2.0],
            up: [0.0, 1.0, 0.0],
            fov: 34.0,
        }],
        ..Model::default()
    }
}

/// Height of the ground: gentle waves, and a rise to the back.
fn height(x: f64, z: f64) -> f64 {
    let waves = 1.1 * libm::sin(x * 0.11 + 0.7) * libm::cos(z * 0.09)
        + 0.35 * libm::sin(x * 0.31 - z * 0.23);
    waves + 0.055 * (REACH - z) - 2.0
}

/// 3,200 triangles.
fn ground() -> Mesh {
    const CELLS: u32 = 40;
    let mut ground = Shape::new("ground");
    let at = |i: u32| f64::from(i) * (2.0 * REACH / f64::from(CELLS)) - REACH;
    for row in 0..=CELLS {
        for column in 0..=CELLS {
            let (x, z) = (at(column), at(row));
            ground.vertex(DVec3::new(x, height(x, z), z));
        }
    }
    for row in 0..CELLS {
        for column in 0..CELLS {
            let at = |row: u32, column: u32| row * (CELLS + 1) + column;
            let corners = [
                at(row, column),
                at(row + 1, column),
                at(row + 1, column + 1),
                at(row, column + 1),
            ];
            ground.quad(corners, EARTH);
        }
    }
    ground.smooth()
}

/// `count` places on the ground, as far apart as they go by trial: the distance asked for shrinks with every failure.
fn apart(count: usize, random: &mut Random) -> Vec<[f64; 2]> {
    let mut places: Vec<[f64; 2]> = Vec::with_capacity(count);
    let mut distance = 6.0;
    while places.len() < count {
        let [x, z] = [(); 2].map(|()| random.between(-REACH, REACH) * 0.96);
        let is_free = |p: &[f64; 2]| {
            let (dx, dz) = (p[0] - x, p[1] - z);
            dx * dx + dz * dz >= distance * distance
        };
        if x * x + z * z > GLADE * GLADE && places.iter().all(is_free) {
            places.push([x, z]);
        } else {
            distance *= 0.9995;
        }
    }
    places
}

/// An instance on the ground, turned about its axis and a little off it; one in five is mirrored.
fn stand(mesh: u32, [x, z]: [f64; 2], size: f64, random: &mut Random) -> Instance {
    let foot = DVec3::new(x, height(x, z) - 0.05 * size, z);
    let about = |axis: DVec3, angle: f64| {
        let (sin, cos) = libm::sincos(0.5 * angle);
        DQuat::from_vec4((axis * sin).extend(cos))
    };
    let lean = about(random.direction(), random.between(0.0, 0.06));
    let turn = about(DVec3::Y, random.between(0.0, TAU));
    let side = if random.below(5) == 0 { -1.0 } else { 1.0 };
    let scale = DVec3::new(side, random.between(0.85, 1.2), 1.0) * size;
    let world_from_mesh = DMat4::from_scale_rotation_translation(scale, lean * turn, foot);
    Instance {
        mesh,
        world_from_mesh: world_from_mesh.as_mat4(),
    }
}

/// A tree of so many triangles: trunk and boughs, and leaves for the rest.
fn tree(kind: u32, triangles: usize, random: &mut Random) -> Mesh {
    let tall = [1.0, 1.25, 0.9][kind as usize % 3];
    let mut wood = Shape::new(["oak", "poplar", "thorn"][kind as usize % 3]);
    let mut tips = Vec::new();
    let trunk: Vec<DVec3> = smooth_curve(
        &[
            DVec3::new(0.0, -0.3, 0.0),
            DVec3::new(random.between(-0.2, 0.2), 1.6, random.between(-0.2, 0.2)),
            DVec3::new(random.between(-0.4, 0.4), 3.4, random.between(-0.4, 0.4)),
            DVec3::new(random.between(-0.5, 0.5), 5.2, random.between(-0.5, 0.5)),
        ]
        .map(|p| DVec3::new(p.x, p.y * tall, p.z)),
        8,
    );
    let taper = |i: usize, count: usize, from: f64, to: f64| {
        from + (to - from) * (i as f64 / (count - 1) as f64)
    };
    let radii: Vec<f64> = (0..trunk.len())
        .map(|i| taper(i, trunk.len(), 0.27, 0.07) * if i == 0 { 1.5 } else { 1.0 })
        .collect();
    wood.tube(&trunk, &radii, 10, BARK);
    for bough in 0..22 {
        let start = trunk[8 + bough % (trunk.len() - 9)];
        let (sin, cos) = libm::sincos(bough as f64 * 2.399_963 + random.between(-0.3, 0.3));
        let reach = random.between(1.2, 2.2) * [1.15, 0.7, 1.0][kind as usize % 3];
        let rise = random.between(0.5, 1.3) * tall;
        let out = DVec3::new(cos * reach, rise, sin * reach);
        let path = smooth_curve(
            &[
                start,
                start + out * 0.45 + DVec3::Y * random.between(-0.15, 0.1),
                start + out,
            ],
            4,
        );
        let radii: Vec<f64> = (0..path.len())
            .map(|i| taper(i, path.len(), 0.075, 0.018))
            .collect();
        wood.tube(&path, &radii, 6, BARK);
        tips.extend([path[5], path[8]]);
    }
    tips.extend_from_slice(&trunk[trunk.len() - 4..]);
    let leaves = triangles - wood.triangle_count();
    let mut mesh = wood.smooth();
    append(
        &mut mesh,
        crown(leaves / 2, &tips, HUES[kind as usize % 3], random),
    );
    mesh
}

/// Leaves of two triangles each in clumps round the tips.
fn crown(count: usize, tips: &[DVec3], hues: [u32; 3], random: &mut Random) -> Mesh {
    let mut leaves = Shape::new("leaves");
    for i in 0..count {
        let tip = tips[i % tips.len()];
        let way = random.direction();
        let base = tip + way * (0.85 * random.unit().max(random.unit()));
        let front = (way + random.direction() * 0.6 + DVec3::Y * 0.5).normalize_or(DVec3::Y);
        let along = any_orthonormal(front);
        let lean = random.direction();
        let along = (along + lean - front * lean.dot(front)).normalize_or(along);
        let across = along.cross(front) * random.between(0.09, 0.13);
        let length = random.between(0.30, 0.44);
        // The clump's own roundness, mixed into the leaves' normals, lets it be read from afar.
        let soft = (front * 0.5 + way).normalize_or(front);
        let mut corner = |p: DVec3| leaves.vertex_with_normal(p, soft);
        let corners = [
            corner(base),
            corner(base + along * (length * 0.45) + across),
            corner(base + along * length - front * 0.04),
            corner(base + along * (length * 0.45) - across),
        ];
        leaves.quad(corners, LEAF + hues[random.below(hues.len())]);
    }
    leaves.finish()
}

/// 320 triangles: an icosahedron, split twice and dented.
fn rock(random: &mut Random) -> Mesh {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut corners: Vec<DVec3> = Vec::new();
    for (one, phi) in [
        (-1.0, -golden),
        (-1.0, golden),
        (1.0, -golden),
        (1.0, golden),
    ] {
        corners.extend([
            DVec3::new(0.0, one, phi),
            DVec3::new(one, phi, 0.0),
            DVec3::new(phi, 0.0, one),
        ]);
    }
    // The faces are the triples of corners at distance 2.
    let is_edge = |a: usize, b: usize| (corners[a].distance(corners[b]) - 2.0).abs() < 1e-9;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if is_edge(a, b) && is_edge(b, c) && is_edge(a, c) {
                    let [p, q, r] = [corners[a], corners[b], corners[c]];
                    let faces_out = (q - p).cross(r - p).dot(p) > 0.0;
                    faces.push(if faces_out { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..2 {
        faces = split(&faces, &mut corners);
    }
    let dents: Vec<DVec3> = (0..9).map(|_| random.direction()).collect();
    let mut rock = Shape::new("rock");
    for corner in corners {
        let way = corner.normalize();
        let cut = dents.iter().map(|dent| way.dot(*dent)).fold(0.0, f64::max);
        // Flat cuts, as stone breaks, and not round.
        let p = way * (0.82 / cut.max(0.72));
        rock.vertex(DVec3::new(p.x, p.y * 0.7 + 0.35, p.z));
    }
    for face in faces {
        rock.triangle(face.map(|v| v as u32), STONE);
    }
    rock.finish()
}

/// Each face in four; new corners are shared.
fn split(faces: &[[usize; 3]], corners: &mut Vec<DVec3>) -> Vec<[usize; 3]> {
    let mut middles = std::collections::BTreeMap::new();
    let mut middle = |a: usize, b: usize| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            corners.push((corners[a] + corners[b]).normalize());
            corners.len() - 1
        })
    };
    let mut finer = Vec::with_capacity(4 * faces.len());
    for &[a, b, c] in faces {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    finer
}

/// Adds a mesh that has normals to another one.
fn append(mesh: &mut Mesh, more: Mesh) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(more.positions);
    mesh.normals.extend(more.normals);
    mesh.material_of.extend(more.material_of);
    mesh.indices
        .extend(more.indices.iter().map(|t| t.map(|v| first + v)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thousand_instances_show_what_five_meshes_store() {
        for seed in [0, 7] {
            let model = build(&Params { n: 0, seed });
            assert_eq!(model.triangle_count(), 2_746_000);
            assert_eq!(model.unique_triangle_count(), 21_820);
            assert_eq!(model.meshes.len(), 5);
            let mirrored = |i: &&Instance| i.world_from_mesh.determinant() < 0.0;
            assert!(model.instances.iter().filter(mirrored).count() > 100);
        }
    }

    #[test]
    fn the_rock_is_closed_and_shows_its_outside() {
        let rock = rock(&mut Random::new(1));
        let at = |v: u32| glam::Vec3::from(rock.positions[v as usize]);
        let middle = glam::Vec3::new(0.0, 0.35, 0.0);
        for t in &rock.indices {
            let [a, b, c] = t.map(at);
            assert!((b - a).cross(c - a).dot(a - middle) > 0.0);
        }
        assert_eq!((rock.positions.len(), rock.indices.len()), (162, 320));
    }
}
