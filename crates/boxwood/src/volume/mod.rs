//! Bounding volumes: simple shapes around complicated things.
//!
//! The lecture's rule: *if the ray misses the volume, it misses the object*. A volume pays when its test is much
//! cheaper than the object's and when it fits tightly. Three are here; a new one is one file with
//! `impl BoundingVolume` and one line in [`VOLUMES`](crate::VOLUMES).

mod aabb;
mod obb;
mod sphere;

use crate::geom::{Aabb, Interval, PreparedRay, Sphere, Triangle};

/// A shape that encloses others and is quick to test.
pub trait BoundingVolume: Copy + std::fmt::Debug + Send + Sync + 'static {
    /// As in the table and on the command line.
    const NAME: &'static str;
    /// Operations of one [`BoundingVolume::interval`].
    const FLOPS: u32;
    /// True if the volume around volumes is the volume around their content.
    const UNION_IS_TIGHT: bool = false;

    /// What the test wants to know of a ray, computed once per ray.
    type Ray: Copy;
    /// Two volumes side by side, in the layout that a test of both at once likes.
    type Pair: Copy + std::fmt::Debug + Send + Sync + 'static;

    /// The volume around points. No points, or only NaN ones, give an empty volume that no ray meets.
    fn of_points(points: &[[f32; 3]]) -> Self;

    /// The volume around a sphere.
    fn of_sphere(sphere: &Sphere) -> Self;

    /// The volume around volumes of its kind.
    fn of_volumes(volumes: &[Self]) -> Self;

    /// The volume around a triangle.
    fn of_triangle(triangle: &Triangle) -> Self {
        Self::of_points(&triangle.0)
    }

    /// The volume around a set of triangles.
    fn of_triangles(triangles: &[Triangle]) -> Self {
        Self::of_points(&triangles.iter().flat_map(|t| t.0).collect::<Vec<_>>())
    }

    /// The volume around an axis-aligned box.
    fn of_aabb(bounds: &Aabb) -> Self {
        if bounds.is_empty() {
            Self::of_points(&[])
        } else {
            Self::of_points(&bounds.corners())
        }
    }

    /// The volume around two.
    fn union(&self, other: &Self) -> Self {
        Self::of_volumes(&[*self, *other])
    }

    /// Makes a ray ready for volumes whose content lies in `bounds`; the padding of every test grows with the
    /// distance of that content (see [`crate::geom`]).
    fn prepare(ray: &PreparedRay, bounds: &Aabb) -> Self::Ray;

    /// Where the line is inside, never too short; empty for a miss. Of an empty volume (its `bounds` say so) it may be
    /// anything.
    fn interval(&self, ray: &Self::Ray) -> Interval;

    /// Puts two volumes side by side.
    fn pair(a: &Self, b: &Self) -> Self::Pair;

    /// Takes a pair apart again.
    fn of_pair(pair: &Self::Pair) -> [Self; 2];

    /// [`BoundingVolume::interval`] of both.
    fn pair_intervals(pair: &Self::Pair, ray: &Self::Ray) -> [Interval; 2];

    /// Surface area: what the chance of a random line to meet the volume is in proportion to.
    fn surface_area(&self) -> f64;

    /// Volume.
    fn volume(&self) -> f64;

    /// The axis-aligned box around the volume.
    fn bounds(&self) -> Aabb;

    /// True if the point is inside or on the surface, up to `slack`.
    fn contains(&self, point: [f32; 3], slack: f32) -> bool;
}

/// One volume of any kind, as [`Volume::fit`](crate::Volume::fit) gives it.
pub trait FittedVolume: Send + Sync {
    /// Surface area.
    fn surface_area(&self) -> f64;
    /// Volume.
    fn volume(&self) -> f64;
    /// Counts the rays that meet the volume in their range; one virtual call for the whole slice.
    fn count_hits(&self, rays: &[crate::Ray]) -> usize;
    /// For each ray, whether it meets the volume in its range.
    fn hits(&self, rays: &[crate::Ray]) -> Vec<bool>;
}

impl<V: BoundingVolume> FittedVolume for V {
    fn surface_area(&self) -> f64 {
        V::surface_area(self)
    }

    fn volume(&self) -> f64 {
        V::volume(self)
    }

    fn count_hits(&self, rays: &[crate::Ray]) -> usize {
        let bounds = self.bounds();
        rays.iter().filter(|ray| meets(self, &bounds, ray)).count()
    }

