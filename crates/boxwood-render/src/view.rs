//! The pinhole camera.

use boxwood::{Ray, geom::MAX_COORDINATE};
use boxwood_scene::Camera;
use glam::Vec3;

use crate::RenderError;

/// Widest and highest picture, in pixels.
pub const MAX_SIDE: u32 = 65_535;

/// A checked camera with a picture size: from pixels to rays.
///
/// Right-handed. Pixel `(0, 0)` is the upper left one, and its centre is at `(0.5, 0.5)`. The field
/// of view is the vertical one, in degrees, as in Embree's viewer (`--vp --vi --vu --fov --size`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    camera: Camera,
    width: u32,
    height: u32,
    eye: Vec3,
    /// From the eye to the upper left corner of the picture plane at distance 1.
    corner: Vec3,
    /// One pixel to the right on that plane.
    right: Vec3,
    /// One pixel down on that plane.
    down: Vec3,
}

impl View {
    /// Checks `camera` and a size of `width` x `height` pixels.
    ///
    /// Fails where a number is not finite, `eye` lies beyond [`MAX_COORDINATE`] or equals `target`, `up` is zero or parallel to the
    /// view direction, `fov` lies outside `0..180`, or a side is 0 or above [`MAX_SIDE`]. The error
    /// names the value and a remedy.
    pub fn new(camera: Camera, width: u32, height: u32) -> Result<Self, RenderError> {
        check_size(width, height)?;
        let (forward, right, up) = frame(&camera)?;
        let half_height = libm::tan(f64::from(camera.fov).to_radians() * 0.5) as f32;
        let half_width = half_height * (width as f32 / height as f32);
        Ok(Self {
            camera,
            width,
            height,
            eye: camera.eye.into(),
            corner: forward - right * half_width + up * half_height,
            right: right * (2.0 * half_width / width as f32),
            down: -up * (2.0 * half_height / height as f32),
        })
    }

    /// The camera as given.
    pub fn camera(&self) -> Camera {
        self.camera
    }

    /// In pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// In pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The ray through the point `(x, y)` of the picture, in pixels. Its direction has length 1, so
    /// `t` is the distance from the eye in the unit of the scene.
    pub fn ray(&self, x: f32, y: f32) -> Ray {
        let dir = (self.corner + self.right * x + self.down * y).normalize();
        Ray::new(self.eye.into(), dir.into())
    }

    /// The picture plane at distance 1: from the eye to its upper left corner, one pixel to the right,
    /// one down.
    pub(crate) fn plane(&self) -> [Vec3; 3] {
        [self.corner, self.right, self.down]
    }

    /// The ray through the centre of pixel `(x, y)`.
    pub fn pixel_ray(&self, x: u32, y: u32) -> Ray {
        self.ray(x as f32 + 0.5, y as f32 + 0.5)
    }
}

fn check_size(width: u32, height: u32) -> Result<(), RenderError> {
    if (1..=MAX_SIDE).contains(&width) && (1..=MAX_SIDE).contains(&height) {
        return Ok(());
    }
    Err(RenderError::Size {
        what: format!("a picture of {width}x{height} pixels"),
        remedy: "give each side 1 to 65535 pixels",
    })
}

/// Forward, right and up, each of length 1 and at right angles. In f64, so that far-away cameras do
/// not shake.
fn frame(camera: &Camera) -> Result<(Vec3, Vec3, Vec3), RenderError> {
    let bad = |what: String, remedy| Err(RenderError::Camera { what, remedy });
    let Camera {
        eye,
        target,
        up,
        fov,
    } = *camera;
    for (name, v) in [("eye", eye), ("target", target), ("up", up)] {
        if !v.iter().all(|x| x.is_finite()) {
            return bad(
                format!("{name} {v:?} is not finite"),
                "give three plain numbers",
            );
        }
    }
    if eye.iter().any(|x| x.abs() > MAX_COORDINATE) {
        return bad(
            format!("eye {eye:?} lies beyond 2^100, where no ray can start"),
            "move --vp nearer, or scale the scene down",
        );
    }
    if !(fov > 0.0 && fov < 180.0) {
        return bad(
            format!("a field of view of {fov} degrees"),
            "choose more than 0 and less than 180, e.g. --fov 60",
        );
    }
    if eye == target {
        return bad(
            format!("eye and target are both {eye:?}"),
            "move --vi to the point to look at",
        );
    }
    let forward = (Vec3::from(target).as_dvec3() - Vec3::from(eye).as_dvec3()).normalize();
    let right = forward.cross(Vec3::from(up).as_dvec3().normalize_or_zero());
    if right.length() < 1e-6 {
        return bad(
            format!("up {up:?} is zero or parallel to the view direction"),
            "choose another --vu, e.g. 0,0,1 when looking straight down",
        );
    }
    let right = right.normalize();
    Ok((
        forward.as_vec3(),
        right.as_vec3(),
        right.cross(forward).as_vec3(),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: Camera = Camera {
        eye: [1.0, 2.0, 3.5],
        target: [1.0, 2.0, -4.0],
        up: [0.0, 1.0, 0.0],
        fov: 90.0,
    };

    #[test]
    fn the_middle_of_the_picture_looks_at_the_target() {
        let ray = View::new(CAMERA, 300, 200).unwrap().ray(150.0, 100.0);
        assert_eq!(ray.origin, CAMERA.eye);
        assert!((Vec3::from(ray.dir) - Vec3::NEG_Z).length() < 1e-6);
    }

    #[test]
    fn x_grows_to_the_right_and_y_downwards() {
        let view = View::new(CAMERA, 300, 200).unwrap();
        let upper_left = Vec3::from(view.ray(0.0, 0.0).dir);
        assert!(upper_left.x < 0.0 && upper_left.y > 0.0);
        // 90 degrees high: the upper edge is at 45 degrees, the left edge 1.5 times as far.
        let on_plane = upper_left / -upper_left.z;
        assert!(
            (on_plane - Vec3::new(-1.5, 1.0, -1.0)).length() < 1e-5,
            "{on_plane}"
        );
    }

    #[test]
    fn each_impossible_camera_is_refused_with_its_remedy() {
        let refused = [
            (
                Camera {
                    eye: [f32::NAN, 0.0, 0.0],
                    ..CAMERA
                },
                "eye",
            ),
            (
                Camera {
                    target: [f32::INFINITY, 0.0, 0.0],
                    ..CAMERA
                },
                "target",
            ),
            (
                Camera {
                    target: CAMERA.eye,
                    ..CAMERA
                },
                "both",
            ),
            (
                Camera {
                    up: [0.0, 0.0, 2.0],
                    ..CAMERA
                },
                "parallel",
            ),
            (
                Camera {
                    up: [0.0; 3],
                    ..CAMERA
                },
                "parallel",
            ),
            (Camera { fov: 0.0, ..CAMERA }, "field of view"),
            (
                Camera {
                    fov: 180.0,
                    ..CAMERA
                },
                "field of view",
            ),
            (
                Camera {
                    fov: f32::NAN,
                    ..CAMERA
                },
                "field of view",
            ),
        ];
        for (camera, word) in refused {
            let message = View::new(camera, 3, 2).unwrap_err().to_string();
            assert!(
                message.contains(word) && message.contains("; "),
                "{message}"
            );
        }
        for (width, height) in [(0, 2), (2, 0), (65_536, 1)] {
            assert!(
                View::new(CAMERA, width, height)
                    .unwrap_err()
                    .to_string()
                    .contains("65535")
            );
        }
    }
}
