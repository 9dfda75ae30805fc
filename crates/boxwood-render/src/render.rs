//! From a scene and a view to an exposed film: tiles on all cores.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use boxwood::{Counts, Hit, Ray, Scene};
use glam::Vec3;
use rayon::prelude::*;

use crate::{
    Film, PointLight, RenderError, Scale, ScaleOptions, Shading, Surfaces, TILE, Tone, View,
    probe::Probe,
    sampler::Sampler,
    shade::{DARK, Layer, Paint},
    stage::Stage,
    tone::luminance,
};

/// Most pixels of one film; larger pictures are made in crops. A film of that size takes about 12
/// GB.
pub const MAX_PIXELS: u64 = 1 << 28;
/// Most samples per pixel.
pub const MAX_SAMPLES: u32 = 1 << 20;

/// What picture to make.
#[derive(Clone, Debug)]
pub struct RenderOptions {
    /// From [`crate::SHADINGS`].
    pub shading: &'static Shading,
    /// Per pixel, 1 to [`MAX_SAMPLES`]; none: [`Shading::samples`]. A single one goes through the
    /// pixel's centre.
    pub samples: Option<u32>,
    /// Another seed gives another noise.
    pub seed: u64,
    /// Only this part of the picture; the pixels are the same as in the whole.
    pub crop: Option<Crop>,
    /// Most bounces of light; 0 shows direct glow only.
    pub max_depth: u32,
    /// Lamps besides what glows in the scene.
    pub lights: Vec<PointLight>,
    /// Strength of sun and sky; 0 is night. None: 1, but 0 in interiors that have lights of their
    /// own.
    pub sky: Option<f32>,
    /// A floor under objects that are seen from outside by daylight.
    pub floor: bool,
    /// In stops, 0 is neutral; no matter for colours that are data. None: neutral by daylight,
    /// measured indoors and where lamps shine.
    pub exposure: Option<f32>,
    /// For depth and heat.
    pub scale: ScaleOptions,
}

impl RenderOptions {
    /// Everything automatic.
    pub fn new(shading: &'static Shading) -> Self {
        Self {
            shading,
            samples: None,
            seed: 0,
            crop: None,
            max_depth: 8,
            lights: Vec::new(),
            sky: None,
            floor: true,
            exposure: None,
            scale: ScaleOptions::default(),
        }
    }
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Left edge.
    pub x: u32,
    /// Upper edge.
    pub y: u32,
    /// At least 1.
    pub width: u32,
    /// At least 1.
    pub height: u32,
}

/// How the caller looks on, and stops the work. The default does neither.
#[derive(Clone, Copy, Default)]
pub struct Watch<'a> {
    /// Set it, and [`render`] returns within the time of some pixels, with the tiles that are done.
    pub cancel: Option<&'a AtomicBool>,
    /// Called after each tile, from any thread.
    pub report: Option<&'a (dyn Fn(Progress) + Sync)>,
}

/// What is done so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Of finished tiles.
    pub pixels: u64,
    /// Of the whole film.
    pub all_pixels: u64,
    /// Shot for the finished tiles.
    pub rays: u64,
}

/// Renders `scene`, seen from `view`, on the threads of the caller's rayon pool.
///
/// `scene` must be built from the one mesh that `surfaces` describe, in the same order. The film is
/// the same, bit for bit, for any number of threads; each sample's randomness depends only on seed,
/// pixel and number. Fails only if the options are out of range, the memory is refused, or the scene has not as many
/// primitives as the surfaces have triangles. An interrupted picture is a film whose
/// [`Film::is_complete`] is false.
pub fn render(
    scene: &Scene,
    surfaces: Surfaces<'_>,
    view: &View,
    options: &RenderOptions,
    watch: Watch<'_>,
) -> Result<Film, RenderError> {
    let window = check(view, options)?;
    if scene.len() != surfaces.triangles().len() {
        return Err(RenderError::Size {
            what: format!(
                "the scene has {} primitives, its surfaces {}",
                scene.len(),
                surfaces.triangles().len()
            ),
            remedy: "build both from the same flattened mesh",
        });
    }
    let mut stage = Stage::new(scene, surfaces, view, options);
    let shading = options.shading;
    stage.exposure = exposure(&stage, view, options);
    let job = Job {
        stage: &stage,
        view,
        window,
        options,
        samples: options.samples.unwrap_or(shading.samples),
    };
    let film = Film::unexposed(
        window,
        [view.width(), view.height()],
        shading.tone,
        stage.exposure,
    )?;
    let mut film = job.expose(film, watch);
    if let Paint::Layer(layer) = shading.paint {
        color_layer(&mut film, &layer, options.scale);
    }
    Ok(film)
}

