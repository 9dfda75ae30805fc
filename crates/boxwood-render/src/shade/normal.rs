//! `normal`: directions as colours.

use boxwood::{Hit, Ray};
use glam::Vec3;

use super::{DARK, Paint, Shading};
use crate::{Tone, stage::Stage};

pub(super) const SHADING: Shading = Shading {
    name: "normal",
    about: "the shading normal in world space: red, green, blue for x, y, z from -1 to 1",
    samples: 4,
    tone: Tone::Clamp,
    lit: false,
    paint: Paint::Hit(shade),
};

fn shade(stage: &Stage<'_>, ray: &Ray, hit: Option<Hit>) -> Vec3 {
    hit.map_or(DARK, |hit| {
        let code = stage.surfaces.at(ray, &hit).normal * 0.5 + 0.5;
        // The customary colours are the numbers themselves as sRGB codes; the square is close to
        // that in linear light.
        code * code
    })
}
