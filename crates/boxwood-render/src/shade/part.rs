//! `part`: a colour for each part of the scene.

use boxwood::{Hit, Ray};
use glam::Vec3;

use super::{DARK, Paint, Shading, prim::color_of};
use crate::{Tone, stage::Stage};

pub(super) const SHADING: Shading = Shading {
    name: "part",
    about: "a colour for each part of the scene: each material of each instance",
    samples: 4,
    tone: Tone::Clamp,
    lit: false,
    paint: Paint::Hit(shade),
};

fn shade(stage: &Stage<'_>, ray: &Ray, hit: Option<Hit>) -> Vec3 {
    let Some(hit) = hit else { return DARK };
    let surface = stage.surfaces.at(ray, &hit);
    let facing = surface.face_normal.dot(-Vec3::from(ray.dir)).max(0.0);
    let material = stage.surfaces.material_index(hit.inst, hit.prim);
    // Far apart, so that sums of the two numbers do not meet.
    let part = material.wrapping_add(hit.inst.wrapping_mul(0x9e37_79b9));
    color_of(part) * (0.35 + 0.65 * facing)
}
