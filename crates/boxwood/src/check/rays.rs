//! Rays that look for trouble: aimed at edges and vertices, along axes, from planes of boxes, from far away.

use super::Aim;
use crate::geom::{Aabb, MAX_COORDINATE, Ray, Triangle};

/// An endless list of rays at triangles. Ray `i` depends on nothing but the triangles, the seed, the aim and `i`, and is
/// the same on every machine.
#[derive(Clone, Debug)]
pub struct Rays<'a> {
    triangles: &'a [Triangle],
    aim: Aim,
    seed: u64,
    bounds: Aabb,
    /// Length of the diagonal, never 0.
    size: f32,
}

/// One ray in so many is none: a NaN, an infinity, no direction.
const INVALID: u64 = 256;
/// Rays of a tile: neighbours, which structures may trace together.
const TILE: u64 = 64;
/// One tile in so many of a mixture is coherent.
const COHERENT: u64 = 4;

impl<'a> Rays<'a> {
    /// Rays at `triangles`; without any, rays around the unit cube.
    pub fn new(triangles: &'a [Triangle], aim: Aim, seed: u64) -> Self {
        let in_domain = |t: &&Triangle| t.0.iter().flatten().all(|x| x.abs() <= MAX_COORDINATE);
        let boxes: Vec<Aabb> = triangles
            .iter()
            .filter(in_domain)
            .map(Triangle::bounds)
            .collect();
        let mut bounds = Aabb::of_boxes(&boxes);
        if bounds.is_empty() {
            bounds = Aabb {
                min: [0.0; 3],
                max: [1.0; 3],
            };
        }
        let reach = bounds.reach([0.0; 3]);
        let size = (bounds.diagonal() as f32).max(reach * 1e-3);
        let size = if size > 0.0 { size } else { 1.0 };
        Self {
            triangles,
            aim,
            seed,
            bounds,
            size,
        }
    }

    /// Ray `index`.
    pub fn ray(&self, index: u64) -> Ray {
        let mut random = Random::new(self.seed, index);
        let aim = match self.aim {
            Aim::Mixed if index / TILE % COHERENT == COHERENT - 1 => Aim::Tiles,
            Aim::Mixed => random.pick([Aim::Random, Aim::Edges, Aim::Vertices]),
            aim => aim,
        };
        let ray = match aim {
            Aim::Edges => self.ray_at(self.point_of_edge(&mut random), &mut random),
            Aim::Vertices => self.ray_at(self.vertex(&mut random), &mut random),
            Aim::Tiles => self.ray_of_tile(index / TILE, &mut random),
            Aim::Random | Aim::Mixed => self.ray_anywhere(&mut random),
        };
        // Rays of a tile are spoilt less often: one that is none parts the tile.
        let tile = if aim == Aim::Tiles { TILE } else { 1 };
        if random.one_in(INVALID * tile) {
            spoilt(ray, &mut random)
        } else {
            ray
        }
    }

    /// Half of them towards the box, the others anywhere.
    fn ray_anywhere(&self, random: &mut Random) -> Ray {
        let origin = self.origin(random);
        let dir = match random.below(8) {
            0 => random.along_an_axis(),
            1 => random.in_a_coordinate_plane(),
            2..=3 => random.direction(),
            _ => minus(self.in_bounds(1.0, random), origin),
        };
        let length = length(dir);
        // An exact change of length: `dir` need not be unit.
        let scale = 2.0 / (1 << random.below(12)) as f32;
        self.limited(
            Ray::new(origin, dir.map(|d| d * scale)),
            self.size / (length * scale),
            random,
        )
    }

