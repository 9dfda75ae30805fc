//! The teapot in the stadium: all the detail in a millionth of the room. A uniform grid puts the whole teapot into one
//! cell; a hierarchy does not notice. (The example is Eric Haines', "Spline surface rendering, and what's wrong with
//! octrees", Ray Tracing News 1988.)

use glam::DVec3;

use super::random::Random;
use super::shape::{Shape, circle};
use super::teapot::teapot;
use super::{Builtin, Params, Size, assemble, matte};
use crate::{Camera, Material, Mesh, Model};

pub(super) const BUILTIN: Builtin = Builtin {
    name: "stadium",
    about: "a teapot of 0.3 m on the pitch of a stadium of 190 m: breaks uniform grids (39,288 triangles)",
    size: Size::Fixed,
    seeded: false,
    build,
};

const BRASS: u32 = 0;
const LIGHT_GRASS: u32 = 1;
const DARK_GRASS: u32 = 2;
const CHALK: u32 = 3;
const TRACK: u32 = 4;
const CONCRETE: u32 = 5;
/// The first of the colours of the crowd.
const CROWD: u32 = 6;

/// The lines lie this far above the grass, in metres.
const CHALK_HEIGHT: f64 = 0.002;

/// In metres.
fn build(_: &Params) -> Model {
    let meshes = vec![
        teapot(0.3, DVec3::new(0.9, 0.0, 0.0), BRASS),
        pitch(),
        bowl(),
    ];
    let mut materials = vec![
        Material {
            metallic: 1.0,
            roughness: 0.3,
            ..matte("brass", [0.86, 0.62, 0.27])
        },
        matte("light grass", [0.15, 0.30, 0.05]),
        matte("dark grass", [0.09, 0.22, 0.035]),
        matte("chalk", [0.72, 0.72, 0.68]),
        matte("track", [0.42, 0.11, 0.06]),
        matte("concrete", [0.46, 0.45, 0.43]),
    ];
    materials.extend(COLORS.iter().map(|&color| matte("crowd", color)));
    let camera = Camera {
        eye: [1.3, 0.27, 0.7],
        target: [0.9, 0.13, 0.0],
        up: [0.0, 1.0, 0.0],
        fov: 36.0,
    };
    assemble(meshes, materials, camera)
}

const COLORS: [[f32; 3]; 6] = [
    [0.10, 0.20, 0.42],
    [0.10, 0.20, 0.42],
    [0.62, 0.60, 0.56],
    [0.55, 0.09, 0.07],
    [0.70, 0.50, 0.12],
    [0.16, 0.15, 0.15],
];

/// Grass in stripes, lines of chalk, and a track below that fills the bowl.
fn pitch() -> Mesh {
    let mut pitch = Shape::new("pitch");
    let mut plate = |[x0, x1]: [f64; 2], [z0, z1]: [f64; 2], y: f64, material: u32| {
        let corners = [[x0, z0], [x0, z1], [x1, z1], [x1, z0]];
        pitch.plate(corners.map(|[x, z]| DVec3::new(x, y, z)), material);
    };
    let stripe = 105.0 / 19.0;
    for i in 0..19 {
        let left = -52.5 + stripe * f64::from(i);
        let grass = if i % 2 == 0 { LIGHT_GRASS } else { DARK_GRASS };
        plate([left, left + stripe], [-34.0, 34.0], 0.0, grass);
    }
    for end in [-1.0, 1.0] {
        plate(
            [-51.0, 51.0],
            [end * 32.5 - 0.06, end * 32.5 + 0.06],
            CHALK_HEIGHT,
            CHALK,
        );
        plate(
            [end * 51.0 - 0.06, end * 51.0 + 0.06],
            [-32.5, 32.5],
            CHALK_HEIGHT,
            CHALK,
        );
    }
    plate([-0.06, 0.06], [-32.5, 32.5], CHALK_HEIGHT, CHALK);

    let ring = circle(96);
    let on_ring = |rim: usize, side: usize| {
        let (sin, cos) = ring[side];
        DVec3::new(cos, 0.0, -sin) * [9.21, 9.09][rim] + DVec3::Y * CHALK_HEIGHT
    };
    pitch.skin(2, 96, on_ring, |_, _| CHALK);
    let on_track = |rim: usize, side: usize| oval(circle(SIDES)[side], [INNER, 0.0][rim], -0.05);
    pitch.skin(2, SIDES, on_track, |_, _| TRACK);
    pitch.finish()
}

const SIDES: usize = 192;
const STEPS: usize = 40;
/// Half the length of the bowl at its foot, and the depth of one step.
const INNER: f64 = 62.0;
const STEP: f64 = 0.82;

/// Steps with a crowd on them, and a wall around the outside.
fn bowl() -> Mesh {
    let circle = circle(SIDES);
    // Riser, tread, riser, tread, ... up to the rim, then down the outside.
    let mut profile = vec![(INNER, -0.05)];
    for i in 0..STEPS {
        let height = 1.1 + 0.35 * i as f64 + 0.006 * (i * i) as f64;
        let foot = INNER + STEP * i as f64;
        profile.extend([(foot, height), (foot + STEP, height)]);
    }
    let (rim, top) = profile[2 * STEPS];
    profile.extend([(rim, top + 1.1), (rim + 0.4, top + 1.1), (rim + 0.4, -0.05)]);

    let mut random = Random::new(1);
    let mut bowl = Shape::new("stands");
    // From the rim inwards, so that the front of each step faces the pitch.
    let last = profile.len() - 1;
    let point = |ring: usize, side: usize| {
        oval(circle[side], profile[last - ring].0, profile[last - ring].1)
    };
    let material = |ring: usize, side: usize| {
        let part = last - ring - 1;
        // From below one sees the risers, from above the treads: the crowd is on both.
        let is_seats = (1..2 * STEPS).contains(&part);
        let is_aisle = side.is_multiple_of(12) || part / 2 % 14 == 13;
        if is_seats && !is_aisle {
            CROWD + random.below(COLORS.len()) as u32
        } else {
            CONCRETE
        }
    };
    bowl.skin(profile.len(), SIDES, point, material);
    bowl.finish()
}

/// A point of the oval that is `half_length` long on the x axis and 14 m shorter on the z axis.
fn oval((sin, cos): (f64, f64), half_length: f64, height: f64) -> DVec3 {
    DVec3::new(
        cos * half_length,
        height,
        -sin * (half_length - 14.0).max(0.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_teapot_is_small_and_the_stadium_is_large() {
        let model = build(&Params { n: 0, seed: 0 });
        let flat = |mesh: usize| {
            let instances = vec![model.instances[mesh]];
            Model {
                instances,
                ..model.clone()
            }
            .bounds()
            .unwrap()
        };
        let width = |(min, max): ([f32; 3], [f32; 3])| max[0] - min[0];
        assert!((0.29..0.31).contains(&width(flat(0))));
        assert!((189.0..192.0).contains(&width(flat(2))));
        assert_eq!(model.meshes[0].indices.len(), 6984);
        assert_eq!(model.triangle_count(), 39_288);
    }

    #[test]
    fn the_treads_and_the_pitch_face_up() {
        let model = build(&Params { n: 0, seed: 0 });
        for mesh in &model.meshes[1..] {
            for triangle in &mesh.indices {
                let [a, b, c] =
                    triangle.map(|v| glam::Vec3::from(mesh.positions[v as usize]).as_dvec3());
                let normal = (b - a).cross(c - a).normalize();
                assert!(normal.y > -1e-3, "{} {a} {b} {c}", mesh.name);
            }
        }
    }
}
