//! A clipped boxwood: a ball over a box, as the bounding volumes are, and 40,000 triangles, as the lecture has it.

use std::f64::consts::TAU;

use glam::DVec3;

use super::random::Random;
use super::shape::{Shape, any_orthonormal, ball_profile};
use super::{Builtin, Params, Size, assemble, matte};
use crate::{Camera, Material, Mesh, Model};

pub(super) const BUILTIN: Builtin = Builtin {
    name: "bush",
    about: "a clipped boxwood in a planter, leaf by leaf: 40,000 triangles unless n says otherwise",
    size: Size::Exact {
        default: 40_000,
        least: 3_000,
    },
    seeded: true,
    build,
};

const STONE: u32 = 0;
const PLINTH: u32 = 1;
const TERRACOTTA: u32 = 2;
const SOIL: u32 = 3;
const BARK: u32 = 4;
const SHADE: u32 = 5;
/// The first of [`GREENS`].
const LEAF: u32 = 6;

/// Old leaves inside, young ones outside; a few have caught the frost.
const GREENS: [[f32; 3]; 6] = [
    [0.050, 0.138, 0.026],
    [0.074, 0.204, 0.036],
    [0.110, 0.288, 0.050],
    [0.168, 0.384, 0.070],
    [0.276, 0.516, 0.102],
    [0.456, 0.384, 0.096],
];

/// Where the box and the ball stand, in metres, y up, and half of their widths.
const BOX_CENTER: DVec3 = DVec3::new(0.0, 1.29, 0.0);
const BOX_HALF: f64 = 0.56;
const BOX_ROUNDING: f64 = 0.10;
const BALL_CENTER: DVec3 = DVec3::new(0.0, 2.40, 0.0);
const BALL_RADIUS: f64 = 0.44;

fn build(params: &Params) -> Model {
    let [ball, block] = core();
    let shapes = [stage(), planter(), stem(), ball, block];
    let fixed: usize = shapes.iter().map(Shape::triangle_count).sum();
    let leaves = leaves(params.n as usize - fixed, params.seed);
    let [stage, planter, stem, ball, block] = shapes;
    let meshes = vec![
        leaves,
        stage.finish(),
        planter.finish(),
        stem.smooth(),
        ball.smooth(),
        block.finish(),
    ];

    let mut materials = vec![
        matte("stone", [0.50, 0.47, 0.43]),
        matte("plinth", [0.62, 0.59, 0.54]),
        Material {
            roughness: 0.85,
            ..matte("terracotta", [0.52, 0.20, 0.095])
        },
        matte("soil", [0.045, 0.03, 0.02]),
        matte("bark", [0.17, 0.115, 0.07]),
        matte("shade", [0.012, 0.03, 0.008]),
    ];
    materials.extend(GREENS.iter().map(|&green| Material {
        roughness: 0.5,
        ..matte("leaf", green)
    }));
    let camera = Camera {
        eye: [3.7, 2.75, 5.6],
        target: [0.0, 1.36, 0.0],
        up: [0.0, 1.0, 0.0],
        fov: 29.0,
    };
    assemble(meshes, materials, camera)
}

/// The floor disc and the plinth, both with a chamfered rim.
fn stage() -> Shape {
    let mut stage = Shape::new("stage");
    disc(&mut stage, 2.6, -0.08, 0.0, STONE);
    disc(&mut stage, 0.80, 0.0, 0.12, PLINTH);
    stage
}

fn disc(stage: &mut Shape, radius: f64, bottom: f64, top: f64, material: u32) {
    let chamfer = 0.02;
    let profile = [
        [radius, bottom],
        [radius, top - chamfer],
        [radius - chamfer, top],
        [0.0, top],
    ];
    stage.lathe(&profile.map(|[x, y]| DVec3::new(x, y, 0.0)), 96, material);
}

