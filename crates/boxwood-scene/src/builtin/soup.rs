//! Random triangles: no order to exploit, the plain worst case.

use glam::DVec3;

use super::random::Random;
use super::shape::Shape;
use super::{Builtin, Params, Size, assemble, matte};
use crate::{Camera, Model};

pub(super) const BUILTIN: Builtin = Builtin {
    name: "soup",
    about: "random triangles in a cube",
    size: Size::Exact {
        default: 10_000,
        least: 1,
    },
    seeded: true,
    build,
};

/// Triangles of about the size of the gap between them, with their centers in the cube from 0 to 1.
fn build(params: &Params) -> Model {
    let mut random = Random::new(params.seed);
    let reach = 0.9 / libm::cbrt(params.n as f64);
    let mut soup = Shape::new("soup");
    for _ in 0..params.n {
        let center = DVec3::new(random.unit(), random.unit(), random.unit());
        let corners = [(); 3].map(|()| {
            soup.vertex(center + random.direction() * (reach * random.between(0.4, 1.0)))
        });
        soup.triangle(corners, random.below(COLORS.len()) as u32);
    }
    let materials = COLORS.iter().map(|&color| matte("soup", color)).collect();
    let camera = Camera {
        eye: [1.9, 1.45, 2.6],
        target: [0.5, 0.47, 0.5],
        up: [0.0, 1.0, 0.0],
        fov: 32.0,
    };
    assemble(vec![soup.finish()], materials, camera)
}

const COLORS: [[f32; 3]; 6] = [
    [0.62, 0.16, 0.11],
    [0.78, 0.42, 0.10],
    [0.80, 0.68, 0.36],
    [0.20, 0.42, 0.26],
    [0.11, 0.30, 0.46],
    [0.74, 0.72, 0.66],
];
