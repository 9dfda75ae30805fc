//! A floor to stand on, where the scene has none.

use boxwood::{Ray, Scene};
use glam::{Vec2, Vec3};

use crate::{Surface, View, light::smoothstep};

/// A plane below the scene that dissolves into the background.
///
/// It gives single objects a shadow to stand on. It is no part of the scene: the data layers of the
/// film do not know it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Floor {
    up: Vec3,
    /// `position.dot(up)` of its points.
    height: f32,
    centre: Vec3,
    /// Of the circle around the scene.
    radius: f32,
}

impl Floor {
    /// The floor at the foot of the scene's bounds; none if the camera stands inside the bounds, or
    /// below the floor.
    pub(crate) fn under(scene: &Scene, up: Vec3, view: &View) -> Option<Self> {
        let bounds = scene.bounds();
        let (min, max) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
        let (centre, half) = (min.midpoint(max), (max - min) * 0.5);
        let height = centre.dot(up) - half.dot(up.abs());
        let eye = Vec3::from(view.camera().eye);
        let inside = eye.cmpge(min).all() && eye.cmple(max).all();
        // A tilted plane would cut through what the box of a level scene contains only in part.
        let level = up.abs().max_element() > 0.9999;
        let radius = half.length();
        (level && radius.is_finite() && !inside && eye.dot(up) > height).then_some(Self {
            up,
            height,
            centre,
            radius,
        })
    }

    /// Where `ray` meets it from above before `t_max`.
    pub(crate) fn surface(&self, ray: &Ray, t_max: f32) -> Option<Surface> {
        let (origin, dir) = (Vec3::from(ray.origin), Vec3::from(ray.dir));
        let descent = -dir.dot(self.up);
        if descent <= 1e-6 {
            return None;
        }
        let t = (origin.dot(self.up) - self.height) / descent;
        if !(t > ray.t_min && t < t_max) {
            return None;
        }
        let position = origin + dir * t;
        let away = (position - self.centre).reject_from(self.up).length();
        let fade = smoothstep(1.2 * self.radius, 5.0 * self.radius, away);
        (fade < 1.0).then_some(Surface {
            position,
            face_normal: self.up,
            normal: self.up,
            back: false,
            uv: Vec2::ZERO,
            base_color: Vec3::new(0.52, 0.53, 0.55),
            emission: Vec3::ZERO,
            metallic: 0.0,
            roughness: 1.0,
            fade,
        })
    }
}
