//! No leaks, no double hits: rays aimed at the edges and vertices of closed meshes, where every other test fails.
//!
//! A line crosses a closed surface an even number of times. So from inside a ray hits an odd number of triangles, from
//! outside an even number; and a ray at an edge or vertex must hit exactly one of the triangles that share it.

mod common;

use boxwood::{Ray, STRUCTURES, Scene};
use common::{Mesh, Random, code, integer_cube, moved, star};

fn closed_meshes() -> Vec<(&'static str, Mesh, [f32; 3])> {
    let far = [148_376.0, 1234.0, -223_423.0];
    vec![
        ("integer cube", integer_cube(6), [3.0; 3]),
        ("star", star(24, 36, 3.0), [0.0; 3]),
        ("star with fans of 64", star(6, 64, 2.0), [0.0; 3]),
        ("tetrahedron-like, valence 3", star(2, 3, 0.0), [0.0; 3]),
        (
            "star far away, quantised",
            moved(&star(24, 36, 3.0), 2.0, far),
            far,
        ),
        (
            "tiny star",
            moved(&star(12, 16, 2.0), 1e-12, [0.0; 3]),
            [0.0; 3],
        ),
        (
            "huge star",
            moved(&star(12, 16, 2.0), 1e20, [0.0; 3]),
            [0.0; 3],
        ),
    ]
}

/// A point of the mesh: a vertex, a point of an edge as near as floats allow, or any.
fn target(mesh: &Mesh, kind: usize, random: &mut Random) -> [f32; 3] {
    let corners = mesh.1[random.below(mesh.1.len())].map(|i| mesh.0[i as usize]);
    let f = random.unit();
    match kind {
        0 => corners[0],
        1 => std::array::from_fn(|k| corners[0][k] + f * (corners[1][k] - corners[0][k])),
        2 => std::array::from_fn(|k| 0.5 * corners[1][k] + 0.5 * corners[2][k]),
        _ => boxwood::Triangle(corners).point(0.25, f * 0.5),
    }
}

/// Counts hits without a structure and with one, and checks parity in both directions from a point inside.
#[test]
fn rays_aimed_at_edges_and_vertices_never_leak_or_hit_twice() {
    for (name, mesh, middle) in closed_meshes() {
        let list = Scene::builder()
            .mesh(&mesh.0, &mesh.1)
            .structure("list")
            .build()
            .unwrap();
        let tree = Scene::new(&mesh.0, &mesh.1).unwrap();
        let size = f64::from(tree.bounds().diagonal() as f32) as f32;
        let mut random = Random::new(21);
        for i in 0..6000 {
            let inside = std::array::from_fn(|k| middle[k] + random.signed() * size * 0.02);
            let inside = if i % 4 == 0 { middle } else { inside };
            let ray = Ray::between(inside, target(&mesh, i % 4, &mut random))
                .with_range(0.0, f32::INFINITY);
            let hits = tree.all_hits(&ray);
            assert!(
                !hits.len().is_multiple_of(2),
                "{name}: {} hits from inside, {}",
                hits.len(),
                code(&ray)
            );
            assert_eq!(hits, list.all_hits(&ray), "{name}: {}", code(&ray));

            let outside = std::array::from_fn(|k| {
                middle[k] + (ray.dir[k] * 0.7 + random.signed() * size) * 3.0
            });
            let ray = Ray::between(outside, target(&mesh, i % 4, &mut random))
                .with_range(0.0, f32::INFINITY);
            let is_outside = !tree.bounds().contains(outside);
            let hits = tree.all_hits(&ray);
            assert!(
                !is_outside || hits.len().is_multiple_of(2),
                "{name}: {} hits from outside, {}",
                hits.len(),
                code(&ray)
            );
        }
    }
}

#[test]
fn every_box_around_a_hit_triangle_is_hit() {
    for (name, mesh, middle) in closed_meshes() {
        let scene = Scene::new(&mesh.0, &mesh.1).unwrap();
        let mut nodes = Vec::new();
        scene
            .query()
            .for_each_node(&mut |node| nodes.push(node.bounds));
        let mut random = Random::new(3);
        for i in 0..300 {
            let ray = Ray::between(middle, target(&mesh, i % 4, &mut random))
                .with_range(0.0, f32::INFINITY);
            let hit = scene.closest_hit(&ray).expect("from inside");
            let own = scene.triangle(hit.geom, hit.prim).unwrap().bounds();
            let prepared = boxwood::geom::PreparedRay::new(&ray).unwrap();
            let slab = boxwood::geom::SlabRay::new(&prepared, &scene.bounds());
            for bounds in nodes.iter().filter(|b| b.contains_box(&own)) {
                let interval = slab.interval(bounds);
                assert!(
                    interval.near <= hit.t && hit.t <= interval.far,
                    "{name}: {}",
                    code(&ray)
                );
            }
        }
    }
}

