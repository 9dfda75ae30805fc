//! The exposed picture with its layers.

use std::collections::TryReserveError;

use boxwood::Counts;
use glam::Vec3;

use crate::{
    Crop, Image, RenderError, Scale, ScaleOptions, Shading, Tone, legend,
    shade::{DARK, Layer, Paint},
    share::map_each,
};

/// Side of a tile in pixels.
pub const TILE: u32 = 16;

/// A picture in linear light, and what is known about each pixel.
///
/// All layers have `width * height` entries, row by row from the upper left. The data layers (all
/// but `color`) belong to the one ray through the pixel's centre and know only the scene, not the
/// renderer's own floor.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Where in the full picture this film lies; its size is the size of the film.
    pub window: Crop,
    /// Width and height of the full picture.
    pub full_size: [u32; 2],
    /// Linear RGB (Rec. 709 primaries), before exposure.
    pub color: Vec<[f32; 3]>,
    /// Distance from the eye in the unit of the scene; infinite where nothing is hit.
    pub depth: Vec<f32>,
    /// The shading normal in world space, on the side of the eye; zero where nothing is hit.
    pub normal: Vec<[f32; 3]>,
    /// Number of the triangle, `u32::MAX` where nothing is hit.
    pub prim: Vec<u32>,
    /// Number of the material, `u32::MAX` for the default material and where nothing is hit.
    pub material: Vec<u32>,
    /// Box tests of the centre ray; in a grid the cells that it visits, if they are more.
    pub box_tests: Vec<u32>,
    /// Primitive tests of the centre ray.
    pub prim_tests: Vec<u32>,
    /// Whether each tile of [`TILE`] x [`TILE`] pixels is done, row by row; false after an
    /// interruption.
    pub finished: Vec<bool>,
    /// All rays: centre, camera, shadow, bounce.
    pub rays: u64,
    /// The work of the centre rays together.
    pub counts: Counts,
    /// How `color` is to be shown.
    pub tone: Tone,
    /// Factor on `color` before `tone`.
    pub exposure: f32,
    /// Of shadings that colour a layer: the scale, for the legend.
    pub scale: Option<Scale>,
}

impl Film {
    /// Nothing exposed yet. Fails where the system refuses the memory.
    pub(crate) fn unexposed(
        window: Crop,
        full_size: [u32; 2],
        tone: Tone,
        exposure: f32,
    ) -> Result<Self, RenderError> {
        let n = window.width as usize * window.height as usize;
        let refused = |_: TryReserveError| RenderError::Memory {
            what: format!("a film of {}x{} pixels", window.width, window.height),
            gib: n as f64 * BYTES_PER_PIXEL / f64::from(1 << 30),
            remedy: "use --crop or a smaller --size",
        };
        let film = || -> Result<Self, TryReserveError> {
            Ok(Self {
                window,
                full_size,
                color: filled([0.0; 3], n)?,
                depth: filled(f32::INFINITY, n)?,
                normal: filled([0.0; 3], n)?,
                prim: filled(u32::MAX, n)?,
                material: filled(u32::MAX, n)?,
                box_tests: filled(0, n)?,
                prim_tests: filled(0, n)?,
                finished: filled(false, window.tile_count())?,
                rays: 0,
                counts: Counts::default(),
                tone,
                exposure,
                scale: None,
            })
        };
        film().map_err(refused)
    }

    /// In pixels.
    pub fn width(&self) -> u32 {
        self.window.width
    }

    /// In pixels.
    pub fn height(&self) -> u32 {
        self.window.height
    }

    /// Where in the layers the pixel `(x, y)` of the full picture lies.
    pub(crate) fn index(&self, x: u32, y: u32) -> usize {
        (y - self.window.y) as usize * self.window.width as usize + (x - self.window.x) as usize
    }

    /// Where tile number `number` lies, in pixels of the full picture. Tiles are counted row by row from 0 to
    /// `finished.len()`.
    pub fn tile_window(&self, number: u32) -> Crop {
        self.window.tile(number)
    }

