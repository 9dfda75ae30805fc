//! The functions that C sees, in the order of the header. Each checks what it is given and calls safe code.
#![allow(unsafe_code, reason = "pointers come in, and names go out unmangled")]
#![allow(
    clippy::missing_safety_doc,
    reason = "the comments go into the header, which says at its top what every pointer must be"
)]

use crate::ask;
use crate::error::{self, BwError, Failure, call, status};
use crate::file;
use crate::memory::{self, Input, Output, handle, read, write};
use crate::scene::{BwScene, Given};
use crate::threads::MAX_THREADS;
use crate::types::{BW_INVALID_ID, BwBounds, BwHit, BwNearest, BwQuality, BwRay, BwStats};
use boxwood::{BuildError, Ray, Transform};
use std::ffi::c_char;

/// The version of the library, as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn bw_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}

/// The code of this thread's latest failed call; BW_ERROR_NONE if there was none since `bw_clear_error`.
///
/// Calls that succeed leave it as it is, so that it can be asked once after many.
#[unsafe(no_mangle)]
pub extern "C" fn bw_last_error() -> BwError {
    error::last_code()
}

/// What went wrong in it, in a sentence; "" if nothing did. Never NULL.
///
/// The text belongs to the library and stays until this thread's next failed call, `bw_clear_error` or end: copy it to keep it.
#[unsafe(no_mangle)]
pub extern "C" fn bw_last_error_message() -> *const c_char {
    error::last_message()
}

/// Forgets this thread's error.
#[unsafe(no_mangle)]
pub extern "C" fn bw_clear_error() {
    error::forget();
}

/// A scene of nothing yet; NULL after an error. `bw_scene_free` ends it.
#[unsafe(no_mangle)]
pub extern "C" fn bw_scene_new() -> *mut BwScene {
    call(std::ptr::null_mut(), || {
        Ok(Box::into_raw(Box::new(BwScene::new())))
    })
}

/// Writes the scene as it was last committed to a file (`.bwx`), some 90 bytes a triangle, which `bw_scene_open` opens without a build,
/// as do Rust, Python and the command line. Only triangles that are not compact are saved: BW_ERROR_UNSUPPORTED for others.
///
/// The file is written beside `path` and renamed there: whoever reads what stood there, or has it mapped, keeps it, and after an error it
/// stays. `path` ends with a zero byte, and is UTF-8 where the system does not take any bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_scene_save(scene: *const BwScene, path: *const c_char) -> BwError {
    status(|| {
        // SAFETY: as the header demands of the caller.
        let (scene, path) = unsafe { (handle("scene", scene)?, memory::path(path)?) };
        file::save(&*scene.committed()?, scene.threads(), &path)
    })
}

/// The scene in a file that `bw_scene_save` wrote, committed; NULL after an error. `bw_scene_free` ends it. All bytes are checked first.
///
/// The file is mapped, not copied: all processes that open it share one copy. It must stay as it is until all scenes and instances made
/// of it have gone: saving over it by renaming, as `bw_scene_save` does, is fine, but a program that writes into it in place breaks its
/// readers in any way (wrong answers, a crash), and one that cuts it short ends them (SIGBUS). Where that may be, take `bw_scene_read`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_scene_open(path: *const c_char) -> *mut BwScene {
    // SAFETY: as the header demands of the caller.
    unsafe { from_file(path, true) }
}

/// `bw_scene_open`, but copied into memory: what becomes of the file afterwards does not matter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_scene_read(path: *const c_char) -> *mut BwScene {
    // SAFETY: as the header demands of the caller.
    unsafe { from_file(path, false) }
}

/// Ends a scene; NULL is fine. No other call may be using it. Instances of it in other scenes stay.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_scene_free(scene: *mut BwScene) {
    call((), || {
        if !scene.is_null() {
            // SAFETY: a `Box` made it (`bw_scene_new`, `from_file`), and the caller gives it up.
            drop(unsafe { Box::from_raw(scene) });
        }
        Ok(())
    });
}

/// Adds a mesh of triangles: three floats per position, three numbers of positions per triangle. Both are copied, so the arrays
/// may go.
///
/// Strides are in bytes from one position or triangle to the next, multiples of 4; 0: without gaps. Returns the number of the
/// geometry, 0 for the first (`BwHit.geom`), or BW_INVALID_ID after an error: an index out of range, instances in the scene, more
/// than 2^31 - 1 triangles. Positions that are not finite are no error: their triangles keep their numbers, are never hit, and are
/// counted in `BwStats.skipped`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_attach_triangles(
    scene: *mut BwScene,
    positions: *const f32,
    position_count: usize,
    position_stride: usize,
    indices: *const u32,
    triangle_count: usize,
    index_stride: usize,
) -> u32 {
    call(BW_INVALID_ID, || {
        // SAFETY: as the header demands of the caller.
        unsafe {
            handle("scene", scene)?.attach(given(
                (positions, position_count, position_stride),
                (indices, triangle_count, index_stride),
            )?)
        }
    })
}

