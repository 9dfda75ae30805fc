//! Scenes inside scenes, as their users see them: numbers, masks, limits, and change without a moment of disorder.

mod common;

use boxwood::{
    BuildError, BuildOptions, Hit, Instance, Ray, STRUCTURES, Scene, Sphere, Transform, VOLUMES,
};
use common::{Random, code, rays, star};
use std::sync::Arc;

/// The same bits as brute force.
fn assert_same(what: &str, scene: &Scene, list: &Scene, rays: &[Ray]) {
    for ray in rays {
        let place = || format!("{what}, {}", code(ray));
        assert_eq!(scene.closest_hit(ray), list.closest_hit(ray), "{}", place());
        assert_eq!(scene.occluded(ray), list.occluded(ray), "{}", place());
        assert_eq!(scene.all_hits(ray), list.all_hits(ray), "{}", place());
    }
}

/// A triangle at height `z`, seen from below.
fn plate(z: f32) -> Arc<Scene> {
    let corners = [[-4.0, -4.0, z], [4.0, -4.0, z], [0.0, 4.0, z]];
    Arc::new(Scene::new(&corners, &[[0, 1, 2]]).unwrap())
}

const UP: Ray = Ray::new([0.0; 3], [0.0, 0.0, 1.0]);

#[test]
fn ties_go_to_the_lower_instance_whatever_the_structure() {
    let plates = [2.0, 1.0, 1.0, 1.0].map(plate);
    for structure in STRUCTURES {
        let scene = Scene::builder()
            .instances(plates.iter().map(|p| Instance::new(p, Transform::IDENTITY)))
            .structure(structure.name)
            .build()
            .unwrap();
        let order: Vec<u32> = scene.all_hits(&UP).iter().map(|hit| hit.inst).collect();
        assert_eq!(order, [1, 2, 3, 0], "{}", structure.name);
        assert_eq!(scene.closest_hit(&UP).unwrap().inst, 1);
    }
}

#[test]
fn paths_are_numbered_depth_first_and_lead_to_the_primitive() {
    let up = |z: f32| Transform::translation([0.0, 0.0, z]);
    let inner = Scene::builder()
        .instance(&plate(1.0), up(0.0))
        .instance(&plate(1.0), up(1.0));
    let inner = Arc::new(inner.build().unwrap());
    let scene = Scene::builder()
        .instance(&plate(9.0), up(0.0))
        .instance(&inner, up(2.0))
        .instance(&inner, up(4.0))
        .build()
        .unwrap();
    assert_eq!((scene.nesting(), scene.path_count()), (2, 5));
    let found: Vec<_> = scene
        .all_hits(&UP)
        .iter()
        .map(|hit| {
            let placed = scene.placed(hit.inst).unwrap();
            // The way back ends where the ray hits.
            let corner = placed.scene.triangle(0, 0).unwrap().0[0].map(f64::from);
            let z = placed.world_from_object.point(corner)[2];
            assert_eq!(z, f64::from(hit.t));
            (hit.t, hit.inst, placed.path)
        })
        .collect();
    let right = [
        (3.0, 1, vec![1, 0]),
        (4.0, 2, vec![1, 1]),
        (5.0, 3, vec![2, 0]),
        (6.0, 4, vec![2, 1]),
        (9.0, 0, vec![0]),
    ];
    assert_eq!(found, right);
    assert!(scene.placed(5).is_none() && scene.placed(Hit::NO_INSTANCE).is_none());
    let own = plate(1.0);
    assert!(own.placed(Hit::NO_INSTANCE).unwrap().path.is_empty());
}

#[test]
fn masks_hide_instances_on_every_level() {
    let up = |z: f32| Transform::translation([0.0, 0.0, z]);
    let inner = Scene::builder().instances([
        Instance::new(&plate(1.0), up(0.0)).with_mask(1),
        Instance::new(&plate(1.0), up(1.0)).with_mask(6),
    ]);
    let inner = Arc::new(inner.build().unwrap());
    let scene = Scene::builder().instances([
        Instance::new(&inner, up(0.0)).with_mask(3),
        Instance::new(&plate(1.0), up(4.0)).with_mask(4),
    ]);
    let scene = scene.build().unwrap();
    let seen = |mask| -> Vec<f32> {
        let hits = scene.all_hits_masked(&UP, mask);
        let closest = scene.closest_hit_masked(&UP, mask);
        assert_eq!(closest, hits.first().copied());
        assert_eq!(scene.occluded_masked(&UP, mask), closest.is_some());
        hits.iter().map(|hit| hit.t).collect()
    };
    assert_eq!(seen(u32::MAX), [1.0, 2.0, 5.0]);
    assert_eq!(seen(1), [1.0]);
    assert_eq!(seen(2), [2.0]);
    assert_eq!(
        seen(4),
        [5.0],
        "the outer mask hides what the inner would show"
    );
    assert!(seen(8).is_empty());
    assert_eq!(seen(u32::MAX).len(), scene.all_hits(&UP).len());
}

