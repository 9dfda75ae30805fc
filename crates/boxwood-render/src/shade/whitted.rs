//! `whitted`: the ray tracer of the course: shadow rays to the lights, mirror rays, nothing else.

use boxwood::{Hit, Ray};
use glam::Vec3;

use super::{Paint, Shading};
use crate::{
    Surface, Tone,
    bsdf::fresnel,
    light::Shadows,
    probe::Probe,
    wave::{Shade, open},
};

pub(super) const SHADING: Shading = Shading {
    name: "whitted",
    about: "recursive ray tracing: point lights with hard shadows, area lights with soft ones, mirrors",
    samples: 16,
    tone: Tone::Neutral,
    lit: true,
    paint: Paint::Rays(open::<Whitted>),
};

/// Whitted, "An Improved Illumination Model for Shaded Display", CACM 1980, with Blinn's highlights
/// and the sky as ambient light. As only the mirror ray goes on, the recursion is a loop.
struct Whitted;

impl Shade for Whitted {
    async fn shade(mut probe: Probe<'_>, mut ray: Ray, hit: Option<Hit>) -> Vec3 {
        let mut seen = probe.first(&ray, hit);
        let (mut light, mut share) = (Vec3::ZERO, Vec3::ONE);
        for depth in 0..=probe.stage.max_depth {
            let dir = Vec3::from(ray.dir);
            let behind = if depth == 0 {
                probe.backdrop(dir)
            } else {
                probe.sky(dir)
            };
            let Some(surface) = seen else {
                return light + share * behind;
            };
            light += share * surface.fade * behind;
            share *= 1.0 - surface.fade;
            let mirror = mirror_share(&surface, -dir);
            light += share * (surface.emission + lit(&mut probe, &surface, -dir, mirror).await);
            share *= mirror;
            if share.max_element() < 0.01 {
                break;
            }
            ray = probe
                .stage
                .spawn(&surface, reflect(dir, &surface), f32::INFINITY);
            seen = probe.trace(&ray).await;
        }
        light
    }
}

/// Ambient light and all lamps that are not in shadow.
async fn lit(probe: &mut Probe<'_>, surface: &Surface, out: Vec3, mirror: Vec3) -> Vec3 {
    let matte = surface.base_color * (Vec3::ONE - mirror) * (1.0 - 0.6 * surface.metallic);
    let mut light = matte * ambient(probe, surface);
    // A highlight as wide as the roughness says: Blinn's exponent for Beckmann slopes of the same
    // width.
    let width = (surface.roughness * surface.roughness).max(0.02);
    let exponent = 2.0 / (width * width) - 2.0;
    let gloss = Vec3::splat(0.04).lerp(surface.base_color, surface.metallic);
    for index in 0..probe.stage.lights.count() {
        let Some(sample) = probe.light(index, surface, Shadows::Hard).await else {
            continue;
        };
        let cosine = surface.normal.dot(sample.dir);
        if cosine <= 0.0 {
            continue;
        }
        let half = (sample.dir + out).normalize_or_zero();
        let highlight =
            libm::powf(surface.normal.dot(half).max(0.0), exponent) * (exponent + 2.0) / 8.0;
        light +=
            (matte + gloss * highlight) * sample.light * (cosine * std::f32::consts::FRAC_1_PI);
    }
    light
}

/// The sky's light on the surface; indoors a little of the lamps' own, since Whitted's light does
/// not bounce.
fn ambient(probe: &Probe<'_>, surface: &Surface) -> Vec3 {
    probe.stage.sky.ambient(surface.normal) * 0.6 + probe.stage.ambient
}

/// What part of the light goes on along the mirror ray: none for surfaces rougher than a brushed
/// metal.
fn mirror_share(surface: &Surface, out: Vec3) -> Vec3 {
    let smooth = (1.0 - surface.roughness / 0.4).max(0.0);
    let f0 = Vec3::splat(0.04).lerp(surface.base_color, surface.metallic);
    fresnel(f0, surface.normal.dot(out)) * smooth
}

/// The mirror direction, kept above the flat triangle.
fn reflect(dir: Vec3, surface: &Surface) -> Vec3 {
    let about = |normal: Vec3| dir - normal * (2.0 * dir.dot(normal));
    let smooth = about(surface.normal);
    if smooth.dot(surface.face_normal) > 0.0 {
        smooth
    } else {
        about(surface.face_normal)
    }
}
