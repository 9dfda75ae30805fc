//! A camera that goes once around the scene.

use boxwood::Scene;
use boxwood_scene::Camera;
use glam::{DQuat, DVec3, Vec3};

use crate::Surfaces;

/// One turn around a scene, in even steps.
///
/// The axis is the camera's up, through the middle of the scene's bounds; the camera goes to the right, so that the scene seems
/// to turn to the left. A camera that stands within the bounds, as in a room, turns on the spot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turntable {
    camera: Camera,
    pivot: DVec3,
    axis: DVec3,
    frames: u32,
}

impl Turntable {
    /// Begins at `camera`; after `frames` frames (at least 1) it would be there again.
    pub fn new(scene: &Scene, camera: Camera, frames: u32) -> Self {
        let bounds = scene.bounds();
        let [min, max, eye] = [bounds.min, bounds.max, camera.eye].map(wide);
        let on_the_spot = eye.cmpge(min).all() && eye.cmple(max).all();
        Self {
            camera,
            pivot: if on_the_spot { eye } else { min.midpoint(max) },
            axis: wide(camera.up).normalize_or(DVec3::Y),
            frames: frames.max(1),
        }
    }

    /// Whether the camera stays where it is, and looks around.
    pub fn is_on_the_spot(&self) -> bool {
        wide(self.camera.eye) == self.pivot
    }

    /// With the camera looking at the middle, from so far back that no triangle leaves a picture of `width` x `height` pixels on the whole turn. For cameras that
    /// were found; one that turns on the spot stays where it is. Looks at each triangle once.
    pub fn fitted(self, surfaces: &Surfaces<'_>, width: u32, height: u32) -> Self {
        let back = (wide(self.camera.eye) - self.pivot).normalize_or_zero();
        if back == DVec3::ZERO {
            return self;
        }
        let slope = libm::tan(f64::from(self.camera.fov).to_radians() * 0.5);
        let lens = Lens {
            slope: [slope * f64::from(width) / f64::from(height.max(1)), slope],
            sine: back.dot(self.axis),
            cosine: back.cross(self.axis).length(),
        };
        let distance = surfaces
            .shown()
            .flat_map(|(_, _, corners)| corners)
            .map(|corner| lens.distance(self.axis, corner.as_dvec3() - self.pivot))
            .filter(|distance| distance.is_finite())
            .fold(0.0, f64::max);
        if distance == 0.0 {
            return self;
        }
        // A little air around it.
        let eye = self.pivot + back * (distance * 1.02);
        let place = |v: DVec3| v.as_vec3().to_array();
        Self {
            camera: Camera {
                eye: place(eye),
                target: place(self.pivot),
                ..self.camera
            },
            ..self
        }
    }

    /// The camera of `frame`, counted from 1; goes around as often as it takes.
    pub fn camera(&self, frame: i32) -> Camera {
        let step = (i64::from(frame) - 1).rem_euclid(self.frames.into());
        if step == 0 {
            return self.camera;
        }
        let angle = std::f64::consts::TAU * step as f64 / f64::from(self.frames);
        let half = 0.5 * angle;
        let sine = self.axis * libm::sin(half);
        let turn = DQuat::from_xyzw(sine.x, sine.y, sine.z, libm::cos(half));
        let turned = |point: [f32; 3]| {
            (self.pivot + turn * (wide(point) - self.pivot))
                .as_vec3()
                .to_array()
        };
        Camera {
            eye: turned(self.camera.eye),
            target: turned(self.camera.target),
            ..self.camera
        }
    }
}

/// How a camera looks at the pivot.
struct Lens {
    /// Half width and half height of the view at distance 1.
    slope: [f64; 2],
    /// Of the angle from which it looks down.
    sine: f64,
    cosine: f64,
}

impl Lens {
    /// How far the camera must be from the pivot to see `point` in every position of the turn.
    ///
    /// Turned by the angle a, a point of radius r and height h lies `r sin(a)` to the side, `h cosine - r cos(a) sine` above the
    /// middle, and `r cos(a) cosine + h sine` nearer than the pivot. It is in the picture if side and above are at most the slope
    /// times (distance - nearer); the worst angle of each gives the largest distance.
    fn distance(&self, axis: DVec3, point: DVec3) -> f64 {
        let height = point.dot(axis);
        let radius = (point - axis * height).length();
        let (sine, cosine) = (self.sine, self.cosine);
        let [wide, high] = self.slope;
        let nearer = height * sine;
        let side = libm::hypot(radius / wide, radius * cosine) + nearer;
        let above = height * cosine / high + nearer + radius * (cosine - sine / high).abs();
        let below = -height * cosine / high + nearer + radius * (cosine + sine / high).abs();
        side.max(above).max(below)
    }
}