#[test]
fn what_cannot_be_placed_is_never_hit_and_counted() {
    let (plate, empty) = (plate(1.0), Arc::new(Scene::new(&[], &[]).unwrap()));
    let bad = [
        Transform::scale([1.0, 1.0, 0.0]),
        Transform::scale([f32::NAN, 1.0, 1.0]),
        Transform::translation([0.0, 0.0, f32::INFINITY]),
        Transform::translation([0.0, 0.0, 2e30]),
        Transform::scale([1e-30, 1.0, 1.0]),
    ];
    for structure in STRUCTURES {
        let scene = Scene::builder()
            .instances(bad.map(|t| Instance::new(&plate, t)))
            .instance(&empty, Transform::IDENTITY)
            .instance(&plate, Transform::IDENTITY)
            .structure(structure.name)
            .build()
            .unwrap();
        assert_eq!((scene.len(), scene.skipped()), (7, 6), "{}", structure.name);
        let hit = scene.closest_hit(&UP).unwrap();
        assert_eq!((hit.t, hit.inst), (1.0, 6));
    }
}

#[test]
fn too_deep_too_many_and_mixed_are_errors() {
    let mut scene = plate(1.0);
    for depth in 1..=8 {
        let builder = Scene::builder().instance(&scene, Transform::IDENTITY);
        scene = Arc::new(builder.build().unwrap());
        assert_eq!(scene.nesting(), depth);
        assert_eq!(scene.closest_hit(&UP).unwrap().t, 1.0);
    }
    let builder = Scene::builder().instance(&scene, Transform::IDENTITY);
    let error = builder.build().unwrap_err();
    assert_eq!(error, BuildError::NestedTooDeep { depth: 9, limit: 8 });

    let mut many = plate(1.0);
    for _ in 0..2 {
        let all = (0..1 << 14).map(|_| Instance::new(&many, Transform::IDENTITY));
        many = Arc::new(Scene::builder().instances(all).build().unwrap());
    }
    assert_eq!(many.path_count(), 1 << 28);
    assert_eq!(many.census().shown, 1 << 28);
    let all = (0..1 << 4).map(|_| Instance::new(&many, Transform::IDENTITY));
    let error = Scene::builder().instances(all).build().unwrap_err();
    assert!(matches!(error, BuildError::TooManyPaths { count, .. } if count == 1 << 32));

    let both = Scene::builder()
        .mesh(&[], &[])
        .instance(&plate(1.0), Transform::IDENTITY);
    assert_eq!(both.build().unwrap_err(), BuildError::MixedPrimitives);
}

#[test]
fn kinds_mix_as_instances() {
    let balls = vec![Sphere {
        center: [0.0, 0.0, 5.0],
        radius: 1.0,
    }];
    let balls = Arc::new(Scene::builder().spheres(balls).build().unwrap());
    let scene = Scene::builder()
        .instance(&plate(6.0), Transform::IDENTITY)
        .instance(&balls, Transform::scale([1.0, 1.0, 0.5]))
        .build()
        .unwrap();
    let found: Vec<_> = scene.all_hits(&UP).iter().map(|h| (h.t, h.inst)).collect();
    assert_eq!(found, [(2.0, 1), (6.0, 0)]);
    assert_eq!(
        scene.normal(&scene.all_hits(&UP)[1]),
        Some([0.0, 0.0, 64.0])
    );
}

#[test]
fn a_thousand_copies_are_stored_once() {
    let mesh = star(30, 40, 3.0);
    let content = Arc::new(Scene::new(&mesh.0, &mesh.1).unwrap());
    let place =
        |i: u32| Transform::translation([(i % 32) as f32 * 4.0, (i / 32) as f32 * 4.0, 0.0]);
    let all = (0..1000).map(|i| Instance::new(&content, place(i)));
    let scene = Scene::builder().instances(all).build().unwrap();
    let census = scene.census();
    assert_eq!(census.shown, 1000 * content.len() as u64);
    assert_eq!((census.stored, census.scenes), (content.len() as u64, 2));
    let once = content.census().bytes;
    assert!(census.bytes - once < 1000 * 400, "{census:?}, once {once}");
}

#[test]
fn a_moved_scene_is_new_and_the_old_one_stays() {
    let content = plate(1.0);
    let at = |z: f32| Transform::translation([0.0, 0.0, z]);
    let scene = Scene::builder()
        .instances([at(0.0), at(5.0)].map(|t| Instance::new(&content, t)))
        .structure("grid");
    let scene = scene.build().unwrap();
    let moved = scene.with_transforms(&[at(2.0), at(1.0)]).unwrap();
    let times = |scene: &Scene| -> Vec<f32> { scene.all_hits(&UP).iter().map(|h| h.t).collect() };
    assert_eq!(
        (times(&scene), times(&moved)),
        (vec![1.0, 6.0], vec![2.0, 3.0])
    );
    assert_eq!(moved.structure(), "grid");
    assert!(Arc::ptr_eq(&moved.instances()[0].scene, &content));
    let error = scene.with_transforms(&[at(2.0)]).unwrap_err();
    assert_eq!(error.to_string(), "1 transforms for 2");
}

