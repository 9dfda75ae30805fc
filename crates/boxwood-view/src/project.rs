//! From the scene to the window: where things that are drawn as lines stand in the picture.

use boxwood::Aabb;
use boxwood_scene::Camera;
use glam::{DVec3, Vec3};

use crate::{
    canvas::{Canvas, Color, Stroke},
    navigate::Frame,
};

/// The camera's view of points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projector {
    eye: DVec3,
    ahead: DVec3,
    right: DVec3,
    down: DVec3,
    /// Pixels of a length of 1 at distance 1.
    scale: f64,
    middle: [f64; 2],
    /// What is nearer is not seen.
    near: f64,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pen {
    pub(crate) color: Color,
    pub(crate) stroke: Stroke,
    /// The picture shows through.
    pub(crate) is_faint: bool,
}

/// Corners of a box are numbered by three bits; an edge joins two that differ in one.
const EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [2, 3],
    [4, 5],
    [6, 7],
    [0, 2],
    [1, 3],
    [4, 6],
    [5, 7],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

impl Projector {
    /// For a window of that size.
    pub(crate) fn new(camera: &Camera, [width, height]: [u32; 2]) -> Self {
        let frame = Frame::of(camera);
        let half_height = (f64::from(camera.fov).to_radians() * 0.5).tan();
        Self {
            eye: frame.eye,
            ahead: frame.ahead,
            right: frame.right,
            down: frame.ahead.cross(frame.right),
            scale: f64::from(height) * 0.5 / half_height,
            middle: [width, height].map(|side| f64::from(side) * 0.5),
            near: frame.distance() * 1e-4,
        }
    }

    /// The part of a line that is before the eye, in pixels.
    pub(crate) fn segment(&self, from: [f32; 3], to: [f32; 3]) -> Option<[[f32; 2]; 2]> {
        let [a, b] = [from, to].map(|p| Vec3::from(p).as_dvec3() - self.eye);
        let [da, db] = [a.dot(self.ahead), b.dot(self.ahead)];
        if !(da > self.near || db > self.near) {
            return None;
        }
        // The point of the line at the near plane.
        let cut = |behind: DVec3, db: f64, before: DVec3, df: f64| {
            behind + (before - behind) * ((self.near - db) / (df - db))
        };
        let a_seen = if da < self.near { cut(a, da, b, db) } else { a };
        let b_seen = if db < self.near { cut(b, db, a, da) } else { b };
        Some([a_seen, b_seen].map(|p| self.pixel(p)))
    }

    /// Of a point before the eye, seen from there.
    fn pixel(&self, p: DVec3) -> [f32; 2] {
        let scale = self.scale / p.dot(self.ahead);
        let [x, y] = [p.dot(self.right), p.dot(self.down)];
        [
            (self.middle[0] + x * scale) as f32,
            (self.middle[1] + y * scale) as f32,
        ]
    }

    /// Draws a line of the scene.
    pub(crate) fn line(&self, canvas: &mut Canvas<'_>, from: [f32; 3], to: [f32; 3], pen: Pen) {
        let Some([from, to]) = self.segment(from, to) else {
            return;
        };
        match pen.is_faint {
            true => canvas.faint_line(from, to, pen.color, pen.stroke),
            false => canvas.line(from, to, pen.color, pen.stroke),
        }
    }

    /// Draws the edges of a box.
    pub(crate) fn edges(&self, canvas: &mut Canvas<'_>, bounds: &Aabb, pen: Pen) {
        let corner = |i: usize| {
            [0, 1, 2].map(|k| {
                if i >> k & 1 == 1 {
                    bounds.max[k]
                } else {
                    bounds.min[k]
                }
            })
        };
        for [a, b] in EDGES {
            self.line(canvas, corner(a), corner(b), pen);
        }
    }
}

#[cfg(test)]
mod tests {
    use boxwood_render::View;

    use super::*;

    const CAMERA: Camera = Camera {
        eye: [1.0, 2.0, 8.5],
        target: [0.5, 1.0, -2.0],
        up: [0.0, 1.0, 0.0],
        fov: 50.0,
    };

    #[test]
    fn points_stand_where_the_renderer_sees_them() {
        let view = View::new(CAMERA, 320, 200).unwrap();
        let projector = Projector::new(&CAMERA, [320, 200]);
        for [x, y] in [[3.5, 7.25], [160.0, 100.0], [310.0, 188.0]] {
            let ray = view.ray(x, y);
            let at = |t: f32| [0, 1, 2].map(|k| ray.origin[k] + t * ray.dir[k]);
            let [a, b] = projector.segment(at(2.0), at(11.0)).unwrap();
            for p in [a, b] {
                assert!(
                    (p[0] - x).abs() < 0.02 && (p[1] - y).abs() < 0.02,
                    "{p:?} {x} {y}"
                );
            }
        }
    }

    #[test]
    fn what_is_behind_the_eye_is_not_drawn() {
        let projector = Projector::new(&CAMERA, [320, 200]);
        assert_eq!(projector.segment([0.0, 0.0, 20.0], [1.0, 5.0, 9.0]), None);
        // From behind the eye to before it: a part remains.
        let [a, b] = projector
            .segment([1.0, 3.0, 12.0], [1.0, 1.0, 0.0])
            .unwrap();
        assert!(a[1] < 0.0 && b[1] > 0.0 && b[1] < 200.0, "{a:?} {b:?}");
        assert_eq!(projector.segment([f32::NAN; 3], [f32::NAN; 3]), None);
    }
}
