//! What a shading works with: one sample's random numbers, and the answers to its rays.

use std::rc::Rc;

use boxwood::{Hit, Ray};
use glam::Vec3;

use crate::{
    Surface,
    light::{LightSample, Shadows},
    sampler::Sampler,
    stage::Stage,
    wave::Port,
};

/// One sample of one pixel at work. What asks a ray is to be awaited: meanwhile the other paths of
/// the [`wave`](crate::wave) catch up.
#[derive(Debug)]
pub(crate) struct Probe<'s> {
    pub(crate) stage: &'s Stage<'s>,
    pub(crate) sampler: Sampler,
    port: Rc<Port>,
}

impl<'s> Probe<'s> {
    /// Its rays go through `port`.
    pub(crate) fn new(stage: &'s Stage<'s>, sampler: Sampler, port: Rc<Port>) -> Self {
        Self {
            stage,
            sampler,
            port,
        }
    }

    /// What `ray` sees: the scene, the floor, or nothing but sky.
    pub(crate) async fn trace(&self, ray: &Ray) -> Option<Surface> {
        let hit = self.port.closest_hit(ray).await;
        self.stage.surface(ray, hit)
    }

    /// What a camera ray sees whose hit is known already.
    pub(crate) fn first(&self, ray: &Ray, hit: Option<Hit>) -> Option<Surface> {
        self.stage.surface(ray, hit)
    }

    /// Whether something of the scene stands in the way.
    pub(crate) async fn occluded(&self, ray: &Ray) -> bool {
        self.port.occluded(ray).await
    }

    /// As [`Probe::occluded`], with the floor as an obstacle.
    pub(crate) async fn occluded_or_floor(&self, ray: &Ray) -> bool {
        self.occluded(ray).await || self.stage.surface(ray, None).is_some()
    }

    /// Light number `index` as it reaches `surface` on its visible side; none if it comes from
    /// behind or is in shadow.
    pub(crate) async fn light(
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
        (!self.occluded(&shadow_ray).await).then_some(sample)
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
