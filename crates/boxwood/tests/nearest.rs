//! The nearest place of a surface: the same bits from every structure, near the truth, and on the right side.

mod common;

use boxwood::{BUILDERS, BuildOptions, InstructionSet, Nearest, STRUCTURES, Scene, Triangle};
use common::{Random, built, scenes, triangles};

/// Points where mistakes show: corners, middles of edges and faces, a hair off them, all about, far away, and no points.
fn points(triangles: &[Triangle], random: &mut Random) -> Vec<[f32; 3]> {
    let mut points = vec![
        [f32::NAN, 0.0, 0.0],
        [0.0, f32::INFINITY, 0.0],
        [1e30, -1e30, 1e30],
        [-0.0, 0.0, -0.0],
    ];
    let picks = (0..25).map(|_| random.below(triangles.len().max(1)));
    for pick in picks.collect::<Vec<_>>() {
        let Some(Triangle([a, b, c])) = triangles.get(pick) else {
            continue;
        };
        let mix = |weights: [f32; 3]| {
            std::array::from_fn(|k| weights[0] * a[k] + weights[1] * b[k] + weights[2] * c[k])
        };
        let on = [*a, mix([0.5, 0.5, 0.0]), mix([0.3, 0.3, 0.4])];
        let size = (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f32::max);
        for place in on {
            points.push(place);
            for off in [1e-6, 0.3, 30.0] {
                points.push(place.map(|x| x + (random.unit() - 0.5) * off * size));
            }
        }
    }
    points
}

fn bits(nearest: Option<Nearest>) -> String {
    // -0 is not 0 here.
    format!("{nearest:?}")
}

#[test]
fn every_structure_gives_the_same_bits() {
    let mut random = Random::new(1);
    let mut answers = 0;
    for (name, mesh) in scenes() {
        let points = points(&triangles(&mesh), &mut random);
        let build = |structure, options| built(&mesh, structure, options);
        let list = build("list", BuildOptions::default());
        let expected: Vec<_> = points.iter().map(|p| list.closest_point(*p)).collect();
        answers += expected.iter().flatten().count();
        let agrees = |scene: &Scene, how: &str| {
            let mut together = vec![None; points.len()];
            scene.closest_points(&points, &mut together);
            for (k, point) in points.iter().enumerate() {
                let alone = scene.closest_point(*point);
                assert_eq!(bits(alone), bits(expected[k]), "{name}, {how}, {point:?}");
                assert_eq!(
                    bits(together[k]),
                    bits(expected[k]),
                    "{name}, {how}, together"
                );
            }
        };
        for structure in STRUCTURES {
            agrees(
                &build(structure.name, BuildOptions::default()),
                structure.name,
            );
        }
        for instructions in InstructionSet::available() {
            for builder in BUILDERS {
                let options = BuildOptions {
                    instructions,
                    ..BuildOptions::with(*builder)
                };
                let how = format!("wide, {}, {}", instructions.name(), builder.name);
                agrees(&build("wide", options), &how);
            }
        }
    }
    assert!(answers > 500, "{answers}");
}

#[test]
fn no_place_of_any_triangle_is_nearer() {
    let mut random = Random::new(2);
    for (name, mesh) in scenes() {
        let triangles = triangles(&mesh);
        let scene = Scene::new(&mesh.0, &mesh.1).unwrap();
        for point in points(&triangles, &mut random) {
            let Some(found) = scene.closest_point(point) else {
                continue;
            };
            let to = |place: [f32; 3]| {
                let square = |k: usize| (f64::from(point[k]) - f64::from(place[k])).powi(2);
                (0..3).map(square).sum::<f64>().sqrt()
            };
            // What rounding the place to single precision may do.
            let room = place_size(&found.point).max(place_size(&point)) * 1e-6 + 1e-44;
            assert!(
                (to(found.point) - f64::from(found.distance)).abs() <= room,
                "{name}"
            );
            for Triangle(corners) in &triangles {
                if corners
                    .iter()
                    .flatten()
                    .all(|x| x.is_finite() && x.abs() < 1e30)
                {
                    let least = corners.map(to).into_iter().fold(f64::INFINITY, f64::min);
                    assert!(
                        f64::from(found.distance) <= least * (1.0 + 1e-6) + room,
                        "{name}"
                    );
                }
            }
        }
    }
}

