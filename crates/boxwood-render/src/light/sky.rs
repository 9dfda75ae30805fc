//! A clear sky without a sun: what rays see that hit nothing.

use glam::Vec3;

/// A sky that fades from the horizon to the zenith, and the picture's background.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sky {
    /// Unit.
    pub(crate) up: Vec3,
    /// Factor on the light that it sends; 0 is night. The background is not affected.
    pub(crate) strength: f32,
}

const ZENITH: Vec3 = Vec3::new(0.33, 0.43, 0.60);
const HORIZON: Vec3 = Vec3::new(0.62, 0.64, 0.67);
/// The light that the ground below the horizon throws back.
const GROUND: Vec3 = Vec3::new(0.22, 0.21, 0.20);

/// The background: light at the horizon, as in a photographer's studio.
const BACKDROP_TOP: Vec3 = Vec3::new(0.30, 0.44, 0.66);
const BACKDROP_HORIZON: Vec3 = Vec3::new(0.74, 0.79, 0.85);
const BACKDROP_BOTTOM: Vec3 = Vec3::new(0.52, 0.55, 0.59);

impl Sky {
    /// Linear radiance from the unit direction `dir`.
    pub(crate) fn radiance(&self, dir: Vec3) -> Vec3 {
        let height = dir.dot(self.up);
        let color = if height >= 0.0 {
            HORIZON.lerp(ZENITH, height.sqrt())
        } else {
            // A narrow haze joins sky and ground.
            HORIZON.lerp(GROUND, smoothstep(0.0, 0.15, -height))
        };
        color * self.strength
    }

    /// The average of [`Sky::radiance`] over the hemisphere around `normal`, weighted by the
    /// cosine, roughly.
    pub(crate) fn ambient(&self, normal: Vec3) -> Vec3 {
        let above = HORIZON.lerp(ZENITH, 0.75);
        GROUND.lerp(above, 0.5 + 0.5 * normal.dot(self.up)) * self.strength
    }

    /// What the camera sees behind everything.
    pub(crate) fn backdrop(&self, dir: Vec3) -> Vec3 {
        let height = dir.dot(self.up);
        if height >= 0.0 {
            BACKDROP_HORIZON.lerp(BACKDROP_TOP, smoothstep(0.0, 0.7, height))
        } else {
            BACKDROP_HORIZON.lerp(BACKDROP_BOTTOM, smoothstep(0.0, 0.7, -height))
        }
    }
}

/// 0 up to `from`, 1 from `to` on, smooth between.
pub(crate) fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let x = ((x - from) / (to - from)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}
