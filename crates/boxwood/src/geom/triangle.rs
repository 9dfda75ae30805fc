//! The exact ray/triangle test: the definition of what a ray hits.
//!
//! Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2013, made exact in three ways:
//!
//! * An edge function `a.x * b.y - a.y * b.x` of single-precision numbers, rounded after each product, never has the
//!   wrong sign (rounding is monotone): it is right, or zero, or NaN by overflow. In the last two cases the sign is taken
//!   from double precision, where the products are exact. A fused multiply-add would break this.
//! * A true zero (the ray meets an edge or vertex exactly) is decided as if the ray were shifted by `(e, e^2)` for
//!   an infinitely small `e` (Edelsbrunner and Mücke, "Simulation of Simplicity", 1990). The rule is antisymmetric in the
//!   edge's ends, so every edge and vertex that triangles share belongs to exactly one of them, and a triangle seen
//!   edge-on to none.
//! * `t`, `u`, `v` of an accepted triangle are evaluated in double precision, and `t` is bound to the triangle's own
//!   padded box (see [`super::slab`]), which makes every structure agree bit for bit.
//!
//! Vertices must be shared bit for bit: a mesh with duplicated vertices is closed only if the copies are equal.

use super::{Aabb, Candidate, PreparedRay};

/// Three corners.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Triangle(pub [[f32; 3]; 3]);

/// The numbers of one exact test, for explaining it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeTrace {
    /// The edge functions opposite to each vertex; their signs decide, and a zero is settled by `signs`.
    pub edges: [f64; 3],
    /// -1 or 1 each, 0 only for an edge that is a point as seen along the ray. All equal: a hit.
    pub signs: [i8; 3],
    /// The candidate, if the signs agree.
    pub candidate: Option<Candidate>,
}

impl Triangle {
    /// Operations of the test up to the decision: 9 subtractions (translate), 6 products and 6 subtractions (shear), 6
    /// products and 3 subtractions (edges).
    pub const FLOPS_MISS: u32 = 30;
    /// Operations of a test that accepts: the decision, then 9 for the edges again, 2 for the determinant, 6 for the depth,
    /// 4 for `t` and weights, and 56 for the own box: its bounds 12, reach 12, padding 2, slabs 24, their cut 4, `t` 2.
    pub const FLOPS_HIT: u32 = Self::FLOPS_MISS + 77;

    /// The exact test, without regard to the ray's range. `None`: the line misses, or sees the triangle edge-on.
    #[inline(always)]
    pub fn intersect(&self, ray: &PreparedRay) -> Option<Candidate> {
        let [a, b, c] = [
            sheared(&self.0[0], ray),
            sheared(&self.0[1], ray),
            sheared(&self.0[2], ray),
        ];
        let (ea, eb, ec) = (edge(b, c), edge(c, a), edge(a, b));
        // Selections, not branches: which edge a miss is beyond cannot be guessed.
        let negative = (ea < 0.0) | (eb < 0.0) | (ec < 0.0);
        let positive = (ea > 0.0) | (eb > 0.0) | (ec > 0.0);
        if negative & positive {
            return None;
        }
        // Not decided by certain signs alone: some are zero or NaN.
        let certain =
            ((ea < 0.0) & (eb < 0.0) & (ec < 0.0)) | ((ea > 0.0) & (eb > 0.0) & (ec > 0.0));
        if !certain && !inside(exact_signs(a, b, c)) {
            return None;
        }
        evaluate(a, b, c, ray)
    }

    /// The same test with its numbers.
    pub fn trace(&self, ray: &PreparedRay) -> EdgeTrace {
        let [a, b, c] = [
            sheared(&self.0[0], ray),
            sheared(&self.0[1], ray),
            sheared(&self.0[2], ray),
        ];
        let edges = [edge_f64(b, c), edge_f64(c, a), edge_f64(a, b)];
        EdgeTrace {
            edges,
            signs: exact_signs(a, b, c),
            candidate: self.intersect(ray),
        }
    }

    /// Bounding box.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        Aabb::of_triangle(self)
    }

    /// `(v1 - v0) x (v2 - v0)`: not unit; its length is twice the area.
    #[inline]
    pub fn normal(&self) -> [f32; 3] {
        let [a, b, c] = self.0.map(glam::Vec3::from);
        (b - a).cross(c - a).to_array()
    }

    /// The point with weights `1 - u - v`, `u`, `v`.
    pub fn point(&self, u: f32, v: f32) -> [f32; 3] {
        let [a, b, c] = self.0.map(glam::Vec3::from);
        (a * (1.0 - u - v) + b * u + c * v).to_array()
    }
}