/// Puts another mesh in the place of geometry `geom`, of as many triangles as you like; no triangles remove it, and its number
/// stays. It counts from the next commit on. Arguments as in `bw_attach_triangles`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_set_triangles(
    scene: *mut BwScene,
    geom: u32,
    positions: *const f32,
    position_count: usize,
    position_stride: usize,
    indices: *const u32,
    triangle_count: usize,
    index_stride: usize,
) -> BwError {
    status(|| {
        // SAFETY: as the header demands of the caller.
        unsafe {
            let given = given(
                (positions, position_count, position_stride),
                (indices, triangle_count, index_stride),
            )?;
            handle("scene", scene)?.change(geom, given)
        }
    })
}

/// Adds an instance of a committed scene, as it is now: it is shared, not copied, and `content` may change or be freed later.
///
/// `world_from_object` is a 3x4 matrix of twelve floats, row by row: x' = m0 x + m1 y + m2 z + m3, and so on. Rays asked with a mask
/// see the instance if it shares a bit with `mask`; 0xFFFFFFFF is seen by all. A scene is of triangles or of instances. Returns the
/// number of the instance, 0 for the first (`BwHit.inst`), or BW_INVALID_ID after an error. A matrix that cannot be undone is no
/// error: the instance is never hit and counted in `BwStats.skipped`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_attach_instance(
    scene: *mut BwScene,
    content: *const BwScene,
    world_from_object: *const f32,
    mask: u32,
) -> u32 {
    call(BW_INVALID_ID, || {
        // SAFETY: as the header demands of the caller.
        unsafe {
            let (scene, content) = (handle("scene", scene)?, handle("content", content)?);
            scene.place(content, transform(world_from_object)?, mask)
        }
    })
}

/// Moves instance `inst`, from the next commit on. The matrix as in `bw_attach_instance`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_set_transform(
    scene: *mut BwScene,
    inst: u32,
    world_from_object: *const f32,
) -> BwError {
    status(|| {
        // SAFETY: as the header demands of the caller.
        unsafe { handle("scene", scene)?.transform(inst, transform(world_from_object)?) }
    })
}

/// How well the next commit builds: a `BwQuality`. Answers are the same in all.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_scene_set_quality(scene: *mut BwScene, quality: u32) -> BwError {
    status(|| {
        let all = [BwQuality::Fast, BwQuality::Default, BwQuality::High];
        let Some(&known) = all.iter().find(|&&known| known as u32 == quality) else {
            let message = format!("quality {quality} is not fast (0), default (1) or high (2)");
            return Err(Failure::new(BwError::InvalidArgument, message));
        };
        // SAFETY: as the header demands of the caller.
        unsafe { handle("scene", scene)? }.set_quality(known);
        Ok(())
    })
}

/// Whether the next commit builds the form that takes about 0.6 of the memory at about 0.6 of the speed. Answers are the same.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_scene_set_compact(scene: *mut BwScene, is_compact: bool) -> BwError {
    status(|| {
        // SAFETY: as the header demands of the caller.
        unsafe { handle("scene", scene)? }.set_compact(is_compact);
        Ok(())
    })
}

/// On how many threads this scene is committed and answers arrays of questions: 0, as at first, for as many as the machine has; 1
/// for arrays on the calling thread alone. Answers are the same. Threads are shared by all scenes of the same number, and stay.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_scene_set_threads(scene: *mut BwScene, threads: u32) -> BwError {
    status(|| {
        if threads > MAX_THREADS {
            let message = format!("{threads} threads, at most {MAX_THREADS} are possible");
            return Err(Failure::new(BwError::InvalidArgument, message));
        }
        // SAFETY: as the header demands of the caller.
        unsafe { handle("scene", scene)? }.set_threads(threads);
        Ok(())
    })
}

/// Builds what is attached; from then on the scene is asked as it is now. After an error everything is as before.
///
/// Other threads may ask the scene meanwhile: each call gets its answers from before or from after the commit, never a mixture.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_scene_commit(scene: *mut BwScene) -> BwError {
    // SAFETY: as the header demands of the caller.
    status(|| unsafe { handle("scene", scene)? }.commit())
}

/// The box around all that can be hit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_scene_bounds(scene: *const BwScene, bounds: *mut BwBounds) -> BwError {
    status(|| {
        // SAFETY: as the header demands of the caller.
        unsafe {
            let scene = handle("scene", scene)?;
            write("bounds", bounds, || Ok(scene.committed()?.bounds().into()))
        }
    })
}

