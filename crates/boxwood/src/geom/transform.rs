//! Affine maps: where an instance stands, the ray as it sees it, and a box that no rounding escapes.
//!
//! # The recipe
//!
//! An instance is hit where the ray, turned into its space, hits its content. The turned ray is part of the definition
//! of a hit, so it is made in one way everywhere: with `A` the 3x3 part and `b` the last column of the matrix, and
//! `R = A^-1` by cofactors in double precision,
//!
//! ```text
//! origin' = round32(R (origin - b))     dir' = round32(R dir)     t' = t
//! ```
//!
//! each sum from left to right in double precision, rounded to single once. `dir'` is not made unit, so `t` means the same inside
//! and outside. The identity leaves the ray as it is.
//!
//! # Why the world box suffices
//!
//! Structures meet an instance as a box in the world. A hit at `t` is a fact about the rounded ray in the object's
//! space; the box must hold the *world* ray's point at `t`, or a structure might skip the instance. Let `u = 2^-24`, norms be
//! largest row sums, `A'` the reach (see [`Aabb::reach`]) of the content's box from `origin'`, and `m` its largest
//! coordinate. The content promises ([`Slack`]) that the rounded ray's point at `t` is in its box padded by
//! `s A' + k f'`, where `f'` is the ray's padding floor. Then the world point at `t` is in the instance's box up to
//!
//! * `|A| (s A' + k f')`, the content's own slack seen from the world,
//! * `|A| (u |origin'| + u t |dir'|)`, the roundings of the recipe: at most `|A| (2 u A' + u m)`,
//! * `e (3 reach + |A| m)`, where `e` bounds `|A R - I|`, `|R A - I|` and all roundings in double precision.
//!
//! With `A' <= |R| reach + (e + 4 u) m`, where `reach` is that of the instance's box from `origin`, the whole is
//! `s1 reach + k1 f` with `s1 = |A| |R| (s + 4 u) + 3 e` and `k1 = |A| |R| k`, which depends on the ray, plus a part that does
//! not. The latter is added to the box ([`Placement::world_box`]); the former is the slack of the instance, by which
//! the padding of every filter is raised ([`PreparedRay::loosened`]). So slack grows by about the condition number of the
//! matrix with every level: 3 at most for a rotation.

use super::PreparedRay;
use super::{Aabb, Ray};

/// An affine map from an object's space to the world: a 3x4 matrix, row by row, as Embree, Vulkan and DXR have it.
///
/// The last column is the translation: `point'[i] = m[i][0] x + m[i][1] y + m[i][2] z + m[i][3]`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Transform(pub [[f32; 4]; 3]);

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// Leaves everything where it is.
    pub const IDENTITY: Self = Self([
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
    ]);

    /// Moves by `by`.
    pub const fn translation(by: [f32; 3]) -> Self {
        Self([
            [1.0, 0.0, 0.0, by[0]],
            [0.0, 1.0, 0.0, by[1]],
            [0.0, 0.0, 1.0, by[2]],
        ])
    }

    /// Scales along the axes; a negative factor mirrors.
    pub const fn scale(by: [f32; 3]) -> Self {
        Self([
            [by[0], 0.0, 0.0, 0.0],
            [0.0, by[1], 0.0, 0.0],
            [0.0, 0.0, by[2], 0.0],
        ])
    }

    /// From the four columns of a 4x4 matrix as glTF and OpenGL store it; the last row is taken to be `0 0 0 1`.
    pub fn from_columns(columns: [[f32; 4]; 4]) -> Self {
        Self(std::array::from_fn(|row| {
            std::array::from_fn(|column| columns[column][row])
        }))
    }

    /// Where a point comes to lie; in double precision, rounded once.
    pub fn point(&self, point: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = point.map(f64::from);
        self.0.map(|row| {
            let [a, b, c, d] = row.map(f64::from);
            (a * x + b * y + c * z + d) as f32
        })
    }

    /// `self` after `first`, in double precision, rounded once.
    pub fn after(&self, first: &Self) -> Self {
        let (outer, inner) = (Affine::of(self), Affine::of(first));
        Self(outer.after(&inner).0.map(|row| row.map(|x| x as f32)))
    }
}

