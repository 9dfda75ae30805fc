//! Every structure, builder and volume gives the same bits as the list, on every scene, for every question, one ray at a
//! time or many.

mod common;

use boxwood::{AxisRule, BUILDERS, BuildOptions, Counts, Hit, Ray, STRUCTURES, Scene, Sphere};
use common::{code, rays, scenes};

/// The structures with every choice that matters to them.
fn variants() -> Vec<(String, &'static str, BuildOptions)> {
    let mut variants = Vec::new();
    for structure in STRUCTURES {
        if !structure.is_tree {
            for grid_density in [0.5, 4.0] {
                let options = BuildOptions {
                    grid_density,
                    ..BuildOptions::default()
                };
                variants.push((
                    format!("{} {grid_density}", structure.name),
                    structure.name,
                    options,
                ));
            }
            continue;
        }
        for instructions in structure.instruction_sets() {
            let options = BuildOptions {
                instructions,
                ..BuildOptions::default()
            };
            let name = format!("{} {}", structure.name, instructions.name());
            variants.push((name, structure.name, options));
        }
        for builder in BUILDERS {
            for volume in structure.volumes() {
                for (axis, max_leaf) in [(AxisRule::Longest, 4), (AxisRule::RoundRobin, 1)] {
                    let name = format!(
                        "{} {} {} {axis:?}",
                        structure.name, builder.name, volume.name
                    );
                    let options = BuildOptions {
                        volume: volume.name,
                        axis,
                        max_leaf,
                        ..BuildOptions::with(*builder)
                    };
                    variants.push((name, structure.name, options));
                }
            }
        }
    }
    variants
}

/// Equal to the last bit, so that -0 and 0 differ.
fn bits(hit: Option<Hit>) -> Option<[u32; 6]> {
    hit.map(|h| {
        [
            h.t.to_bits(),
            h.u.to_bits(),
            h.v.to_bits(),
            h.prim,
            h.geom,
            h.inst,
        ]
    })
}

struct Truth {
    rays: Vec<Ray>,
    closest: Vec<Option<Hit>>,
    all: Vec<Vec<Hit>>,
}

fn assert_same(what: &str, scene: &Scene, truth: &Truth) {
    let mut closest = vec![None; truth.rays.len()];
    scene.closest_hits(&truth.rays, &mut closest);
    let mut occluded = vec![false; truth.rays.len()];
    scene.occluded_each(&truth.rays, &mut occluded);
    let lists = scene.list_hits(&truth.rays);
    let mut numbers = vec![7; truth.rays.len()];
    scene.count_hits(&truth.rays, &mut numbers);
    let mut counts = Counts::default();
    for (i, ray) in truth.rays.iter().enumerate() {
        let expected = bits(truth.closest[i]);
        let place = || format!("{what}, {}", code(ray));
        assert_eq!(
            bits(scene.closest_hit(ray)),
            expected,
            "closest, {}",
            place()
        );
        assert_eq!(bits(closest[i]), expected, "batch, {}", place());
        assert_eq!(
            bits(scene.closest_hit_counted(ray, &mut counts)),
            expected,
            "counted, {}",
            place()
        );
        assert_eq!(
            scene.occluded(ray),
            expected.is_some(),
            "occluded, {}",
            place()
        );
        assert_eq!(
            occluded[i],
            expected.is_some(),
            "batch of occluded, {}",
            place()
        );
        let all = scene.all_hits(ray);
        assert_eq!(all, truth.all[i], "all hits, {}", place());
        assert_eq!(lists.of(i), truth.all[i], "lists, {}", place());
        assert_eq!(numbers[i] as usize, all.len(), "counts, {}", place());
        assert_eq!(
            bits(all.first().copied()),
            expected,
            "first of all, {}",
            place()
        );
        if i % 16 == 0 {
            assert_eq!(
                bits(scene.explain(ray).hit),
                expected,
                "explained, {}",
                place()
            );
        }
    }
    assert_eq!(counts.rays, truth.rays.len() as u64);
}

fn truth(list: &Scene, rays: Vec<Ray>) -> Truth {
    let closest = rays.iter().map(|ray| list.closest_hit(ray)).collect();
    let all = rays.iter().map(|ray| list.all_hits(ray)).collect();
    Truth { rays, closest, all }
}

/// One test per structure, so that they share the cores.
fn agrees_with_the_list_on_every_scene(structure: &str) {
    let mut hits = 0;
    for (name, mesh) in scenes() {
        let build = |structure: &str, options: &BuildOptions| {
            Scene::builder()
                .mesh(&mesh.0, &mesh.1)
                .structure(structure)
                .options(options.clone())
                .build()
                .unwrap()
        };
        let list = build("list", &BuildOptions::default());
        let truth = truth(&list, rays(&mesh, 600, 1));
        hits += truth.closest.iter().flatten().count();
        for (variant, _, options) in variants().iter().filter(|v| v.1 == structure) {
            assert_same(
                &format!("{variant} on '{name}'"),
                &build(structure, options),
                &truth,
            );
        }
    }
    assert!(hits > 2000, "the rays must hit: {hits}");
}

