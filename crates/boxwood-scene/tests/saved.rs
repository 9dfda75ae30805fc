//! Real and built-in meshes, built, saved and opened again: the same bits to every question.

use std::path::{Path, PathBuf};

use boxwood::check::{Aim, Rays};
use boxwood::{BuildOptions, Hit, Ray, Scene, Triangle};
use boxwood_scene::FlatMesh;

/// Meshes of the folder of shared scenes; none where it is not there.
fn shared() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes");
    let files = [
        "objects/stanford-bunny.obj",
        "thin/slivers_small.ply",
        "arch/kitchen.obj",
        "thin/teapot_in_stadium.obj",
    ];
    let paths = files.map(|file| folder.join(file));
    paths
        .into_iter()
        .filter(|path| {
            if !path.exists() {
                println!("skipped: no {}", path.display());
            }
            path.exists()
        })
        .collect()
}

fn meshes() -> Vec<(String, FlatMesh)> {
    let built_in = [
        "builtin:bush",
        "builtin:stadium",
        "builtin:terrain",
        "builtin:soup?n=5000",
    ]
    .map(str::to_owned);
    let names = built_in.into_iter().chain(
        shared()
            .into_iter()
            .map(|path| path.to_string_lossy().into_owned()),
    );
    names
        .map(|name| {
            let mesh = boxwood_scene::open(&name).unwrap().flatten().unwrap();
            (name, mesh)
        })
        .collect()
}

fn bits(hit: &Hit) -> [u32; 5] {
    [
        hit.t.to_bits(),
        hit.u.to_bits(),
        hit.v.to_bits(),
        hit.prim,
        hit.geom,
    ]
}

fn triangles(mesh: &FlatMesh) -> Vec<Triangle> {
    let corner = |i: u32| mesh.positions[i as usize];
    mesh.indices
        .iter()
        .map(|t| Triangle(t.map(corner)))
        .collect()
}

#[test]
fn opened_scenes_give_the_bits_of_built_ones() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.bwx");
    for (name, mesh) in meshes() {
        let triangles = triangles(&mesh);
        let aimed = Rays::new(&triangles, Aim::Mixed, 5);
        let rays: Vec<Ray> = (0..4000).map(|index| aimed.ray(index)).collect();
        for options in [
            BuildOptions::fast(),
            BuildOptions::default(),
            BuildOptions::high(),
        ] {
            let scene = Scene::builder()
                .mesh(&mesh.positions, &mesh.indices)
                .options(options)
                .build()
                .unwrap();
            let mut file = std::io::BufWriter::new(std::fs::File::create(&path).unwrap());
            let hash = scene.save(&mut file).unwrap();
            drop(file);
            for opened in [Scene::open(&path).unwrap(), Scene::read(&path).unwrap()] {
                assert_eq!(opened.content_hash(), Ok(hash));
                assert_same(&opened, &scene, &rays, &name);
            }
        }
    }
}

fn assert_same(opened: &Scene, built: &Scene, rays: &[Ray], name: &str) {
    let (mut a, mut b) = (vec![None; rays.len()], vec![None; rays.len()]);
    opened.closest_hits(rays, &mut a);
    built.closest_hits(rays, &mut b);
    let same = a
        .iter()
        .flatten()
        .map(bits)
        .eq(b.iter().flatten().map(bits));
    assert!(
        same && a
            .iter()
            .map(Option::is_some)
            .eq(b.iter().map(Option::is_some)),
        "{name}"
    );
    assert!(a.iter().flatten().count() > 500, "{name}");
    let (mut a, mut b) = (vec![false; rays.len()], vec![false; rays.len()]);
    opened.occluded_each(rays, &mut a);
    built.occluded_each(rays, &mut b);
    assert_eq!(a, b, "{name}");
    for ray in &rays[..500] {
        assert!(
            opened
                .all_hits(ray)
                .iter()
                .map(bits)
                .eq(built.all_hits(ray).iter().map(bits)),
            "{name}"
        );
        assert_eq!(
            opened.closest_point(ray.origin),
            built.closest_point(ray.origin),
            "{name}"
        );
    }
    assert_eq!(opened.stats(), built.stats(), "{name}");
}
