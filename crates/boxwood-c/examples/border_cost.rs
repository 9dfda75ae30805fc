//! What the border costs: a million rays at hills of 131,072 triangles from Rust and as C asks them, in turns, on one thread.
//!
//! `cargo run --release -p boxwood-c --example border_cost`
#![allow(unsafe_code, reason = "half of the calls are C's")]

use boxwood::{Hit, Ray, Scene};
use boxwood_c::*;
use std::time::Instant;

const SIDE: u32 = 256;
const ACROSS: usize = 1000;
const RAYS: usize = ACROSS * ACROSS;
const ROUNDS: usize = 9;

fn main() -> Result<(), boxwood::BuildError> {
    let (positions, indices) = hills();
    let scene = Scene::new(&positions, &indices)?;
    let asked = rays();
    let rays: Vec<Ray> = asked.iter().map(|&ray| ray.into()).collect();
    let mut hits: Vec<Option<Hit>> = vec![None; RAYS];
    let mut answers = vec![std::mem::MaybeUninit::<BwHit>::uninit(); RAYS];
    let first = answers.as_mut_ptr().cast::<BwHit>();
    // SAFETY: the arrays are there, of so many values, as long as they are asked for.
    let handle = unsafe {
        let handle = bw_scene_new();
        let (vertices, triangles) = (positions.len(), indices.len());
        let (positions, indices) = (positions.as_ptr().cast(), indices.as_ptr().cast());
        bw_attach_triangles(handle, positions, vertices, 0, indices, triangles, 0);
        bw_scene_set_threads(handle, 1);
        bw_scene_commit(handle);
        handle
    };
    let mut best = [f64::INFINITY; 4];
    for _ in 0..ROUNDS {
        let round = [
            nanoseconds(|| {
                for (ray, hit) in rays.iter().zip(&mut hits) {
                    *hit = scene.closest_hit(ray);
                }
            }),
            nanoseconds(|| {
                for (index, ray) in asked.iter().enumerate() {
                    // SAFETY: there are as many places as rays.
                    unsafe { bw_intersect1(handle, ray, first.add(index)) };
                }
            }),
            // Slices so small that they stay on this thread.
            nanoseconds(|| {
                for (rays, hits) in rays.chunks(1024).zip(hits.chunks_mut(1024)) {
                    scene.closest_hits(rays, hits);
                }
            }),
            // SAFETY: there are as many places as rays.
            nanoseconds(|| unsafe {
                bw_intersect(handle, asked.as_ptr(), RAYS, 0, first, 0);
            }),
        ];
        for (best, time) in best.iter_mut().zip(round) {
            *best = best.min(time);
        }
    }
    // SAFETY: nobody asks any more.
    unsafe { bw_scene_free(handle) };
    let [rust, c, slices, arrays] = best;
    println!(
        "{} of {RAYS} rays hit; nanoseconds per ray, the best of {ROUNDS} rounds:",
        hits.iter().flatten().count()
    );
    println!("one by one: {rust:.0} from Rust, {c:.0} from C");
    println!("together:   {slices:.0} from Rust, {arrays:.0} from C");
    Ok(())
}

fn hills() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let across = SIDE + 1;
    let height = |x: f32, y: f32| 8.0 * ((0.1 * x).sin() + (0.13 * y).cos());
    let position = |i| {
        let (x, y) = ((i % across) as f32, (i / across) as f32);
        [x, y, height(x, y)]
    };
    let square = |i| {
        let a = i / SIDE * across + i % SIDE;
        let (b, c, d) = (a + 1, a + across, a + across + 1);
        [[a, b, c], [c, b, d]]
    };
    let positions = (0..across * across).map(position).collect();
    (positions, (0..SIDE * SIDE).flat_map(square).collect())
}

/// A camera above a corner, that looks across.
fn rays() -> Vec<BwRay> {
    let ray = |i: usize| BwRay {
        origin: [-20.0, -30.0, 60.0],
        t_min: 0.0,
        dir: [(i % ACROSS) as f32, (ACROSS - i / ACROSS) as f32, -300.0],
        t_max: f32::INFINITY,
    };
    (0..RAYS).map(ray).collect()
}

/// Per ray.
fn nanoseconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e9 / RAYS as f64
}