fn place_size(point: &[f32; 3]) -> f64 {
    point.iter().map(|x| f64::from(x.abs())).fold(0.0, f64::max)
}

/// An octahedron around a centre, closed.
fn octahedron(center: [f32; 3], radius: f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let corner = |axis: usize, sign: f32| {
        let mut corner = center;
        corner[axis] += sign * radius;
        corner
    };
    let positions = (0..6).map(|i| corner(i / 2, if i % 2 == 0 { 1.0 } else { -1.0 }));
    let faces = (0..8).map(|octant: u32| {
        let [x, y, z] = [0, 1, 2].map(|axis| 2 * axis + (octant >> axis & 1));
        if octant.count_ones().is_multiple_of(2) {
            [x, y, z]
        } else {
            [x, z, y]
        }
    });
    (positions.collect(), faces.collect())
}

#[test]
fn signs_are_those_of_the_solid() {
    for (center, radius) in [([0.0; 3], 1.0), ([1e5, -3e4, 7.0], 64.0), ([0.0; 3], 1e-20)] {
        let (positions, indices) = octahedron(center, radius);
        let scene = Scene::new(&positions, &indices).unwrap();
        let mut random = Random::new(3);
        let points: Vec<[f32; 3]> = (0..4000)
            .map(|_| center.map(|x| x + (random.unit() - 0.5) * 2.5 * radius))
            .collect();
        let (mut distances, mut inside) = (vec![0.0; points.len()], vec![false; points.len()]);
        scene.signed_distances(&points, &mut distances);
        scene.is_inside_each(&points, &mut inside);
        for (k, point) in points.iter().enumerate() {
            let off: f64 = (0..3)
                .map(|axis| (f64::from(point[axis]) - f64::from(center[axis])).abs())
                .sum();
            // The planes are |x| + |y| + |z| = radius.
            let depth = (off - f64::from(radius)) / 3_f64.sqrt();
            if depth.abs() > 1e-5 * f64::from(radius) {
                assert_eq!(distances[k] < 0.0, depth < 0.0, "{point:?} of {center:?}");
                assert_eq!(inside[k], depth < 0.0);
            }
            if depth < 0.0 {
                let error = (f64::from(distances[k]) - depth).abs();
                assert!(error < 1e-5 * f64::from(radius), "{error}");
            }
        }
        assert!(inside.iter().any(|inside| *inside) && inside.iter().any(|inside| !*inside));
    }
}

#[test]
fn the_middle_of_a_solid_and_its_very_surface() {
    let (positions, indices) = octahedron([0.0; 3], 2.0);
    let scene = Scene::new(&positions, &indices).unwrap();
    let mut distances = [0.0; 4];
    scene.signed_distances(
        &[[0.0; 3], [2.0, 0.0, 0.0], [9.0, 0.0, 0.0], [f32::NAN; 3]],
        &mut distances,
    );
    assert!((distances[0] + 2.0 / 3_f32.sqrt()).abs() < 1e-6);
    assert_eq!((distances[1].abs(), distances[2]), (0.0, 7.0));
    assert!(distances[3].is_nan());
    let nearest = scene.closest_point([9.0, 0.0, 0.0]).unwrap();
    assert_eq!((nearest.point, nearest.prim), ([2.0, 0.0, 0.0], 0));
}

#[test]
fn meshes_and_empty_scenes() {
    let (positions, indices) = octahedron([0.0; 3], 1.0);
    let (others, _) = octahedron([10.0, 0.0, 0.0], 1.0);
    let scene = Scene::builder()
        .mesh(&positions, &indices)
        .mesh(&others, &indices)
        .build()
        .unwrap();
    let near = scene.closest_point([9.5, 0.1, 0.1]).unwrap();
    assert_eq!(near.geom, 1);
    assert!(near.prim < 8);
    let none = Scene::new(&[], &[]).unwrap();
    assert_eq!(none.closest_point([0.0; 3]), None);
    let ball = Scene::builder()
        .spheres(vec![boxwood::Sphere {
            center: [0.0; 3],
            radius: 1.0,
        }])
        .build()
        .unwrap();
    assert_eq!(ball.closest_point([0.0; 3]), None);
}
