//! `uv`: texture coordinates, or where there are none the triangle's own.

use boxwood::{Hit, Ray};
use glam::{Vec2, Vec3};

use super::{DARK, Paint, Shading};
use crate::{Tone, stage::Stage};

pub(super) const SHADING: Shading = Shading {
    name: "uv",
    about: "texture coordinates: red u, green v, with a checkerboard; barycentric coordinates where the mesh has none",
    samples: 4,
    tone: Tone::Clamp,
    lit: false,
    paint: Paint::Hit(shade),
};

fn shade(stage: &Stage<'_>, ray: &Ray, hit: Option<Hit>) -> Vec3 {
    let Some(hit) = hit else { return DARK };
    let surfaces = stage.surfaces;
    let uv = if surfaces.has_uvs() {
        surfaces.at(ray, &hit).uv
    } else {
        Vec2::new(hit.u, hit.v)
    };
    let within = uv - uv.floor();
    let checker = if surfaces.has_uvs() {
        checkerboard(within)
    } else {
        0.0
    };
    Vec3::new(within.x, within.y, 0.25) * (1.0 - 0.3 * checker)
}

/// 0 or 1: eight fields to a side.
fn checkerboard(uv: Vec2) -> f32 {
    let cell = (uv * 8.0).floor();
    (cell.x + cell.y).rem_euclid(2.0)
}