    /// One of 64 neighbours that go nearly the same way, from one origin or from near it, to a corner of one triangle, to points of
    /// its edges or past them.
    fn ray_of_tile(&self, tile: u64, random: &mut Random) -> Ray {
        let mut shared = Random::new(!self.seed, tile);
        let origin = self.origin(&mut shared);
        let corners = self.triangle(&mut shared);
        let corner = shared.pick(corners);
        let distance = length(minus(corner, origin));
        let apart = distance * shared.pick([0.0, 0.0, 1e-6, 1e-3]);
        let spread = distance * shared.pick([0.0, 1e-6, 1e-3, 0.03]);
        let (is_along_axis, range) = (shared.one_in(6), shared.below(8));
        // As far along the edge as is still nearly the same way.
        let edge = minus(random.pick(corners), corner);
        let part = random.pick([0.0, 0.5, 1.0]) * (0.2 * distance / length(edge)).min(1.0);
        let part = if part.is_finite() { part } else { 0.0 };
        let near = |point: [f32; 3], by: f32, random: &mut Random| {
            point.map(|x| x + by * (2.0 * random.unit() - 1.0))
        };
        let origin = near(origin, apart, random);
        let target = std::array::from_fn(|k| corner[k] + part * edge[k]);
        let mut dir = minus(near(target, spread, random), origin);
        if is_along_axis {
            let main = (0..3).max_by(|a, b| dir[*a].abs().total_cmp(&dir[*b].abs()));
            let others = (0..3).filter(|k| Some(*k) != main);
            others.for_each(|k| dir[k] = random.pick([0.0, -0.0]));
        }
        let ray = Ray::new(origin, dir);
        match range {
            0 => ray.with_range(0.0, 1.0),
            1 => ray.with_range(1.0, f32::INFINITY),
            2 => ray.with_range(0.0, 2.0 * random.unit()),
            3 => ray.with_range(-1.0, f32::INFINITY),
            _ => ray,
        }
    }

    /// Through `target`, exactly wherever rounding allows.
    fn ray_at(&self, target: [f32; 3], random: &mut Random) -> Ray {
        let mut origin = self.origin(random);
        let dir = match random.below(4) {
            // Two coordinates of the line are the target's, so the line meets it exactly.
            0 => {
                let axis = random.below(3) as usize;
                let along = random.along_an_axis_of(axis);
                let step = self.size * random.unit() * if random.one_in(8) { 1e3 } else { 1.0 };
                origin = target;
                origin[axis] -= step.copysign(along[axis]);
                along
            }
            // On a diagonal: exact on integer meshes.
            1 => {
                let step = (self.size * random.unit()).ceil();
                let dir: [f32; 3] = std::array::from_fn(|_| random.pick([-1.0, 1.0, 1.0, 0.0]));
                origin = std::array::from_fn(|k| target[k] - dir[k] * step);
                dir
            }
            _ => minus(target, origin),
        };
        self.limited(Ray::new(origin, dir), 1.0, random)
    }

    /// Some rays end at `t_unit`, before or behind it; some begin late.
    fn limited(&self, ray: Ray, t_unit: f32, random: &mut Random) -> Ray {
        match random.below(16) {
            0 => ray.with_range(0.0, t_unit),
            1 => ray.with_range(0.0, t_unit * 2.0 * random.unit()),
            2 => ray.with_range(t_unit * random.unit(), f32::INFINITY),
            3 => ray.with_range(-t_unit, t_unit * 4.0),
            _ => ray,
        }
    }

    /// Inside, on a plane of the box, near, far, on the mesh.
    fn origin(&self, random: &mut Random) -> [f32; 3] {
        match random.below(8) {
            0..=2 => self.in_bounds(1.0, random),
            3 => {
                let mut on_plane = self.in_bounds(1.5, random);
                let axis = random.below(3) as usize;
                on_plane[axis] = random.pick([self.bounds.min, self.bounds.max])[axis];
                on_plane
            }
            4..=5 => self.in_bounds(3.0, random),
            6 => {
                let distance = self.size * random.pick([10.0, 100.0, 1e3, 1e4]);
                let (center, dir) = (self.bounds.center(), random.direction());
                std::array::from_fn(|k| center[k] + distance * dir[k])
            }
            _ => self.vertex(random),
        }
    }

