//! Scenes that were saved answer as those that were built, and no file makes opening or asking them unsafe.

mod common;

use boxwood::{BuildOptions, FileCause, Hit, InstructionSet, Ray, Scene};
use common::{Mesh, built, code, rays, scenes};

fn saved(scene: &Scene) -> Vec<u8> {
    let mut bytes = Vec::new();
    let hash = scene.save(&mut bytes).unwrap();
    assert_eq!(scene.content_hash(), Ok(hash));
    bytes
}

/// The hash as it must be for these bytes: what a forger would write.
fn seal(bytes: &mut [u8]) {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&bytes[..32]).update(&bytes[64..]);
    bytes[32..64].copy_from_slice(hasher.finalize().as_bytes());
}

fn bits(hit: Option<Hit>) -> Option<[u32; 6]> {
    hit.map(|h| {
        let [t, u, v] = [h.t, h.u, h.v].map(f32::to_bits);
        [t, u, v, h.prim, h.geom, h.inst]
    })
}

/// Every question, to both.
fn assert_same(a: &Scene, b: &Scene, rays: &[Ray], name: &str) {
    assert_eq!(a.bounds(), b.bounds(), "{name}");
    assert_eq!((a.len(), a.skipped()), (b.len(), b.skipped()), "{name}");
    assert_eq!(a.stats(), b.stats(), "{name}");
    let (mut of_a, mut of_b) = (vec![None; rays.len()], vec![None; rays.len()]);
    a.closest_hits(rays, &mut of_a);
    b.closest_hits(rays, &mut of_b);
    for (i, ray) in rays.iter().enumerate() {
        assert_eq!(bits(of_a[i]), bits(of_b[i]), "{name}: {}", code(ray));
        assert_eq!(
            bits(a.closest_hit(ray)),
            bits(b.closest_hit(ray)),
            "{name}: {}",
            code(ray)
        );
        assert_eq!(a.occluded(ray), b.occluded(ray), "{name}: {}", code(ray));
        let all = |scene: &Scene| scene.all_hits(ray).into_iter().map(|hit| bits(Some(hit)));
        assert!(all(a).eq(all(b)), "{name}: {}", code(ray));
    }
    #[cfg(feature = "lists")]
    assert_same_lists(a, b, rays, name);
}

/// Lists and their lengths, of one scene and of the other, as `all_hits` has them.
#[cfg(feature = "lists")]
fn assert_same_lists(a: &Scene, b: &Scene, rays: &[Ray], name: &str) {
    let (of_a, of_b) = (a.list_hits(rays), b.list_hits(rays));
    let counts = [a, b].map(|scene| {
        let mut counts = vec![0; rays.len()];
        scene.count_hits(rays, &mut counts);
        counts
    });
    for (i, ray) in rays.iter().enumerate() {
        let expected = a.all_hits(ray);
        assert_eq!(of_a.of(i), expected, "{name}: {}", code(ray));
        assert_eq!(of_b.of(i), expected, "{name}: {}", code(ray));
        for counts in &counts {
            assert_eq!(counts[i] as usize, expected.len(), "{name}: {}", code(ray));
        }
    }
}

#[cfg(feature = "distances")]
fn assert_same_distances(a: &Scene, b: &Scene, points: &[[f32; 3]], name: &str) {
    for point in points {
        assert_eq!(
            a.closest_point(*point),
            b.closest_point(*point),
            "{name}: {point:?}"
        );
    }
}

#[test]
fn an_opened_scene_answers_bit_for_bit_like_the_built_one_and_like_brute_force() {
    for (name, mesh) in scenes() {
        for options in [
            BuildOptions::fast(),
            BuildOptions::default(),
            BuildOptions::high(),
        ] {
            let scene = built(&mesh, "wide", options);
            let bytes = saved(&scene);
            let opened = Scene::open_bytes(bytes.clone()).unwrap_or_else(|e| panic!("{name}: {e}"));
            let rays = rays(&mesh, 300, 11);
            assert_same(&opened, &scene, &rays, name);
            assert_eq!(saved(&opened), bytes, "{name}");
            assert_eq!(opened.options(), scene.options(), "{name}");
            let list = built(&mesh, "list", BuildOptions::default());
            for ray in &rays {
                let expected = bits(list.closest_hit(ray));
                assert_eq!(
                    bits(opened.closest_hit(ray)),
                    expected,
                    "{name}: {}",
                    code(ray)
                );
            }
            #[cfg(feature = "distances")]
            {
                let points: Vec<_> = rays.iter().map(|ray| ray.origin).collect();
                assert_same_distances(&opened, &scene, &points, name);
            }
        }
    }
}

