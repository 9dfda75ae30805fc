//! Boxwood for a side-by-side measurement that loads peers from shared objects.
//!
//! The interface is the measurement's, so this is the one place with raw pointers: `peer_mode` names what the next build is
//! to be, `peer_build` builds from a triangle soup, `peer_closest` and `peer_occluded` answer slices of rays on the
//! calling thread.
//!
//! Modes: `boxwood-single` asks ray by ray, `boxwood-batch` asks for the whole slice; either with
//! `-fast` or `-high` builds with that preset, and with `-avx2` or `-sse2` uses that instruction set. Any name is split at `-`, also into
//! structures, builders and volumes, as in `boxwood-bvh2-sweep` or `boxwood-bounded-sphere`.

use boxwood::build::PRESETS;
use boxwood::{
    BUILDERS, BuildOptions, Hit, InstructionSet, Query, Ray, STRUCTURES, Structure, VOLUMES,
};
use std::collections::HashMap;
use std::ffi::{CStr, c_char, c_void};
use std::sync::Mutex;
use std::time::Instant;

/// What the next build is to be.
static MODE: Mutex<String> = Mutex::new(String::new());

/// A ray as the measurement has it: the same layout as [`Ray`].
const _: () = assert!(size_of::<Ray>() == 32);

/// A hit as the measurement has it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PeerHit {
    t: f32,
    u: f32,
    v: f32,
    prim: u32,
}

struct Peer {
    query: Box<dyn Query>,
    in_slices: bool,
}

/// Sets the mode of the next build.
///
/// # Safety
/// `name` must point to a string that ends with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_mode(name: *const c_char) {
    // SAFETY: the caller's promise.
    let name = unsafe { CStr::from_ptr(name) };
    *MODE.lock().unwrap() = name.to_string_lossy().into_owned();
}

/// Builds over `count` triangles of nine floats each; writes the milliseconds and the bytes that it took.
///
/// # Safety
/// `floats` must point to `9 * count` numbers, `ms` and `bytes` to one each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_build(
    floats: *const f32,
    count: u32,
    ms: *mut f64,
    bytes: *mut u64,
) -> *mut c_void {
    // SAFETY: the caller's promise.
    let soup =
        unsafe { std::slice::from_raw_parts(floats.cast::<[[f32; 3]; 3]>(), count as usize) };
    let (positions, indices) = indexed(soup);
    let mode = MODE.lock().unwrap().clone();
    let start = Instant::now();
    let query = build(&mode, &positions, &indices);
    let elapsed = start.elapsed();
    // SAFETY: the caller's promise.
    unsafe {
        *ms = elapsed.as_secs_f64() * 1e3;
        *bytes = query.bytes() as u64;
    }
    Box::into_raw(Box::new(Peer {
        query,
        in_slices: !mode.contains("single"),
    }))
    .cast()
}

/// The closest hit of each ray.
///
/// # Safety
/// `peer` must come from [`peer_build`], `rays` and `hits` point to `count` elements each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_closest(
    peer: *mut c_void,
    rays: *const Ray,
    count: usize,
    hits: *mut PeerHit,
) {
    // SAFETY: the caller's promise.
    let (peer, rays, answers) = unsafe {
        let answers = std::slice::from_raw_parts_mut(hits, count);
        (
            &*peer.cast::<Peer>(),
            std::slice::from_raw_parts(rays, count),
            answers,
        )
    };
    if peer.in_slices {
        let mut found = [None; 1024];
        for (rays, answers) in rays.chunks(found.len()).zip(answers.chunks_mut(1024)) {
            peer.query.closest_hits(rays, &mut found[..rays.len()]);
            found
                .iter()
                .zip(answers)
                .for_each(|(hit, answer)| *answer = peer_hit(*hit));
        }
    } else {
        rays.iter()
            .zip(answers)
            .for_each(|(ray, answer)| *answer = peer_hit(peer.query.closest_hit(ray)));
    }
}

/// For each ray 1 if anything is in its way, else 0.
///
/// # Safety
/// `peer` must come from [`peer_build`], `rays` and `occluded` point to `count` elements each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_occluded(
    peer: *mut c_void,
    rays: *const Ray,
    count: usize,
    occluded: *mut u8,
) {
    // SAFETY: the caller's promise.
    let (peer, rays, answers) = unsafe {
        let answers = std::slice::from_raw_parts_mut(occluded, count);
        (
            &*peer.cast::<Peer>(),
            std::slice::from_raw_parts(rays, count),
            answers,
        )
    };
    if peer.in_slices {
        let mut found = [false; 1024];
        for (rays, answers) in rays.chunks(found.len()).zip(answers.chunks_mut(1024)) {
            peer.query.occluded_each(rays, &mut found[..rays.len()]);
            found
                .iter()
                .zip(answers)
                .for_each(|(is, answer)| *answer = u8::from(*is));
        }
    } else {
        rays.iter()
            .zip(answers)
            .for_each(|(ray, answer)| *answer = u8::from(peer.query.occluded(ray)));
    }
}

fn peer_hit(hit: Option<Hit>) -> PeerHit {
    let miss = PeerHit {
        t: f32::INFINITY,
        u: 0.0,
        v: 0.0,
        prim: u32::MAX,
    };
    hit.map_or(miss, |h| PeerHit {
        t: h.t,
        u: h.u,
        v: h.v,
        prim: h.prim,
    })
}

/// An indexed mesh of the soup: vertices that are equal bit for bit become one.
fn indexed(soup: &[[[f32; 3]; 3]]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut positions = Vec::new();
    let mut numbers = HashMap::new();
    let mut number = |p: [f32; 3]| {
        *numbers.entry(p.map(f32::to_bits)).or_insert_with(|| {
            positions.push(p);
            positions.len() as u32 - 1
        })
    };
    let indices = soup.iter().map(|t| t.map(&mut number)).collect();
    (positions, indices)
}

fn build(mode: &str, positions: &[[f32; 3]], indices: &[[u32; 3]]) -> Box<dyn Query> {
    let mut options = BuildOptions::default();
    let mut structure = Structure::DEFAULT;
    let preset = |word| PRESETS.iter().find(move |preset| preset.name == word);
    if let Some(preset) = mode.split('-').find_map(preset) {
        options = (preset.options)();
    }
    for word in mode.split('-') {
        options.instructions = InstructionSet::named(word).unwrap_or(options.instructions);
        let named = |name: &&str| *name == word;
        structure = STRUCTURES
            .iter()
            .map(|s| s.name)
            .find(named)
            .unwrap_or(structure);
        options.volume = VOLUMES
            .iter()
            .map(|v| v.name)
            .find(named)
            .unwrap_or(options.volume);
        options.builder = BUILDERS
            .iter()
            .copied()
            .find(|b| b.name == word)
            .unwrap_or(options.builder);
    }
    let scene = boxwood::Scene::builder()
        .mesh(positions, indices)
        .structure(structure)
        .options(options);
    scene
        .build()
        .expect("indices are of our own making")
        .into_query()
}