    /// True unless the picture was interrupted.
    pub fn is_complete(&self) -> bool {
        self.finished.iter().all(|&done| done)
    }

    /// The share of the tiles that are done, 0 to 1.
    pub fn finished_share(&self) -> f32 {
        self.finished.iter().filter(|&&done| done).count() as f32
            / self.finished.len().max(1) as f32
    }

    /// Whether the tile of this pixel is done.
    pub fn is_finished(&self, pixel: usize) -> bool {
        let width = self.width() as usize;
        let tile = TILE as usize;
        self.finished[(pixel / width / tile) * width.div_ceil(tile) + (pixel % width) / tile]
    }

    /// What can only be done once all tiles are there: for shadings that colour a layer, the scale over all finished pixels,
    /// and their colours. Others stay as they are.
    pub fn develop(&mut self, shading: &Shading, options: ScaleOptions) {
        if let Paint::Layer(layer) = shading.paint {
            self.color_layer(&layer, options);
        }
    }

    fn color_layer(&mut self, layer: &Layer, options: ScaleOptions) {
        let numbers: Vec<Option<f32>> = (0..self.color.len())
            .map(|i| {
                self.is_finished(i)
                    .then(|| (layer.value)(self, i))
                    .flatten()
            })
            .collect();
        let known: Vec<f32> = numbers.iter().copied().flatten().collect();
        let scale = Scale::of(layer, &known, options);
        for (color, number) in self.color.iter_mut().zip(numbers) {
            *color = number.map_or(DARK, |number| scale.color(number)).into();
        }
        self.scale = Some(scale);
    }

    /// The picture for a screen: exposed, tone-mapped, sRGB, with the legend of the scale where it
    /// fits in. Tiles that are not done are a dim checkerboard.
    pub fn to_image(&self) -> Image {
        let mut image = self.to_plain_image();
        if let Some(scale) = &self.scale {
            legend::draw(&mut image, scale);
        }
        image
    }

    /// [`Film::to_image`] without a legend: of a crop the same pixels as there in the whole.
    pub fn to_plain_image(&self) -> Image {
        let width = self.width() as usize;
        let code_of = |pixel: usize| {
            if self.is_finished(pixel) {
                let shown = self
                    .tone
                    .apply(Vec3::from(self.color[pixel]) * self.exposure);
                shown.to_array().map(crate::tone::linear_to_srgb8)
            } else {
                unexposed_checker(pixel % width, pixel / width)
            }
        };
        Image {
            width: self.width(),
            height: self.height(),
            rgb: map_each(self.color.len(), code_of),
        }
    }
}

impl Crop {
    /// How many tiles a film of this window has.
    pub(crate) fn tile_count(&self) -> usize {
        self.width.div_ceil(TILE) as usize * self.height.div_ceil(TILE) as usize
    }

    /// Tile number `number` of a film of this window.
    pub(crate) fn tile(&self, number: u32) -> Self {
        let columns = self.width.div_ceil(TILE);
        let (x, y) = (number % columns * TILE, number / columns * TILE);
        Self {
            x: self.x + x,
            y: self.y + y,
            width: TILE.min(self.width - x),
            height: TILE.min(self.height - y),
        }
    }
}

/// Of all layers.
const BYTES_PER_PIXEL: f64 = 44.0;

/// As `vec![value; n]`, but memory that is refused is an error, not the end of the process.
fn filled<T: Clone>(value: T, n: usize) -> Result<Vec<T>, TryReserveError> {
    let mut layer = Vec::new();
    layer.try_reserve_exact(n)?;
    layer.resize(n, value);
    Ok(layer)
}

fn unexposed_checker(x: usize, y: usize) -> [u8; 3] {
    if (x / 8 + y / 8).is_multiple_of(2) {
        [40; 3]
    } else {
        [56; 3]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_is_refused_is_an_error() {
        assert!(filled([0.0; 3], usize::MAX / 16).is_err());
        assert_eq!(filled(7, 3), Ok(vec![7; 3]));
    }
}