/// A square pot with cut corners and a rim, filled with soil.
fn planter() -> Shape {
    let floor = 0.12;
    let profile = [
        [0.37, 0.00],
        [0.37, 0.05],
        [0.345, 0.07],
        [0.43, 0.46],
        [0.49, 0.47],
        [0.50, 0.485],
        [0.50, 0.60],
        [0.49, 0.615],
        [0.445, 0.615],
        [0.435, 0.57],
    ];
    let corner = |half: f64, side: usize| {
        let cut = half - 0.035;
        let [x, z] = [
            [half, cut],
            [half, -cut],
            [cut, -half],
            [-cut, -half],
            [-half, -cut],
            [-half, cut],
            [-cut, half],
            [cut, half],
        ][side];
        [x, z]
    };
    let mut pot = Shape::new("planter");
    let point = |ring: usize, side: usize| {
        let [half, y] = profile[ring];
        let [x, z] = corner(half, side);
        DVec3::new(x, y + floor, z)
    };
    pot.skin(profile.len(), 8, point, |_, _| TERRACOTTA);
    let h = 0.437;
    pot.plate(
        [[-h, -h], [-h, h], [h, h], [h, -h]].map(|[x, z]| DVec3::new(x, 0.56 + floor, z)),
        SOIL,
    );
    pot
}

/// From the soil through the box into the ball.
fn stem() -> Shape {
    let path: Vec<_> = (0..=20)
        .map(|i| f64::from(i) / 20.0)
        .map(|t| {
            DVec3::new(
                0.018 * libm::sin(7.0 * t),
                0.60 + 1.75 * t,
                0.015 * libm::cos(9.0 * t),
            )
        })
        .collect();
    let radii: Vec<_> = (0..=20)
        .map(|i| 0.055 - 0.0008 * f64::from(i) + 0.003 * f64::from(i % 3))
        .collect();
    let mut stem = Shape::new("stem");
    stem.tube(&path, &radii, 12, BARK);
    stem
}

/// The dark inside of the bush, so that no light falls through the leaves.
fn core() -> [Shape; 2] {
    let mut ball = Shape::new("core of the ball");
    let profile = ball_profile(14).map(|p| p * (BALL_RADIUS * 0.91) + BALL_CENTER);
    ball.lathe(&profile.collect::<Vec<_>>(), 28, SHADE);

    let mut block = Shape::new("core of the box");
    let half = BOX_HALF * 0.88;
    let corner = |ring: usize, side: usize| {
        let [x, z] = [[half, half], [half, -half], [-half, -half], [-half, half]][side];
        let [across, height] = [[0.0, -half], [1.0, -half], [1.0, half], [0.0, half]][ring];
        BOX_CENTER + DVec3::new(x * across, height, z * across)
    };
    block.skin(4, 4, corner, |_, _| SHADE);
    [ball, block]
}

/// `triangles` triangles in leaves of two; an odd one is half a leaf.
fn leaves(triangles: usize, seed: u64) -> Mesh {
    let mut random = Random::new(seed ^ 0xb0_c5);
    let count = triangles.div_ceil(2);
    // The leaves keep covering the bush, however many they are.
    let scale = (18_000.0 / count as f64).sqrt().clamp(0.05, 3.0);
    let fallen = count / 90;
    let mut leaves = Shape::new("leaves");
    for i in 0..count {
        let halves = if triangles - leaves.triangle_count() == 1 {
            1
        } else {
            2
        };
        let place = if i < fallen {
            fallen_leaf(&mut random)
        } else {
            grown_leaf(&mut random)
        };
        leaf(&mut leaves, &place, scale, halves, &mut random);
    }
    leaves.finish()
}

/// Where a leaf is and how it stands.
struct Leaf {
    base: DVec3,
    /// Unit, from the base to the tip.
    along: DVec3,
    /// Unit, about square to `along`.
    front: DVec3,
    /// Unit, the clipped surface's own normal: mixed into the leaf's, it lets the shape be read.
    shape_normal: DVec3,
    material: u32,
}

/// A leaf of the box or of the ball.
fn grown_leaf(random: &mut Random) -> Leaf {
    let (surface, normal) = loop {
        let candidate = surface_point(random);
        // Nobody sees the underside of the box, which lies on the planter.
        if candidate.1.y > -0.75 || candidate.0.y > 1.9 {
            break candidate;
        }
    };
    // Most leaves end at the cut, some are shaded below it, a few young ones have grown beyond.
    let depth = random.unit();
    let age = random.unit();
    let height = if age > 0.985 {
        random.between(0.0, 0.035)
    } else {
        -0.085 * depth * depth
    };
    let front = (normal + random.direction() * 0.75).normalize_or(normal);
    let lean = (any_orthonormal(front) + random.direction() * 1.2 + normal * 0.7 + DVec3::Y * 0.25)
        .normalize_or(normal);
    let along = (lean - front * lean.dot(front))
        .try_normalize()
        .unwrap_or_else(|| any_orthonormal(front));
    let material = match (depth, age) {
        (_, age) if age > 0.985 => LEAF + 4,
        (_, age) if age < 0.012 => LEAF + 5,
        (depth, _) if depth > 0.75 => LEAF + random.below(2) as u32,
        _ => LEAF + 1 + random.below(3) as u32,
    };
    Leaf {
        base: surface + normal * (height - 0.02),
        along,
        front,
        shape_normal: normal,
        material,
    }
}

