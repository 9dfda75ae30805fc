//! Every question has the bits that Rust has.

use crate::handle::{BOGUS, Handle, Random, bits, rays, same, soup};
use boxwood::{Ray, Scene};
use boxwood_c::*;
use std::ptr::null_mut;

#[test]
fn every_question_has_the_bits_that_rust_has() {
    let (a, b) = (soup(1, 900), soup(2, 300));
    let rays = rays(3, 5000);
    let scene = Scene::builder()
        .mesh(&a.0, &a.1)
        .mesh(&b.0, &b.1)
        .build()
        .unwrap();
    for (quality, is_compact, threads) in
        [(0, false, 1), (1, false, 0), (1, true, 3), (2, false, 2)]
    {
        let handle = Handle::new();
        handle.attach(&a);
        handle.attach(&b);
        // SAFETY: a scene.
        unsafe {
            assert_eq!(bw_scene_set_quality(handle.0, quality), BwError::None);
            assert_eq!(bw_scene_set_compact(handle.0, is_compact), BwError::None);
            assert_eq!(bw_scene_set_threads(handle.0, threads), BwError::None);
        }
        assert_eq!(handle.commit(), BwError::None);
        let many = handle.intersect(&rays);
        let mut occluded = vec![false; rays.len()];
        // SAFETY: as many answers as rays.
        let code = unsafe {
            bw_occluded(
                handle.0,
                rays.as_ptr(),
                rays.len(),
                0,
                occluded.as_mut_ptr(),
            )
        };
        assert_eq!(code, BwError::None);
        let mut hits = 0;
        for ((ray, hit), occluded) in rays.iter().zip(&many).zip(occluded) {
            let expected = scene.closest_hit(&Ray::from(*ray));
            same(&scene, expected, hit);
            let (is_hit, one) = handle.intersect1(ray);
            assert_eq!(bits(&one), bits(hit));
            assert_eq!(is_hit, expected.is_some());
            assert_eq!(occluded, is_hit);
            // SAFETY: a ray.
            assert_eq!(unsafe { bw_occluded1(handle.0, ray) }, is_hit);
            hits += usize::from(is_hit);
        }
        assert!(1000 < hits && hits < 4500, "rays must hit and miss: {hits}");
    }
}

#[test]
fn all_hits_come_in_order_and_say_how_many_there_are() {
    let mesh = soup(4, 2000);
    let (scene, handle) = (
        Scene::new(&mesh.0, &mesh.1).unwrap(),
        Handle::committed(&[&mesh]),
    );
    let mut most = 0;
    for ray in rays(5, 200) {
        let expected = scene.all_hits(&Ray::from(ray));
        for capacity in [0, 1, expected.len(), expected.len() + 2] {
            let (mut hits, mut total) = (vec![BOGUS; capacity], usize::MAX);
            let room = if capacity == 0 {
                null_mut()
            } else {
                hits.as_mut_ptr()
            };
            // SAFETY: room for `capacity` hits.
            let code = unsafe { bw_all_hits1(handle.0, &ray, room, capacity, &mut total) };
            assert_eq!((code, total), (BwError::None, expected.len()));
            for (index, hit) in hits.iter().enumerate() {
                match expected.get(index) {
                    Some(&expected) => same(&scene, Some(expected), hit),
                    None => assert_eq!(*hit, BOGUS, "places that are not needed stay"),
                }
            }
        }
        most = most.max(expected.len());
    }
    assert!(most > 3, "some ray must hit often: {most}");
}

#[test]
fn distances_are_those_of_rust() {
    let mesh = soup(6, 500);
    let (scene, handle) = (
        Scene::new(&mesh.0, &mesh.1).unwrap(),
        Handle::committed(&[&mesh]),
    );
    let mut random = Random(7);
    let mut points: Vec<[f32; 3]> = (0..3000).map(|_| random.point(5.0)).collect();
    points[9][1] = f32::NAN;
    let mut places = vec![None; points.len()];
    let mut signed = vec![0.0; points.len()];
    scene.closest_points(&points, &mut places);
    scene.signed_distances(&points, &mut signed);
    let nowhere = BwNearest {
        point: [0.0; 3],
        distance: 0.0,
        u: 7.0,
        v: 7.0,
        prim: 0,
        geom: 0,
    };
    let mut found = vec![nowhere; points.len()];
    let mut distances = vec![0.0_f32; points.len()];
    let start = points.as_ptr().cast();
    // SAFETY: as many answers as points.
    unsafe {
        let code = bw_closest_points(handle.0, start, points.len(), 12, found.as_mut_ptr(), 0);
        assert_eq!(code, BwError::None);
        let code = bw_signed_distances(handle.0, start, points.len(), 0, distances.as_mut_ptr());
        assert_eq!(code, BwError::None);
    }
    for (place, found) in places.iter().zip(&found) {
        match place {
            None => assert!(found.geom == BW_INVALID_ID && found.distance.is_nan()),
            Some(place) => {
                let (found, place) = (*found, BwNearest::from(*place));
                assert_eq!(found, place);
            }
        }
    }
    assert_eq!(found[9].geom, BW_INVALID_ID);
    assert!(signed.iter().any(|&d| d < 0.0));
    let of = |values: &[f32]| {
        values
            .iter()
            .map(|value| value.to_bits())
            .collect::<Vec<_>>()
    };
    assert_eq!(of(&distances), of(&signed));
}

#[test]
fn strides_step_over_what_is_between() {
    /// A vertex as graphics programs have them, and a ray beside its hit.
    #[derive(Clone, Copy)]
    #[repr(C)]
    struct Vertex {
        position: [f32; 3],
        colour: [u8; 4],
    }
    #[derive(Clone, Copy)]
    #[repr(C)]
    struct RayHit {
        ray: BwRay,
        tag: u32,
        hit: BwHit,
    }
    let mesh = soup(8, 700);
    let tight = Handle::committed(&[&mesh]);
    let vertices: Vec<_> = mesh
        .0
        .iter()
        .map(|&position| Vertex {
            position,
            colour: [255; 4],
        })
        .collect();
    let corners: Vec<[u32; 4]> = mesh
        .1
        .iter()
        .map(|&[a, b, c]| [a, b, c, u32::MAX])
        .collect();
    let handle = Handle::new();
    // SAFETY: as many vertices and triangles, 16 bytes apart.
    let geom = unsafe {
        let (positions, indices) = (vertices.as_ptr().cast(), corners.as_ptr().cast());
        bw_attach_triangles(
            handle.0,
            positions,
            vertices.len(),
            16,
            indices,
            corners.len(),
            16,
        )
    };
    assert_eq!((geom, handle.commit()), (0, BwError::None));
    let rays = rays(9, 3000);
    let mut woven: Vec<_> = rays
        .iter()
        .map(|&ray| RayHit {
            ray,
            tag: 42,
            hit: BOGUS,
        })
        .collect();
    let stride = size_of::<RayHit>();
    let start = woven.as_mut_ptr();
    // SAFETY: rays and hits in one array, each a struct apart.
    let code = unsafe {
        let (rays, hits) = (&raw const (*start).ray, &raw mut (*start).hit);
        bw_intersect(handle.0, rays, woven.len(), stride, hits, stride)
    };
    assert_eq!(code, BwError::None);
    for ((expected, woven), ray) in tight.intersect(&rays).iter().zip(&woven).zip(&rays) {
        assert_eq!(bits(expected), bits(&woven.hit));
        assert_eq!((woven.tag, woven.ray), (42, *ray));
    }
}
