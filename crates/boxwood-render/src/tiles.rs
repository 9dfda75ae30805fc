//! Tiles of a picture, on all threads: for each, waves of paths through its pixels.

use std::sync::{
    Mutex, MutexGuard, PoisonError,
    atomic::{AtomicBool, AtomicU64, Ordering},
};

use boxwood::{Counts, Hit, Ray};
use glam::Vec3;

use crate::{
    Crop, Film, Keep, RenderError, RenderOptions, TILE, TileWork, View, Watch,
    render::Progress,
    sampler::Sampler,
    share::share_out,
    stage::Stage,
    wave::{MOST_PATHS, Start, Wave},
};

/// The work of one picture, as the threads share it.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    pub(crate) stage: &'a Stage<'a>,
    pub(crate) view: &'a View,
    pub(crate) options: &'a RenderOptions,
    /// Per pixel.
    pub(crate) samples: u32,
    /// Whether the work of the centre rays is counted.
    pub(crate) counted: bool,
}

impl<'a> Job<'a> {
    /// `tiles`, onto the film as they get ready, and each to `keep`, whose first error ends the work.
    pub(crate) fn expose(
        &self,
        film: Film,
        tiles: &[u32],
        watch: Watch<'_>,
        keep: Keep<'_>,
    ) -> Result<Film, RenderError> {
        let window = film.window;
        let size = |&number: &u32| window.tile(number).area();
        let begun: u64 = (0..film.finished.len() as u32)
            .filter(|&number| film.finished[number as usize])
            .map(|number| size(&number))
            .sum();
        let all_pixels = begun + tiles.iter().map(size).sum::<u64>();
        let (pixels, rays) = (AtomicU64::new(begun), AtomicU64::new(0));
        let film = Mutex::new(film);
        let failure = Mutex::new(None);
        let failed = AtomicBool::new(false);
        let cancelled = || {
            let set = |flag: &AtomicBool| flag.load(Ordering::Relaxed);
            watch.cancel.is_some_and(set) || set(&failed)
        };
        let desk = || Desk::of(*self);
        share_out(tiles.len() as u32, desk, |desk, turn| {
            let number = tiles[turn as usize];
            if desk.expose(window.tile(number), &cancelled).is_none() {
                return;
            }
            let done = desk.pixels.len() as u64;
            let pixels = pixels.fetch_add(done, Ordering::Relaxed) + done;
            let rays = rays.fetch_add(desk.rays, Ordering::Relaxed) + desk.rays;
            let mut film = locked(&film);
            // Others may have waited for the film while its last tile could not be kept.
            if failed.load(Ordering::Relaxed) {
                return;
            }
            desk.lay_down(&mut film, number as usize);
            if let Err(error) = keep(&film, &desk.work(number)) {
                failed.store(true, Ordering::Relaxed);
                locked(&failure).get_or_insert(error);
                return;
            }
            drop(film);
            if let Some(report) = watch.report {
                report(Progress {
                    pixels,
                    all_pixels,
                    rays,
                });
            }
        });
        match failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(error) => Err(error),
            None => Ok(film.into_inner().unwrap_or_else(PoisonError::into_inner)),
        }
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Where one thread works on its tiles, one after the other. All memory is used again.
struct Desk<'a> {
    job: Job<'a>,
    wave: Option<Box<dyn Wave + 'a>>,
    pixels: Vec<Pixel>,
    rays: u64,
    counts: Counts,
    camera_rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    starts: Vec<Start>,
    colors: Vec<Vec3>,
}

/// One pixel of the tile, and what is known about it.
struct Pixel {
    /// In the full picture.
    place: [u32; 2],
    /// The sum over its samples.
    color: Vec3,
    /// Of the ray through the centre, as is all below.
    hit: Option<Hit>,
    /// Shading normal; zero where nothing is hit.
    normal: Vec3,
    /// As [`Film::material`] has it.
    material: u32,
    counts: Counts,
}

impl<'a> Desk<'a> {
    fn of(job: Job<'a>) -> Self {
        Self {
            job,
            wave: job.options.shading.wave(job.stage),
            pixels: Vec::new(),
            rays: 0,
            counts: Counts::default(),
            camera_rays: Vec::new(),
            hits: Vec::new(),
            starts: Vec::new(),
            colors: Vec::new(),
        }
    }

    /// All samples of all pixels of `window`; none if it was cancelled on the way.
    fn expose(&mut self, window: Crop, cancelled: &dyn Fn() -> bool) -> Option<()> {
        (self.rays, self.counts) = (0, Counts::default());
        if cancelled() {
            return None;
        }
        self.look_through_centres(window);
        let Some(mut wave) = self.wave.take() else {
            return Some(());
        };
        let exposed = self.sample_all(&mut *wave, cancelled);
        self.wave = Some(wave);
        exposed
    }

    /// What the rays through the pixels' centres hit.
    fn look_through_centres(&mut self, window: Crop) {
        let Job { view, stage, .. } = self.job;
        self.pixels.clear();
        self.pixels.extend(places(window).map(|place| Pixel {
            place,
            color: Vec3::ZERO,
            hit: None,
            normal: Vec3::ZERO,
            material: u32::MAX,
            counts: Counts::default(),
        }));
        let centre_rays = self.pixels.iter().map(|pixel| {
            let [x, y] = pixel.place;
            view.pixel_ray(x, y)
        });
        self.camera_rays.clear();
        self.camera_rays.extend(centre_rays);
        self.rays += self.pixels.len() as u64;
        if self.job.counted {
            self.trace_and_count();
        } else {
            self.trace_camera_rays();
        }
        let answers = self.camera_rays.iter().zip(&self.hits);
        for (pixel, (ray, hit)) in self.pixels.iter_mut().zip(answers) {
            pixel.hit = *hit;
            if let Some(hit) = hit {
                pixel.normal = stage.surfaces.at(ray, hit).normal;
                pixel.material = stage.surfaces.material_index(hit.inst, hit.prim);
            }
        }
    }