/// An affine map in double precision, as maps come out that are put together from several: rows of a 3x4 matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine(pub [[f64; 4]; 3]);

impl Affine {
    /// The same map.
    pub fn of(transform: &Transform) -> Self {
        Self(transform.0.map(|row| row.map(f64::from)))
    }

    /// `self` after `first`.
    pub fn after(&self, first: &Self) -> Self {
        Self(std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                let product: f64 = (0..3).map(|k| self.0[row][k] * first.0[k][column]).sum();
                product + if column == 3 { self.0[row][3] } else { 0.0 }
            })
        }))
    }

    /// Where a point comes to lie.
    pub fn point(&self, point: [f64; 3]) -> [f64; 3] {
        self.0
            .map(|[a, b, c, d]| a * point[0] + b * point[1] + c * point[2] + d)
    }

    /// Where the normal of a surface comes to point, scaled as areas are, on the side on which it was: the cofactors of the 3x3
    /// part times the vector, turned round by a map that mirrors.
    pub fn normal(&self, normal: [f64; 3]) -> [f64; 3] {
        let linear = self.0.map(|[a, b, c, _]| [a, b, c]);
        let cofactors = cofactors(&linear);
        let side = determinant(&linear, &cofactors).signum();
        cofactors.map(|row| side * dot(row, normal))
    }
}

/// How far outside of the box of a scene the hits of its content may lie: on each axis `per_reach` of the reach of the box
/// plus `per_floor` of the ray's padding floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slack {
    pub(crate) per_reach: f64,
    pub(crate) per_floor: f64,
}

impl Slack {
    /// Of primitives: `t` is bound to a box padded by `16 u A`, and computing that errs by `4 u A` (see
    /// [`super::slab`]). Rounded up.
    pub(crate) const OF_PRIMITIVES: Self = Self {
        per_reach: 2.0 * UNIT * 16.0,
        per_floor: 2.0,
    };

    /// Beyond that a padding says nothing, and the instance counts as singular: condition numbers of some 10^8.
    const MOST: f64 = 1024.0;

    /// The larger in each.
    pub(crate) fn max(self, other: Self) -> Self {
        Self {
            per_reach: self.per_reach.max(other.per_reach),
            per_floor: self.per_floor.max(other.per_floor),
        }
    }
}

impl PreparedRay {
    /// The ray for structures around instances: the padding of every filter is raised by the instances' slack.
    /// `bounds` is around all of them.
    pub(crate) fn loosened(&self, slack: Slack, bounds: &Aabb) -> Self {
        // A percent for the roundings of this line and of the slab test.
        let floor = 1.01 * slack.per_reach * f64::from(bounds.reach(self.origin))
            + 1.01 * slack.per_floor * f64::from(self.pad_floor);
        Self {
            pad_floor: floor as f32,
            ..*self
        }
    }
}

/// A [`Transform`] that can be undone, ready to turn rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    /// `R`.
    object_from_world: [[f64; 3]; 3],
    /// `b`.
    origin: [f64; 3],
    is_identity: bool,
}

impl Placement {
    /// Operations of [`Placement::ray_in_object`]: 3 subtractions, two products of matrix and vector. Preparing the turned ray is,
    /// as for every ray, not counted.
    pub(crate) const FLOPS: u32 = 3 + 15 + 15;

    /// `None` if the matrix is not finite or not invertible.
    pub(crate) fn new(world_from_object: &Transform) -> Option<Self> {
        let Affine(rows) = Affine::of(world_from_object);
        let linear = rows.map(|[a, b, c, _]| [a, b, c]);
        let cofactors = cofactors(&linear);
        let determinant = determinant(&linear, &cofactors);
        // The inverse is the transpose of the cofactors over the determinant.
        let object_from_world: [[f64; 3]; 3] =
            std::array::from_fn(|i| std::array::from_fn(|k| cofactors[k][i] / determinant));
        let origin = rows.map(|row| row[3]);
        let is_finite = object_from_world
            .iter()
            .flatten()
            .chain(&origin)
            .all(|x| x.is_finite());
        (is_finite && determinant != 0.0).then_some(Self {
            object_from_world,
            origin,
            is_identity: *world_from_object == Transform::IDENTITY,
        })
    }

