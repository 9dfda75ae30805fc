//! The Cornell box: Goral, Torrance, Greenberg, Battaile, "Modeling the interaction of light between diffuse
//! surfaces", SIGGRAPH 1984, with the measures and colours that Cornell published for the later two-block version.

use glam::DVec3;

use super::shape::Shape;
use super::{Builtin, Params, Size, assemble, matte};
use crate::{Camera, Material, Model};

pub(super) const BUILTIN: Builtin = Builtin {
    name: "cornell",
    about: "the Cornell box: two blocks, a red wall, a green wall, one lamp (32 triangles)",
    size: Size::Fixed,
    seeded: false,
    build,
};

const WHITE: u32 = 0;
const RED: u32 = 1;
const GREEN: u32 = 2;
const LAMP: u32 = 3;
const SHORT: u32 = 4;
const TALL: u32 = 5;

const WIDTH: f64 = 556.0;
const HEIGHT: f64 = 548.8;
const DEPTH: f64 = 559.2;

/// In millimetres; the room is open towards the camera at -z.
fn build(_: &Params) -> Model {
    let mut room = Shape::new("room");
    let corner = |x: f64, y: f64, z: f64| DVec3::new(WIDTH * x, HEIGHT * y, DEPTH * z);
    let mut wall = |corners: [[f64; 3]; 4], material| {
        room.plate(corners.map(|[x, y, z]| corner(x, y, z)), material);
    };
    wall(
        [[0., 0., 0.], [0., 0., 1.], [1., 0., 1.], [1., 0., 0.]],
        WHITE,
    );
    wall(
        [[0., 1., 0.], [1., 1., 0.], [1., 1., 1.], [0., 1., 1.]],
        WHITE,
    );
    wall(
        [[0., 0., 1.], [0., 1., 1.], [1., 1., 1.], [1., 0., 1.]],
        WHITE,
    );
    wall(
        [[1., 0., 0.], [1., 0., 1.], [1., 1., 1.], [1., 1., 0.]],
        RED,
    );
    wall(
        [[0., 0., 0.], [0., 1., 0.], [0., 1., 1.], [0., 0., 1.]],
        GREEN,
    );

    // The lamp hangs a tenth of a millimetre below the ceiling and shines down.
    let lamp = [[213., 227.], [343., 227.], [343., 332.], [213., 332.]];
    room.plate(lamp.map(|[x, z]| DVec3::new(x, HEIGHT - 0.1, z)), LAMP);

    block(
        &mut room,
        [[130., 65.], [82., 225.], [240., 272.], [290., 114.]],
        165.0,
        SHORT,
    );
    block(
        &mut room,
        [[423., 247.], [265., 296.], [314., 456.], [472., 406.]],
        330.0,
        TALL,
    );

    let white = [0.725, 0.71, 0.68];
    let lamp = Material {
        emission: [18.4, 13.5, 6.8],
        ..matte("lamp", [0.78; 3])
    };
    let materials = vec![
        matte("white", white),
        matte("red", [0.63, 0.065, 0.05]),
        matte("green", [0.14, 0.45, 0.091]),
        lamp,
        matte("short block", white),
        matte("tall block", white),
    ];
    let camera = Camera {
        eye: [278.0, 273.0, -800.0],
        target: [278.0, 273.0, 0.0],
        up: [0.0, 1.0, 0.0],
        fov: 39.3,
    };
    assemble(vec![room.finish()], materials, camera)
}

/// A block on the floor, without its underside. `foot` runs clockwise as seen from above.
fn block(room: &mut Shape, foot: [[f64; 2]; 4], height: f64, material: u32) {
    let at = |i: usize, y: f64| DVec3::new(foot[i % 4][0], y, foot[i % 4][1]);
    room.plate(
        [at(0, height), at(1, height), at(2, height), at(3, height)],
        material,
    );
    for i in 0..4 {
        room.plate(
            [at(i, 0.0), at(i + 1, 0.0), at(i + 1, height), at(i, height)],
            material,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_of_the_room_faces_its_middle_and_the_blocks_face_away_from_theirs() {
        let model = build(&Params { n: 0, seed: 0 });
        let mesh = &model.meshes[0];
        assert_eq!(mesh.indices.len(), 32);
        for (triangle, &material) in mesh.indices.iter().zip(&mesh.material_of) {
            let [a, b, c] = triangle.map(|v| glam::Vec3::from(mesh.positions[v as usize]));
            let inside = match material {
                SHORT => glam::Vec3::new(185.5, 82.0, 169.0),
                TALL => glam::Vec3::new(368.5, 165.0, 351.0),
                _ => glam::Vec3::new(278.0, 274.0, 280.0),
            };
            let outward = (b - a).cross(c - a).dot(a - inside) > 0.0;
            assert_eq!(
                outward,
                [SHORT, TALL].contains(&material),
                "{triangle:?} of material {material}"
            );
        }
    }
}
