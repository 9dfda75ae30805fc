//! Instances, and what is attached, committed and freed meanwhile.

use crate::handle::{BOGUS, Handle, bits, plate, ray, rays, same, soup};
use boxwood::{Ray, Scene, Transform};
use boxwood_c::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

#[test]
fn instances_move_and_have_masks_and_outlive_their_content() {
    let content = Handle::committed(&[&plate(0.0)]);
    let world = Handle::new();
    let up = |z| Transform::translation([0.0, 0.0, z]);
    assert_eq!(world.place(&content, &up(5.0)), 0);
    assert_eq!(world.place(&content, &up(3.0)), 1);
    drop(content);
    assert_eq!(world.commit(), BwError::None);
    let ray = ray([0.0; 3], [0.0, 0.0, 2.0]);
    let (_, hit) = world.intersect1(&ray);
    assert_eq!((hit.t, hit.inst, hit.geom, hit.prim), (1.5, 1, 0, 0));
    assert_eq!(hit.ng, [0.0, 0.0, 324.0]);
    let mut hit = BOGUS;
    // SAFETY: a ray, and room for a hit.
    unsafe {
        assert!(!bw_intersect1_masked(world.0, &ray, 2, &mut hit));
        assert_eq!(hit.geom, BW_INVALID_ID);
        assert!(bw_intersect1_masked(world.0, &ray, 3, &mut hit));
        assert!(bw_occluded1_masked(world.0, &ray, 1) && !bw_occluded1_masked(world.0, &ray, 6));
        let matrix = up(9.0);
        assert_eq!(
            bw_set_transform(world.0, 1, matrix.0.as_ptr().cast()),
            BwError::None
        );
        assert_eq!(
            bw_set_transform(world.0, 2, matrix.0.as_ptr().cast()),
            BwError::NoSuchId
        );
    }
    assert_eq!(world.intersect1(&ray).1.t, 1.5, "moved, but not committed");
    assert_eq!(world.commit(), BwError::None);
    let (_, hit) = world.intersect1(&ray);
    assert_eq!((hit.t, hit.inst), (2.5, 0));
    let stats = world.stats();
    assert_eq!((stats.triangles, stats.stored, stats.skipped), (2, 1, 0));
    let mut distance = 0.0;
    // SAFETY: one point, one answer.
    let code = unsafe { bw_signed_distances(world.0, ray.origin.as_ptr(), 1, 0, &mut distance) };
    assert_eq!(code, BwError::Unsupported);
}

/// A file's name as C has it.

#[test]
fn what_is_attached_later_counts_from_the_next_commit_and_the_rest_stays() {
    let (a, b) = (soup(10, 400), plate(-20.0));
    let handle = Handle::committed(&[&a]);
    let rays = rays(11, 2000);
    let before = handle.intersect(&rays);
    assert_eq!(handle.attach(&b), 1);
    assert_eq!(
        handle.intersect(&rays).iter().map(bits).collect::<Vec<_>>(),
        before.iter().map(bits).collect::<Vec<_>>()
    );
    assert_eq!(handle.commit(), BwError::None);
    let down = ray([0.0, 0.0, -10.0], [0.0, 0.0, -1.0]);
    assert_eq!(handle.intersect1(&down).1.geom, 1);
    // The first mesh now comes from the committed scene: the same numbers, the same bits.
    let both = Scene::builder()
        .mesh(&a.0, &a.1)
        .mesh(&b.0, &b.1)
        .build()
        .unwrap();
    for (ray, hit) in rays.iter().zip(handle.intersect(&rays)) {
        same(&both, both.closest_hit(&Ray::from(*ray)), &hit);
    }
    assert_eq!(handle.set(1, &plate(-30.0)), BwError::None);
    assert_eq!(handle.set(0, &(vec![], vec![])), BwError::None);
    assert_eq!(handle.commit(), BwError::None);
    assert_eq!(
        (handle.intersect1(&down).1.t, handle.stats().triangles),
        (20.0, 1)
    );
    let mut bounds = BwBounds {
        min: [0.0; 3],
        max: [0.0; 3],
    };
    // SAFETY: room for the answer.
    let code = unsafe { bw_scene_bounds(handle.0, &mut bounds) };
    assert_eq!(code, BwError::None);
    assert_eq!(
        (bounds.min, bounds.max),
        ([-9.0, -9.0, -30.0], [9.0, 9.0, -30.0])
    );
}

#[test]
fn a_commit_disturbs_nobody_who_is_asking() {
    let (low, high) = (plate(5.0), plate(7.0));
    let handle = Handle::committed(&[&low]);
    let rays = vec![ray([0.0; 3], [0.0, 0.0, 1.0]); 3000];
    let is_over = AtomicBool::new(false);
    let seen = std::thread::scope(|scope| {
        let ask = || {
            let mut seen = [0, 0];
            while !is_over.load(Ordering::Relaxed) {
                let first = handle.intersect1(&rays[0]).1.t;
                assert!(first == 5.0 || first == 7.0);
                let hits = handle.intersect(&rays);
                assert!(hits.iter().all(|hit| hit.t == hits[0].t), "never a mixture");
                seen[usize::from(hits[0].t == 7.0)] += 1;
            }
            seen
        };
        let askers = [scope.spawn(ask), scope.spawn(ask)];
        for round in 0..400 {
            assert_eq!(
                handle.set(0, if round % 2 == 0 { &high } else { &low }),
                BwError::None
            );
            assert_eq!(handle.commit(), BwError::None);
        }
        is_over.store(true, Ordering::Relaxed);
        askers.map(|asker| asker.join().unwrap())
    });
    assert!(
        seen[0][0] + seen[1][0] > 0 && seen[0][1] + seen[1][1] > 0,
        "{seen:?}"
    );
}

#[test]
fn instances_in_instances_end_at_eight() {
    let mut inner = Handle::committed(&[&plate(1.0)]);
    for _ in 0..8 {
        let outer = Handle::new();
        assert_eq!(outer.place(&inner, &Transform::IDENTITY), 0);
        assert_eq!(outer.commit(), BwError::None);
        inner = outer;
    }
    let ray = ray([0.0; 3], [0.0, 0.0, 1.0]);
    assert_eq!(inner.intersect1(&ray).1.inst, 0);
    let outer = Handle::new();
    outer.place(&inner, &Transform::IDENTITY);
    assert_eq!(outer.commit(), BwError::Nesting);
}

#[test]
fn a_scene_may_be_freed_while_its_instances_are_asked() {
    let content = Handle::committed(&[&soup(13, 300)]);
    let world = Handle::new();
    world.place(&content, &Transform::IDENTITY);
    assert_eq!(world.commit(), BwError::None);
    let world = Arc::new(world);
    let asked = Arc::clone(&world);
    let rays = rays(14, 4000);
    let expected = content.intersect(&rays);
    let asker = std::thread::spawn(move || asked.intersect(&rays));
    drop(content);
    let found = asker.join().unwrap();
    assert!(
        expected
            .iter()
            .zip(&found)
            .all(|(a, b)| (a.t, a.prim) == (b.t, b.prim))
    );
}
