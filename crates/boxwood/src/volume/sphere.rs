//! The smallest enclosing sphere as a bounding volume.

use super::BoundingVolume;
use crate::geom::{Aabb, Interval, PreparedRay, Sphere, filter_pad};
use glam::DVec3;

/// A ray in double precision with the padding of the radius.
#[derive(Clone, Copy, Debug)]
pub struct SphereRay {
    origin: [f64; 3],
    dir: [f64; 3],
    pad: f32,
}

impl BoundingVolume for Sphere {
    const NAME: &'static str = "sphere";
    /// The roots, the padding, and the cut with the ray's range.
    const FLOPS: u32 = Self::ROOTS_FLOPS + 3;

    type Ray = SphereRay;
    type Pair = [Self; 2];

    fn of_points(points: &[[f32; 3]]) -> Self {
        Ball::around(points).map_or(EMPTY, Ball::rounded_out)
    }

    fn of_sphere(sphere: &Sphere) -> Self {
        *sphere
    }

    /// One after the other, each time the smallest sphere around two: encloses all, but is not the smallest around more
    /// than two, and depends on their order.
    fn of_volumes(volumes: &[Self]) -> Self {
        let mut spheres = volumes.iter().filter(|s| s.radius >= 0.0);
        let Some(first) = spheres.next() else {
            return EMPTY;
        };
        spheres.fold(*first, enclosing_two)
    }

    #[inline]
    fn prepare(ray: &PreparedRay, bounds: &Aabb) -> SphereRay {
        // Twice: the padding is per axis, and the diagonal of a cube is sqrt(3) sides.
        let pad = 2.0 * filter_pad(bounds.reach(ray.origin), ray);
        SphereRay {
            origin: ray.origin.map(f64::from),
            dir: ray.dir.map(f64::from),
            pad,
        }
    }

    #[inline]
    fn interval(&self, ray: &SphereRay) -> Interval {
        let padded = Self {
            radius: self.radius + ray.pad,
            ..*self
        };
        match padded.roots(ray.origin, ray.dir) {
            Some((near, far)) if self.radius >= 0.0 => Interval {
                near: near as f32,
                far: far as f32,
            },
            _ => Interval::EMPTY,
        }
    }

    fn pair(a: &Self, b: &Self) -> [Self; 2] {
        [*a, *b]
    }

    fn of_pair(pair: &[Self; 2]) -> [Self; 2] {
        *pair
    }

    #[inline]
    fn pair_intervals(pair: &[Self; 2], ray: &Self::Ray) -> [Interval; 2] {
        pair.map(|volume| volume.interval(ray))
    }

    fn surface_area(&self) -> f64 {
        4.0 * std::f64::consts::PI * f64::from(self.radius.max(0.0)).powi(2)
    }

    fn volume(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * f64::from(self.radius.max(0.0)).powi(3)
    }

    fn bounds(&self) -> Aabb {
        Aabb::of_sphere(self)
    }

    fn contains(&self, point: [f32; 3], slack: f32) -> bool {
        Self {
            radius: self.radius + slack,
            ..*self
        }
        .contains(point)
    }
}

const EMPTY: Sphere = Sphere {
    center: [0.0; 3],
    radius: -1.0,
};

fn enclosing_two(a: Sphere, b: &Sphere) -> Sphere {
    let (ca, cb) = (
        DVec3::from(a.center.map(f64::from)),
        DVec3::from(b.center.map(f64::from)),
    );
    let (ra, rb) = (f64::from(a.radius), f64::from(b.radius));
    let distance = ca.distance(cb);
    if distance + rb <= ra {
        return a;
    }
    if distance + ra <= rb {
        return *b;
    }
    let radius = 0.5 * (distance + ra + rb);
    let center = ca + (cb - ca) * ((radius - ra) / distance);
    Ball {
        center,
        radius_squared: radius * radius,
    }
    .rounded_out()
}

/// A sphere while it is being fitted.
#[derive(Clone, Copy)]
struct Ball {
    center: DVec3,
    radius_squared: f64,
}

impl Ball {
    /// The smallest ball, by pivoting: the ball of a few support points grows by the point that sticks out farthest
    /// (Gärtner, "Fast and Robust Smallest Enclosing Balls", ESA 1999). Each round is one pass; some ten rounds do.
    fn around(points: &[[f32; 3]]) -> Option<Self> {
        let is_finite = |p: &[f32; 3]| p.iter().all(|x| x.is_finite());
        let point = |p: &[f32; 3]| DVec3::from(p.map(f64::from));
        let first = points.iter().copied().find(is_finite)?;
        let mut support = vec![point(&first)];
        let mut ball = Self {
            center: support[0],
            radius_squared: 0.0,
        };
        for _ in 0..MAX_ROUNDS {
            let farthest = points
                .iter()
                .filter(|p| is_finite(p))
                .map(|p| (point(p), point(p).distance_squared(ball.center)))
                .max_by(|a, b| a.1.total_cmp(&b.1))?;
            if farthest.1 <= ball.radius_squared * (1.0 + 1e-12) {
                return Some(ball);
            }
            support.push(farthest.0);
            let (smaller_support, grown) = smallest_of_few(&support);
            if grown.radius_squared <= ball.radius_squared {
                // Rounding: no progress is possible. Take the centre, and the radius that holds everything.
                return Some(Self {
                    radius_squared: farthest.1,
                    ..ball
                });
            }
            (support, ball) = (smaller_support, grown);
        }
        let reach = |p: &[f32; 3]| point(p).distance_squared(ball.center);
        let radius_squared = points
            .iter()
            .filter(|p| is_finite(p))
            .map(reach)
            .fold(0.0, f64::max);
        Some(Self {
            radius_squared,
            ..ball
        })
    }