/// As asked for; else measured where the brightness of the lamps is anyone's guess.
fn exposure(stage: &Stage<'_>, view: &View, options: &RenderOptions) -> f32 {
    match (options.exposure, options.shading.paint) {
        // Colours that are data are not light.
        _ if options.shading.tone == Tone::Clamp => 1.0,
        (Some(stops), _) => libm::exp2f(stops),
        (None, Paint::Rays(paint)) if options.shading.lit && stage.adapts => {
            measured_exposure(stage, view, paint)
        }
        _ => 1.0,
    }
}

/// The window to render.
fn check(view: &View, options: &RenderOptions) -> Result<Crop, RenderError> {
    let whole = Crop {
        x: 0,
        y: 0,
        width: view.width(),
        height: view.height(),
    };
    let window = options.crop.unwrap_or(whole);
    let fits = |start: u32, length: u32, all: u32| {
        length > 0 && start.checked_add(length).is_some_and(|end| end <= all)
    };
    if !fits(window.x, window.width, whole.width) || !fits(window.y, window.height, whole.height) {
        return Err(RenderError::Size {
            what: format!(
                "the crop {},{},{},{} is not inside {}x{}",
                window.x, window.y, window.width, window.height, whole.width, whole.height
            ),
            remedy: "choose x, y, width and height within the picture",
        });
    }
    if u64::from(window.width) * u64::from(window.height) > MAX_PIXELS {
        return Err(RenderError::Size {
            what: format!(
                "{}x{} pixels do not fit one film",
                window.width, window.height
            ),
            remedy: "render it in crops of at most 268 million pixels",
        });
    }
    if options.samples.is_some_and(|n| n == 0 || n > MAX_SAMPLES) {
        return Err(RenderError::Size {
            what: format!("{} samples per pixel", options.samples.unwrap_or(0)),
            remedy: "choose 1 to 1048576",
        });
    }
    Ok(window)
}

/// Tiles between two visits to the film: a million pixels, so that few wait there, and memory stays
/// small.
const BATCH: u32 = 4096;

/// The work of one picture, as the threads share it.
#[derive(Clone, Copy)]
struct Job<'a> {
    stage: &'a Stage<'a>,
    view: &'a View,
    window: Crop,
    options: &'a RenderOptions,
    samples: u32,
}

/// A finished tile.
struct Tile {
    pixels: Vec<Pixel>,
    rays: u64,
    counts: Counts,
}

struct Pixel {
    color: Vec3,
    /// Of the centre ray: hit, shading normal, box tests, primitive tests.
    hit: Option<(Hit, Vec3)>,
    box_tests: u32,
    prim_tests: u32,
}

