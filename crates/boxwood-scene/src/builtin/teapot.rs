//! A teapot, after the one by Martin Newell (1975) but turned on a lathe: small, dense and easy to recognise.

use glam::DVec3;

use super::shape::{Shape, smooth_curve};
use crate::Mesh;

/// Radius and height of the body, of the lid and of its knob, from the bottom up. Doubled points make creases.
const BODY: [[f64; 2]; 12] = [
    [0.00, 0.00],
    [0.52, 0.00],
    [0.60, 0.06],
    [0.80, 0.24],
    [0.95, 0.50],
    [1.00, 0.80],
    [0.95, 1.08],
    [0.85, 1.32],
    [0.78, 1.44],
    [0.77, 1.48],
    [0.74, 1.49],
    [0.72, 1.46],
];
const LID: [[f64; 2]; 9] = [
    [0.71, 1.46],
    [0.62, 1.55],
    [0.38, 1.63],
    [0.14, 1.68],
    [0.09, 1.74],
    [0.14, 1.81],
    [0.15, 1.87],
    [0.09, 1.92],
    [0.00, 1.94],
];
const HANDLE: [[f64; 2]; 7] = [
    [-0.85, 1.18],
    [-1.15, 1.32],
    [-1.42, 1.24],
    [-1.50, 0.98],
    [-1.38, 0.72],
    [-1.15, 0.54],
    [-0.88, 0.46],
];
const SPOUT: [[f64; 2]; 6] = [
    [0.80, 0.56],
    [1.15, 0.68],
    [1.36, 0.98],
    [1.48, 1.26],
    [1.62, 1.42],
    [1.72, 1.47],
];
const SPOUT_RADII: [f64; 6] = [0.34, 0.27, 0.18, 0.13, 0.115, 0.13];

/// 6,984 triangles, `width` from spout to handle, standing on `foot`.
pub(super) fn teapot(width: f64, foot: DVec3, material: u32) -> Mesh {
    let mut pot = Shape::new("teapot");
    pot.lathe(&smooth_curve(&BODY.map(point), 3), 64, material);
    pot.lathe(&smooth_curve(&LID.map(point), 2), 64, material);
    let handle = smooth_curve(&HANDLE.map(point), 3);
    pot.tube(&handle, &vec![0.085; handle.len()], 10, material);
    let radii = smooth_curve(&SPOUT_RADII.map(DVec3::splat), 3);
    let radii: Vec<_> = radii.iter().map(|r| r.x).collect();
    pot.tube(&smooth_curve(&SPOUT.map(point), 3), &radii, 16, material);
    // From -1.585 at the handle to about 1.75 at the spout.
    pot.place(|p| foot + (p - DVec3::X * 0.08) * (width / 3.34));
    pot.smooth()
}

fn point([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x, y, 0.0)
}