    /// The ray as the object sees it, up to `t_max`; see the module's recipe. `None` if that is no ray (see [`Ray`]).
    #[inline]
    pub(crate) fn ray_in_object(&self, ray: &PreparedRay, t_max: f32) -> Option<PreparedRay> {
        let (mut origin, mut dir) = (ray.origin, ray.dir);
        if !self.is_identity {
            let from_b: [f64; 3] =
                std::array::from_fn(|k| f64::from(ray.origin[k]) - self.origin[k]);
            let along = ray.dir.map(f64::from);
            origin = self.object_from_world.map(|row| dot(row, from_b) as f32);
            dir = self.object_from_world.map(|row| dot(row, along) as f32);
        }
        let turned = PreparedRay::new(&Ray {
            origin,
            t_min: ray.t_min,
            dir,
            t_max,
        })?;
        Some(PreparedRay {
            mask: ray.mask,
            ..turned
        })
    }

    /// The box in the world around content in `bounds` with `slack`, and the slack that remains (see the module's
    /// argument). `None` where that is out of bounds: nothing can be hit there.
    pub(crate) fn world_box(
        &self,
        world_from_object: &Transform,
        bounds: &Aabb,
        slack: Slack,
    ) -> Option<(Aabb, Slack)> {
        if bounds.is_empty() {
            return None;
        }
        let map = Affine::of(world_from_object);
        let linear = map.0.map(|[a, b, c, _]| [a, b, c]);
        let inverse = &self.object_from_world;
        let condition = norm(&linear) * norm(inverse);
        let error = residual(&linear, inverse).max(residual(inverse, &linear))
            + TWO_POW_MINUS_48 * condition;
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let corner = |k: usize| [bounds.min[k], bounds.max[k]].map(f64::from);
        let size = largest(&[corner(0), corner(1), corner(2)].concat());

        let (s, k) = (slack.per_reach, slack.per_floor);
        let remains = Slack {
            per_reach: 1.01 * (condition * (s + 4.0 * UNIT) + 3.0 * error),
            per_floor: 1.01 * condition * k,
        };
        let by_size = (s + 4.0 * UNIT) * (error + 4.0 * UNIT) + 2.0 * UNIT + error;
        let fixed = 1.01 * norm(&linear) * (size * by_size + k * FLOOR)
            + TWO_POW_MINUS_48 * largest(&self.origin);

        let center = map.point([0, 1, 2].map(|k| 0.5 * corner(k)[0] + 0.5 * corner(k)[1]));
        let half = linear.map(|row| {
            let side = |k: usize| row[k].abs() * (0.5 * corner(k)[1] - 0.5 * corner(k)[0]);
            side(0) + side(1) + side(2) + fixed
        });
        let world = Aabb {
            min: std::array::from_fn(|k| ((center[k] - half[k]) as f32).next_down()),
            max: std::array::from_fn(|k| ((center[k] + half[k]) as f32).next_up()),
        };
        let is_usable = remains.per_reach <= Slack::MOST && remains.per_floor.is_finite();
        (is_usable && world.is_in_domain()).then_some((world, remains))
    }
}

/// Half the distance of neighbouring single-precision numbers, relative.
const UNIT: f64 = 1.0 / (1 << 24) as f64;
const TWO_POW_MINUS_48: f64 = UNIT * UNIT;
/// 2^-110: what [`PreparedRay::pad_floor`] is at least.
const FLOOR: f64 = 1.0 / (1_u128 << 110) as f64;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Row `i` has the cofactors of row `i`.
fn cofactors(rows: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let [x, y, z] = *rows;
    [cross(y, z), cross(z, x), cross(x, y)]
}

fn determinant(rows: &[[f64; 3]; 3], cofactors: &[[f64; 3]; 3]) -> f64 {
    dot(rows[0], cofactors[0])
}

