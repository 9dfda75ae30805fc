//! A ball of long, thin, curled tubes: every box is full of what a ray misses.

use glam::DVec3;

use super::random::Random;
use super::shape::{Shape, any_orthonormal};
use super::{Builtin, Params, Size, assemble, matte};
use crate::{Camera, Material, Model};

pub(super) const BUILTIN: Builtin = Builtin {
    name: "hairball",
    about: "a ball of thin curled tubes, three-sided; n in steps of 6",
    size: Size::AtMost {
        default: 180_000,
        least: 6,
    },
    seeded: true,
    build,
};

const SIDES: usize = 3;
/// Joints of a whole strand. The last strand is as short as `n` wants it.
const SEGMENTS: usize = 40;
const PER_SEGMENT: usize = 2 * SIDES;

fn build(params: &Params) -> Model {
    let mut random = Random::new(params.seed);
    let mut segments_left = params.n as usize / PER_SEGMENT;
    let strands = segments_left.div_ceil(SEGMENTS);
    // More strands are thinner ones, so that the ball stays as dense as it is.
    let thickness = (0.007 * (750.0 / strands as f64).sqrt()).clamp(0.0006, 0.012);
    let mut ball = Shape::new("hairball");
    while segments_left > 0 {
        let segments = segments_left.min(SEGMENTS);
        let path = strand(&mut random, segments + 1);
        let radii: Vec<_> = (0..=segments)
            .map(|i| thickness * taper(i as f64 / SEGMENTS as f64))
            .collect();
        ball.tube(&path, &radii, SIDES, random.below(COLORS.len()) as u32);
        segments_left -= segments;
    }
    let materials = COLORS
        .iter()
        .map(|&color| Material {
            roughness: 0.45,
            ..matte("hair", color)
        })
        .collect();
    let camera = Camera {
        eye: [1.3, 0.95, 3.7],
        target: [0.0; 3],
        up: [0.0, 1.0, 0.0],
        fov: 36.0,
    };
    assemble(vec![ball.smooth()], materials, camera)
}

/// A curl that starts near the middle and wanders out and around.
fn strand(random: &mut Random, points: usize) -> Vec<DVec3> {
    let step = 2.4 / SEGMENTS as f64;
    let reach = random.between(0.8, 1.05);
    let mut p = random.direction() * random.between(0.12, 0.5);
    let mut heading = (p.normalize() + random.direction() * 0.8).normalize();
    let mut bend = any_orthonormal(heading);
    let mut path = Vec::with_capacity(points);
    for _ in 0..points {
        path.push(p);
        // Beyond its reach the strand turns back; inside it keeps its curl, which drifts.
        let home = if p.length() > reach {
            p * -0.45
        } else {
            DVec3::ZERO
        };
        bend = (bend + random.direction() * 0.35).normalize();
        heading = (heading + bend * 0.13 + home).normalize();
        p += heading * step;
    }
    path
}

/// Thinner towards the tip, never zero.
fn taper(t: f64) -> f64 {
    1.0 - 0.75 * t * t
}

const COLORS: [[f32; 3]; 4] = [
    [0.32, 0.13, 0.05],
    [0.45, 0.21, 0.07],
    [0.58, 0.33, 0.13],
    [0.22, 0.08, 0.035],
];