    /// A point of the box, grown about its centre by a factor.
    fn in_bounds(&self, factor: f32, random: &mut Random) -> [f32; 3] {
        let (center, extent) = (self.bounds.center(), self.bounds.extent());
        std::array::from_fn(|k| center[k] + extent[k] * factor * (random.unit() - 0.5))
    }

    fn triangle(&self, random: &mut Random) -> [[f32; 3]; 3] {
        match self.triangles.len() as u64 {
            0 => [self.bounds.min, self.bounds.center(), self.bounds.max],
            count => self.triangles[random.below(count) as usize].0,
        }
    }

    fn vertex(&self, random: &mut Random) -> [f32; 3] {
        let corners = self.triangle(random);
        random.pick(corners)
    }

    fn point_of_edge(&self, random: &mut Random) -> [f32; 3] {
        let [a, b, c] = self.triangle(random);
        let (from, to) = random.pick([(a, b), (b, c), (c, a)]);
        // Eighths are exact on integer meshes.
        let f = if random.one_in(2) {
            random.below(9) as f32 / 8.0
        } else {
            random.unit()
        };
        std::array::from_fn(|k| from[k] + f * (to[k] - from[k]))
    }
}

fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn length(a: [f32; 3]) -> f32 {
    a.iter().map(|x| x * x).sum::<f32>().sqrt()
}

/// A ray with one number, or its direction, made impossible.
fn spoilt(mut ray: Ray, random: &mut Random) -> Ray {
    let bad = random.pick([f32::NAN, f32::INFINITY, f32::NEG_INFINITY]);
    let axis = random.below(3) as usize;
    match random.below(5) {
        0 => ray.origin[axis] = bad,
        1 => ray.dir[axis] = bad,
        2 => ray.dir = [0.0, -0.0, 0.0],
        3 => ray.t_min = f32::NAN,
        _ => ray.t_max = f32::NAN,
    }
    ray
}

/// SplitMix64 (Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014), seeded by two numbers.
struct Random(u64);

impl Random {
    fn new(seed: u64, index: u64) -> Self {
        Self(mix(seed ^ 0x5851_F42D_4C95_7F2D).wrapping_add(mix(index)))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        mix(self.0)
    }

    /// In 0..n; the bias for small `n` is of no account.
    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    fn one_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }

    fn pick<T: Copy, const N: usize>(&mut self, choices: [T; N]) -> T {
        choices[self.below(N as u64) as usize]
    }

    /// In 0..1.
    fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Uniform, of length 0.1 to 1: a point of the ball.
    fn direction(&mut self) -> [f32; 3] {
        loop {
            let point: [f32; 3] = std::array::from_fn(|_| 2.0 * self.unit() - 1.0);
            let square: f32 = point.iter().map(|x| x * x).sum();
            if (0.01..=1.0).contains(&square) {
                return point;
            }
        }
    }

    fn along_an_axis(&mut self) -> [f32; 3] {
        let axis = self.below(3) as usize;
        self.along_an_axis_of(axis)
    }

    /// Forwards or backwards, the zeros of either sign.
    fn along_an_axis_of(&mut self, axis: usize) -> [f32; 3] {
        let mut dir = std::array::from_fn(|_| self.pick([0.0, -0.0]));
        dir[axis] = self.pick([-1.0, 1.0]);
        dir
    }

    fn in_a_coordinate_plane(&mut self) -> [f32; 3] {
        let mut dir = self.direction();
        dir[self.below(3) as usize] = self.pick([0.0, -0.0]);
        // The two others may both be tiny, but hardly zero; then the ray is none, which is an input as well.
        dir
    }
}