    fn hits(&self, rays: &[crate::Ray]) -> Vec<bool> {
        let bounds = self.bounds();
        rays.iter().map(|ray| meets(self, &bounds, ray)).collect()
    }
}

#[inline]
fn meets<V: BoundingVolume>(volume: &V, bounds: &Aabb, ray: &crate::Ray) -> bool {
    !bounds.is_empty()
        && PreparedRay::new(ray).is_some_and(|ray| {
            volume
                .interval(&V::prepare(&ray, bounds))
                .meets(ray.t_min, ray.t_max)
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Obb;
    use crate::testing::Random;

    /// Every construction of every volume encloses what it was made of, also far from the origin and when flat.
    fn encloses<V: BoundingVolume>() {
        let mut random = Random::new(3);
        for round in 0..400 {
            let offset = [0.0, 1e3, 1e6][round % 3];
            let flat = [1.0, 0.0, 1e-4][round % 3];
            let count = 1 + round % 40;
            let points: Vec<[f32; 3]> = (0..count)
                .map(|_| {
                    [
                        random.signed() * 3.0 + offset,
                        random.signed() - offset,
                        random.signed() * flat,
                    ]
                })
                .collect();
            let size = Aabb::of_points(&points).diagonal() as f32;
            let slack = size * 1e-5 + offset * 3e-7;
            let volume = V::of_points(&points);
            for p in &points {
                assert!(
                    volume.contains(*p, slack),
                    "{} misses {p:?} of {points:?}",
                    V::NAME
                );
            }
            let halves = [
                V::of_points(&points[..count / 2]),
                V::of_points(&points[count / 2..]),
            ];
            for (all, what) in [
                (V::of_volumes(&halves), "volumes"),
                (halves[0].union(&halves[1]), "union"),
            ] {
                for p in &points {
                    assert!(
                        all.contains(*p, 2.0 * slack),
                        "{} of {what} misses {p:?}",
                        V::NAME
                    );
                }
            }
        }
        let ball = Sphere {
            center: [3.0, -2.0, 5.5],
            radius: 1.5,
        };
        for axis in 0..3 {
            let mut pole = ball.center;
            pole[axis] += ball.radius;
            assert!(V::of_sphere(&ball).contains(pole, 1e-5));
        }
        let bounds = Aabb {
            min: [1.0, 2.0, 3.0],
            max: [2.0, 4.0, 3.5],
        };
        assert!(
            bounds
                .corners()
                .iter()
                .all(|c| V::of_aabb(&bounds).contains(*c, 1e-5))
        );
    }

    /// A ray aimed at a point of the content meets the volume, from near and far.
    fn rays_that_hit_content_hit_the_volume<V: BoundingVolume>() {
        let mut random = Random::new(4);
        for round in 0..20_000 {
            let flat = [1.0, 0.0, 1e-3][round % 3];
            let points: Vec<[f32; 3]> = (0..3 + round % 5)
                .map(|_| {
                    [
                        random.signed(),
                        random.signed() * 2.0,
                        random.signed() * flat,
                    ]
                })
                .collect();
            let volume = V::of_points(&points);
            let distance = 10.0_f32.powi((round % 7) as i32 - 1);
            let origin = std::array::from_fn(|_| random.signed() * distance);
            let aim = points[round % points.len()];
            let ray = crate::Ray::between(origin, aim).with_range(0.0, f32::INFINITY);
            assert!(volume.hits(&[ray])[0], "{}: {ray:?} at {points:?}", V::NAME);
        }
    }

    #[test]
    fn volumes_enclose_their_parts() {
        encloses::<Aabb>();
        encloses::<Sphere>();
        encloses::<Obb>();
    }

    #[test]
    fn a_ray_at_the_content_hits_the_volume() {
        rays_that_hit_content_hit_the_volume::<Aabb>();
        rays_that_hit_content_hit_the_volume::<Sphere>();
        rays_that_hit_content_hit_the_volume::<Obb>();
    }

    #[test]
    fn an_empty_volume_is_never_hit() {
        let ray = crate::Ray::new([0.0; 3], [1.0, 2.0, 3.0]);
        for entry in crate::VOLUMES {
            for points in [vec![], vec![[f32::NAN; 3]]] {
                assert_eq!(
                    entry.fit(&points).count_hits(&[ray]),
                    0,
                    "{} of {points:?}",
                    entry.name
                );
            }
        }
    }
}
