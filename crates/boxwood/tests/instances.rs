//! Scenes inside scenes: every structure outside and inside gives the same bits, through maps of every kind, up to four
//! levels deep, and nothing leaks.

mod common;

use boxwood::{BuildOptions, Counts, Hit, Instance, Ray, STRUCTURES, Scene, Transform, VOLUMES};
use common::{Mesh, Random, code, integer_cube, rays, star};
use std::collections::HashSet;
use std::sync::Arc;

/// A scene to be, in any structures.
#[derive(Clone)]
enum Plan {
    Mesh(Mesh),
    Instances(Vec<(Plan, Transform)>),
}

impl Plan {
    fn build(&self, outside: (&str, &BuildOptions), inside: &str) -> Scene {
        let (structure, options) = match self {
            Self::Mesh(_) => (inside, &BuildOptions::default()),
            Self::Instances(_) => outside,
        };
        let builder = Scene::builder()
            .structure(structure)
            .options(options.clone());
        match self {
            Self::Mesh((positions, indices)) => builder.mesh(positions, indices),
            Self::Instances(all) => builder.instances(all.iter().map(|(plan, transform)| {
                Instance::new(&Arc::new(plan.build(outside, inside)), *transform)
            })),
        }
        .build()
        .unwrap()
    }

    /// All triangles in the world, rounded there: to aim at.
    fn flattened(&self) -> Mesh {
        let Self::Instances(all) = self else {
            let Self::Mesh(mesh) = self else {
                unreachable!()
            };
            return mesh.clone();
        };
        let mut flat: Mesh = Default::default();
        for (plan, transform) in all {
            let (positions, indices) = plan.flattened();
            let first = flat.0.len() as u32;
            flat.0.extend(positions.iter().map(|p| transform.point(*p)));
            flat.1.extend(indices.iter().map(|t| t.map(|i| first + i)));
        }
        flat
    }
}

/// A rotation from two random directions, by Gram and Schmidt.
fn rotation(random: &mut Random) -> [[f32; 3]; 3] {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let unit = |a: [f64; 3]| a.map(|x| x / dot(a, a).sqrt());
    let x = unit(random.point(1.0).map(f64::from));
    let y = random.point(1.0).map(f64::from);
    let along = dot(x, y);
    let y = unit([0, 1, 2].map(|k| y[k] - along * x[k]));
    let z = [
        x[1] * y[2] - x[2] * y[1],
        x[2] * y[0] - x[0] * y[2],
        x[0] * y[1] - x[1] * y[0],
    ];
    [x, y, z].map(|row| row.map(|x| x as f32))
}

const KINDS: [&str; 10] = [
    "moved",
    "turned",
    "scaled",
    "stretched",
    "sheared",
    "mirrored",
    "far",
    "home",
    "tiny",
    "squashed",
];

/// A map of each kind, seldom a kind one.
fn transform(kind: &str, random: &mut Random) -> Transform {
    let power = |random: &mut Random| 10.0_f32.powf(3.0 * random.signed());
    let by = random.point(3.0);
    let turn = rotation(random).map(|[a, b, c]| [a, b, c, 0.0]);
    let turn = Transform(turn);
    let at = Transform::translation(by);
    match kind {
        "moved" => at,
        "turned" => at.after(&turn),
        "scaled" => {
            let s = power(random);
            at.after(&Transform::scale([s; 3]).after(&turn))
        }
        "stretched" => {
            let s = [(); 3].map(|()| power(random));
            at.after(&turn.after(&Transform::scale(s)))
        }
        // The scale comes last: what is rounded along one axis ends on another, up to a million times as large.
        "squashed" => {
            let s = [(); 3].map(|()| power(random));
            at.after(&Transform::scale(s).after(&turn))
        }
        "sheared" => {
            let mut rows = Transform::IDENTITY.0;
            rows[0][1] = 4.0 * random.signed();
            rows[1][2] = 4.0 * random.signed();
            at.after(&Transform(rows).after(&turn))
        }
        "mirrored" => at.after(&turn.after(&Transform::scale([-1.0, 0.5, 2.0]))),
        "far" => Transform::translation(random.point(1e5)).after(&turn),
        "home" => at.after(&turn.after(&Transform::translation([-1e5, 3e4, 0.0]))),
        _ => at.after(&turn.after(&Transform::scale([1e-3; 3]))),
    }
}

/// `levels` of instances, three on each, around a closed mesh that is turned, stretched and so on.
fn plan(kind: &str, levels: u32, random: &mut Random) -> Plan {
    let mut plan = match levels % 2 {
        // Far from its own origin, from where the innermost maps bring it back.
        _ if kind == "home" => Plan::Mesh(common::moved(&star(7, 9, 3.0), 1.0, [1e5, -3e4, 0.0])),
        0 => Plan::Mesh(star(7, 9, 3.0)),
        // Large coordinates and flat faces along the axes.
        _ => Plan::Mesh(common::moved(&integer_cube(2), 1.0, [40.0, -7.0, 0.0])),
    };
    for level in 0..levels {
        let kind = if kind == "home" && level > 0 {
            "turned"
        } else {
            kind
        };
        let one = |random: &mut Random| (plan.clone(), transform(kind, random));
        plan = Plan::Instances(vec![one(random), one(random), one(random)]);
    }
    plan
}