/// The largest sum of sizes in a row.
fn norm(rows: &[[f64; 3]; 3]) -> f64 {
    rows.iter()
        .map(|[a, b, c]| a.abs() + b.abs() + c.abs())
        .fold(0.0, f64::max)
}

/// `|a b - I|`: how far `b` is from being the inverse.
fn residual(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> f64 {
    let entry = |i: usize, k: usize| {
        let product: f64 = (0..3).map(|j| a[i][j] * b[j][k]).sum();
        product - if i == k { 1.0 } else { 0.0 }
    };
    norm(&std::array::from_fn(|i| {
        std::array::from_fn(|k| entry(i, k))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    const CROOKED: Transform = Transform([
        [0.5, -2.0, 0.25, 3.0],
        [1.5, 0.75, -1.0, -7.0],
        [0.0, 1.25, 2.0, 100.0],
    ]);

    fn turned(transform: &Transform, ray: &Ray) -> Option<PreparedRay> {
        let ray = PreparedRay::new(ray).unwrap();
        Placement::new(transform)?.ray_in_object(&ray, ray.t_max)
    }

    #[test]
    fn a_turned_ray_comes_back_to_where_it_was() {
        let ray = Ray::new([1.0, 2.0, 3.5], [0.5, -1.0, 2.0]).with_range(0.25, 9.0);
        let inside = turned(&CROOKED, &ray).unwrap();
        let back = CROOKED.point(std::array::from_fn(|k| {
            inside.origin[k] + 3.0 * inside.dir[k]
        }));
        for k in 0..3 {
            assert!((back[k] - ray.at(3.0)[k]).abs() < 1e-4, "{back:?}");
        }
        assert_eq!((inside.t_min, inside.t_max), (0.25, 9.0));
    }

    #[test]
    fn the_identity_keeps_every_bit() {
        let ray = Ray::new([1.0, -0.0, 3.5], [-0.0, -1.0, 2.0]);
        let inside = turned(&Transform::IDENTITY, &ray).unwrap();
        let bits = |v: [f32; 3]| v.map(f32::to_bits);
        assert_eq!(bits(inside.origin), bits(ray.origin));
        assert_eq!(bits(inside.dir), bits(ray.dir));
    }

    #[test]
    fn a_line_looks_the_same_both_ways() {
        let ray = Ray::new([1.1, 2.3, 3.7], [0.51, -1.3, 2.7]);
        let back = Ray {
            dir: ray.dir.map(|d| -d),
            ..ray
        };
        let [there, back] = [ray, back].map(|ray| turned(&CROOKED, &ray).unwrap());
        assert_eq!(there.origin, back.origin);
        assert_eq!(there.dir, back.dir.map(|d| -d));
    }

    #[test]
    fn singular_and_non_finite_matrices_place_nothing() {
        assert!(Placement::new(&Transform::scale([1.0, 0.0, 2.0])).is_none());
        assert!(Placement::new(&Transform([[1.0, 2.0, 3.0, 0.0]; 3])).is_none());
        assert!(Placement::new(&Transform::translation([0.0, f32::NAN, 0.0])).is_none());
        assert!(Placement::new(&Transform::scale([f32::INFINITY; 3])).is_none());
    }

    #[test]
    fn maps_after_each_other_are_one_map() {
        let scale = Transform::scale([2.0, -0.5, 4.0]);
        let p = [1.0, 2.0, 3.5];
        assert_eq!(
            CROOKED.after(&scale).point(p),
            CROOKED.point(scale.point(p))
        );
        let columns = [
            [0.5, 1.5, 0.0, 0.0],
            [-2.0, 0.75, 1.25, 0.0],
            [0.25, -1.0, 2.0, 0.0],
            [3.0, -7.0, 100.0, 1.0],
        ];
        assert_eq!(Transform::from_columns(columns), CROOKED);
    }

    #[test]
    fn normals_stay_square_to_their_plane_and_on_their_side() {
        for mirror in [1.0, -1.0] {
            let map = Affine::of(&CROOKED.after(&Transform::scale([mirror, 1.0, 1.0])));
            let (u, v) = ([1.0, 2.0, 0.5], [-1.0, 0.25, 3.0]);
            let linear = map.0.map(|[a, b, c, _]| [a, b, c]);
            let normal = map.normal(cross(u, v));
            let [u1, v1] = [u, v].map(|p| linear.map(|row| dot(row, p)));
            assert!(dot(normal, u1).abs() < 1e-9 && dot(normal, v1).abs() < 1e-9);
            // A point in front of the plane stays in front.
            let front = linear.map(|row| dot(row, cross(u, v)));
            assert!(dot(normal, front) > 0.0);
        }
    }

    /// What the argument above promises, for rays at corners, edges and faces of the object's box, from near and far, through maps of
    /// every kind: the world ray's point at a `t` that is inside for the turned ray is in the padded world box.
    #[test]
    fn the_world_box_holds_what_the_turned_ray_finds() {
        let mut random = Random::new(11);
        let (mut met, mut tight) = (0, 0.0_f64);
        for _ in 0..60_000 {
            let pick =
                |random: &mut Random, values: [f32; 3]| values[(random.unit() * 3.0) as usize % 3];
            let power = |random: &mut Random, most: f32| 10.0_f32.powf(random.signed() * most);
            let shape: [f32; 3] = match (random.unit() * 4.0) as u32 {
                0 => [1.0; 3],
                1 => [power(&mut random, 3.0); 3],
                2 => [(); 3].map(|()| power(&mut random, 3.0)),
                _ => [-1.0, 1.0, power(&mut random, 1.0)],
            };
            let mut rows = [[0.0; 4]; 3];
            for row in 0..3 {
                for column in 0..3 {
                    rows[row][column] = random.signed() * shape[column];
                }
                rows[row][3] = random.signed() * pick(&mut random, [0.0, 1.0, 1e5]);
            }
            let transform = Transform(rows);
            let offset = pick(&mut random, [0.0, 0.0, 1e4]);
            let min = [(); 3].map(|()| random.signed() + offset);
            let max = std::array::from_fn(|k| {
                min[k]
                    + if random.unit() < 0.3 {
                        0.0
                    } else {
                        random.unit()
                    }
            });
            let bounds = Aabb { min, max };
            let Some(placement) = Placement::new(&transform) else {
                continue;
            };
            let slack = Slack::OF_PRIMITIVES;
            let Some((world, remains)) = placement.world_box(&transform, &bounds, slack) else {
                continue;
            };
            let target = [0, 1, 2].map(|k| if random.unit() < 0.5 { min[k] } else { max[k] });
            let target = transform.point(target);
            let far = pick(&mut random, [1.0, 30.0, 1e4]) * world.diagonal() as f32;
            let origin: [f32; 3] = std::array::from_fn(|k| target[k] + random.signed() * far);
            let dir = std::array::from_fn(|k| target[k] - origin[k]);
            let Some(ray) = PreparedRay::new(&Ray::new(origin, dir)) else {
                continue;
            };
            let Some(inside) = placement.ray_in_object(&ray, f32::INFINITY) else {
                continue;
            };
            let own = bounds.own_interval(&inside);
            if own.near > own.far {
                continue;
            }
            met += 1;
            let loose = ray.loosened(remains, &world);
            let filter = world.own_interval(&loose);
            assert!(
                filter.near <= own.near && own.far <= filter.far,
                "{transform:?} {bounds:?} {ray:?}: {own:?} in {filter:?}"
            );
            // How much of the allowance a hit ever uses, to see that this test bites.
            let pad = f64::from(loose.pad_floor);
            for t in [own.near, own.far].map(f64::from) {
                for k in 0..3 {
                    let p = f64::from(ray.origin[k]) + t * f64::from(ray.dir[k]);
                    let out = (f64::from(world.min[k]) - p).max(p - f64::from(world.max[k]));
                    tight = tight.max(out / pad);
                }
            }
        }
        assert!(met > 20_000, "the rays must meet the boxes: {met}");
        assert!(tight > 0.05, "the padding is far too large: {tight}");
    }
}