/// Integer rays at integer triangles, decided by whole numbers: the sign of the volume of (origin, end, edge).
#[test]
fn integer_scenes_agree_with_whole_number_arithmetic() {
    let mut random = Random::new(40);
    let mut integer = |size: f32| -> [i128; 3] { random.point(size).map(|x| x as i128) };
    let sub = |a: [i128; 3], b: [i128; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let det = |a: [i128; 3], b: [i128; 3], c: [i128; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    let (mut inside, mut outside, mut on_edge) = (0, 0, 0);
    for _ in 0..300_000 {
        let [origin, a, b, c] = [integer(9.0), integer(9.0), integer(9.0), integer(9.0)];
        // Directions whose shear is exact: the largest component is a power of two.
        let mut dir = integer(3.9);
        dir[(a[0].unsigned_abs() % 3) as usize] = if b[0] < 0 { -4 } else { 4 };
        let [pa, pb, pc] = [a, b, c].map(|v| sub(v, origin));
        let volumes = [det(dir, pb, pc), det(dir, pc, pa), det(dir, pa, pb)];
        let whole = det(sub(b, a), sub(c, a), dir);
        let float = |v: [i128; 3]| v.map(|x| x as f32);
        let scene = Scene::new(&[float(a), float(b), float(c)], &[[0, 1, 2]]).unwrap();
        let forward = scene.closest_hit(&Ray::new(float(origin), float(dir)));
        let backward = scene.closest_hit(&Ray::new(float(origin), float(dir.map(|d| -d))));
        let is_hit = forward.is_some() || backward.is_some();
        if volumes.iter().all(|&v| v > 0) || volumes.iter().all(|&v| v < 0) {
            inside += 1;
            assert!(is_hit, "{origin:?} {dir:?} {a:?} {b:?} {c:?}");
            // t = det(a - origin, edges) / det(dir, edges), within rounding.
            let t = det(pa, sub(b, a), sub(c, a)) as f64 / whole as f64;
            let found = forward.map_or_else(|| -backward.unwrap().t, |hit| hit.t);
            assert!(
                (f64::from(found) - t).abs() <= 1e-6 * t.abs(),
                "{found} for {t}"
            );
        } else if volumes.iter().any(|&v| v > 0) && volumes.iter().any(|&v| v < 0) {
            outside += 1;
            assert!(!is_hit, "{origin:?} {dir:?} {a:?} {b:?} {c:?}");
        } else {
            on_edge += 1;
        }
    }
    assert!(
        inside > 10_000 && outside > 10_000 && on_edge > 100,
        "{inside} {outside} {on_edge}"
    );
}

/// What must not change an answer: a scale by a power of two, a turn of the axes, another order of the triangles, a mesh
/// cut in two.
#[test]
fn answers_follow_scale_turn_order_and_cut() {
    let mesh = star(16, 20, 3.0);
    let (positions, indices) = &mesh;
    let scene = Scene::new(positions, indices).unwrap();
    let scale = 2.0_f32.powi(13);
    let scaled = moved(&mesh, scale, [0.0; 3]);
    let scaled = Scene::new(&scaled.0, &scaled.1).unwrap();
    let turn = |p: [f32; 3]| [p[1], p[2], p[0]];
    let turned = Scene::new(
        &positions.iter().map(|p| turn(*p)).collect::<Vec<_>>(),
        indices,
    )
    .unwrap();
    let n = indices.len() as u32;
    let reversed = Scene::new(
        positions,
        &indices.iter().rev().copied().collect::<Vec<_>>(),
    )
    .unwrap();
    let cut = Scene::builder()
        .mesh(positions, &indices[..200])
        .mesh(positions, &indices[200..])
        .build()
        .unwrap();
    let mut hits = 0;
    for ray in common::rays(&mesh, 4000, 8) {
        let hit = scene.closest_hit(&ray);
        hits += usize::from(hit.is_some());
        let far = Ray {
            origin: ray.origin.map(|x| x * scale),
            dir: ray.dir.map(|x| x * scale),
            ..ray
        };
        assert_eq!(scaled.closest_hit(&far), hit, "scaled, {}", code(&ray));
        let halves = cut
            .closest_hit(&ray)
            .map(|h| (h.t, h.u, h.v, h.prim + 200 * h.geom));
        assert_eq!(
            halves,
            hit.map(|h| (h.t, h.u, h.v, h.prim)),
            "cut, {}",
            code(&ray)
        );
        // Where triangles tie in t, another order may prefer another: compare t.
        assert_eq!(
            reversed.closest_hit(&ray).map(|h| h.t),
            hit.map(|h| h.t),
            "reversed, {}",
            code(&ray)
        );
        let unique = scene.all_hits(&ray).windows(2).all(|w| w[0].t != w[1].t);
        if unique {
            let mirrored = reversed
                .closest_hit(&ray)
                .map(|h| (h.u, h.v, n - 1 - h.prim));
            assert_eq!(
                mirrored,
                hit.map(|h| (h.u, h.v, h.prim)),
                "reversed, {}",
                code(&ray)
            );
        }
        let quarter = Ray {
            origin: turn(ray.origin),
            dir: turn(ray.dir),
            ..ray
        };
        // Two equal components may make another axis the main one; then only the answer, not its last bits, must agree.
        let size = ray.dir.map(f32::abs);
        if size[0] != size[1] && size[1] != size[2] && size[0] != size[2] {
            let bits = |h: boxwood::Hit| (h.t, h.u, h.v, h.prim);
            assert_eq!(
                turned.closest_hit(&quarter).map(bits),
                hit.map(bits),
                "turned, {}",
                code(&ray)
            );
        }
    }
    assert!(hits > 1000, "{hits}");
}

/// `t` never leaves the depth of the triangle along the ray, however thin the triangle.
#[test]
fn t_stays_in_the_depth_of_slivers() {
    let mut random = Random::new(31);
    let mut hits = 0;
    for _ in 0..100_000 {
        let a = random.point(1.0);
        let d = random.point(300.0);
        let b: [f32; 3] = std::array::from_fn(|k| a[k] + d[k]);
        let thin = random.point(1e-4);
        let c: [f32; 3] = std::array::from_fn(|k| a[k] + 0.5 * d[k] + thin[k]);
        let origin = random.point(20.0);
        let on = boxwood::Triangle([a, b, c]).point(random.unit() * 0.5, random.unit() * 0.5);
        let ray = Ray::between(origin, on).with_range(0.0, f32::INFINITY);
        let scene = Scene::new(&[a, b, c], &[[0, 1, 2]]).unwrap();
        let Some(hit) = scene.closest_hit(&ray) else {
            continue;
        };
        hits += 1;
        let axis = (0..3)
            .max_by(|&i, &j| ray.dir[i].abs().total_cmp(&ray.dir[j].abs()))
            .unwrap();
        let depths = [a, b, c]
            .map(|p| (f64::from(p[axis]) - f64::from(origin[axis])) / f64::from(ray.dir[axis]));
        let (lo, hi) = (
            depths.into_iter().fold(f64::MAX, f64::min),
            depths.into_iter().fold(f64::MIN, f64::max),
        );
        let slack = 1e-6 * lo.abs().max(hi.abs());
        assert!(
            (lo - slack..=hi + slack).contains(&f64::from(hit.t)),
            "{} not in {lo}..{hi}, {}",
            hit.t,
            code(&ray)
        );
    }
    assert!(hits > 1000, "{hits}");
}

/// Input on which naive builders recurse for ever, and naive grids take all memory.
#[test]
fn a_million_copies_are_bounded_in_depth_and_memory() {
    let positions = [[0.0, 0.0, 1.0], [1.0, 0.25, 1.5], [0.25, 1.0, 1.0]];
    let indices = vec![[0, 1, 2]; 1_000_000];
    for structure in ["bvh2", "wide", "compact", "grid"] {
        let scene = Scene::builder()
            .mesh(&positions, &indices)
            .structure(structure)
            .build()
            .unwrap();
        let stats = scene.stats();
        assert!(stats.max_depth < 96, "{structure}: {}", stats.max_depth);
        assert!(
            stats.bytes < 200 * indices.len(),
            "{structure}: {} bytes",
            stats.bytes
        );
        let hit = scene
            .closest_hit(&Ray::new([0.4, 0.4, 0.0], [0.0, 0.0, 1.0]))
            .unwrap();
        assert_eq!(hit.prim, 0, "{structure}: ties go to the lowest number");
    }
}

#[test]
fn a_range_that_ends_at_minus_zero_ends_at_zero() {
    let positions = [[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [-1.0, 2.0, 0.0]];
    let ray = Ray::new([0.0; 3], [0.1, 0.2, 1.0]).with_range(0.0, -0.0);
    for structure in STRUCTURES {
        // Two in the same place: the lower number wins, wherever the bound stands by then.
        let scene = Scene::builder()
            .mesh(&positions, &[[0, 1, 2], [0, 1, 2]])
            .structure(structure.name)
            .build()
            .unwrap();
        let hit = scene.closest_hit(&ray);
        let mut hits = [None; 80];
        scene.closest_hits(&[ray; 80], &mut hits);
        assert_eq!(
            hit.map(|h| (h.t, h.prim)),
            Some((0.0, 0)),
            "{}",
            structure.name
        );
        assert!(hits.iter().all(|h| *h == hit), "{}", structure.name);
        assert!(scene.occluded(&ray), "{}", structure.name);
    }
}
