//! From a scene and a view to an exposed film: what can be asked for, and the way through.

use std::sync::atomic::AtomicBool;

use boxwood::{Counts, Scene};

use crate::{
    Film, PointLight, RenderError, ScaleOptions, Shading, Surfaces, View, exposure::exposure,
    stage::Stage, tiles::Job,
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
    /// Whether the scene is lit by day or by lamps, where the sun stands and how bright the picture is, are found out from
    /// here, so that the frames of a flight agree. None: from the view itself.
    pub light_from: Option<View>,
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
            light_from: None,
            scale: ScaleOptions::default(),
            counts: true,
        }
    }
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "farm", derive(serde::Serialize, serde::Deserialize))]
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

impl Crop {
    /// In pixels.
    pub fn area(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
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
    /// Of finished tiles, those finished earlier too.
    pub pixels: u64,
    /// Of these and the tiles to be made: of the whole film, usually.
    pub all_pixels: u64,
    /// Shot for the tiles of this run.
    pub rays: u64,
}

/// Is given each tile as soon as it is on the film, one at a time, from any thread. Its first error ends the work.
pub type Keep<'a> = &'a (dyn Fn(&Film, &TileWork) -> Result<(), RenderError> + Sync);

/// What a tile has cost; its pixels are on the film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileWork {
    /// As [`Film::tile_window`] counts.
    pub number: u32,
    /// All of them.
    pub rays: u64,
    /// The work of the centre rays.
    pub counts: Counts,
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
    let session = Session::new(scene, surfaces, view, options)?;
    let film = session.film()?;
    let tiles: Vec<u32> = (0..film.finished.len() as u32).collect();
    let mut film = session.expose(film, &tiles, watch, &|_, _| Ok(()))?;
    film.develop(options.shading, options.scale);
    Ok(film)
}

/// [`render()`] in steps, for pictures that are made in pieces: `new`, `film`, `expose` as often as it takes, and
/// [`Film::develop`] at the end.
///
/// The pixels of a tile are the same whichever tiles are exposed with it.
#[derive(Clone, Debug)]
pub struct Session<'a> {
    stage: Stage<'a>,
    view: View,
    window: Crop,
    options: &'a RenderOptions,
}

impl<'a> Session<'a> {
    /// Checks the options, and finds out how the scene is lit and how bright it is. Fails as [`render()`] does.
    pub fn new(
        scene: &'a Scene,
        surfaces: Surfaces<'a>,
        view: &View,
        options: &'a RenderOptions,
    ) -> Result<Self, RenderError> {
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
        let metered = options.light_from.as_ref().unwrap_or(view);
        stage.exposure = exposure(&stage, metered, options);
        Ok(Self {
            stage,
            view: *view,
            window,
            options,
        })
    }

    /// Nothing exposed yet. Fails where the memory is refused.
    pub fn film(&self) -> Result<Film, RenderError> {
        let full_size = [self.view.width(), self.view.height()];
        Film::unexposed(
            self.window,
            full_size,
            self.options.shading.tone,
            self.stage.exposure,
        )
    }

    /// Exposes `tiles` of `film`, which is this session's, and tells `keep` of each. Fails only if `keep` does; what was
    /// interrupted is not [finished](Film::finished).
    ///
    /// # Panics
    ///
    /// If there is no tile of such a number.
    pub fn expose(
        &self,
        film: Film,
        tiles: &[u32],
        watch: Watch<'_>,
        keep: Keep<'_>,
    ) -> Result<Film, RenderError> {
        let shading = self.options.shading;
        let job = Job {
            stage: &self.stage,
            view: &self.view,
            options: self.options,
            samples: self.options.samples.unwrap_or(shading.samples),
            counted: self.options.counts || shading.is_scale(),
        };
        job.expose(film, tiles, watch, keep)
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