#[test]
fn an_opened_scene_of_split_triangles_names_each_of_them_once() {
    let scenes = scenes();
    let (name, mesh) = scenes.iter().find(|(name, _)| *name == "slivers").unwrap();
    let options = BuildOptions {
        split_budget: 2.0,
        ..BuildOptions::high()
    };
    let scene = built(mesh, "wide", options);
    let (references, triangles) = (scene.stats().references, scene.len());
    assert!(references > triangles, "{references} of {triangles}");
    let opened = Scene::open_bytes(saved(&scene)).unwrap();
    let rays = rays(mesh, 2000, 5);
    assert_same(&opened, &scene, &rays, name);
    let list = built(mesh, "list", BuildOptions::default());
    for ray in &rays {
        let all = |scene: &Scene| scene.all_hits(ray).into_iter().map(|hit| bits(Some(hit)));
        assert!(all(&opened).eq(all(&list)), "{}", code(ray));
    }
}

#[test]
fn the_same_scene_gives_the_same_bytes_for_every_instruction_set_and_number_of_threads() {
    let (_, mesh) = scenes()
        .into_iter()
        .find(|(name, _)| *name == "cloud")
        .unwrap();
    let bytes = saved(&built(&mesh, "wide", BuildOptions::default()));
    for instructions in InstructionSet::available() {
        let options = BuildOptions {
            instructions,
            ..BuildOptions::default()
        };
        assert_eq!(saved(&built(&mesh, "wide", options)), bytes);
    }
    #[cfg(feature = "rayon")]
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let on_these = pool.install(|| saved(&built(&mesh, "wide", BuildOptions::default())));
        assert_eq!(on_these, bytes);
    }
}

#[test]
fn meshes_and_notes_come_back_and_belong_to_the_hash() {
    let (a, b) = (&scenes()[10].1, &scenes()[13].1);
    let scene = Scene::builder()
        .mesh(&a.0, &a.1)
        .mesh(&[], &[])
        .mesh(&b.0, &b.1)
        .build()
        .unwrap();
    let plain = scene.content_hash().unwrap();
    let scene = scene
        .with_note("units", "mm")
        .with_note("origin", [1, 2, 3]);
    assert_ne!(scene.content_hash().unwrap(), plain);
    let opened = Scene::open_bytes(saved(&scene)).unwrap();
    assert_eq!(opened.content_hash(), scene.content_hash());
    assert_eq!(opened.notes().collect::<Vec<_>>(), ["origin", "units"]);
    assert_eq!(opened.note("units"), Some(&b"mm"[..]));
    assert_eq!(opened.note("unit"), None);
    for (geom, prim) in [(0, 3), (1, 0), (2, 7), (2, b.1.len() as u32), (3, 0)] {
        assert_eq!(opened.triangle(geom, prim), scene.triangle(geom, prim));
    }
    let changed = opened.with_note("units", "inch");
    assert_ne!(changed.content_hash(), scene.content_hash());
    let all: Vec<Ray> = rays(a, 200, 3).into_iter().chain(rays(b, 200, 4)).collect();
    assert_same(&changed, &scene, &all, "two meshes");
    let moved: Vec<_> = b.0.iter().map(|p| p.map(|x| x + 0.25)).collect();
    let [new, expected] = [&changed, &scene].map(|s| s.with_mesh(2, &moved, &b.1).unwrap());
    assert_same(&new, &expected, &all, "a changed mesh");
    assert_eq!(new.notes().count(), 0);
}

#[test]
fn what_is_not_saved_says_so() {
    let mesh = &scenes()[10].1;
    for structure in ["grid", "compact", "bvh2", "list"] {
        let error = built(mesh, structure, BuildOptions::default())
            .content_hash()
            .unwrap_err();
        assert!(error.to_string().contains(structure), "{error}");
    }
    let spheres = vec![boxwood::Sphere {
        center: [0.0; 3],
        radius: 1.0,
    }];
    let spheres = Scene::builder().spheres(spheres).build().unwrap();
    let inner = std::sync::Arc::new(built(mesh, "wide", BuildOptions::default()));
    let outer = Scene::builder().instance(&inner, boxwood::Transform::IDENTITY);
    for scene in [spheres, outer.build().unwrap()] {
        let error = scene.save(&mut Vec::new()).unwrap_err();
        assert!(matches!(error.cause, FileCause::NotSaved { .. }), "{error}");
    }
}

#[test]
fn files_are_opened_mapped_and_copied_and_survive_their_replacement() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bwx");
    let mesh = &scenes()[13].1;
    let scene = built(mesh, "wide", BuildOptions::default());
    std::fs::write(&path, saved(&scene)).unwrap();
    let (mapped, copied) = (Scene::open(&path).unwrap(), Scene::read(&path).unwrap());
    let beside = folder.path().join("b.bwx");
    std::fs::write(
        &beside,
        saved(&built(&scenes()[1].1, "wide", BuildOptions::default())),
    )
    .unwrap();
    std::fs::rename(&beside, &path).unwrap();
    let rays = rays(mesh, 300, 2);
    assert_same(&mapped, &scene, &rays, "mapped");
    assert_same(&copied, &scene, &rays, "copied");
    assert_eq!(Scene::open(&path).unwrap().len(), 1);
}

