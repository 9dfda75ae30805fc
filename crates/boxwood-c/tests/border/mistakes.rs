//! Codes and sentences for every mistake.

use crate::handle::{BOGUS, Handle, last, plate, ray, soup};
use boxwood::Transform;
use boxwood_c::*;
use std::ptr::{null, null_mut};

#[test]
fn mistakes_have_codes_and_sentences_and_change_nothing() {
    let (handle, other) = (Handle::new(), Handle::committed(&[&plate(1.0)]));
    bw_clear_error();
    assert_eq!(last(), (BwError::None, String::new()));
    let (ray, mut hit) = (ray([0.0; 3], [0.0, 0.0, 1.0]), BOGUS);

    assert_eq!(
        handle.intersect1(&ray),
        (
            false,
            BwHit {
                t: f32::INFINITY,
                u: 0.0,
                v: 0.0,
                prim: BW_INVALID_ID,
                geom: BW_INVALID_ID,
                inst: BW_INVALID_ID,
                ng: [0.0; 3]
            }
        )
    );
    assert_eq!(
        last(),
        (
            BwError::NotCommitted,
            "the scene was never committed: call bw_scene_commit first".into()
        )
    );
    assert_eq!(handle.place(&handle, &Transform::IDENTITY), BW_INVALID_ID);
    assert_eq!(last().0, BwError::NotCommitted);

    assert_eq!(
        handle.attach(&(vec![[0.0; 3]; 3], vec![[0, 1, 2], [0, 3, 1]])),
        BW_INVALID_ID
    );
    assert_eq!(
        last(),
        (
            BwError::IndexOutOfRange,
            "mesh 0, triangle 1: vertex 3 of 3".into()
        )
    );
    assert_eq!(handle.set(0, &plate(1.0)), BwError::NoSuchId);
    assert_eq!(last().1, "mesh 0 is to change, the scene has 0");

    let mut matrix = Transform::IDENTITY;
    matrix.0[1][2] = f32::NAN;
    assert_eq!(handle.place(&other, &matrix), BW_INVALID_ID);
    assert_eq!(last(), (BwError::NotFinite, "matrix[6] is NaN".into()));
    assert_eq!(other.place(&other, &Transform::IDENTITY), BW_INVALID_ID);
    assert_eq!(last().0, BwError::Mixed);

    let numbers = [0.0_f32; 9];
    let indices = [0_u32, 1, 2];
    let (at, of) = (numbers.as_ptr(), indices.as_ptr());
    // SAFETY: what is wrong is found before it is followed; what is right is there.
    unsafe {
        let attach = |at, points, step, of, triangles, stride| {
            assert_eq!(
                bw_attach_triangles(handle.0, at, points, step, of, triangles, stride),
                BW_INVALID_ID
            );
            last()
        };
        assert_eq!(
            attach(null(), 3, 0, of, 1, 0),
            (BwError::NullPointer, "positions is NULL".into())
        );
        assert_eq!(
            attach(at, 3, 0, null(), 1, 0),
            (BwError::NullPointer, "indices is NULL".into())
        );
        assert_eq!(attach(at, 3, 8, of, 1, 0).0, BwError::BadStride);
        assert_eq!(attach(at, 3, 0, of, 1, 14).0, BwError::BadStride);
        assert_eq!(
            attach(at.byte_add(2), 2, 0, of, 1, 0).0,
            BwError::Misaligned
        );
        assert_eq!(attach(at, usize::MAX / 4, 0, of, 1, 0).0, BwError::TooLarge);
        let (code, message) = attach(at, 3, 0, of, 1 << 31, 0);
        assert_eq!(code, BwError::TooLarge);
        assert_eq!(
            message,
            "2147483648 primitives, at most 2147483647 are possible"
        );

        assert_eq!(bw_scene_commit(null_mut()), BwError::NullPointer);
        assert_eq!(last().1, "scene is NULL");
        assert!(!bw_intersect1(other.0, null(), &mut hit) && hit.geom == BW_INVALID_ID);
        assert_eq!(last().1, "ray is NULL");
        assert!(!bw_intersect1(other.0, &ray, null_mut()));
        assert_eq!(last().1, "hit is NULL");
        assert!(!bw_occluded1(null(), &ray));
        assert_eq!(
            bw_intersect(other.0, null(), 2, 0, &mut hit, 0),
            BwError::NullPointer
        );
        assert_eq!(
            bw_intersect(other.0, null(), 0, 0, null_mut(), 0),
            BwError::None
        );
        assert_eq!(
            bw_all_hits1(other.0, &ray, null_mut(), 1, null_mut()),
            BwError::NullPointer
        );
        assert_eq!(bw_scene_bounds(other.0, null_mut()), BwError::NullPointer);
        assert_eq!(bw_scene_stats(handle.0, null_mut()), BwError::NullPointer);
        assert_eq!(bw_scene_set_quality(handle.0, 3), BwError::InvalidArgument);
        assert_eq!(
            last().1,
            "quality 3 is not fast (0), default (1) or high (2)"
        );
        assert_eq!(
            bw_scene_set_threads(handle.0, 5000),
            BwError::InvalidArgument
        );
        bw_scene_free(null_mut());
    }
    assert_eq!(handle.commit(), BwError::None, "nothing was attached");
    assert_eq!(handle.stats().triangles, 0);
    assert!(!handle.intersect1(&ray).0);
}

#[test]
fn what_is_not_finite_is_counted_and_missed() {
    let mut mesh = soup(12, 50);
    mesh.0[4][0] = f32::NAN;
    mesh.0[30][2] = f32::INFINITY;
    let handle = Handle::committed(&[&mesh]);
    assert_eq!((handle.stats().triangles, handle.stats().skipped), (50, 2));
    let good = ray([0.0; 3], [0.0, 1.0, 0.0]);
    let bad = [
        ray([0.0, f32::NAN, 0.0], [0.0, 0.0, 1.0]),
        ray([0.0; 3], [0.0; 3]),
        ray([f32::INFINITY, 0.0, 0.0], [0.0, 0.0, 1.0]),
        BwRay {
            t_max: f32::NAN,
            ..good
        },
    ];
    // SAFETY: rays.
    unsafe {
        assert!(bw_ray_is_valid(&good) && !bw_ray_is_valid(null()));
        for ray in &bad {
            assert!(!bw_ray_is_valid(ray));
            assert!(!bw_occluded1(handle.0, ray));
        }
    }
    assert!(
        handle
            .intersect(&bad)
            .iter()
            .all(|hit| hit.geom == BW_INVALID_ID)
    );
}

#[test]
fn the_header_declares_every_function_that_is_exported() {
    let header = include_str!("../../include/boxwood.h");
    let source = include_str!("../../src/api.rs");
    let exported: Vec<&str> = source
        .split("extern \"C\" fn ")
        .skip(1)
        .map(|rest| rest.split('(').next().unwrap())
        .collect();
    assert!(exported.len() > 20, "{exported:?}");
    assert_eq!(
        source.matches("#[unsafe(no_mangle)]").count(),
        exported.len()
    );
    for name in exported {
        assert!(
            header.contains(&format!("{name}(")),
            "cargo xtask c-header: {name} is missing"
        );
    }
}
