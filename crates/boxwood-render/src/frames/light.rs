//! The light of a frame: sun, sky, and tables from light to codes for the screen.

use glam::Vec3;

use super::desk::{Run, SIDE};
use crate::{
    Tone, View,
    light::Sky,
    stage::key_light,
    tone::{linear_to_srgb8, neutral},
};

/// What shines, with its tables.
#[derive(Debug)]
pub(super) struct Light {
    /// Towards it, unit.
    pub(super) sun: Vec3,
    pub(super) sky: Sky,
    /// Of a white surface that faces the sun.
    sunlight: [f32; 3],
    /// Of a white wall, and what turning it up adds.
    skylight: [[f32; 3]; 2],
    /// sRGB codes of linear light from 0 to [`BRIGHTEST`].
    codes: Box<[u8; TONES]>,
    /// The background by the sine of the elevation, from -1 to 1.
    behind: Box<[Run; HEIGHTS]>,
}

/// Steps of the tone table: finer than one code everywhere.
const TONES: usize = 1 << 13;
/// All brighter light is shown alike.
const BRIGHTEST: f32 = 2.0;
/// Of the tone table for what a surface with 255 as the root of its colour throws back.
const STEPS: f32 = (TONES - 1) as f32 / BRIGHTEST / (255.0 * 255.0);
/// Steps of the background.
const HEIGHTS: usize = 1 << 9;

impl Light {
    pub(super) fn of(view: &View) -> Self {
        let sky = Sky {
            up: Vec3::from(view.camera().up).normalize(),
            strength: 1.0,
        };
        let sun = key_light(view, sky, 1.05);
        let [below, above] = [-sky.up, sky.up].map(|normal| sky.ambient(normal) * 0.6);
        let tone = |i| {
            let grey = Vec3::splat(i as f32 * (BRIGHTEST / (TONES - 1) as f32));
            linear_to_srgb8(neutral(grey).x)
        };
        let behind = |i| {
            let height = i as f32 * (2.0 / (HEIGHTS - 1) as f32) - 1.0;
            let color = Tone::Neutral.apply(sky.backdrop(sky.up * height));
            [color.to_array().map(linear_to_srgb8); SIDE]
        };
        Self {
            sun: sun.dir,
            sky,
            sunlight: (sun.irradiance * (STEPS * std::f32::consts::FRAC_1_PI)).into(),
            skylight: [above + below, above - below].map(|sum| (sum * (STEPS * 0.5)).into()),
            codes: Box::new(std::array::from_fn(tone)),
            behind: Box::new(std::array::from_fn(behind)),
        }
    }

    /// What a white surface throws back of one colour, given its cosines to sun and zenith; in units
    /// for [`Light::tone`].
    #[inline]
    pub(super) fn shine(&self, channel: usize, facing_sun: f32, facing_up: f32) -> f32 {
        let [base, rise] = self.skylight;
        base[channel] + rise[channel] * facing_up + self.sunlight[channel] * facing_sun
    }

    /// The nearest step of the tone table, by the sum with 2^23, whose last bit counts ones: that is
    /// quicker than a conversion, and all pixels of a tile can be added at once.
    #[inline]
    pub(super) fn tone(&self, shine: f32) -> u32 {
        const MOST: f32 = (TONES - 1) as f32;
        let within = if shine < MOST { shine } else { MOST };
        (within + 8_388_608.0).to_bits()
    }

    /// The sRGB code of a step.
    #[inline]
    pub(super) fn code(&self, tone: u32) -> u8 {
        self.codes[tone as usize % TONES]
    }

    /// The background in the direction `dir`, about unit.
    pub(super) fn behind(&self, dir: Vec3) -> Run {
        let height = dir.dot(self.sky.up) + 1.0;
        let step = height * (0.5 * (HEIGHTS - 1) as f32);
        self.behind[(step as usize).min(HEIGHTS - 1)]
    }
}

#[cfg(test)]
mod tests {
    use boxwood_scene::Camera;

    use super::*;

    #[test]
    fn tones_of_the_table_are_those_of_the_film() {
        let camera = Camera {
            eye: [3.0, 1.0, 2.0],
            target: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            fov: 50.0,
        };
        let light = Light::of(&View::new(camera, 4, 3).unwrap());
        for i in 0..1000 {
            let linear = i as f32 * 0.0027;
            let shine = linear * (STEPS * 255.0 * 255.0);
            let exact = linear_to_srgb8(neutral(Vec3::splat(linear.min(BRIGHTEST))).x);
            let found = light.code(light.tone(shine));
            assert!(found.abs_diff(exact) <= 1, "{linear}: {found}, not {exact}");
        }
        // Nonsense is some colour.
        for shine in [-5.0, f32::NAN, f32::INFINITY] {
            let _ = light.code(light.tone(shine));
        }
    }
}