    /// To single precision, large enough for the rounded centre.
    fn rounded_out(self) -> Sphere {
        let center = self.center.to_array().map(|x| x as f32);
        let moved = DVec3::from(center.map(f64::from)).distance(self.center);
        let radius = (self.radius_squared.sqrt() + moved) * (1.0 + 1e-9);
        Sphere {
            center,
            radius: (radius as f32).next_up(),
        }
    }
}

const MAX_ROUNDS: usize = 100;

/// Tries every choice of at most four of at most five points as the support of the smallest ball.
fn smallest_of_few(points: &[DVec3]) -> (Vec<DVec3>, Ball) {
    let mut best: Option<(Vec<DVec3>, Ball)> = None;
    for choice in 1u32..1 << points.len() {
        if choice.count_ones() > 4 {
            continue;
        }
        let chosen: Vec<DVec3> = (0..points.len())
            .filter(|i| choice >> i & 1 == 1)
            .map(|i| points[i])
            .collect();
        let Some(ball) = circumscribed(&chosen) else {
            continue;
        };
        let holds_all = points
            .iter()
            .all(|p| p.distance_squared(ball.center) <= ball.radius_squared * (1.0 + 1e-10));
        if holds_all
            && best
                .as_ref()
                .is_none_or(|(_, b)| ball.radius_squared < b.radius_squared)
        {
            best = Some((chosen, ball));
        }
    }
    best.unwrap_or_else(|| {
        let last = points[points.len() - 1];
        (
            vec![last],
            Ball {
                center: last,
                radius_squared: 0.0,
            },
        )
    })
}

/// The smallest ball with all the points on its surface: its centre is `p0 + sum x_i (p_i - p0)` with
/// `sum_i x_i (d_i . d_j) = d_j . d_j / 2`. `None` if they do not span it.
fn circumscribed(points: &[DVec3]) -> Option<Ball> {
    let (origin, others) = points.split_first()?;
    let d: Vec<DVec3> = others.iter().map(|p| *p - *origin).collect();
    let gram = |i: usize, j: usize| {
        if i < d.len() && j < d.len() {
            d[i].dot(d[j])
        } else {
            f64::from(u8::from(i == j))
        }
    };
    let column = |j: usize| DVec3::new(gram(0, j), gram(1, j), gram(2, j));
    let half = |i: usize| d.get(i).map_or(0.0, |v| 0.5 * v.length_squared());
    let system = glam::DMat3::from_cols(column(0), column(1), column(2));
    let scale: f64 = d.iter().map(|v| v.length_squared()).product();
    if !(system.determinant() > 1e-14 * scale) && !d.is_empty() {
        return None;
    }
    let weights = system.inverse() * DVec3::new(half(0), half(1), half(2));
    let offset: DVec3 = d.iter().zip(weights.to_array()).map(|(v, w)| *v * w).sum();
    Some(Ball {
        center: *origin + offset,
        radius_squared: offset.length_squared(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn the_sphere_of_a_cube_is_half_its_diagonal() {
        let corners = Aabb {
            min: [1.0, 2.0, 3.0],
            max: [3.0, 4.0, 5.0],
        }
        .corners();
        let sphere = <Sphere as BoundingVolume>::of_points(&corners);
        assert!((sphere.radius - 3.0_f32.sqrt()).abs() < 1e-6, "{sphere:?}");
        assert!(
            (0..3).all(|k| (sphere.center[k] - [2.0, 3.0, 4.0][k]).abs() < 1e-6),
            "{sphere:?}"
        );
    }

    #[test]
    fn no_smaller_sphere_is_found_by_shaking_the_centre() {
        let mut random = Random::new(8);
        for _ in 0..200 {
            let points: Vec<[f32; 3]> = (0..30)
                .map(|_| [random.signed() * 4.0, random.signed(), random.signed()])
                .collect();
            let best = <Sphere as BoundingVolume>::of_points(&points);
            for _ in 0..100 {
                let center =
                    DVec3::from(best.center.map(|c| f64::from(c + random.signed() * 0.05)));
                let reach = points
                    .iter()
                    .map(|p| DVec3::from(p.map(f64::from)).distance(center))
                    .fold(0.0, f64::max);
                assert!(
                    reach >= f64::from(best.radius) * (1.0 - 1e-6),
                    "{reach} < {best:?}"
                );
            }
        }
    }

    #[test]
    fn coincident_and_collinear_points_have_a_sphere() {
        let same = <Sphere as BoundingVolume>::of_points(&[[1.0, 2.0, 3.0]; 50]);
        assert!(same.radius < 1e-6 && same.contains([1.0, 2.0, 3.0]));
        let line: Vec<[f32; 3]> = (0..9).map(|i| [i as f32, 0.0, 0.0]).collect();
        assert!((<Sphere as BoundingVolume>::of_points(&line).radius - 4.0).abs() < 1e-5);
    }
}
