//! `eyelight`: a lamp at the eye and no shadows: shape at a glance for one ray per sample.

use boxwood::{Hit, Ray};
use glam::Vec3;

use super::{Paint, Shading};
use crate::{Tone, stage::Stage};

pub(super) const SHADING: Shading = Shading {
    name: "eyelight",
    about: "a lamp at the eye, no shadows: the cheapest picture that shows the shape",
    samples: 4,
    tone: Tone::Neutral,
    lit: false,
    paint: Paint::Hit(shade),
};

fn shade(stage: &Stage<'_>, ray: &Ray, hit: Option<Hit>) -> Vec3 {
    let dir = Vec3::from(ray.dir);
    // Not the floor: without shadows it would only hide the horizon.
    let Some(hit) = hit else {
        return stage.sky.backdrop(dir);
    };
    let surface = stage.surfaces.at(ray, &hit);
    let facing = surface.normal.dot(-dir).max(0.0);
    surface.base_color * (0.08 + 0.92 * facing) + surface.emission.min(Vec3::ONE)
}
