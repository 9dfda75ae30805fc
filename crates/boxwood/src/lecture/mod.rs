//! The lecture's own formulas, under the lecture's names, counted and tested.
//!
//! None of them decides what a ray hits: that is the exact test of [`Triangle`](crate::Triangle), which they are measured
//! against. They differ from it at edges (the same edge may be nobody's or both neighbours') and by rounding.
//!
//! | slide | here |
//! |---|---|
//! | Barycentric ray-triangle intersection, Cramer's rule, 27 flops | [`cramer`] |
//! | Ray tracing is expensive: 2.8 and 995 gigaflops | [`price`] |
//! | More efficient intersection routines | [`moller_trumbore`], [`baldwin_weber`] |
//! | Carefully reduce triangle count | `simplify` of the scene crate |
//! | Bounding volumes: sphere, axis-aligned box, oriented box | [`volume`](crate::volume) |
//! | Is this worth it? | `boxwood bounds` |
//! | Bounding volume hierarchy; partition along an axis | [`build`](crate::build), [`Bvh2`](crate::structure::Bvh2) |
//! | New kind of object: `BoundedObject` | [`BoundedObject`](crate::BoundedObject) |
//! | Uniform space subdivision; constant offset between faces | [`Grid`](crate::structure::Grid) |
//! | AABB for a sphere, a triangle, a collection of AABBs | [`Aabb`](crate::Aabb) |
//! | 1D: a slab; 3D: the intersection of three slabs | [`slab_1d`](crate::geom::slab_1d), [`Aabb::slab`](crate::Aabb::slab) |

pub mod baldwin_weber;
pub mod cramer;
pub mod moller_trumbore;
pub mod price;

/// What a lecture formula answers: the weights of the slides, `p + t d = a + beta (b - a) + gamma (c - a)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barycentric {
    /// Weight of the second vertex.
    pub beta: f32,
    /// Weight of the third vertex.
    pub gamma: f32,
    /// Ray parameter.
    pub t: f32,
}

/// Where a formula stopped. The operations up to there are the formula's `FLOPS`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// The first weight is outside 0..=1.
    Beta,
    /// The second weight is below 0, or both are above 1 together.
    Gamma,
    /// All numbers were computed.
    Full,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{PreparedRay, Ray, Triangle};
    use crate::testing::Random;

    /// Away from edges all three formulas find what the exact test finds, with the same weights.
    #[test]
    fn the_formulas_agree_with_the_exact_test() {
        let mut random = Random::new(12);
        let mut point = |s: f32| -> [f32; 3] { std::array::from_fn(|_| random.signed() * s) };
        let (mut hits, mut misses) = (0, 0);
        for _ in 0..50_000 {
            let triangle = Triangle([point(2.0), point(2.0), point(2.0)]);
            let ray =
                Ray::between(point(5.0), point(1.0)).with_range(f32::NEG_INFINITY, f32::INFINITY);
            let exact = triangle.trace(&PreparedRay::new(&ray).unwrap());
            let size: f64 = exact.edges.iter().map(|e| e.abs()).sum();
            if exact.edges.iter().any(|e| e.abs() < 1e-3 * size.max(0.05)) {
                continue;
            }
            let answers = [
                ("cramer", cramer::intersect(&ray, &triangle).0),
                (
                    "moller_trumbore",
                    moller_trumbore::intersect(&ray, &triangle).0,
                ),
                (
                    "baldwin_weber",
                    baldwin_weber::Precomputed::new(&triangle).and_then(|p| p.intersect(&ray).0),
                ),
            ];
            for (name, answer) in answers {
                match (answer, exact.candidate) {
                    (Some(b), Some(c)) => {
                        let close = |x: f32, y: f32| (x - y).abs() < 2e-3 * (1.0 + y.abs());
                        assert!(
                            close(b.t, c.t) && close(b.beta, c.u) && close(b.gamma, c.v),
                            "{name}: {b:?} {c:?}"
                        );
                        hits += 1;
                    }
                    (None, None) => misses += 1,
                    other => panic!("{name}: {other:?} for {ray:?} {triangle:?}"),
                }
            }
        }
        assert!(hits > 1000 && misses > 1000, "{hits} hits, {misses} misses");
    }
}
