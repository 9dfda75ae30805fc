//! Cameras in motion. All arithmetic is in f64, so that far-away cameras do not shake.

use boxwood_scene::Camera;
use glam::{DMat3, DVec3, Vec3};

/// How near the view may come to straight up or down, in degrees.
const POLE: f64 = 2.0;

/// A camera in parts: ahead, right and up are unit and at right angles.
pub(crate) struct Frame {
    pub(crate) eye: DVec3,
    target: DVec3,
    up: DVec3,
    pub(crate) ahead: DVec3,
    pub(crate) right: DVec3,
}

fn wide(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

impl Frame {
    pub(crate) fn of(camera: &Camera) -> Self {
        let (eye, target) = (wide(camera.eye), wide(camera.target));
        let ahead = (target - eye).normalize_or(DVec3::NEG_Z);
        let up = wide(camera.up).normalize_or(DVec3::Y);
        let right = ahead.cross(up).normalize_or(ahead.any_orthonormal_vector());
        Self {
            eye,
            target,
            up,
            ahead,
            right,
        }
    }

    pub(crate) fn distance(&self) -> f64 {
        (self.target - self.eye).length()
    }

    /// `dir` turned about the up axis by `yaw` and towards it by `pitch`, in degrees, but not over the pole.
    fn turned(&self, dir: DVec3, yaw: f64, pitch: f64) -> DVec3 {
        let from_up = dir.angle_between(self.up).to_degrees();
        let pitch = pitch.clamp(from_up - 180.0 + POLE, (from_up - POLE).max(0.0));
        let turn = DMat3::from_axis_angle(self.up, yaw.to_radians())
            * DMat3::from_axis_angle(self.right, pitch.to_radians());
        turn * dir
    }
}

fn moved(camera: &Camera, eye: DVec3, target: DVec3) -> Camera {
    Camera {
        eye: eye.as_vec3().into(),
        target: target.as_vec3().into(),
        ..*camera
    }
}

/// The eye goes round the target, by degrees to the right and up.
pub(crate) fn orbit(camera: &Camera, right: f64, up: f64) -> Camera {
    let frame = Frame::of(camera);
    let ahead = frame.turned(frame.ahead, right, -up);
    moved(
        camera,
        frame.target - ahead * frame.distance(),
        frame.target,
    )
}

/// The eye looks elsewhere, by degrees to the right and up.
pub(crate) fn turn(camera: &Camera, right: f64, up: f64) -> Camera {
    let frame = Frame::of(camera);
    let ahead = frame.turned(frame.ahead, -right, up);
    moved(camera, frame.eye, frame.eye + ahead * frame.distance())
}

/// Eye and target go along the picture plane, such that the target moves by shares of the picture's height.
pub(crate) fn pan(camera: &Camera, right: f64, up: f64) -> Camera {
    let frame = Frame::of(camera);
    let height = 2.0 * frame.distance() * (f64::from(camera.fov).to_radians() * 0.5).tan();
    let way = frame.right * (right * height) + frame.right.cross(frame.ahead) * (up * height);
    moved(camera, frame.eye + way, frame.target + way)
}

/// The distance between eye and target changes by `factor`.
pub(crate) fn zoom(camera: &Camera, factor: f64) -> Camera {
    let frame = Frame::of(camera);
    // Nearer than this the numbers of the two would be the same.
    let least = 1e-5 * frame.eye.abs().max(frame.target.abs()).max_element();
    let distance = (frame.distance() * factor).max(least).max(1e-30);
    moved(camera, frame.target - frame.ahead * distance, frame.target)
}

/// Eye and target go on, in the unit of the scene.
pub(crate) fn fly(camera: &Camera, ahead: f64, right: f64) -> Camera {
    let frame = Frame::of(camera);
    let way = frame.ahead * ahead + frame.right * right;
    moved(camera, frame.eye + way, frame.target + way)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: Camera = Camera {
        eye: [1.0, 2.0, 8.5],
        target: [1.0, 2.0, 0.5],
        up: [0.0, 1.0, 0.0],
        fov: 90.0,
    };

    fn distance(camera: &Camera) -> f32 {
        Vec3::from(camera.eye).distance(camera.target.into())
    }

    #[test]
    fn an_orbit_keeps_distance_and_target_and_comes_back() {
        let mut camera = CAMERA;
        for _ in 0..36 {
            camera = orbit(&camera, 10.0, 0.0);
            assert!((distance(&camera) - 8.0).abs() < 1e-4);
            assert_eq!(camera.target, CAMERA.target);
        }
        assert!(Vec3::from(camera.eye).distance(CAMERA.eye.into()) < 1e-3);
        let right = orbit(&CAMERA, 90.0, 0.0);
        assert!(
            Vec3::from(right.eye).distance(Vec3::new(9.0, 2.0, 0.5)) < 1e-3,
            "{right:?}"
        );
    }

    #[test]
    fn neither_orbit_nor_turn_goes_over_the_pole() {
        for degrees in [-400.0, 400.0] {
            for camera in [orbit(&CAMERA, 0.0, degrees), turn(&CAMERA, 0.0, degrees)] {
                let ahead = Vec3::from(camera.target) - Vec3::from(camera.eye);
                let angle = ahead.angle_between(Vec3::Y).to_degrees();
                assert!((1.9..178.1).contains(&angle), "{angle}");
            }
        }
        assert!(orbit(&CAMERA, 0.0, 30.0).eye[1] > 2.0 && turn(&CAMERA, 0.0, 30.0).target[1] > 2.0);
    }

    #[test]
    fn turning_keeps_the_eye_and_looks_to_the_right() {
        let camera = turn(&CAMERA, 90.0, 0.0);
        assert_eq!(camera.eye, CAMERA.eye);
        assert!(camera.target[0] > 8.9);
    }

    #[test]
    fn a_pan_by_half_a_picture_puts_the_target_on_its_edge() {
        // 90 degrees high: at distance 8 the picture is 16 high.
        let camera = pan(&CAMERA, 0.0, 0.5);
        assert!((camera.target[1] - 10.0).abs() < 1e-4 && (camera.eye[1] - 10.0).abs() < 1e-4);
        assert!(pan(&CAMERA, 0.5, 0.0).eye[0] > CAMERA.eye[0]);
    }

    #[test]
    fn zooming_in_for_ever_never_reaches_the_target() {
        let mut camera = CAMERA;
        for _ in 0..1000 {
            camera = zoom(&camera, 0.8);
        }
        assert!(distance(&camera) > 0.0);
        assert!((distance(&zoom(&CAMERA, 2.0)) - 16.0).abs() < 1e-4);
    }

    #[test]
    fn flying_moves_eye_and_target_alike() {
        let camera = fly(&CAMERA, 2.0, 1.0);
        assert!(Vec3::from(camera.eye).distance(Vec3::new(2.0, 2.0, 6.5)) < 1e-5);
        assert!((distance(&camera) - 8.0).abs() < 1e-5);
    }
}
