//! Scenes and rays that the integration tests share. Degenerate input is a scene like any other.

#![allow(dead_code, reason = "each test binary uses a part")]

use boxwood::{BuildOptions, Ray, Scene, Triangle};

/// A small generator with a fixed law, so that a failing seed fails everywhere.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// In 0..1.
    pub(crate) fn unit(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    /// In -1..1.
    pub(crate) fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f32) as usize).min(n - 1)
    }

    pub(crate) fn point(&mut self, size: f32) -> [f32; 3] {
        std::array::from_fn(|_| self.signed() * size)
    }

    /// Every finite and non-finite bit pattern.
    pub(crate) fn bits(&mut self) -> f32 {
        let high = (self.unit() * 65536.0) as u32;
        f32::from_bits(high << 16 | (self.unit() * 65536.0) as u32)
    }
}

pub(crate) type Mesh = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// Triangles of a mesh.
pub(crate) fn triangles((positions, indices): &Mesh) -> Vec<Triangle> {
    indices
        .iter()
        .map(|t| Triangle(t.map(|i| positions[i as usize])))
        .collect()
}

/// A mesh in a structure.
pub(crate) fn built(mesh: &Mesh, structure: &str, options: BuildOptions) -> Scene {
    Scene::builder()
        .mesh(&mesh.0, &mesh.1)
        .structure(structure)
        .options(options)
        .build()
        .unwrap()
}

fn soup(triangles: impl IntoIterator<Item = [[f32; 3]; 3]>) -> Mesh {
    let positions: Vec<_> = triangles.into_iter().flatten().collect();
    let indices = (0..positions.len() as u32 / 3)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    (positions, indices)
}

