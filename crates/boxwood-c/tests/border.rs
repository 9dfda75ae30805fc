//! The functions of the header, called as C calls them: the same bits as from Rust, and a code for every mistake.
#![allow(unsafe_code, reason = "the calls are C's")]

use boxwood::{Hit, Ray, Scene, Transform};
use boxwood_c::*;
use std::ffi::{CStr, CString};
use std::path::Path;
use std::ptr::{null, null_mut};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A handle that frees itself. Only tests of what is allowed share it.
struct Handle(*mut BwScene);

// SAFETY: the header allows every call from every thread.
unsafe impl Sync for Handle {}
// SAFETY: as above.
unsafe impl Send for Handle {}

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: made by `bw_scene_new`, freed once.
        unsafe { bw_scene_free(self.0) };
    }
}

type Mesh = (Vec<[f32; 3]>, Vec<[u32; 3]>);

impl Handle {
    fn new() -> Self {
        let handle = bw_scene_new();
        assert!(!handle.is_null());
        Self(handle)
    }

    fn attach(&self, (positions, indices): &Mesh) -> u32 {
        // SAFETY: the slices are there during the call.
        unsafe {
            bw_attach_triangles(
                self.0,
                positions.as_ptr().cast(),
                positions.len(),
                12,
                indices.as_ptr().cast(),
                indices.len(),
                12,
            )
        }
    }

    fn set(&self, geom: u32, (positions, indices): &Mesh) -> BwError {
        let (vertices, triangles) = (positions.len(), indices.len());
        let (positions, indices) = (positions.as_ptr().cast(), indices.as_ptr().cast());
        // SAFETY: the slices are there during the call.
        unsafe { bw_set_triangles(self.0, geom, positions, vertices, 0, indices, triangles, 0) }
    }

    fn place(&self, content: &Self, matrix: &Transform) -> u32 {
        // SAFETY: twelve numbers.
        unsafe { bw_attach_instance(self.0, content.0, matrix.0.as_ptr().cast(), 1) }
    }

    fn commit(&self) -> BwError {
        // SAFETY: a scene.
        unsafe { bw_scene_commit(self.0) }
    }

    fn committed(meshes: &[&Mesh]) -> Self {
        let handle = Self::new();
        for (mesh, geom) in meshes.iter().zip(0..) {
            assert_eq!(handle.attach(mesh), geom);
        }
        assert_eq!(handle.commit(), BwError::None);
        handle
    }

    fn intersect1(&self, ray: &BwRay) -> (bool, BwHit) {
        let mut hit = BOGUS;
        // SAFETY: a ray, and room for a hit.
        (unsafe { bw_intersect1(self.0, ray, &mut hit) }, hit)
    }

    fn intersect(&self, rays: &[BwRay]) -> Vec<BwHit> {
        let mut hits = vec![BOGUS; rays.len()];
        // SAFETY: as many hits as rays.
        let code =
            unsafe { bw_intersect(self.0, rays.as_ptr(), rays.len(), 0, hits.as_mut_ptr(), 0) };
        assert_eq!(code, BwError::None);
        hits
    }

    fn stats(&self) -> BwStats {
        let mut stats = BwStats {
            triangles: 0,
            stored: 0,
            skipped: 0,
            bytes: 0,
        };
        // SAFETY: room for the answer.
        assert_eq!(unsafe { bw_scene_stats(self.0, &mut stats) }, BwError::None);
        stats
    }
}

/// What no question answers.
const BOGUS: BwHit = BwHit {
    t: -7.0,
    u: -7.0,
    v: -7.0,
    prim: 7,
    geom: 7,
    inst: 7,
    ng: [7.0; 3],
};

fn last() -> (BwError, String) {
    // SAFETY: a C string, copied before the next call.
    let text = unsafe { CStr::from_ptr(bw_last_error_message()) };
    (bw_last_error(), text.to_str().unwrap().to_owned())
}

/// Numbers in -1..1, the same every time.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1_u32 << 23) as f32 - 1.0
    }

    fn point(&mut self, size: f32) -> [f32; 3] {
        std::array::from_fn(|_| size * self.next())
    }
}