fn wide(point: [f32; 3]) -> DVec3 {
    Vec3::from(point).as_dvec3()
}

#[cfg(test)]
mod tests {
    use boxwood_scene::builtin;

    use super::*;
    use crate::{View, auto_camera};

    #[test]
    fn a_turn_keeps_distance_and_height_and_comes_back() {
        let flat = builtin("sphere?n=800").unwrap().flatten().unwrap();
        let scene = Scene::new(&flat.positions, &flat.indices).unwrap();
        let camera = Camera {
            eye: [9.0, 4.0, 1.0],
            target: [0.0, 1.0, 0.0],
            up: [0.0, 2.0, 0.0],
            fov: 30.0,
        };
        let turn = Turntable::new(&scene, camera, 8);
        assert!(!turn.is_on_the_spot());
        for (frame, same) in [(9, 1), (0, 8), (-7, 1), (i32::MIN, i32::MIN + 8)] {
            assert_eq!(turn.camera(frame), turn.camera(same), "frame {frame}");
        }
        assert_eq!(turn.camera(1), camera);
        let from_pivot = |camera: Camera| wide(camera.eye) - turn.pivot;
        let first = from_pivot(camera);
        for frame in 2..=8 {
            let eye = from_pivot(turn.camera(frame));
            assert!((eye.length() - first.length()).abs() < 1e-5);
            assert!((eye.y - first.y).abs() < 1e-6);
        }
        // A quarter, to the right: +X turns to -Z.
        let quarter = from_pivot(turn.camera(3));
        assert!((quarter.x - first.z).abs() < 1e-5 && (quarter.z + first.x).abs() < 1e-5);
    }

    #[test]
    fn a_camera_within_the_scene_turns_on_the_spot() {
        let flat = builtin("cornell").unwrap().flatten().unwrap();
        let scene = Scene::new(&flat.positions, &flat.indices).unwrap();
        let bounds = scene.bounds();
        let camera = Camera {
            eye: bounds.center(),
            target: bounds.max,
            up: [0.0, 1.0, 0.0],
            fov: 60.0,
        };
        let turn = Turntable::new(&scene, camera, 3);
        assert!(turn.is_on_the_spot());
        assert_eq!(turn.camera(2).eye, camera.eye);
        assert_ne!(turn.camera(2).target, camera.target);
    }

    #[test]
    fn the_fitted_camera_sees_all_of_the_scene_from_everywhere_and_wastes_little() {
        for (name, size) in [
            ("soup?n=500", [64, 36]),
            ("terrain?n=2000", [36, 64]),
            ("bush", [64, 64]),
        ] {
            let model = builtin(name).unwrap();
            let flat = model.flatten().unwrap();
            let scene = Scene::new(&flat.positions, &flat.indices).unwrap();
            let surfaces = Surfaces::new(&flat, &model);
            let [width, height] = size;
            let camera = auto_camera(&scene, surfaces, width, height);
            let turn = Turntable::new(&scene, camera, 24).fitted(&surfaces, width, height);
            let mut nearest_to_edge = f32::INFINITY;
            for frame in 1..=24 {
                let view = View::new(turn.camera(frame), width, height).unwrap();
                let [corner, right, down] = view.plane();
                let eye = Vec3::from(view.camera().eye);
                // The centre of the picture is one unit away.
                let ahead = corner + right * (0.5 * width as f32) + down * (0.5 * height as f32);
                for p in &flat.positions {
                    let p = Vec3::from(*p) - eye;
                    let on_plane = p / p.dot(ahead) - corner;
                    let x = on_plane.dot(right) / right.length_squared() / width as f32;
                    let y = on_plane.dot(down) / down.length_squared() / height as f32;
                    nearest_to_edge = [x, 1.0 - x, y, 1.0 - y]
                        .into_iter()
                        .fold(nearest_to_edge, f32::min);
                }
            }
            assert!(
                (0.0..0.03).contains(&nearest_to_edge),
                "{name}: {nearest_to_edge}"
            );
        }
    }
}