impl Job<'_> {
    /// All tiles, in parallel, and then onto the film in their order.
    fn expose(&self, mut film: Film, watch: Watch<'_>) -> Film {
        let columns = self.window.width.div_ceil(TILE);
        let tiles = columns * self.window.height.div_ceil(TILE);
        let (pixels, rays) = (AtomicU64::new(0), AtomicU64::new(0));
        let all_pixels = film.color.len() as u64;
        let expose = |index: u32| {
            let tile = self.tile(self.tile_window(index, columns), watch.cancel)?;
            let done = tile.pixels.len() as u64;
            let pixels = pixels.fetch_add(done, Ordering::Relaxed) + done;
            let rays = rays.fetch_add(tile.rays, Ordering::Relaxed) + tile.rays;
            if let Some(report) = watch.report {
                report(Progress {
                    pixels,
                    all_pixels,
                    rays,
                });
            }
            Some(tile)
        };
        for first in (0..tiles).step_by(BATCH as usize) {
            let batch = first..tiles.min(first.saturating_add(BATCH));
            // One tile at a time: neighbours differ in cost.
            let exposed: Vec<Option<Tile>> = batch
                .clone()
                .into_par_iter()
                .with_max_len(1)
                .map(expose)
                .collect();
            for (index, tile) in batch.zip(exposed) {
                if let Some(tile) = tile {
                    self.lay_down(
                        &mut film,
                        index as usize,
                        self.tile_window(index, columns),
                        &tile,
                    );
                }
            }
        }
        film
    }

    /// In pixels of the full picture.
    fn tile_window(&self, index: u32, columns: u32) -> Crop {
        let (x, y) = (index % columns * TILE, index / columns * TILE);
        Crop {
            x: self.window.x + x,
            y: self.window.y + y,
            width: TILE.min(self.window.width - x),
            height: TILE.min(self.window.height - y),
        }
    }

    /// None if it was cancelled on the way.
    fn tile(&self, window: Crop, cancel: Option<&AtomicBool>) -> Option<Tile> {
        let cancelled = || cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
        let mut tile = Tile {
            pixels: Vec::new(),
            rays: 0,
            counts: Counts::default(),
        };
        for y in window.y..window.y + window.height {
            for x in window.x..window.x + window.width {
                if cancelled() {
                    return None;
                }
                let pixel = self.pixel(x, y, &mut tile);
                tile.pixels.push(pixel);
            }
        }
        Some(tile)
    }

    fn pixel(&self, x: u32, y: u32, tile: &mut Tile) -> Pixel {
        let ray = self.view.pixel_ray(x, y);
        let mut counts = Counts::default();
        let hit = self.stage.scene.closest_hit_counted(&ray, &mut counts);
        tile.rays += 1;
        tile.counts += counts;
        let color = match self.options.shading.paint {
            Paint::Layer(_) => Vec3::ZERO,
            Paint::Rays(paint) => self.color(paint, x, y, (&ray, hit), &mut tile.rays),
        };
        Pixel {
            color,
            hit: hit.map(|hit| (hit, self.stage.surfaces.at(&ray, &hit).normal)),
            // A grid asks few boxes and many cells.
            box_tests: counts
                .boxes
                .max(counts.nodes)
                .try_into()
                .unwrap_or(u32::MAX),
            prim_tests: counts.prims.try_into().unwrap_or(u32::MAX),
        }
    }

    /// The mean over the samples of a pixel; a single sample takes the centre ray as it is.
    fn color(
        &self,
        paint: fn(&mut Probe<'_>, &Ray, Option<Hit>) -> Vec3,
        x: u32,
        y: u32,
        centre: (&Ray, Option<Hit>),
        rays: &mut u64,
    ) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for sample in 0..self.samples {
            let mut probe = Probe {
                stage: self.stage,
                sampler: Sampler::new(self.options.seed, x, y, sample),
                rays: 0,
            };
            let color = if self.samples == 1 {
                paint(&mut probe, centre.0, centre.1)
            } else {
                let [dx, dy] = probe.sampler.next_pair();
                let ray = self.view.ray(x as f32 + dx, y as f32 + dy);
                probe.rays += 1;
                paint(&mut probe, &ray, self.stage.scene.closest_hit(&ray))
            };
            // One sample that is not a number must not blacken the pixel.
            sum += if color.is_finite() { color } else { Vec3::ZERO };
            *rays += probe.rays;
        }
        sum / self.samples as f32
    }

    fn lay_down(&self, film: &mut Film, index: usize, window: Crop, tile: &Tile) {
        film.finished[index] = true;
        film.rays += tile.rays;
        film.counts += tile.counts;
        let width = self.window.width as usize;
        for (place, pixel) in tile.pixels.iter().enumerate() {
            let (column, row) = (place % window.width as usize, place / window.width as usize);
            let at = ((window.y - self.window.y) as usize + row) * width
                + (window.x - self.window.x) as usize
                + column;
            film.color[at] = pixel.color.into();
            film.box_tests[at] = pixel.box_tests;
            film.prim_tests[at] = pixel.prim_tests;
            if let Some((hit, normal)) = &pixel.hit {
                film.depth[at] = hit.t;
                film.normal[at] = normal.to_array();
                film.prim[at] = hit.prim;
                film.material[at] = self.stage.surfaces.material_index(hit.prim);
            }
        }
    }
}

/// The exposure at which the median of what the camera sees of the scene is a mid-tone.
///
/// From a grid of samples over the whole view, the same for any crop.
fn measured_exposure(
    stage: &Stage<'_>,
    view: &View,
    paint: fn(&mut Probe<'_>, &Ray, Option<Hit>) -> Vec3,
) -> f32 {
    const GRID: u32 = 32;
    const SAMPLES: u32 = 8;
    const MIDTONE: f32 = 0.28;
    let cell = |i, side: u32| (i as f32 + 0.5) * (side as f32 / GRID as f32);
    let mut seen: Vec<f32> = (0..GRID * GRID)
        .into_par_iter()
        .filter_map(|i| {
            let ray = view.ray(cell(i % GRID, view.width()), cell(i / GRID, view.height()));
            let hit = stage.scene.closest_hit(&ray)?;
            let sample = |sample| {
                let mut probe = Probe {
                    stage,
                    sampler: Sampler::new(0, i, 0, sample),
                    rays: 0,
                };
                luminance(paint(&mut probe, &ray, Some(hit)))
            };
            let mean = (0..SAMPLES).map(sample).sum::<f32>() / SAMPLES as f32;
            (mean > 0.0 && mean.is_finite()).then_some(mean)
        })
        .collect();
    seen.sort_unstable_by(f32::total_cmp);
    seen.get(seen.len() / 2)
        .map_or(1.0, |median| MIDTONE / median)
}

/// Colours the finished pixels by a scale over all of them.
fn color_layer(film: &mut Film, layer: &Layer, options: ScaleOptions) {
    let numbers: Vec<Option<f32>> = (0..film.color.len())
        .map(|i| {
            film.is_finished(i)
                .then(|| (layer.value)(film, i))
                .flatten()
        })
        .collect();
    let known: Vec<f32> = numbers.iter().copied().flatten().collect();
    let scale = Scale::of(layer, &known, options);
    for (color, number) in film.color.iter_mut().zip(numbers) {
        *color = number.map_or(DARK, |number| scale.color(number)).into();
    }
    film.scale = Some(scale);
}