fn bits(hit: Option<Hit>) -> Option<[u32; 6]> {
    hit.map(|h| {
        let Hit { t, u, v, .. } = h;
        [
            t.to_bits(),
            u.to_bits(),
            v.to_bits(),
            h.prim,
            h.geom,
            h.inst,
        ]
    })
}

/// Every question, against the answers of `list`.
fn assert_same(what: &str, scene: &Scene, list: &Scene, rays: &[Ray]) -> usize {
    let mut closest = vec![None; rays.len()];
    scene.closest_hits(rays, &mut closest);
    let mut occluded = vec![false; rays.len()];
    scene.occluded_each(rays, &mut occluded);
    let mut hits = 0;
    for (i, ray) in rays.iter().enumerate() {
        let all = list.all_hits(ray);
        let right = list.closest_hit(ray);
        let place = || format!("{what}, {}", code(ray));
        hits += usize::from(right.is_some());
        assert_eq!(bits(all.first().copied()), bits(right), "{}", place());
        assert_eq!(bits(scene.closest_hit(ray)), bits(right), "{}", place());
        assert_eq!(bits(closest[i]), bits(right), "slice, {}", place());
        assert_eq!(scene.occluded(ray), right.is_some(), "{}", place());
        assert_eq!(occluded[i], right.is_some(), "slice, {}", place());
        assert_eq!(scene.all_hits(ray), all, "all, {}", place());
        if i % 8 == 0 {
            let mut counts = Counts::default();
            let counted = scene.closest_hit_counted(ray, &mut counts);
            assert_eq!(bits(counted), bits(right), "counted, {}", place());
            let walk = scene.explain(ray);
            assert_eq!(bits(walk.hit), bits(right), "explained, {}", place());
            assert_eq!(walk.counts, counts, "explained, {}", place());
        }
    }
    hits
}

#[test]
fn every_structure_outside_and_inside_agrees_with_the_list() {
    let usual = BuildOptions::default();
    let mut random = Random::new(41);
    for kind in KINDS {
        for levels in 1..=2 {
            let plan = plan(kind, levels, &mut random);
            let rays = rays(&plan.flattened(), 250, u64::from(levels));
            let list = plan.build(("list", &usual), "list");
            let mut hits = 0;
            for outside in STRUCTURES {
                for inside in STRUCTURES {
                    let scene = plan.build((outside.name, &usual), inside.name);
                    let what = format!("{} around {}, {kind}, {levels}", outside.name, inside.name);
                    hits += assert_same(&what, &scene, &list, &rays);
                }
            }
            assert!(hits > 300, "the rays must hit: {kind}, {levels}, {hits}");
        }
    }
}

#[test]
fn every_volume_around_instances_agrees_with_the_list() {
    let mut random = Random::new(43);
    for kind in KINDS {
        let plan = plan(kind, 2, &mut random);
        let rays = rays(&plan.flattened(), 400, 5);
        let list = plan.build(("list", &BuildOptions::default()), "list");
        for structure in ["bounded", "bvh2"] {
            for volume in VOLUMES {
                let options = BuildOptions {
                    volume: volume.name,
                    max_leaf: 1,
                    ..BuildOptions::default()
                };
                let scene = plan.build((structure, &options), "bvh2");
                let what = format!("{structure} {}, {kind}", volume.name);
                assert_same(&what, &scene, &list, &rays);
            }
        }
    }
}

/// Flat boxes, rays at their rims, maps that magnify every rounding: what a box that is too tight would lose.
#[test]
fn rims_of_flat_instances_agree_with_the_list() {
    let mut random = Random::new(45);
    let plate = (
        vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
        vec![[0, 1, 2]],
    );
    let far_plate = common::moved(&plate, 1.0, [1e5, -3e4, 0.0]);
    let finest = BuildOptions {
        max_leaf: 1,
        ..BuildOptions::default()
    };
    for kind in KINDS {
        let content = if kind == "home" { &far_plate } else { &plate };
        let place = |random: &mut Random| (Plan::Mesh(content.clone()), transform(kind, random));
        let plan = Plan::Instances((0..24).map(|_| place(&mut random)).collect());
        // Beside the corners by what roundings may make of it.
        let (corners, _) = plan.flattened();
        let aimed: Vec<Ray> = (0..8000)
            .map(|_| {
                let near = |random: &mut Random, most: f32| {
                    let size = most * 10.0_f32.powf(-7.0 * random.unit());
                    random.point(size)
                };
                let (from, by) = (near(&mut random, 1e4), near(&mut random, 0.1));
                let at = corners[random.below(corners.len())];
                let target: [f32; 3] = std::array::from_fn(|k| at[k] + by[k]);
                let origin: [f32; 3] = std::array::from_fn(|k| at[k] + from[k]);
                Ray::between(origin, target).with_range(0.0, f32::INFINITY)
            })
            .collect();
        let list = plan.build(("list", &finest), "list");
        for structure in ["bounded", "bvh2", "grid"] {
            let scene = plan.build((structure, &finest), "list");
            assert_same(&format!("{structure}, {kind}"), &scene, &list, &aimed);
        }
    }
}