/// A vertex in the space where the ray starts at the origin and runs along the last axis. The same operations in the
/// same order for every vertex, so equal vertices stay equal.
#[inline(always)]
fn sheared(vertex: &[f32; 3], ray: &PreparedRay) -> [f32; 3] {
    let [kx, ky, kz] = ray.axes;
    let depth = vertex[kz] - ray.origin[kz];
    [
        (vertex[kx] - ray.origin[kx]) - ray.shear[0] * depth,
        (vertex[ky] - ray.origin[ky]) - ray.shear[1] * depth,
        depth,
    ]
}

#[inline(always)]
fn edge(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[1] - a[1] * b[0]
}

/// Exact in sign: the products of 24-bit numbers fit into 53 bits.
#[inline(always)]
fn edge_f64(a: [f32; 3], b: [f32; 3]) -> f64 {
    f64::from(a[0]) * f64::from(b[1]) - f64::from(a[1]) * f64::from(b[0])
}

#[cold]
fn exact_signs(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [i8; 3] {
    [exact_sign(b, c), exact_sign(c, a), exact_sign(a, b)]
}

/// The sign of the edge function as seen by a ray shifted by `(e, e^2)`: expanding the shifted product gives
/// `edge - e (b.y - a.y) + e^2 (b.x - a.x)`, and the first term that is not zero decides.
fn exact_sign(a: [f32; 3], b: [f32; 3]) -> i8 {
    let sign = |x: f64| i8::from(x > 0.0) - i8::from(x < 0.0);
    let difference = |k: usize| f64::from(b[k]) - f64::from(a[k]);
    [edge_f64(a, b), -difference(1), difference(0)]
        .into_iter()
        .map(sign)
        .find(|&s| s != 0)
        .unwrap_or(0)
}

fn inside(signs: [i8; 3]) -> bool {
    signs[0] != 0 && signs[0] == signs[1] && signs[0] == signs[2]
}

/// The weights are computed from the sheared vertices, so the point is on the triangle however grazing the ray.
#[inline(always)]
fn evaluate(a: [f32; 3], b: [f32; 3], c: [f32; 3], ray: &PreparedRay) -> Option<Candidate> {
    let (ea, eb, ec) = (edge_f64(b, c), edge_f64(c, a), edge_f64(a, b));
    let determinant = ea + eb + ec;
    // Divided late, so that a plane of constant depth has that depth and a ray from a triangle starts at 0.
    let depth = (ea * f64::from(a[2]) + eb * f64::from(b[2]) + ec * f64::from(c[2])) / determinant;
    let t = (depth * ray.t_per_depth) as f32 + 0.0;
    // Both have the sign of the determinant; `abs` turns -0 into 0.
    let (u, v) = ((eb / determinant).abs(), (ec / determinant).abs());
    (determinant != 0.0 && t.is_finite()).then_some(Candidate {
        t,
        u: u as f32,
        v: v as f32,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Ray;

    fn hit(triangle: [[f32; 3]; 3], origin: [f32; 3], dir: [f32; 3]) -> Option<Candidate> {
        Triangle(triangle).intersect(&PreparedRay::new(&Ray::new(origin, dir)).unwrap())
    }

    const CROOKED: [[f32; 3]; 3] = [[1.0, 0.0, 5.0], [4.0, 1.0, 5.0], [2.0, 3.5, 5.0]];

    #[test]
    fn weights_and_t_name_the_point_in_units_of_dir() {
        let target = Triangle(CROOKED).point(0.25, 0.5);
        let origin = [0.5, -1.0, -3.0];
        let dir: [f32; 3] = std::array::from_fn(|k| (target[k] - origin[k]) * 0.5);
        let found = hit(CROOKED, origin, dir).unwrap();
        assert!(
            (found.t - 2.0).abs() < 1e-6
                && (found.u - 0.25).abs() < 1e-6
                && (found.v - 0.5).abs() < 1e-6
        );
    }

    #[test]
    fn both_sides_are_hit_and_behind_has_a_negative_t() {
        assert!(hit(CROOKED, [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]).unwrap().t == 5.0);
        assert!(hit(CROOKED, [2.0, 1.0, 9.0], [0.0, 0.0, -1.0]).unwrap().t == 4.0);
        assert!(hit(CROOKED, [2.0, 1.0, 9.0], [0.0, 0.0, 1.0]).unwrap().t == -4.0);
    }

    #[test]
    fn an_edge_belongs_to_exactly_one_of_its_two_triangles() {
        let (p, q, left, right) = (
            [0.0, 0.0, 1.0],
            [4.0, 2.0, 1.0],
            [1.0, 3.0, 1.0],
            [2.0, -2.0, 1.0],
        );
        for k in 0..=8 {
            let on_edge = [k as f32 * 0.5, k as f32 * 0.25, 0.0];
            let up = [0.0, 0.0, 1.0];
            let count = [[p, q, left], [q, p, right]]
                .iter()
                .filter(|t| hit(**t, on_edge, up).is_some())
                .count();
            // The two ends are also corners of triangles that are not here.
            assert!(
                if k == 0 || k == 8 {
                    count <= 1
                } else {
                    count == 1
                },
                "at {on_edge:?}: {count}"
            );
        }
    }

    #[test]
    fn a_vertex_of_a_fan_belongs_to_exactly_one_triangle() {
        for valence in 3..=64 {
            let rim = |i: usize| {
                let angle = (i % valence) as f32 / valence as f32 * std::f32::consts::TAU;
                [
                    angle.cos() * 3.0 + 1.0,
                    angle.sin() * 2.0 + 0.5,
                    1.0 + (i % valence) as f32 * 0.125,
                ]
            };
            let hub = [1.0, 0.5, 2.0];
            for (origin, dir) in [
                ([1.0, 0.5, -4.0], [0.0, 0.0, 1.0]),
                ([3.0, 0.5, 0.0], [-1.0, 0.0, 1.0]),
                ([0.0, 0.0, 0.0], hub),
            ] {
                let count = (0..valence)
                    .filter(|&i| hit([hub, rim(i), rim(i + 1)], origin, dir).is_some())
                    .count();
                assert_eq!(count, 1, "valence {valence} from {origin:?}");
            }
        }
    }

    #[test]
    fn degenerate_and_edge_on_triangles_are_never_hit() {
        let p = [1.0, 1.0, 1.0];
        assert_eq!(hit([p, p, p], [0.0; 3], p), None);
        assert_eq!(
            hit(
                [[0.0, 0.0, 1.0], [1.0, 1.0, 1.0], [2.0, 2.0, 1.0]],
                [1.0, 1.0, 0.0],
                [0.0, 0.0, 1.0]
            ),
            None
        );
        assert_eq!(
            hit(
                [[0.0, 0.0, 1.0], [0.0, 2.0, 1.0], [0.0, 1.0, 3.0]],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0]
            ),
            None
        );
    }

    #[test]
    fn coordinates_whose_products_overflow_are_hit_all_the_same() {
        let s = 5e29;
        let found = hit(
            [[-s, -s, s], [s, -s, s], [0.0, s, s]],
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
        )
        .unwrap();
        assert_eq!((found.t, found.u, found.v), (s, 0.25, 0.5));
    }

    #[test]
    fn signs_agree_with_integer_arithmetic() {
        let mut seed = 5u32;
        let mut small = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 24) as i32 % 5 - 2
        };
        let mut hits = 0;
        for _ in 0..200_000 {
            // Along z from an integer point: the sheared triangle is exact, so the oracle is a 2D orientation test.
            let t: [[i32; 3]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| small()));
            let orient = |a: [i32; 3], b: [i32; 3]| a[0] * b[1] - a[1] * b[0];
            let e = [orient(t[1], t[2]), orient(t[2], t[0]), orient(t[0], t[1])];
            let found = hit(
                t.map(|v| v.map(|x| x as f32)),
                [0.0, 0.0, -9.0],
                [0.0, 0.0, 1.0],
            )
            .is_some();
            if e.iter().all(|&x| x > 0) || e.iter().all(|&x| x < 0) {
                assert!(found, "{t:?}");
                hits += 1;
            } else if e.iter().any(|&x| x > 0) && e.iter().any(|&x| x < 0) {
                assert!(!found, "{t:?}");
            }
        }
        assert!(hits > 1000, "the sample must hit: {hits}");
    }
}
