//! Mountains around a lake: a height field, the friendliest scene for a uniform grid.

use glam::DVec3;

use super::random::mix;
use super::shape::Shape;
use super::{Builtin, Params, Size, assemble, matte};
use crate::{Camera, Material, Model};

pub(super) const BUILTIN: Builtin = Builtin {
    name: "terrain",
    about: "a fractal height field, two triangles for each cell",
    size: Size::AtMost {
        default: 131_072,
        least: 2,
    },
    seeded: true,
    build,
};

/// Side of the square, in units of which the highest peak has about a fifth.
const SIDE: f64 = 100.0;

/// `rows * columns` cells with `rows = floor(sqrt(n / 2))` and as many columns as fit.
fn build(params: &Params) -> Model {
    let rows = (params.n / 2).isqrt();
    let columns = params.n / 2 / rows;
    let mut land = Shape::new("terrain");
    for row in 0..=rows {
        for column in 0..=columns {
            let x = column as f64 / columns as f64 - 0.5;
            let z = row as f64 / rows as f64 - 0.5;
            let p = ground(x, z, params.seed);
            let step = 1.0 / (2 * rows.max(columns)) as f64;
            let slope_x = ground(x + step, z, params.seed) - ground(x - step, z, params.seed);
            let slope_z = ground(x, z + step, params.seed) - ground(x, z - step, params.seed);
            land.vertex_with_normal(p, slope_z.cross(slope_x).normalize());
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let at = |row: u64, column: u64| (row * (columns + 1) + column) as u32;
            let corners = [
                at(row, column),
                at(row + 1, column),
                at(row + 1, column + 1),
                at(row, column + 1),
            ];
            land.quad_by(corners, kind_of_ground);
        }
    }
    let water = Material {
        roughness: 0.3,
        ..matte("water", [0.03, 0.12, 0.17])
    };
    let materials = vec![
        water,
        matte("sand", [0.50, 0.41, 0.26]),
        matte("grass", [0.13, 0.22, 0.06]),
        matte("rock", [0.25, 0.22, 0.20]),
        matte("snow", [0.86, 0.88, 0.92]),
    ];
    let camera = Camera {
        eye: [42.0, 21.0, 50.0],
        target: [-8.0, 0.0, -12.0],
        up: [0.0, 1.0, 0.0],
        fov: 36.0,
    };
    assemble(vec![land.finish()], materials, camera)
}

/// Index of the material of a triangle, by its height and steepness.
fn kind_of_ground([a, b, c]: [DVec3; 3]) -> u32 {
    let height = (a.y + b.y + c.y) / 3.0;
    let up = (b - a).cross(c - a).normalize_or(DVec3::Y).y;
    match height {
        h if h <= 0.0 && up > 0.9999 => 0,
        h if h < 0.35 && up > 0.8 => 1,
        h if h > 6.3 && up > 0.62 => 4,
        h if h > 5.4 || up < 0.74 => 3,
        _ => 2,
    }
}

/// The surface above `x`, `z` in -0.5..0.5. The lake lies at height 0.
fn ground(x: f64, z: f64, seed: u64) -> DVec3 {
    let [u, v] = [x * 3.0 + 7.3, z * 3.0 + 2.9];
    // Bending the coordinates by noise breaks the regular look of plain octaves.
    let bend = |shift: f64| 0.35 * octaves(u + shift, v - shift, 3, seed ^ 0xbe4d);
    let (u, v) = (u + bend(5.2), v + bend(1.3));
    let hills = octaves(u, v, 9, seed);
    let ridges = 1.0 - octaves(u * 0.9 + 11.0, v * 0.9 + 4.0, 8, seed ^ 0x51de).abs() * 2.2;
    let height = hills * 7.0 + ridges.max(0.0).powi(2) * 9.0 * smooth(hills + 0.6) - 1.6;
    DVec3::new(x * SIDE, height.max(0.0), z * SIDE)
}

/// Fractional Brownian motion: noise of doubling frequency and halving height, about -1..1.
fn octaves(x: f64, z: f64, count: u32, seed: u64) -> f64 {
    let mut sum = 0.0;
    let (mut frequency, mut height) = (1.0, 0.5);
    for octave in 0..count {
        sum += height
            * noise(
                x * frequency,
                z * frequency,
                seed.wrapping_add(u64::from(octave)),
            );
        frequency *= 2.03;
        height *= 0.44;
    }
    sum
}

/// Gradient noise on the integer lattice, about -1..1: Perlin, "Improving noise", SIGGRAPH 2002.
fn noise(x: f64, z: f64, seed: u64) -> f64 {
    let (column, row) = (x.floor(), z.floor());
    let (fx, fz) = (x - column, z - row);
    let corner = |dx: f64, dz: f64| {
        let key = ((column + dx) as i64 as u64).wrapping_mul(0x9e37_79b9)
            ^ (((row + dz) as i64 as u64) << 32);
        let bits = mix(mix(key) ^ seed);
        let gradient = |bits: u64| (bits & 0xffff) as f64 / 32768.0 - 1.0;
        gradient(bits) * (fx - dx) + gradient(bits >> 16) * (fz - dz)
    };
    let (sx, sz) = (smooth(fx), smooth(fz));
    let near = corner(0.0, 0.0) + (corner(1.0, 0.0) - corner(0.0, 0.0)) * sx;
    let far = corner(0.0, 1.0) + (corner(1.0, 1.0) - corner(0.0, 1.0)) * sx;
    1.6 * (near + (far - near) * sz)
}

/// From 0 to 1 with two derivatives zero at the ends.
fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_of_the_land_faces_up() {
        let mesh = &build(&Params { n: 3000, seed: 0 }).meshes[0];
        for triangle in &mesh.indices {
            let [a, b, c] = triangle.map(|v| glam::Vec3::from(mesh.positions[v as usize]));
            assert!((b - a).cross(c - a).y > 0.0);
        }
        assert!(mesh.normals.iter().all(|n| n[1] > 0.0));
    }

    #[test]
    fn noise_is_continuous_across_cells() {
        for i in -20..20 {
            let x = f64::from(i);
            assert!((noise(x - 1e-9, 0.37, 5) - noise(x + 1e-9, 0.37, 5)).abs() < 1e-7);
        }
    }
}