#[test]
fn a_bent_mesh_is_refitted_and_a_torn_one_built_again() {
    let (positions, indices) = star(24, 30, 3.0);
    let spare = star(8, 10, 2.0);
    let bend = |p: &[f32; 3], by: f32| [p[0] + by * p[1] * p[1], p[1], p[2] * (1.0 + by)];
    for volume in VOLUMES {
        let options = BuildOptions {
            volume: volume.name,
            ..BuildOptions::default()
        };
        let build = |positions: &[[f32; 3]], structure: &str| {
            Scene::builder()
                .mesh(&spare.0, &spare.1)
                .mesh(positions, &indices)
                .structure(structure)
                .options(options.clone())
                .build()
                .unwrap()
        };
        let scene = build(&positions, "bvh2");
        let before = scene.closest_hit(&Ray::new([3.0, 0.1, 0.2], [-1.0, 0.0, 0.0]));
        let bent: Vec<_> = positions.iter().map(|p| bend(p, 0.05)).collect();
        let new = scene.with_mesh(1, &bent, &indices).unwrap();
        assert!(new.is_refitted() && !scene.is_refitted(), "{}", volume.name);
        let list = build(&bent, "list");
        let aimed = rays(&(bent, indices.clone()), 1500, 17);
        assert_same(volume.name, &new, &list, &aimed);
        assert_eq!(
            scene.closest_hit(&Ray::new([3.0, 0.1, 0.2], [-1.0, 0.0, 0.0])),
            before
        );

        // Vertices at random places: the tree is worthless.
        let mut random = Random::new(3);
        let torn: Vec<_> = positions.iter().map(|_| random.point(1.0)).collect();
        let new = new.with_mesh(1, &torn, &indices).unwrap();
        assert!(!new.is_refitted(), "{}", volume.name);
        let aimed = rays(&(torn.clone(), indices.clone()), 500, 17);
        assert_same(volume.name, &new, &build(&torn, "list"), &aimed);
    }
}

#[test]
fn meshes_that_change_what_can_be_hit_are_built_again() {
    let (mut positions, indices) = star(8, 10, 3.0);
    let scene = Scene::new(&positions, &indices).unwrap();
    positions[3] = [f32::NAN; 3];
    let hurt = scene.with_mesh(0, &positions, &indices).unwrap();
    assert!(!hurt.is_refitted() && hurt.skipped() > 0);
    let healed = hurt.with_mesh(0, &star(8, 10, 3.0).0, &indices).unwrap();
    assert_eq!(healed.skipped(), 0);
    for ray in rays(&star(8, 10, 3.0), 500, 2) {
        assert_eq!(healed.closest_hit(&ray), scene.closest_hit(&ray));
    }
}

#[test]
fn impossible_changes_are_errors() {
    let (positions, indices) = star(8, 10, 3.0);
    let scene = Scene::new(&positions, &indices).unwrap();
    let change = |geom, indices: &[[u32; 3]]| scene.with_mesh(geom, &positions, indices);
    let error = change(1, &indices).unwrap_err();
    assert_eq!(error.to_string(), "mesh 1 is to change, the scene has 1");
    let error = change(0, &indices[1..]).unwrap_err();
    assert_eq!(error.to_string(), "139 triangles for 140");
    let mut wild = indices.clone();
    wild[7] = [0, 1, 9999];
    assert!(matches!(
        change(0, &wild),
        Err(BuildError::IndexOutOfRange { triangle: 7, .. })
    ));
    assert!(matches!(
        plate(1.0).with_transforms(&[Transform::IDENTITY]),
        Err(BuildError::WrongCount { expected: 0, .. })
    ));
}

/// Readers on other threads see the scene that they have, whole, while new ones are made.
#[test]
fn readers_never_see_half_a_change() {
    let content = plate(0.0);
    let at = |z: f32| [z, z + 0.5].map(|z| Transform::translation([0.0, 0.0, z]));
    let first = Scene::builder().instances(at(1.0).map(|t| Instance::new(&content, t)));
    let shown = std::sync::RwLock::new(Arc::new(first.build().unwrap()));
    std::thread::scope(|scope| {
        let shown = &shown;
        for _ in 0..2 {
            scope.spawn(move || {
                for _ in 0..2000 {
                    let scene = Arc::clone(&shown.read().unwrap());
                    let times: Vec<f32> = scene.all_hits(&UP).iter().map(|h| h.t).collect();
                    assert_eq!(times.len(), 2);
                    assert_eq!(times[1] - times[0], 0.5, "both of one moment: {times:?}");
                }
            });
        }
        for step in 1..200 {
            let next = shown.read().unwrap().with_transforms(&at(step as f32));
            *shown.write().unwrap() = Arc::new(next.unwrap());
        }
    });
}
