//! How bright a picture is to be.

use std::sync::Mutex;

use crate::{
    RenderOptions, Shading, Tone, View,
    sampler::Sampler,
    share::share_out,
    stage::Stage,
    tone::luminance,
    wave::{MOST_PATHS, Start},
};

/// The factor on scene light: as asked for; else measured where the brightness of the lamps is
/// anyone's guess.
pub(crate) fn exposure(stage: &Stage<'_>, view: &View, options: &RenderOptions) -> f32 {
    let shading = options.shading;
    match options.exposure {
        // Colours that are data are not light.
        _ if shading.tone == Tone::Clamp => 1.0,
        Some(stops) => libm::exp2f(stops),
        None if shading.lit && stage.adapts => measured(stage, view, shading),
        None => 1.0,
    }
}

/// Cells of the view to a side, and paths in each.
const GRID: u32 = 32;
const SAMPLES: u32 = 8;
/// Cells whose paths make a wave.
const CELLS: u32 = MOST_PATHS as u32 / SAMPLES;
/// What the median is to become.
const MIDTONE: f32 = 0.28;

/// The exposure at which the median of what the camera sees of the scene is a mid-tone.
///
/// From a grid of samples over the whole view, the same for any crop.
fn measured(stage: &Stage<'_>, view: &View, shading: &Shading) -> f32 {
    let seen = Mutex::new(Vec::new());
    share_out(
        (GRID * GRID).div_ceil(CELLS),
        || shading.wave(stage),
        |wave, number| {
            let starts = starts(stage, view, number * CELLS);
            let mut colors = Vec::new();
            let traced = wave
                .as_mut()
                .and_then(|wave| wave.run(&starts, &mut colors, &|| false));
            if traced.is_none() {
                return;
            }
            let means = colors.chunks(SAMPLES as usize).map(|samples| {
                samples.iter().copied().map(luminance).sum::<f32>() / SAMPLES as f32
            });
            let bright = means.filter(|&mean| mean > 0.0 && mean.is_finite());
            seen.lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner)
                .extend(bright);
        },
    );
    let mut seen = seen
        .into_inner()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    seen.sort_unstable_by(f32::total_cmp);
    seen.get(seen.len() / 2)
        .map_or(1.0, |median| MIDTONE / median)
}

/// The paths through the cells from number `first` on that see something of the scene.
fn starts(stage: &Stage<'_>, view: &View, first: u32) -> Vec<Start> {
    let cell = |i, side: u32| (i as f32 + 0.5) * (side as f32 / GRID as f32);
    let through = |i| {
        let ray = view.ray(cell(i % GRID, view.width()), cell(i / GRID, view.height()));
        let hit = Some(stage.scene.closest_hit(&ray)?);
        let start = move |sample| Start {
            ray,
            hit,
            sampler: Sampler::new(0, i, 0, sample),
        };
        Some((0..SAMPLES).map(start))
    };
    (first..(first + CELLS).min(GRID * GRID))
        .filter_map(through)
        .flatten()
        .collect()
}
