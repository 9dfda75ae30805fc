//! `prim`: a colour for each triangle.

use boxwood::{Hit, Ray};
use glam::Vec3;

use super::{DARK, Paint, Shading};
use crate::{Tone, sampler::hash, stage::Stage};

pub(super) const SHADING: Shading = Shading {
    name: "prim",
    about: "a colour for each triangle, by its number in the input",
    samples: 4,
    tone: Tone::Clamp,
    lit: false,
    paint: Paint::Hit(shade),
};

fn shade(stage: &Stage<'_>, ray: &Ray, hit: Option<Hit>) -> Vec3 {
    let Some(hit) = hit else { return DARK };
    let facing = stage
        .surfaces
        .at(ray, &hit)
        .face_normal
        .dot(-Vec3::from(ray.dir))
        .max(0.0);
    color_of(hit.prim) * (0.35 + 0.65 * facing)
}

/// A hue by hash, with enough spread in brightness to tell neighbours apart.
pub(super) fn color_of(number: u32) -> Vec3 {
    let bits = hash(number.wrapping_add(0x51ed_270b));
    let share = |shift: u32| ((bits >> shift) & 0xff) as f32 / 255.0;
    let hue = share(0) * 6.0;
    let pure = Vec3::new(
        (hue - 3.0).abs() - 1.0,
        2.0 - (hue - 2.0).abs(),
        2.0 - (hue - 4.0).abs(),
    );
    let saturation = 0.55 + 0.35 * share(8);
    let color =
        Vec3::ONE.lerp(pure.clamp(Vec3::ZERO, Vec3::ONE), saturation) * (0.55 + 0.45 * share(16));
    color * color
}