/// A leaf that the shears left on the stone around the planter.
fn fallen_leaf(random: &mut Random) -> Leaf {
    let (sin, cos) = libm::sincos(random.between(0.0, TAU));
    let radius = random.between(0.55, 1.0) + 0.9 * random.unit() * random.unit() * random.unit();
    let floor = if radius < 0.79 { 0.12 } else { 0.0 };
    let front = (DVec3::Y + random.direction() * 0.25).normalize();
    let along = any_orthonormal(front);
    let turn = random.direction();
    let along = (turn - front * turn.dot(front)).normalize_or(along);
    let base = DVec3::new(radius * cos, floor + 0.012, radius * sin);
    Leaf {
        base,
        along,
        front,
        shape_normal: DVec3::Y,
        material: LEAF + 2 + random.below(4) as u32,
    }
}

/// A point on the box or on the ball with the normal there, about evenly spread over both.
fn surface_point(random: &mut Random) -> (DVec3, DVec3) {
    let box_area = 6.0 * (2.0 * BOX_HALF) * (2.0 * BOX_HALF);
    let ball_area = 2.0 * TAU * BALL_RADIUS * BALL_RADIUS;
    if random.between(0.0, box_area + ball_area) < ball_area {
        let normal = random.direction();
        return (BALL_CENTER + normal * BALL_RADIUS, normal);
    }
    let [a, b] = [(); 2].map(|()| random.between(-BOX_HALF, BOX_HALF));
    let side = if random.unit() < 0.5 {
        -BOX_HALF
    } else {
        BOX_HALF
    };
    let p = match random.below(3) {
        0 => DVec3::new(side, a, b),
        1 => DVec3::new(a, side, b),
        _ => DVec3::new(a, b, side),
    };
    // Rounding: the nearest point of the smaller box, then straight out.
    let inner = DVec3::splat(BOX_HALF - BOX_ROUNDING);
    let heart = p.clamp(-inner, inner);
    let normal = (p - heart).normalize();
    (BOX_CENTER + heart + normal * BOX_ROUNDING, normal)
}

/// One blade: two triangles that meet in the midrib, wings up and tip down, so that light plays on it.
fn leaf(leaves: &mut Shape, place: &Leaf, scale: f64, halves: usize, random: &mut Random) {
    let length = scale * random.between(0.050, 0.074);
    let width = length * random.between(0.24, 0.32);
    let fold = length * 0.11;
    let across = place.along.cross(place.front);
    let middle = place.base + place.along * (length * 0.46) + place.front * fold;
    let tip = place.base + place.along * length - place.front * (length * 0.10);

    let soft = |normal: DVec3| (normal + place.shape_normal * 0.9).normalize_or(place.shape_normal);
    let base = leaves.vertex_with_normal(place.base, soft(place.front));
    let tip = leaves.vertex_with_normal(tip, soft(place.front + place.along * 0.3));
    let right =
        leaves.vertex_with_normal(middle + across * width, soft(place.front - across * 0.35));
    leaves.triangle([base, right, tip], place.material);
    if halves == 2 {
        let left =
            leaves.vertex_with_normal(middle - across * width, soft(place.front + across * 0.35));
        leaves.triangle([base, tip, left], place.material);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_face_away_from_the_bush_more_often_than_not() {
        let leaves = leaves(20_000, 0);
        let front = leaves.indices.iter().filter(|triangle| {
            let [a, b, c] = triangle.map(|v| glam::Vec3::from(leaves.positions[v as usize]));
            (b - a)
                .cross(c - a)
                .dot(glam::Vec3::from(leaves.normals[triangle[0] as usize]))
                > 0.0
        });
        assert!(front.count() > 17_000);
    }

    #[test]
    fn an_odd_count_ends_with_half_a_leaf() {
        assert_eq!(leaves(4_001, 0).indices.len(), 4_001);
    }
}
