//! How many frames a second a structure draws: camera rays, shadow rays, shading.

use std::{
    hash::{DefaultHasher, Hash, Hasher},
    sync::atomic::{AtomicU64, Ordering},
    time::{Duration, Instant},
};

use boxwood::{Hit, Ray, Scene};
use boxwood_render::{FrameRays, Frames, Image, Surfaces, Tracer, View};

use crate::measure::{Clock, Task, interleaved};

/// Most frames of each structure.
const MOST: u32 = 41;

/// What one structure does, on all threads of the pool.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameRate {
    /// The median.
    pub(crate) frame: Duration,
    /// Of each frame.
    pub(crate) rays: FrameRays,
    /// The share of the threads' time that goes into the queries, 0 to 1. The rest makes rays, shades, waits.
    pub(crate) query_share: f64,
    /// Of the picture's bytes.
    pub(crate) picture: u64,
}

impl FrameRate {
    /// Frames per second.
    pub(crate) fn per_second(&self) -> f64 {
        1.0 / self.frame.as_secs_f64()
    }

    /// All rays, in 10^6 a second.
    pub(crate) fn mrays_per_second(&self) -> f64 {
        (self.rays.camera + self.rays.shadow) as f64 * 1e-6 * self.per_second()
    }
}

/// Lets the scenes, which hold the same triangles, draw what `view` sees, in turns, for about as long as `patience` all
/// together.
pub(crate) fn frame_rates(
    scenes: &[&Scene],
    surfaces: Surfaces<'_>,
    view: &View,
    patience: Duration,
) -> Vec<FrameRate> {
    let frames = Frames::new(surfaces, view);
    let first: Vec<FrameRate> = scenes
        .iter()
        .map(|scene| first_frame(&frames, scene, view))
        .collect();
    let round: Duration = first.iter().map(|rate| rate.frame).sum();
    let rounds = patience.as_secs_f64() / round.as_secs_f64().max(1e-9);
    let rounds = (rounds as u32).clamp(1, MOST);
    let mut tasks: Vec<Task<'_>> = Vec::new();
    for scene in scenes {
        let (frames, mut image) = (&frames, no_image());
        tasks.push(Box::new(move |_| {
            frames.draw(*scene, view, &mut image);
        }));
    }
    let medians = interleaved(Clock::Wall, rounds as usize, &mut tasks);
    let rates = medians.into_iter().zip(first);
    rates
        .map(|(frame, first)| FrameRate { frame, ..first })
        .collect()
}

/// A frame that warms up, and tells what the next ones will be like.
fn first_frame(frames: &Frames, scene: &Scene, view: &View) -> FrameRate {
    let mut image = no_image();
    let timed = Timed {
        scene,
        nanoseconds: AtomicU64::new(0),
    };
    let start = Instant::now();
    let rays = frames.draw(&timed, view, &mut image);
    let frame = start.elapsed();
    let all_threads = frame.as_secs_f64() * rayon::current_num_threads() as f64;
    let mut hasher = DefaultHasher::new();
    image.rgb.hash(&mut hasher);
    FrameRate {
        frame,
        rays,
        query_share: timed.nanoseconds.into_inner() as f64 * 1e-9 / all_threads,
        picture: hasher.finish(),
    }
}

fn no_image() -> Image {
    Image {
        width: 0,
        height: 0,
        rgb: Vec::new(),
    }
}

/// A scene that looks at the clock, twice a batch.
struct Timed<'a> {
    scene: &'a Scene,
    /// Of all threads.
    nanoseconds: AtomicU64,
}

impl Timed<'_> {
    fn time(&self, batch: impl FnOnce()) {
        let start = Instant::now();
        batch();
        let time = start.elapsed().as_nanos() as u64;
        self.nanoseconds.fetch_add(time, Ordering::Relaxed);
    }
}

impl Tracer for Timed<'_> {
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.time(|| Tracer::closest_hits(self.scene, rays, hits));
    }

    fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.time(|| Tracer::occluded_each(self.scene, rays, occluded));
    }
}