/// How much the scene holds.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_scene_stats(scene: *const BwScene, stats: *mut BwStats) -> BwError {
    status(|| {
        // SAFETY: as the header demands of the caller.
        unsafe {
            let scene = handle("scene", scene)?;
            write("stats", stats, || Ok(scene.committed()?.stats()))
        }
    })
}

/// False for a ray that hits nothing by definition, because it is none: see `BwRay`. False for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_ray_is_valid(ray: *const BwRay) -> bool {
    call(false, || {
        // SAFETY: as the header demands of the caller.
        let ray = unsafe { read("ray", ray)? };
        Ok(Ray::from(ray).is_valid())
    })
}

/// The closest hit: the one with the smallest `t`, and of equal ones that with the smallest (inst, geom, prim).
///
/// True for a hit. For a miss, and after an error (`bw_last_error`), false, and `hit->geom` is BW_INVALID_ID.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_intersect1(
    scene: *const BwScene,
    ray: *const BwRay,
    hit: *mut BwHit,
) -> bool {
    // SAFETY: as the header demands of the caller.
    unsafe { answer1(scene, ray, hit, |scene, ray| scene.closest_hit(ray)) }
}

/// `bw_intersect1` among the instances whose mask shares a bit with `mask`, on every level. Triangles have no mask and are always
/// there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_intersect1_masked(
    scene: *const BwScene,
    ray: *const BwRay,
    mask: u32,
    hit: *mut BwHit,
) -> bool {
    // SAFETY: as the header demands of the caller.
    unsafe {
        answer1(scene, ray, hit, |scene, ray| {
            scene.closest_hit_masked(ray, mask)
        })
    }
}

/// True if anything is hit in the ray's range. After an error (`bw_last_error`) false.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_occluded1(scene: *const BwScene, ray: *const BwRay) -> bool {
    call(false, || {
        // SAFETY: as the header demands of the caller.
        let (scene, ray) = unsafe { (handle("scene", scene)?, read("ray", ray)?) };
        Ok(scene.committed()?.occluded(&ray.into()))
    })
}

/// `bw_occluded1` by the instances whose mask shares a bit with `mask`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_occluded1_masked(
    scene: *const BwScene,
    ray: *const BwRay,
    mask: u32,
) -> bool {
    call(false, || {
        // SAFETY: as the header demands of the caller.
        let (scene, ray) = unsafe { (handle("scene", scene)?, read("ray", ray)?) };
        Ok(scene.committed()?.occluded_masked(&ray.into(), mask))
    })
}

/// All hits in the ray's range, nearest first, each triangle at most once: the first `capacity` of them are written to `hits`, and
/// how many there are in all to `total`.
///
/// If `total` is larger than `capacity`, ask again with more room. `hits` may be NULL if `capacity` is 0: then they are only counted.
/// Else all of them, 24 bytes each, are in memory meanwhile, however small `capacity` is; a ray may meet every triangle there is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_all_hits1(
    scene: *const BwScene,
    ray: *const BwRay,
    hits: *mut BwHit,
    capacity: usize,
    total: *mut usize,
) -> BwError {
    status(|| {
        // SAFETY: as the header demands of the caller.
        unsafe {
            let (scene, ray) = (handle("scene", scene)?, read("ray", ray)?);
            let mut places = Output::new("hits", hits, capacity, 0)?;
            write("total", total, || {
                let scene = scene.committed()?;
                if capacity == 0 {
                    let mut count = [0];
                    scene.count_hits(&[ray.into()], &mut count);
                    return Ok(count[0] as usize);
                }
                let found = scene.all_hits(&ray.into());
                for (index, &hit) in found.iter().take(capacity).enumerate() {
                    places.set(index, ask::located(&scene, Some(hit)));
                }
                Ok(found.len())
            })
        }
    })
}

/// `bw_intersect1` for `count` rays, on the scene's threads, and up to three times as fast on each.
///
/// Strides are in bytes, multiples of 4; 0: without gaps. Rays and hits may be woven into each other. Neighbours that go the same way
/// are quickest.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_intersect(
    scene: *const BwScene,
    rays: *const BwRay,
    count: usize,
    ray_stride: usize,
    hits: *mut BwHit,
    hit_stride: usize,
) -> BwError {
    status(|| {
        // SAFETY: as the header demands of the caller.
        unsafe {
            let scene = handle("scene", scene)?;
            let rays = Input::new("rays", rays, count, ray_stride)?;
            let hits = Output::new("hits", hits, count, hit_stride)?;
            ask::closest_hits(&*scene.committed()?, scene.threads(), &rays, hits)
        }
    })
}

