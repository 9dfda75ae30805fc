//! What a shading works with: one sample's random numbers and the rays that it shoots.

use boxwood::{Hit, Ray};
use glam::Vec3;

use crate::{
    Surface,
    light::{LightSample, Shadows},
    sampler::Sampler,
    stage::Stage,
};

/// One sample of one pixel at work. Counts the rays that it shoots.
#[derive(Debug)]
pub(crate) struct Probe<'s> {
    pub(crate) stage: &'s Stage<'s>,
    pub(crate) sampler: Sampler,
    /// Shot so far.
    pub(crate) rays: u64,
}

impl Probe<'_> {
    /// What `ray` sees: the scene, the floor, or nothing but sky.
    pub(crate) fn trace(&mut self, ray: &Ray) -> Option<Surface> {
        self.rays += 1;
        let hit = self.stage.scene.closest_hit(ray);
        self.stage.surface(ray, hit)
    }

    /// What a camera ray sees whose hit is known already.
    pub(crate) fn first(&self, ray: &Ray, hit: Option<Hit>) -> Option<Surface> {
        self.stage.surface(ray, hit)
    }

    /// Whether something of the scene stands in the way.
    pub(crate) fn occluded(&mut self, ray: &Ray) -> bool {
        self.rays += 1;
        self.stage.scene.occluded(ray)
    }

    /// As [`Probe::occluded`], with the floor as an obstacle.
    pub(crate) fn occluded_or_floor(&mut self, ray: &Ray) -> bool {
        self.occluded(ray) || self.stage.surface(ray, None).is_some()
    }

    /// Light number `index` as it reaches `surface` on its visible side; none if it comes from
    /// behind or is in shadow.
    pub(crate) fn light(
        &mut self,
        index: usize,
        surface: &Surface,
        shadows: Shadows,
    ) -> Option<LightSample> {
        let pair = self.sampler.next_pair();
        let sample = self
            .stage
            .lights
            .sample(index, surface.position, pair, shadows)?;
        // By the face alone: where the shading normal turns away, the material decides (and knows which normal it uses).
        if sample.dir.dot(surface.face_normal) <= 0.0 {
            return None;
        }
        // A glowing triangle must not hide itself.
        let reach = sample.distance * (1.0 - 1e-3);
        let shadow_ray = self.stage.spawn(surface, sample.dir, reach);
        (!self.occluded(&shadow_ray)).then_some(sample)
    }

    /// The sky in direction `dir`, as light.
    pub(crate) fn sky(&self, dir: Vec3) -> Vec3 {
        self.stage.sky.radiance(dir)
    }

    /// What the camera sees behind everything, in the light of the scene.
    ///
    /// The background keeps its looks whatever the exposure; at night it is dark.
    pub(crate) fn backdrop(&self, dir: Vec3) -> Vec3 {
        if self.stage.sky.strength > 0.0 {
            self.stage.sky.backdrop(dir) / self.stage.exposure
        } else {
            Vec3::ZERO
        }
    }
}
