//! `ao`: ambient occlusion: how much of the hemisphere above a point is free.

use boxwood::{Hit, Ray};
use glam::Vec3;

use super::{Paint, Shading};
use crate::{
    Tone,
    probe::Probe,
    sampling::cosine_hemisphere,
    wave::{Shade, open},
};

pub(super) const SHADING: Shading = Shading {
    name: "ao",
    about: "ambient occlusion: white clay under an even sky; dark where other surfaces are near",
    samples: 16,
    tone: Tone::Neutral,
    lit: false,
    paint: Paint::Rays(open::<Ao>),
};

/// Rays per sample.
const RAYS: usize = 4;
/// Of perfectly free clay.
const CLAY: Vec3 = Vec3::new(0.74, 0.73, 0.71);

/// Only what is nearer counts: three tenths of the scene's diagonal, or the distance to the eye
/// where that is less, so that a room is not dark all over, nor a detail seen from close by.
struct Ao;

impl Shade for Ao {
    async fn shade(mut probe: Probe<'_>, ray: Ray, hit: Option<Hit>) -> Vec3 {
        let dir = Vec3::from(ray.dir);
        let Some(surface) = probe.first(&ray, hit) else {
            return probe.stage.sky.backdrop(dir);
        };
        let reach =
            (0.3 * probe.stage.diagonal).min(surface.position.distance(Vec3::from(ray.origin)));
        let mut open = 0.0;
        for pair in probe.sampler.next_pairs::<RAYS>() {
            let dir = cosine_hemisphere(surface.normal, pair);
            // Directions below the flat triangle are closed: the surface itself is in the way.
            if dir.dot(surface.face_normal) > 0.0 {
                let feeler = probe.stage.spawn(&surface, dir, reach);
                open += if probe.occluded_or_floor(&feeler).await {
                    0.0
                } else {
                    1.0 / RAYS as f32
                };
            }
        }
        (CLAY * open).lerp(probe.stage.sky.backdrop(dir), surface.fade)
    }
}