/// A closed cube of `2 * 6 * n * n` triangles with integer coordinates `0..=n`.
pub(crate) fn integer_cube(n: u32) -> Mesh {
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    let mut numbers = std::collections::HashMap::new();
    let mut vertex = |p: [u32; 3]| {
        *numbers.entry(p).or_insert_with(|| {
            positions.push(p.map(|x| x as f32));
            positions.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        for side in [0, n] {
            for i in 0..n {
                for j in 0..n {
                    let mut corner = |a: u32, b: u32| {
                        let mut p = [0; 3];
                        (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, i + a, j + b);
                        vertex(p)
                    };
                    let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    let flip = |t: [u32; 3]| if side == 0 { [t[0], t[2], t[1]] } else { t };
                    indices.extend([flip([a, b, c]), flip([a, c, d])]);
                }
            }
        }
    }
    (positions, indices)
}

/// A closed star-shaped surface: a sphere of `rings x sectors` with a wavy radius, as positions and triangles.
pub(crate) fn star(rings: u32, sectors: u32, waves: f32) -> Mesh {
    let mut positions = vec![[0.0, 0.0, 1.0]];
    for ring in 1..rings {
        let theta = ring as f32 / rings as f32 * std::f32::consts::PI;
        for sector in 0..sectors {
            let phi = sector as f32 / sectors as f32 * std::f32::consts::TAU;
            let radius = 1.0 + 0.2 * (waves * phi).sin() * (waves * theta).sin();
            positions.push(
                [
                    theta.sin() * phi.cos(),
                    theta.sin() * phi.sin(),
                    theta.cos(),
                ]
                .map(|x| x * radius),
            );
        }
    }
    positions.push([0.0, 0.0, -1.0]);
    let south = positions.len() as u32 - 1;
    let at = |ring: u32, sector: u32| 1 + (ring - 1) * sectors + sector % sectors;
    let mut indices = Vec::new();
    for s in 0..sectors {
        indices.push([0, at(1, s), at(1, s + 1)]);
        indices.push([south, at(rings - 1, s + 1), at(rings - 1, s)]);
        for r in 1..rings - 1 {
            indices.push([at(r, s), at(r + 1, s), at(r + 1, s + 1)]);
            indices.push([at(r, s), at(r + 1, s + 1), at(r, s + 1)]);
        }
    }
    (positions, indices)
}

/// The same mesh elsewhere, with its coordinates rounded there.
pub(crate) fn moved((positions, indices): &Mesh, scale: f32, by: [f32; 3]) -> Mesh {
    let place = |p: &[f32; 3]| std::array::from_fn(|k| p[k] * scale + by[k]);
    (positions.iter().map(place).collect(), indices.clone())
}

/// Every kind of scene that has ever broken a ray tracer, by name.
pub(crate) fn scenes() -> Vec<(&'static str, Mesh)> {
    let mut random = Random::new(77);
    let mut cloud = |n: usize, size: f32| -> Mesh {
        soup((0..n).map(|_| {
            let p = random.point(1.0);
            std::array::from_fn(|_| {
                let d = random.point(size);
                std::array::from_fn(|k| p[k] + d[k])
            })
        }))
    };
    let one = [[0.0, 0.0, 1.0], [1.0, 0.25, 1.5], [0.25, 1.0, 1.0]];
    let nan = [[f32::NAN, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    let infinite = [[0.0, 0.0, 1.0], [f32::INFINITY, 0.0, 1.0], [0.0, 1.0, 1.0]];
    let mut bits = Random::new(5);
    let mut mixed = cloud(200, 0.3);
    for garbage in [nan, infinite] {
        let (p, _) = soup([garbage]);
        let at = mixed.0.len() as u32;
        mixed.0.extend(p);
        mixed.1.insert(100, [at, at + 1, at + 2]);
    }
    vec![
        ("nothing", soup([])),
        ("one triangle", soup([one])),
        ("only garbage", soup([nan, infinite])),
        ("garbage among good ones", mixed),
        (
            "random bits",
            soup((0..300).map(|_| std::array::from_fn(|_| std::array::from_fn(|_| bits.bits())))),
        ),
        (
            "a point and a line",
            soup([[[1.0; 3]; 3], [[0.0; 3], [1.0; 3], [2.0; 3]], one]),
        ),
        ("copies", soup([one; 3000])),
        (
            "flat in a plane",
            soup((0..500).map(|i| {
                let (x, y) = ((i % 25) as f32, (i / 25) as f32);
                [[x, y, 2.0], [x + 1.0, y, 2.0], [x, y + 1.0, 2.0]]
            })),
        ),
        (
            "exponential",
            soup((0..120).map(|i| {
                let s = 2.0_f32.powi(i - 60);
                [[s, 0.0, 0.0], [s * 1.5, s, 0.0], [s, 0.0, s]]
            })),
        ),
        (
            "slivers",
            soup((0..600).map(|i| {
                let s = i as f32 * 0.01;
                [[s, -s, 0.0], [s + 3.0, 3.0 - s, 3.0], [s + 1e-4, -s, 1e-4]]
            })),
        ),
        ("cloud", cloud(1500, 0.15)),
        ("big triangles", cloud(300, 1.5)),
        ("integer cube", integer_cube(4)),
        ("star", star(14, 20, 3.0)),
        (
            "star far away",
            moved(&star(14, 20, 3.0), 2.0, [148_376.0, 1234.0, -223_423.0]),
        ),
        ("tiny star", moved(&star(9, 12, 2.0), 1e-30, [0.0; 3])),
        ("subnormal star", moved(&star(9, 12, 2.0), 1e-40, [0.0; 3])),
        ("huge star", moved(&star(9, 12, 2.0), 5e29, [0.0; 3])),
        ("far copy and near copy", {
            let (mut p, mut i) = star(9, 12, 2.0);
            let (q, j) = moved(&star(9, 12, 2.0), 0.01, [3e4, 0.0, 0.0]);
            let shift = p.len() as u32;
            p.extend(q);
            i.extend(j.iter().map(|t| t.map(|x| x + shift)));
            (p, i)
        }),
    ]
}

/// Rays at a scene: random ones, ones aimed at vertices and edges, along axes and face planes, from far away, with closed
/// ranges that end exactly on a surface, and some that are no rays.
pub(crate) fn rays(mesh: &Mesh, count: usize, seed: u64) -> Vec<Ray> {
    let triangles = triangles(mesh);
    let mut random = Random::new(seed);
    let finite: Vec<_> = triangles
        .iter()
        .filter(|t| t.0.iter().flatten().all(|x| x.is_finite()))
        .collect();
    let size = finite
        .iter()
        .flat_map(|t| t.0)
        .flatten()
        .fold(1e-3_f32, |m, x| m.max(x.abs()))
        .min(1e30);
    (0..count)
        .map(|i| {
            let origin = match i % 7 {
                0 => random.point(size * 3.0),
                1 => random.point(size),
                2 => random.point(size * 100.0),
                3 => random.point(size * 3.0).map(f32::round),
                4 => random.point(size * 1e4),
                5 if !finite.is_empty() => finite[random.below(finite.len())].0[0],
                _ => [0.0; 3],
            };
            let target = if finite.is_empty() {
                random.point(size)
            } else {
                let t = finite[random.below(finite.len())];
                let (a, b) = (random.unit(), random.unit());
                match i % 5 {
                    0 => t.point(a * 0.5, b * 0.5),
                    1 => t.0[random.below(3)],
                    2 => std::array::from_fn(|k| t.0[0][k] + a * (t.0[1][k] - t.0[0][k])),
                    3 => std::array::from_fn(|k| 0.5 * t.0[1][k] + 0.5 * t.0[2][k]),
                    _ => random.point(size),
                }
            };
            let mut ray = Ray::between(origin, target).with_range(0.0, f32::INFINITY);
            match i % 11 {
                0 => ray.dir[random.below(3)] = 0.0,
                1 => ray.dir[random.below(3)] = -0.0,
                2 => {
                    ray.dir =
                        [[1.0, 0.0, -0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]][random.below(3)];
                }
                3 => ray = ray.with_range(0.0, 1.0),
                4 => ray = ray.with_range(1.0, f32::INFINITY),
                5 => ray = ray.with_range(0.5, random.unit() * 2.0),
                6 if i % 13 == 0 => ray.dir[0] = f32::NAN,
                6 if i % 13 == 1 => ray.origin[1] = f32::INFINITY,
                6 if i % 13 == 2 => ray.dir = [0.0; 3],
                7 => {
                    ray.dir = ray
                        .dir
                        .map(|d| d * 2.0_f32.powi(random.below(60) as i32 - 30));
                }
                _ => {}
            }
            ray
        })
        .collect()
}

/// The ray as code that can be pasted into a test.
pub(crate) fn code(ray: &Ray) -> String {
    format!(
        "Ray::new({:?}, {:?}).with_range({:?}, {:?})",
        ray.origin, ray.dir, ray.t_min, ray.t_max
    )
}
