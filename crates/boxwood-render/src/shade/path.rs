//! `path`: light that bounces: the full answer, with noise.

use boxwood::{Hit, Ray};
use glam::Vec3;

use super::{Paint, Shading};
use crate::{
    Surface, Tone,
    bsdf::Bsdf,
    light::Shadows,
    probe::Probe,
    tone::luminance,
    wave::{Shade, open},
};

pub(super) const SHADING: Shading = Shading {
    name: "path",
    about: "path tracing: matte, metal and rough surfaces, glowing triangles, lamps, sun and sky",
    samples: 64,
    tone: Tone::Neutral,
    lit: true,
    paint: Paint::Rays(open::<Path>),
};

/// Bounces before Russian roulette begins.
const SURE_BOUNCES: u32 = 2;
/// Most light that one indirect path adds, in multiples of white: the rare brighter ones would be
/// lone dots, and are cut, which darkens some reflections a little.
const BRIGHTEST: f32 = 2.5;

/// Highlights that are seen by way of a wide bounce are wide themselves, up to this: nobody can tell,
/// and the dots that a sharp one throws on a matte wall are gone (Kaplanyan and Dachsbacher, "Path
/// Space Regularization", 2013).
const MOST_BLUR: f32 = 0.25;

/// Kajiya 1986, with a light sample at each bounce, combined with the bounce itself by the power
/// heuristic (Veach 1997).
struct Path;

impl Shade for Path {
    async fn shade(mut probe: Probe<'_>, mut ray: Ray, hit: Option<Hit>) -> Vec3 {
        let mut seen = probe.first(&ray, hit);
        let (mut light, mut share) = (Vec3::ZERO, Vec3::ONE);
        let (mut bounce_pdf, mut blur) = (None, 0.0);
        for depth in 0..=probe.stage.max_depth {
            let dir = Vec3::from(ray.dir);
            let behind = if depth == 0 {
                probe.backdrop(dir)
            } else {
                probe.sky(dir)
            };
            let Some(surface) = seen else {
                return light + cut(&probe, share * behind, depth);
            };
            light += share * surface.fade * behind;
            share *= 1.0 - surface.fade;
            light += cut(
                &probe,
                share * glow(&probe, &ray, &surface, bounce_pdf),
                depth,
            );
            if depth == probe.stage.max_depth {
                break;
            }
            let bsdf = Bsdf::new(&surface, -dir, blur);
            let direct = lamps(&mut probe, &surface, &bsdf).await;
            light += cut(&probe, share * direct, depth);
            let Some(bounce) = bsdf.sample(&mut probe.sampler) else {
                break;
            };
            share *= bounce.weight;
            let Some(survivor) = roulette(&mut probe, share, depth) else {
                break;
            };
            share = survivor;
            bounce_pdf = Some(bounce.pdf);
            blur = blur.max(width(bounce.pdf)).min(MOST_BLUR);
            ray = probe.stage.spawn(&surface, bounce.dir, f32::INFINITY);
            seen = probe.trace(&ray).await;
        }
        light
    }
}

/// The light of the glowing surface that the ray ran into, less the part that the light sample
/// before it stands for.
fn glow(probe: &Probe<'_>, ray: &Ray, surface: &Surface, bounce_pdf: Option<f32>) -> Vec3 {
    if surface.emission == Vec3::ZERO {
        return Vec3::ZERO;
    }
    let Some(bounce_pdf) = bounce_pdf else {
        return surface.emission;
    };
    let distance = surface.position.distance(Vec3::from(ray.origin));
    let cosine = surface.face_normal.dot(Vec3::from(ray.dir)).abs();
    let light_pdf = probe
        .stage
        .lights
        .emitters
        .density(surface.emission, distance, cosine);
    surface.emission * power_heuristic(bounce_pdf, light_pdf)
}

/// One sample of each light.
async fn lamps(probe: &mut Probe<'_>, surface: &Surface, bsdf: &Bsdf) -> Vec3 {
    let mut light = Vec3::ZERO;
    for index in 0..probe.stage.lights.count() {
        let Some(sample) = probe.light(index, surface, Shadows::Soft).await else {
            continue;
        };
        let (value, bounce_pdf) = bsdf.eval(sample.dir);
        let weight = if sample.pdf > 0.0 {
            power_heuristic(sample.pdf, bounce_pdf)
        } else {
            1.0
        };
        light += value * sample.light * weight;
    }
    light
}

/// The width of a highlight whose samples have about this density.
fn width(pdf: f32) -> f32 {
    0.5 / (std::f32::consts::PI * pdf).sqrt()
}

/// The weight of a sample of density `a` where another way would have found it with density `b`.
fn power_heuristic(a: f32, b: f32) -> f32 {
    // The ratio first: squares of densities leave the range of f32.
    let ratio = b / a;
    1.0 / (1.0 + ratio * ratio)
}

/// Ends dim paths now and then, and lets the survivors carry their light.
fn roulette(probe: &mut Probe<'_>, share: Vec3, depth: u32) -> Option<Vec3> {
    if depth < SURE_BOUNCES {
        return Some(share);
    }
    let survive = share.max_element().clamp(0.05, 0.95);
    (probe.sampler.next() < survive).then(|| share / survive)
}

fn cut(probe: &Probe<'_>, light: Vec3, depth: u32) -> Vec3 {
    let most = BRIGHTEST / probe.stage.exposure;
    let luminance = luminance(light);
    if depth == 0 || luminance <= most {
        light
    } else {
        light * (most / luminance)
    }
}
