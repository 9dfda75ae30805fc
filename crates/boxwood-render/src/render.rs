//! From a scene and a view to an exposed film: what can be asked for, and the way through.

use std::sync::atomic::AtomicBool;

use boxwood::Scene;

use crate::{
    Film, PointLight, RenderError, Scale, ScaleOptions, Shading, Surfaces, View,
    exposure::exposure,
    shade::{DARK, Layer, Paint},
    stage::Stage,
    tiles::Job,
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
    /// Whether the centre rays are counted ([`Film::counts`], [`Film::box_tests`],
    /// [`Film::prim_tests`]) where the shading does not ask for it; else they stay 0, and a picture of
    /// few samples is made faster. Colours do not depend on it.
    pub counts: bool,
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
            counts: true,
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
    /// Set it, and [`render`] returns within the time of a thousand rays, with the tiles that are
    /// done.
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
    if scene.census().shown != surfaces.triangle_count() {
        return Err(RenderError::Size {
            what: format!(
                "the scene has {} primitives, its surfaces {}",
                scene.census().shown,
                surfaces.triangle_count()
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
        counted: options.counts || shading.is_scale(),
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