/// `bw_occluded1` for `count` rays, on the scene's threads: `occluded[i]` is the answer to ray `i`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_occluded(
    scene: *const BwScene,
    rays: *const BwRay,
    count: usize,
    ray_stride: usize,
    occluded: *mut bool,
) -> BwError {
    status(|| {
        // SAFETY: as the header demands of the caller.
        unsafe {
            let scene = handle("scene", scene)?;
            let rays = Input::new("rays", rays, count, ray_stride)?;
            let occluded = Output::new("occluded", occluded, count, 0)?;
            ask::occluded_each(&*scene.committed()?, scene.threads(), &rays, occluded)
        }
    })
}

/// The place of the surface that is nearest to each of `count` points, three floats each: of equally near ones that of the smallest
/// (geom, prim). For scenes of triangles only.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_closest_points(
    scene: *const BwScene,
    points: *const f32,
    count: usize,
    point_stride: usize,
    nearest: *mut BwNearest,
    nearest_stride: usize,
) -> BwError {
    status(|| {
        // SAFETY: as the header demands of the caller.
        unsafe {
            let scene = handle("scene", scene)?;
            let points = Input::new("points", points.cast(), count, point_stride)?;
            let nearest = Output::new("nearest", nearest, count, nearest_stride)?;
            ask::closest_points(&*scene.committed()?, scene.threads(), &points, nearest)
        }
    })
}

/// The distance of each of `count` points to the surface, negative inside: `distances[i]` is that of point `i`, NaN where
/// `bw_closest_points` has no answer. For scenes of triangles only.
///
/// Inside is where a ray to the outside meets an odd number of surfaces: exact on closed meshes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_signed_distances(
    scene: *const BwScene,
    points: *const f32,
    count: usize,
    point_stride: usize,
    distances: *mut f32,
) -> BwError {
    status(|| {
        // SAFETY: as the header demands of the caller.
        unsafe {
            let scene = handle("scene", scene)?;
            let points = Input::new("points", points.cast(), count, point_stride)?;
            let distances = Output::new("distances", distances, count, 0)?;
            ask::signed_distances(&*scene.committed()?, scene.threads(), &points, distances)
        }
    })
}

/// One ray's closest hit, by whatever question.
///
/// # Safety
/// As in `bw_intersect1`.
#[inline]
unsafe fn answer1(
    scene: *const BwScene,
    ray: *const BwRay,
    hit: *mut BwHit,
    closest: impl FnOnce(&boxwood::Scene, &Ray) -> Option<boxwood::Hit>,
) -> bool {
    call(false, || {
        // SAFETY: as promised by the caller.
        let (mut place, scene, ray) = unsafe {
            let mut place = Output::new("hit", hit, 1, 0)?;
            place.set(0, BwHit::MISS);
            (place, handle("scene", scene)?, read("ray", ray)?)
        };
        let scene = scene.committed()?;
        let found = closest(&scene, &ray.into());
        if found.is_some() {
            place.set(0, ask::located(&scene, found));
        }
        Ok(found.is_some())
    })
}

/// A scene of a file.
///
/// # Safety
/// As in `bw_scene_open`.
unsafe fn from_file(path: *const c_char, is_mapped: bool) -> *mut BwScene {
    call(std::ptr::null_mut(), || {
        // SAFETY: as promised by the caller.
        let path = unsafe { memory::path(path)? };
        let scene = file::opened(&path, is_mapped)?;
        Ok(Box::into_raw(Box::new(BwScene::of(scene))))
    })
}

/// A copy of a mesh that C gave: pointers with counts and strides.
///
/// # Safety
/// As in `bw_attach_triangles`.
unsafe fn given(
    positions: (*const f32, usize, usize),
    indices: (*const u32, usize, usize),
) -> Result<Given, Failure> {
    // A scene has no more; so nobody copies what is refused afterwards.
    let (count, limit) = (indices.1, i32::MAX as usize);
    if count > limit {
        return Err(BuildError::TooManyPrimitives { count, limit }.into());
    }
    // SAFETY: as promised by the caller.
    let (positions, indices) = unsafe {
        (
            Input::new("positions", positions.0.cast(), positions.1, positions.2)?,
            Input::new("indices", indices.0.cast(), indices.1, indices.2)?,
        )
    };
    Ok(Given {
        positions: positions.to_vec()?,
        indices: indices.to_vec()?,
    })
}

/// A matrix that C gave.
///
/// # Safety
/// As in `bw_attach_instance`.
unsafe fn transform(matrix: *const f32) -> Result<Transform, Failure> {
    // SAFETY: as promised by the caller.
    let numbers: [f32; 12] = unsafe { read("world_from_object", matrix.cast())? };
    let row = |k: usize| std::array::from_fn(|column| numbers[4 * k + column]);
    Ok(Transform(std::array::from_fn(row)))
}
