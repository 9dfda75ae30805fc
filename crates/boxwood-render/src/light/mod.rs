//! Where light comes from: lamps and glowing triangles of the scene, or a sun and a sky of our own.

mod emitters;
mod offset;
mod sky;

pub(crate) use offset::offset_point;
pub(crate) use sky::Sky;
pub(crate) use sky::smoothstep;

use glam::Vec3;

use crate::{Surfaces, sampling};
use emitters::Emitters;

/// A small lamp that shines the same in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// World space.
    pub position: [f32; 3],
    /// Linear radiant intensity: irradiance at distance 1.
    pub intensity: [f32; 3],
    /// Of the lamp, in the unit of the scene; 0 gives hard shadows. The lamp itself is not seen.
    pub radius: f32,
}

/// A far-away light: parallel rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sun {
    /// Towards the sun, unit.
    pub(crate) dir: Vec3,
    /// On a surface that faces it.
    pub(crate) irradiance: Vec3,
}

/// Half the angle under which the sun is seen, in radians: wider than the real one (0.0047), for
/// shadows that are soft at arm's length too.
const SUN_RADIUS: f32 = 0.02;

/// All lights but the sky.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lights {
    pub(crate) sun: Option<Sun>,
    pub(crate) points: Vec<PointLight>,
    pub(crate) emitters: Emitters,
}

/// One way for light to reach a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightSample {
    /// Towards the light, unit.
    pub(crate) dir: Vec3,
    /// To the light, infinite for the sun.
    pub(crate) distance: f32,
    /// What a surface that faces the light receives, already divided by the probability of the
    /// sample.
    pub(crate) light: Vec3,
    /// Density over solid angle if the light is a surface that other rays can hit too, else 0.
    pub(crate) pdf: f32,
}

/// Whether lamps have a size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shadows {
    Hard,
    Soft,
}

impl Lights {
    /// The glowing triangles and `points`; no sun.
    pub(crate) fn of(surfaces: Surfaces<'_>, points: Vec<PointLight>) -> Self {
        Self {
            sun: None,
            points,
            emitters: Emitters::of(surfaces),
        }
    }

    /// How many samples light a point: one for the sun, one per lamp, one for all glowing triangles
    /// together.
    pub(crate) fn count(&self) -> usize {
        usize::from(self.sun.is_some()) + self.points.len() + usize::from(!self.emitters.is_empty())
    }

    /// Sample number `index` of [`Lights::count`] for a point at `position`; none where that light
    /// cannot reach it.
    pub(crate) fn sample(
        &self,
        index: usize,
        position: Vec3,
        pair: [f32; 2],
        shadows: Shadows,
    ) -> Option<LightSample> {
        if let Some(point) = self.points.get(index) {
            return point.sample(position, pair, shadows);
        }
        match self.sun {
            Some(sun) if index == self.points.len() => Some(sun.sample(pair, shadows)),
            _ => self.emitters.sample(position, pair),
        }
    }
}

impl PointLight {
    fn sample(&self, position: Vec3, pair: [f32; 2], shadows: Shadows) -> Option<LightSample> {
        let on_lamp = if shadows == Shadows::Soft {
            sampling::sphere(pair) * self.radius
        } else {
            Vec3::ZERO
        };
        let way = Vec3::from(self.position) + on_lamp - position;
        let distance = way.length();
        (distance > 0.0).then(|| LightSample {
            dir: way / distance,
            distance,
            light: Vec3::from(self.intensity) / (distance * distance),
            pdf: 0.0,
        })
    }
}

impl Sun {
    fn sample(&self, pair: [f32; 2], shadows: Shadows) -> LightSample {
        let dir = match shadows {
            Shadows::Hard => self.dir,
            Shadows::Soft => {
                let (x, y) = sampling::disk(pair);
                let (side, other) = self.dir.any_orthonormal_pair();
                (self.dir + (side * x + other * y) * SUN_RADIUS).normalize()
            }
        };
        LightSample {
            dir,
            distance: f32::INFINITY,
            light: self.irradiance,
            pdf: 0.0,
        }
    }
}