#[test]
fn errors_name_the_file_and_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("text"), "v 1 2 3").unwrap();
    std::fs::write(at("nothing"), "").unwrap();
    let mut bytes = saved(&built(&scenes()[10].1, "wide", BuildOptions::default()));
    std::fs::write(at("short"), &bytes[..bytes.len() - 1]).unwrap();
    bytes[8] = 9;
    std::fs::write(at("version"), &bytes).unwrap();
    bytes[8] = 1;
    bytes[12..16].reverse();
    std::fs::write(at("endian"), &bytes).unwrap();
    bytes[12..16].reverse();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(at("bit"), &bytes).unwrap();
    for (name, words) in [
        ("text", "no saved scene"),
        ("nothing", "no saved scene"),
        ("missing", "No such file"),
        (".", "no saved scene"),
        ("short", "copy it again"),
        ("version", "version 9.1"),
        ("endian", "little-endian"),
        ("bit", "damaged"),
    ] {
        for error in [Scene::open(at(name)), Scene::read(at(name))] {
            let error = error.unwrap_err().to_string();
            assert!(error.contains(name) && error.contains(words), "{error}");
        }
    }
}

/// A small file with all there is: two meshes, garbage among the triangles, notes, several nodes.
fn small() -> Vec<u8> {
    let (_, mesh) = scenes()
        .into_iter()
        .find(|(name, _)| *name == "slivers")
        .unwrap();
    let indices: Vec<_> = mesh.1.iter().step_by(18).copied().collect();
    let nan = [[f32::NAN, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    let scene = Scene::builder()
        .mesh(&mesh.0, &indices)
        .mesh(&nan, &[[0, 1, 2]])
        .build()
        .unwrap();
    saved(&scene.with_note("units", "mm"))
}

#[test]
fn every_flipped_bit_is_refused() {
    let bytes = small();
    for at in 0..bytes.len() {
        for bit in 0..8 {
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << bit;
            assert!(Scene::open_bytes(flipped).is_err(), "byte {at}, bit {bit}");
        }
    }
}

/// Asks whatever was opened; what matters is that it answers.
fn ask(scene: &Scene, rays: &[Ray]) {
    let (mut hits, mut occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
    scene.closest_hits(rays, &mut hits);
    scene.occluded_each(rays, &mut occluded);
    for (hit, occluded) in hits.iter().zip(&occluded) {
        assert_eq!(hit.is_some(), *occluded);
        if let Some(hit) = hit {
            assert!(scene.triangle(hit.geom, hit.prim).is_some());
        }
    }
    for ray in &rays[..4] {
        scene.all_hits(ray);
        scene.explain(ray);
    }
    #[cfg(feature = "distances")]
    scene.closest_point(rays[0].origin);
    scene.stats();
}

#[test]
fn forged_files_are_refused_or_answer() {
    let bytes = small();
    let opened = Scene::open_bytes(bytes.clone()).unwrap();
    let mesh: Mesh = (vec![[0.0; 3], [3.0; 3], [6.0, 3.0, 0.0]], vec![[0, 1, 2]]);
    let rays = rays(&mesh, 24, 9);
    ask(&opened, &rays);
    let mut accepted = 0;
    for at in (0..bytes.len()).filter(|at| !(32..64).contains(at)) {
        for change in [1, 2, 4, 8, 16, 32, 64, 128, 255] {
            let mut forged = bytes.clone();
            forged[at] ^= change;
            seal(&mut forged);
            if let Ok(scene) = Scene::open_bytes(forged.clone()) {
                // There is one way to write a scene.
                assert_eq!(saved(&scene), forged, "byte {at}");
                ask(&scene, &rays);
                accepted += 1;
            }
        }
    }
    // Notes, options, planes of boxes that still contain all: 1,201 as this is written.
    assert!(accepted > 500, "only {accepted} forgeries were opened");
}

#[test]
fn files_that_were_cut_off_are_refused_at_every_length() {
    let bytes = small();
    for len in 0..bytes.len() {
        let mut cut = bytes[..len].to_vec();
        assert!(Scene::open_bytes(cut.clone()).is_err(), "{len}");
        if len >= 64 {
            cut[24..32].copy_from_slice(&(len as u64).to_le_bytes());
            seal(&mut cut);
            assert!(Scene::open_bytes(cut).is_err(), "{len}, sealed");
        }
    }
}

#[test]
fn hostile_counts_are_refused_without_taking_memory() {
    let bytes = small();
    let table = 64..64 + 64 * 5;
    let fields = [20, 24]
        .into_iter()
        .chain(table.step_by(64).flat_map(|at| [at + 48, at + 56]));
    let facts = u64::from_le_bytes(bytes[112..120].try_into().unwrap()) as usize;
    for at in fields.chain([facts, facts + 8]) {
        let width = if at == 20 { 4 } else { 8 };
        for number in [
            0,
            1,
            1 << 31,
            u64::from(u32::MAX),
            1 << 40,
            u64::MAX - 63,
            u64::MAX,
        ] {
            let mut forged = bytes.clone();
            let number = number.to_le_bytes();
            if forged[at..at + width] == number[..width] {
                continue;
            }
            forged[at..at + width].copy_from_slice(&number[..width]);
            seal(&mut forged);
            assert!(Scene::open_bytes(forged).is_err(), "byte {at}: {number:?}");
        }
    }
}