/// The finaliser of SplitMix64: every bit of the result depends on every bit of `x`.
pub(super) fn mix(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLES: [Triangle; 2] = [
        Triangle([[1.0, 2.0, 3.5], [4.0, 2.5, 3.0], [2.0, 7.0, 4.0]]),
        Triangle([[4.0, 2.5, 3.0], [2.0, 7.0, 4.0], [6.0, 6.0, 1.0]]),
    ];

    fn rays(aim: Aim) -> Vec<Ray> {
        let rays = Rays::new(&TRIANGLES, aim, 7);
        (0..4000).map(|i| rays.ray(i)).collect()
    }

    #[test]
    fn a_ray_depends_on_seed_and_number_only() {
        let bits = |seed, i| format!("{:?}", Rays::new(&TRIANGLES, Aim::Mixed, seed).ray(i));
        assert_eq!(bits(3, 17), bits(3, 17));
        assert_ne!(bits(3, 17), bits(4, 17));
        assert_ne!(bits(3, 17), bits(3, 18));
    }

    #[test]
    fn all_the_kinds_of_rays_occur() {
        for aim in [Aim::Random, Aim::Edges, Aim::Vertices, Aim::Mixed] {
            let rays = rays(aim);
            let count = |what: &dyn Fn(&Ray) -> bool| rays.iter().filter(|r| what(r)).count();
            assert!((4..200).contains(&count(&|r| !r.is_valid())), "{aim:?}");
            assert!(count(&|r| r.dir.iter().filter(|d| **d == 0.0).count() == 2) > 100);
            assert!(count(&|r| r.dir.iter().any(|d| d.to_bits() == (-0.0_f32).to_bits())) > 100);
            assert!(count(&|r| r.t_max < 1e9) > 100);
            let far = 1e3 * Rays::new(&TRIANGLES, aim, 0).size;
            assert!(count(&|r| r.origin.iter().any(|x| x.abs() > far)) > 50);
        }
    }

    #[test]
    fn rays_of_a_tile_go_nearly_the_same_way() {
        let rays = Rays::new(&TRIANGLES, Aim::Mixed, 7);
        let tile = |number: u64| {
            (0..TILE)
                .map(|k| rays.ray(number * TILE + k))
                .collect::<Vec<_>>()
        };
        let is_coherent = |tile: &[Ray]| {
            let dot = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f32>();
            let valid: Vec<[f32; 3]> = tile
                .iter()
                .filter(|r| r.is_valid())
                .map(|r| r.dir)
                .collect();
            valid.iter().all(|d| {
                let along = dot(*d, valid[0]);
                along > 0.0 && along * along > 0.8 * dot(*d, *d) * dot(valid[0], valid[0])
            })
        };
        let coherent = |from: u64| {
            (0..100)
                .filter(|n| is_coherent(&tile(4 * n + from)))
                .count()
        };
        assert!(coherent(3) > 50, "{}", coherent(3));
        assert_eq!(coherent(0), 0);
    }

    #[test]
    fn aimed_rays_pass_their_targets_within_rounding() {
        let near = |ray: &Ray, p: [f32; 3]| {
            let to: [f64; 3] = std::array::from_fn(|k| f64::from(p[k]) - f64::from(ray.origin[k]));
            let dir = ray.dir.map(f64::from);
            let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
            let t = dot(to, dir) / dot(dir, dir);
            let off: [f64; 3] = std::array::from_fn(|k| to[k] - t * dir[k]);
            dot(off, off).sqrt() <= 1e-6 * (10.0 + dot(to, to).sqrt())
        };
        let vertices: Vec<[f32; 3]> = TRIANGLES.iter().flat_map(|t| t.0).collect();
        for ray in rays(Aim::Vertices).iter().filter(|r| r.is_valid()) {
            assert!(vertices.iter().any(|v| near(ray, *v)), "{ray:?}");
        }
    }

    #[test]
    fn meshes_without_extent_or_triangles_still_get_rays() {
        let point = [Triangle([[3.0, 4.0, 5.0]; 3])];
        let broken = [Triangle([[f32::NAN; 3]; 3])];
        for triangles in [&point[..], &broken, &[]] {
            let rays = Rays::new(triangles, Aim::Random, 1);
            let valid = (0..1000).filter(|i| rays.ray(*i).is_valid()).count();
            assert!(valid > 500, "{valid} of 1000 for {triangles:?}");
        }
    }
}
