//! A ball: the closed surface that watertightness is checked on.

use glam::DVec3;

use super::shape::Shape;
use super::{Builtin, Params, Size, assemble, matte};
use crate::{Camera, Mesh, Model};

pub(super) const BUILTIN: Builtin = Builtin {
    name: "sphere",
    about: "a closed ball of 8 f² triangles: each edge is shared by exactly two",
    size: Size::AtMost {
        default: 20_000,
        least: 8,
    },
    seeded: false,
    build,
};

fn build(params: &Params) -> Model {
    let camera = Camera {
        eye: [1.6, 1.5, 4.1],
        target: [0.0; 3],
        up: [0.0, 1.0, 0.0],
        fov: 30.0,
    };
    assemble(
        vec![ball((params.n / 8).isqrt())],
        vec![matte("ball", [0.62, 0.16, 0.11])],
        camera,
    )
}

/// An octahedron whose edges are cut into `f` parts, blown up to the unit sphere.
///
/// The vertices stand on `2f + 1` circles of latitude: 1, 4, 8, ... 4f, ... 8, 4, 1 of them. All are shared, so the
/// surface is closed exactly, whatever the rounding.
fn ball(f: u64) -> Mesh {
    let mut shape = Shape::new("ball");
    let per_quadrant = |row: u64| row.min(2 * f - row);
    let mut first_of = Vec::new();
    for row in 0..=2 * f {
        first_of.push(shape_row(
            &mut shape,
            row as f64 / (2 * f) as f64,
            per_quadrant(row),
        ));
    }
    let at = |row: u64, quadrant: u64, step: u64| {
        let length = (4 * per_quadrant(row)).max(1);
        first_of[row as usize] + ((quadrant * per_quadrant(row) + step) % length) as u32
    };
    for row in 0..f {
        for quadrant in 0..4 {
            // North: the upper row is the shorter one. South: the same, upside down.
            let (near, far) = (2 * f - row, 2 * f - row - 1);
            for step in 0..=row {
                let [a, b] = [step, step + 1].map(|step| at(row + 1, quadrant, step));
                shape.triangle([at(row, quadrant, step), a, b], 0);
                let [a, b] = [step, step + 1].map(|step| at(far, quadrant, step));
                shape.triangle([at(near, quadrant, step), b, a], 0);
                if step < row {
                    let top = [step, step + 1].map(|step| at(row, quadrant, step));
                    shape.triangle([top[0], at(row + 1, quadrant, step + 1), top[1]], 0);
                    let bottom = [step, step + 1].map(|step| at(near, quadrant, step));
                    shape.triangle([bottom[0], bottom[1], at(far, quadrant, step + 1)], 0);
                }
            }
        }
    }
    shape.finish()
}

/// The circle at `latitude` (0 at the north pole, 1 at the south pole) with 4 `per_quadrant` vertices; a pole has one.
fn shape_row(shape: &mut Shape, latitude: f64, per_quadrant: u64) -> u32 {
    let (radius, height) = libm::sincos(latitude * std::f64::consts::PI);
    let count = (4 * per_quadrant).max(1);
    let mut first = None;
    for step in 0..count {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * step as f64 / count as f64);
        let p = match per_quadrant {
            0 => DVec3::new(0.0, height.signum(), 0.0),
            _ => DVec3::new(radius * cos, height, -radius * sin),
        };
        let vertex = shape.vertex_with_normal(p, p.normalize());
        first.get_or_insert(vertex);
    }
    first.unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    #[test]
    fn each_edge_is_shared_by_exactly_two_triangles_that_run_it_in_opposite_ways() {
        for f in [1, 2, 3, 50] {
            let mesh = ball(f);
            let mut edges = HashMap::new();
            for &[a, b, c] in &mesh.indices {
                for edge in [[a, b], [b, c], [c, a]] {
                    assert!(
                        edges.insert(edge, ()).is_none(),
                        "{edge:?} twice at f = {f}"
                    );
                }
            }
            assert!(
                edges.keys().all(|&[a, b]| edges.contains_key(&[b, a])),
                "a border at f = {f}"
            );
            let euler =
                mesh.positions.len() as i64 - edges.len() as i64 / 2 + mesh.indices.len() as i64;
            assert_eq!((mesh.indices.len() as u64, euler), (8 * f * f, 2));
        }
    }

    #[test]
    fn every_triangle_faces_outward() {
        let mesh = ball(7);
        for triangle in &mesh.indices {
            let [a, b, c] = triangle.map(|v| glam::Vec3::from(mesh.positions[v as usize]));
            assert!((b - a).cross(c - a).dot(a + b + c) > 0.0, "{triangle:?}");
        }
    }
}