#[test]
fn list_agrees_with_itself() {
    agrees_with_the_list_on_every_scene("list");
}

#[test]
fn bounded_agrees_with_the_list() {
    agrees_with_the_list_on_every_scene("bounded");
}

#[test]
fn bvh2_agrees_with_the_list() {
    agrees_with_the_list_on_every_scene("bvh2");
}

#[test]
fn wide_agrees_with_the_list() {
    agrees_with_the_list_on_every_scene("wide");
}

#[test]
fn compact_agrees_with_the_list() {
    agrees_with_the_list_on_every_scene("compact");
}

#[test]
fn grid_agrees_with_the_list() {
    agrees_with_the_list_on_every_scene("grid");
}

#[test]
fn every_structure_of_the_table_has_its_test() {
    let names: Vec<_> = STRUCTURES.iter().map(|s| s.name).collect();
    assert_eq!(
        names,
        ["list", "bounded", "bvh2", "wide", "compact", "grid"],
        "add a test above"
    );
}

#[test]
fn spheres_agree_with_the_list() {
    let mut random = common::Random::new(9);
    let spheres: Vec<Sphere> = (0..400)
        .map(|i| Sphere {
            center: random.point(3.0),
            radius: if i % 50 == 0 {
                -1.0
            } else {
                random.unit() * 0.5
            },
        })
        .collect();
    let positions: Vec<[f32; 3]> = spheres.iter().map(|s| s.center).collect();
    let indices: Vec<[u32; 3]> = (0..positions.len() as u32 - 2)
        .map(|i| [i, i + 1, i + 2])
        .collect();
    let rays = rays(&(positions, indices), 3000, 2);
    let build = |structure: &str, options: &BuildOptions| {
        Scene::builder()
            .spheres(spheres.clone())
            .structure(structure)
            .options(options.clone())
            .build()
            .unwrap()
    };
    let truth = truth(&build("list", &BuildOptions::default()), rays);
    assert!(truth.closest.iter().flatten().count() > 500);
    for (variant, structure, options) in &variants() {
        assert_same(
            &format!("{variant} on spheres"),
            &build(structure, options),
            &truth,
        );
    }
}

#[test]
fn leaves_are_never_larger_than_a_structure_takes() {
    let mesh = common::star(14, 20, 3.0);
    let scene = |structure, options| common::built(&mesh, structure, options);
    let truth = truth(&scene("list", BuildOptions::default()), rays(&mesh, 500, 4));
    for structure in STRUCTURES.iter().filter(|s| s.is_tree) {
        for builder in BUILDERS {
            for max_leaf in [0, 8, 9, 64, 255, u32::MAX] {
                let options = BuildOptions {
                    max_leaf,
                    ..BuildOptions::with(*builder)
                };
                let what = format!("{} {} {max_leaf}", structure.name, builder.name);
                assert_same(&what, &scene(structure.name, options), &truth);
            }
        }
    }
}

#[test]
fn equal_boxes_are_built_as_fast_as_others() {
    // Quadratic, this would take minutes.
    let one = [[0.0, 0.0, 1.0], [1.0, 0.25, 1.5], [0.25, 1.0, 1.0]];
    let on_a_line = |k: usize| one.map(|p| [p[0] + (k / 1000) as f32, 0.0, 0.0]);
    for builder in BUILDERS {
        for copies in [true, false] {
            let count = if builder.name == "sweep" {
                20_000
            } else {
                200_000
            };
            let positions: Vec<[f32; 3]> = (0..count)
                .flat_map(|k| if copies { one } else { on_a_line(k) })
                .collect();
            let indices: Vec<[u32; 3]> = (0..count as u32)
                .map(|k| [3 * k, 3 * k + 1, 3 * k + 2])
                .collect();
            let scene = Scene::builder()
                .mesh(&positions, &indices)
                .options(BuildOptions::with(*builder))
                .build()
                .unwrap();
            let ray = Ray::new([0.4, 0.4, 0.0], [0.0, 0.0, 1.0]);
            let first = scene.closest_hit(&ray).map(|hit| hit.prim);
            assert_eq!(first, copies.then_some(0), "{}", builder.name);
        }
    }
}

#[test]
fn meshes_are_numbered_in_the_order_added() {
    let near = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    let far = near.map(|p| [p[0], p[1], 2.0]);
    let scene = Scene::builder()
        .mesh(&far, &[[0, 1, 2]])
        .mesh(&[], &[])
        .mesh(&near, &[[0, 1, 2], [2, 1, 0]])
        .build()
        .unwrap();
    let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
    let ids: Vec<_> = scene
        .all_hits(&ray)
        .iter()
        .map(|h| (h.geom, h.prim))
        .collect();
    assert_eq!(ids, [(2, 0), (2, 1), (0, 0)], "ties go to the lower number");
    assert_eq!(
        scene.normal(&scene.closest_hit(&ray).unwrap()),
        Some([0.0, 0.0, 1.0])
    );
}