/// Triangles all over the place.
fn soup(seed: u64, count: u32) -> Mesh {
    let mut random = Random(seed);
    let corners = |_| {
        let centre = random.point(4.0);
        [(); 3].map(|()| {
            let off = random.point(0.7);
            std::array::from_fn(|k| centre[k] + off[k])
        })
    };
    let positions = (0..count).flat_map(corners).collect();
    (
        positions,
        (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    )
}

fn rays(seed: u64, count: usize) -> Vec<BwRay> {
    let mut random = Random(seed);
    let mut ray = |_| {
        let (from, to) = (random.point(6.0), random.point(3.0));
        let dir = std::array::from_fn(|k| to[k] - from[k]);
        BwRay {
            origin: from,
            t_min: 0.0,
            dir,
            t_max: 1.5,
        }
    };
    (0..count).map(&mut ray).collect()
}

fn ray(origin: [f32; 3], dir: [f32; 3]) -> BwRay {
    BwRay {
        origin,
        t_min: 0.0,
        dir,
        t_max: f32::INFINITY,
    }
}

/// One triangle at a height.
fn plate(z: f32) -> Mesh {
    (
        vec![[-9.0, -9.0, z], [9.0, -9.0, z], [0.0, 9.0, z]],
        vec![[0, 1, 2]],
    )
}

/// The bits of a hit.
fn bits(hit: &BwHit) -> [u32; 9] {
    let [x, y, z] = hit.ng.map(f32::to_bits);
    let [t, u, v] = [hit.t, hit.u, hit.v].map(f32::to_bits);
    [t, u, v, hit.prim, hit.geom, hit.inst, x, y, z]
}

fn same(scene: &Scene, expected: Option<Hit>, found: &BwHit) {
    let Some(hit) = expected else {
        assert_eq!(
            (found.geom, found.prim, found.inst),
            (BW_INVALID_ID, BW_INVALID_ID, BW_INVALID_ID)
        );
        assert_eq!(
            (found.t, found.u, found.v, found.ng),
            (f32::INFINITY, 0.0, 0.0, [0.0; 3])
        );
        return;
    };
    let Hit {
        t,
        u,
        v,
        prim,
        geom,
        inst,
    } = hit;
    let ng = scene.normal(&hit).unwrap();
    assert_eq!(
        bits(found),
        bits(&BwHit {
            t,
            u,
            v,
            prim,
            geom,
            inst,
            ng
        })
    );
}

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
fn name(path: &Path) -> CString {
    CString::new(path.to_str().unwrap()).unwrap()
}

#[test]
fn a_scene_goes_to_a_file_and_comes_back_with_the_same_bits_and_can_be_built_on() {
    let folder = tempfile::tempdir().unwrap();
    let at = name(&folder.path().join("a.bwx"));
    let (a, b) = (soup(15, 600), soup(16, 200));
    let built = Handle::committed(&[&a, &b]);
    let rays = rays(17, 3000);
    let expected: Vec<_> = built.intersect(&rays).iter().map(bits).collect();
    let opened = || {
        // SAFETY: C strings.
        [unsafe { bw_scene_open(at.as_ptr()) }, unsafe {
            bw_scene_read(at.as_ptr())
        }]
    };
    assert_eq!(opened(), [null_mut(); 2]);
    let (code, message) = last();
    assert_eq!(code, BwError::File);
    assert!(message.contains("a.bwx: "), "{message}");
    // SAFETY: a scene and a C string.
    let save = |handle: &Handle| unsafe { bw_scene_save(handle.0, at.as_ptr()) };
    assert_eq!(save(&built), BwError::None);
    let [mapped, copied] = opened().map(Handle);
    // Saved over, while one is mapped.
    assert_eq!(save(&Handle::committed(&[&plate(1.0)])), BwError::None);
    for handle in [&mapped, &copied] {
        let found: Vec<_> = handle.intersect(&rays).iter().map(bits).collect();
        assert_eq!(found, expected);
        assert_eq!(handle.set(0, &(vec![], vec![])), BwError::None);
        assert_eq!(handle.attach(&plate(-20.0)), 2);
        assert_eq!(handle.commit(), BwError::None);
        assert_eq!(handle.stats().triangles, 201);
    }
    let [new, _] = opened().map(Handle);
    assert_eq!(new.stats().triangles, 1);
    let files = folder.path().read_dir().unwrap().count();
    assert_eq!(files, 1, "nothing stays beside it");
}

#[test]
fn what_cannot_be_saved_or_opened_says_why_and_changes_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bwx");
    std::fs::write(&path, "dear").unwrap();
    let (at, within) = (name(&path), name(folder.path()));
    let (plate, world, empty) = (
        Handle::committed(&[&plate(1.0)]),
        Handle::new(),
        Handle::new(),
    );
    world.place(&plate, &Transform::IDENTITY);
    assert_eq!(world.commit(), BwError::None);
    let nowhere = name(&folder.path().join("no/a.bwx"));
    // SAFETY: scenes, and NULL or C strings.
    unsafe {
        assert_eq!(bw_scene_save(world.0, at.as_ptr()), BwError::Unsupported);
        assert!(
            last()
                .1
                .contains("a.bwx: a scene of instances is not saved"),
            "{}",
            last().1
        );
        assert_eq!(bw_scene_save(empty.0, at.as_ptr()), BwError::NotCommitted);
        assert_eq!(bw_scene_save(plate.0, null()), BwError::NullPointer);
        assert_eq!(
            bw_scene_save(plate.0, c"".as_ptr()),
            BwError::InvalidArgument
        );
        assert_eq!(bw_scene_save(plate.0, within.as_ptr()), BwError::File);
        assert_eq!(bw_scene_save(plate.0, nowhere.as_ptr()), BwError::File);
        for open in [bw_scene_open, bw_scene_read] {
            assert!(open(at.as_ptr()).is_null());
            assert_eq!(last().0, BwError::BadFile);
            assert!(
                last().1.contains("a.bwx: is no saved scene"),
                "{}",
                last().1
            );
            assert!(open(null()).is_null());
            assert_eq!(last(), (BwError::NullPointer, "path is NULL".into()));
        }
    }
    assert_eq!(std::fs::read(&path).unwrap(), b"dear");
    assert_eq!(folder.path().read_dir().unwrap().count(), 1);
}

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
    let header = include_str!("../include/boxwood.h");
    let source = include_str!("../src/api.rs");
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