#[test]
fn four_levels_agree_with_the_list() {
    let usual = BuildOptions::default();
    let mut random = Random::new(47);
    for kind in KINDS {
        for levels in 3..=4 {
            let plan = plan(kind, levels, &mut random);
            let rays = rays(&plan.flattened(), 120, 9);
            let list = plan.build(("list", &usual), "list");
            for structure in ["bounded", "bvh2", "grid"] {
                let scene = plan.build((structure, &usual), structure);
                assert_same(
                    &format!("{structure}, {kind}, {levels}"),
                    &scene,
                    &list,
                    &rays,
                );
            }
        }
    }
}

/// The recipe of `geom/transform.rs`, written again.
fn turned(Transform(rows): &Transform, ray: &Ray) -> Ray {
    let m = rows.map(|row| row.map(f64::from));
    let cross = |a: [f64; 4], b: [f64; 4]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let cofactors = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
    let c = cofactors[0];
    let determinant = m[0][0] * c[0] + m[0][1] * c[1] + m[0][2] * c[2];
    let times = |v: [f64; 3]| {
        std::array::from_fn(|i| {
            let r = [0, 1, 2].map(|k| cofactors[k][i] / determinant);
            (r[0] * v[0] + r[1] * v[1] + r[2] * v[2]) as f32
        })
    };
    Ray {
        origin: times(std::array::from_fn(|k| f64::from(ray.origin[k]) - m[k][3])),
        dir: times(ray.dir.map(f64::from)),
        ..*ray
    }
}

#[test]
fn the_answer_is_the_first_of_what_the_turned_rays_find() {
    let mut random = Random::new(51);
    let mesh = star(8, 10, 3.0);
    let content = Arc::new(Scene::new(&mesh.0, &mesh.1).unwrap());
    for kind in KINDS {
        let transforms = [(); 5].map(|()| transform(kind, &mut random));
        let scene = Scene::builder()
            .instances(transforms.map(|t| Instance::new(&content, t)))
            .build()
            .unwrap();
        let flat = Plan::Instances(
            transforms
                .iter()
                .map(|t| (Plan::Mesh(mesh.clone()), *t))
                .collect(),
        );
        let mut found = 0;
        for ray in rays(&flat.flattened(), 2000, 3)
            .iter()
            .filter(|r| r.is_valid())
        {
            let each = (0..).zip(&transforms).flat_map(|(inst, transform)| {
                let hits = content.all_hits(&turned(transform, ray));
                hits.into_iter().map(move |hit| Hit { inst, ..hit })
            });
            let right = each.min_by(Hit::order);
            assert_eq!(
                bits(scene.closest_hit(ray)),
                bits(right),
                "{kind}, {}",
                code(ray)
            );
            found += usize::from(right.is_some());
        }
        assert!(found > 500, "{kind}: {found}");
    }
}

#[test]
fn closed_meshes_stay_closed_on_every_level() {
    let mut random = Random::new(53);
    let mut lines = 0;
    for kind in KINDS {
        for levels in 1..=4 {
            let plan = plan(kind, levels, &mut random);
            let scene = plan.build(("bvh2", &BuildOptions::default()), "bvh2");
            for ray in rays(&plan.flattened(), 1500, 21)
                .iter()
                .filter(|r| r.is_valid())
            {
                let line = ray.with_range(0.0, f32::INFINITY);
                let back = Ray {
                    dir: ray.dir.map(|d| -d),
                    ..line
                };
                let hits: HashSet<_> = [line, back]
                    .iter()
                    .flat_map(|ray| scene.all_hits(ray))
                    .map(|hit| (hit.inst, hit.prim))
                    .collect();
                assert!(
                    hits.len().is_multiple_of(2),
                    "{kind}, {levels}, {}",
                    code(ray)
                );
                lines += hits.len() / 2;
            }
        }
    }
    assert!(lines > 20_000, "{lines}");
}

#[test]
fn the_identity_changes_no_bit() {
    let mesh = star(12, 16, 3.0);
    let plain = Scene::new(&mesh.0, &mesh.1).unwrap();
    let content = Arc::new(Scene::new(&mesh.0, &mesh.1).unwrap());
    let scene = Scene::builder()
        .instance(&content, Transform::IDENTITY)
        .build()
        .unwrap();
    for ray in rays(&mesh, 3000, 13) {
        let named = plain.closest_hit(&ray).map(|hit| Hit { inst: 0, ..hit });
        assert_eq!(bits(scene.closest_hit(&ray)), bits(named), "{}", code(&ray));
    }
}