    /// One by one: the work of each pixel is asked for.
    fn trace_and_count(&mut self) {
        self.hits.clear();
        for (pixel, ray) in self.pixels.iter_mut().zip(&self.camera_rays) {
            let scene = self.job.stage.scene;
            self.hits
                .push(scene.closest_hit_counted(ray, &mut pixel.counts));
            self.counts += pixel.counts;
        }
    }

    fn trace_camera_rays(&mut self) {
        self.hits.resize(self.camera_rays.len(), None);
        let query = self.job.stage.scene.query();
        query.closest_hits(&self.camera_rays, &mut self.hits);
    }

    /// Some samples of all pixels at a time.
    fn sample_all(&mut self, wave: &mut dyn Wave, cancelled: &dyn Fn() -> bool) -> Option<()> {
        let at_once = (MOST_PATHS / self.pixels.len()).max(1) as u32;
        let mut first = 0;
        while first < self.job.samples {
            let samples = at_once.min(self.job.samples - first);
            self.start(first, samples);
            self.rays += wave.run(&self.starts, &mut self.colors, cancelled)?;
            let colors = self.colors.chunks(samples as usize);
            for (pixel, colors) in self.pixels.iter_mut().zip(colors) {
                for &color in colors {
                    // One sample that is not a number must not blacken the pixel.
                    pixel.color += if color.is_finite() { color } else { Vec3::ZERO };
                }
            }
            first += samples;
        }
        Some(())
    }

    /// Gets ready the paths of these samples, those of one pixel side by side.
    fn start(&mut self, first: u32, samples: u32) {
        let Job { options, view, .. } = self.job;
        let single = self.job.samples == 1;
        self.starts.clear();
        for pixel in &self.pixels {
            let [x, y] = pixel.place;
            for sample in first..first + samples {
                let mut sampler = Sampler::new(options.seed, x, y, sample);
                let ray = if single {
                    view.pixel_ray(x, y)
                } else {
                    let [dx, dy] = sampler.next_pair();
                    view.ray(x as f32 + dx, y as f32 + dy)
                };
                self.starts.push(Start {
                    ray,
                    hit: pixel.hit,
                    sampler,
                });
            }
        }
        // The only sample goes through the centre, and what it hits is known.
        if !single {
            self.trace_starts();
        }
    }

    fn trace_starts(&mut self) {
        self.rays += self.starts.len() as u64;
        self.camera_rays.clear();
        self.camera_rays
            .extend(self.starts.iter().map(|start| start.ray));
        self.trace_camera_rays();
        for (start, hit) in self.starts.iter_mut().zip(&self.hits) {
            start.hit = *hit;
        }
    }

    /// What the tile has cost.
    fn work(&self, number: u32) -> TileWork {
        TileWork {
            number,
            rays: self.rays,
            counts: self.counts,
        }
    }

    /// Onto the film, where it is tile number `number`.
    fn lay_down(&self, film: &mut Film, number: usize) {
        film.finished[number] = true;
        film.rays += self.rays;
        film.counts += self.counts;
        for pixel in &self.pixels {
            let [x, y] = pixel.place;
            let at = film.index(x, y);
            film.color[at] = (pixel.color / self.job.samples as f32).into();
            // A grid asks few boxes and many cells.
            film.box_tests[at] = saturated(pixel.counts.boxes.max(pixel.counts.nodes));
            film.prim_tests[at] = saturated(pixel.counts.prims);
            if let Some(hit) = pixel.hit {
                film.depth[at] = hit.t;
                film.normal[at] = pixel.normal.into();
                film.prim[at] = hit.prim;
                film.material[at] = pixel.material;
            }
        }
    }
}

fn saturated(count: u64) -> u32 {
    count.try_into().unwrap_or(u32::MAX)
}

/// The pixels of a window of at most [`TILE`] x [`TILE`], along Morton's curve: any run of them is
/// compact, and so are the rays through them.
fn places(window: Crop) -> impl Iterator<Item = [u32; 2]> {
    let place = |code: u32| [even_bits(code), even_bits(code >> 1)];
    let inside = move |[x, y]: &[u32; 2]| *x < window.width && *y < window.height;
    (0..TILE * TILE)
        .map(place)
        .filter(inside)
        .map(move |[x, y]| [window.x + x, window.y + y])
}

/// Bits 0, 2, 4 and 6 side by side.
fn even_bits(code: u32) -> u32 {
    (0..4).map(|bit| (code >> bit) & (1 << bit)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pixel_has_its_place_and_aligned_runs_are_squares() {
        let window = |width, height| Crop {
            x: 30,
            y: 50,
            width,
            height,
        };
        let whole: Vec<[u32; 2]> = places(window(TILE, TILE)).collect();
        for run in whole.chunks(64) {
            let side = |axis: usize| {
                let of = |place: &[u32; 2]| place[axis];
                run.iter().map(of).max().unwrap() - run.iter().map(of).min().unwrap() + 1
            };
            assert_eq!([side(0), side(1)], [8, 8]);
        }
        let mut part: Vec<[u32; 2]> = places(window(5, 3)).collect();
        part.sort_unstable();
        let all = (30..35).flat_map(|x| (50..53).map(move |y| [x, y]));
        assert!(part.into_iter().eq(all));
    }
}
