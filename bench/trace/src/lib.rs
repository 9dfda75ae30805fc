//! What the benchmarks of this crate share: cases, rays, scenes.

use boxwood::{BuildOptions, Ray, Scene, Triangle};

/// A soup to bench on.
pub struct Case {
    /// `waves`, `soup`.
    pub name: &'static str,
    /// What it is of.
    pub triangles: Vec<Triangle>,
}

/// A linear congruential generator.
struct Random(u64);

impl Random {
    /// In -1..1.
    fn signed(&mut self) -> f32 {
        let Self(state) = self;
        *state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*state >> 40) as f32 / (1u32 << 23) as f32 - 1.0
    }

    fn point(&mut self, scale: f32) -> [f32; 3] {
        [0; 3].map(|_| self.signed() * scale)
    }
}

/// A surface and a cloud: rays end early in one and pass by much in the other.
pub fn cases() -> [Case; 2] {
    [
        Case {
            name: "waves",
            triangles: waves(96),
        },
        Case {
            name: "soup",
            triangles: soup(20_000),
        },
    ]
}

/// A height field of `2 n n` triangles.
fn waves(n: usize) -> Vec<Triangle> {
    let at = |i: usize, j: usize| {
        let [x, z] = [i, j].map(|k| k as f32 / n as f32 * 2.0 - 1.0);
        [x, 0.2 * (7.0 * x).sin() * (5.0 * z + 1.0).cos(), z]
    };
    let quad = |k: usize| {
        let (i, j) = (k / n, k % n);
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [Triangle([a, b, c]), Triangle([a, c, d])]
    };
    (0..n * n).flat_map(quad).collect()
}

/// `n` small triangles anywhere.
fn soup(n: usize) -> Vec<Triangle> {
    let mut random = Random(5);
    let mut triangle = || {
        let corner = random.point(1.0);
        Triangle([0; 3].map(|_| {
            let edge = random.point(0.03);
            [0, 1, 2].map(|k| corner[k] + edge[k])
        }))
    };
    (0..n).map(|_| triangle()).collect()
}

/// 4096 rays from anywhere around to anywhere inside.
pub fn rays() -> Vec<Ray> {
    let mut random = Random(9);
    (0..4096)
        .map(|_| Ray::between(random.point(1.5), random.point(1.0)))
        .collect()
}

/// The case, built.
pub fn scene(case: &Case, structure: &str, options: BuildOptions) -> Scene {
    let positions: Vec<[f32; 3]> = case.triangles.iter().flat_map(|t| t.0).collect();
    let indices: Vec<[u32; 3]> = (0..case.triangles.len() as u32)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    let scene = Scene::builder()
        .mesh(&positions, &indices)
        .structure(structure)
        .options(options);
    scene.build().expect("a soup is a scene")
}
