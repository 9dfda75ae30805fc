//! How far eight triangles are from a point, from below and from above.
//!
//! # Why the bounds hold
//!
//! A triangle is convex: for any vector `g` at all, no place of it is nearer than the least of `g` times its corners, divided by
//! the length of `g` (corners as seen from the point). With the foot of the point for `g` this is the distance itself. So a foot
//! that single precision has found somewhat beside the true one gives a lower bound that is somewhat loose, but never a wrong one; and
//! as any weights from 0 to 1 name a place of the triangle, its length is an upper bound.
//!
//! What rounding adds, with `u = 2^-24` and `far` the largest distance of a corner: corners `u far`; their products with `g` `3 u far`
//! times its length; `g` itself, from rounded edges and weights, `12 u far`; lengths `3 u far`. The exact test rounds less than
//! `u far`, as it keeps places in the triangle's box, whose sides are no less than the last digit of a coordinate. It takes feet
//! inside a triangle only if that is no sliver; so does this one. `far` is at most the foot's distance and the longest edge:
//! 20 of each stands for all.

use super::lanes::Floats;
use crate::simd::{LeafRows, Third};
use fearless_simd::{f32x8, prelude::*};

/// Error of all distances, of how far a triangle reaches.
const ERROR: f32 = 20.0 / (1 << 24) as f32;
/// Feet nearer than this say nothing but that they are: squares would lose what they are made of.
const LEAST: f32 = 1e-15;
/// Squares of sines of flatter corners are those of slivers.
const SLIVER: f32 = 1.0 / 1024.0;

/// Eight triangles as one point sees them.
pub(super) struct Feet<S: Simd> {
    /// Of the foot.
    length: f32x8<S>,
    /// The least product of a corner with the foot.
    support: f32x8<S>,
    /// What rounding may have done to lengths.
    error: f32x8<S>,
}

impl<S: Simd> Feet<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, rows: LeafRows<'_>, point: &[f32x8<S>; 3]) -> Self {
        let splat = |x: f32| f32x8::splat(simd, x);
        let [a, b, c] = [
            seen(simd, rows, Third::A, point),
            seen(simd, rows, Third::B, point),
            seen(simd, rows, Third::C, point),
        ];
        let (ab, ac) = (minus(b, a), minus(c, a));
        let (bb, bc, cc) = (dot(ab, ab), dot(ab, ac), dot(ac, ac));
        // Edges times the way from corner a to the point.
        let (on_ab, on_ac) = (-dot(ab, a), -dot(ac, a));
        let (zero, one, least) = (splat(0.0), splat(1.0), splat(f32::MIN_POSITIVE));
        // Feet on the lines of the edges; an edge that is a point has products of zero.
        let (per_bb, per_cc) = (one / bb.max(least), one / cc.max(least));
        let ee = (bb + cc) - (bc + bc);
        let (s, t) = (on_ab * per_bb, on_ac * per_cc);
        let r = ((on_ac - on_ab) + (bb - bc)) / ee.max(least);
        // The foot on the plane.
        let slant = bc * per_cc;
        let area = bb - bc * slant;
        let u = (on_ab - bc * t) / area;
        let v = t - slant * u;
        let inside = u.simd_ge(zero)
            & v.simd_ge(zero)
            & (u + v).simd_le(one)
            & area.simd_gt(bb * splat(SLIVER));
        // Feet on the edges, and how much farther than corner a they are, squared.
        let (s, t, r) = (unit(simd, s), unit(simd, t), unit(simd, r));
        let (twice_ab, twice_ac) = (on_ab + on_ab, on_ac + on_ac);
        let rest = one - r;
        let at_s = s * (s * bb - twice_ab);
        let at_t = t * (t * cc - twice_ac);
        let at_r = rest * (rest * bb - twice_ab + (r + r) * bc) + r * (r * cc - twice_ac);
        let is_s = at_s.simd_le(at_t);
        let (edge_u, edge_v) = (is_s.select(s, zero), is_s.select(zero, t));
        let is_r = at_r.simd_lt(at_s.min(at_t));
        let u = inside.select(u, is_r.select(rest, edge_u));
        let v = inside.select(v, is_r.select(r, edge_v));
        let foot = [
            v.mul_add(ac[0], u.mul_add(ab[0], a[0])),
            v.mul_add(ac[1], u.mul_add(ab[1], a[1])),
            v.mul_add(ac[2], u.mul_add(ab[2], a[2])),
        ];
        let length = dot(foot, foot).sqrt();
        let edges = bb + cc;
        Self {
            length,
            support: dot(foot, a).min(dot(foot, b)).min(dot(foot, c)),
            error: (length + (edges + edges).sqrt()) * splat(ERROR),
        }
    }

    /// Lanes that may be as near as `reach`, as bits.
    #[inline(always)]
    pub(super) fn within(&self, simd: S, reach: f32) -> u32 {
        let reach = f32x8::splat(simd, reach) + self.error;
        // Whatever is no number stays.
        let beyond = self.support.simd_gt(self.length * reach)
            & self.length.simd_gt(f32x8::splat(simd, LEAST));
        !(beyond.to_bitmask() as u32)
    }

    /// No nearer than this.
    #[inline(always)]
    pub(super) fn lower(&self, simd: S) -> f32x8<S> {
        let counts = self.length.simd_gt(f32x8::splat(simd, LEAST));
        counts.select(
            self.support / self.length - self.error,
            f32x8::splat(simd, 0.0),
        )
    }

    /// No farther than this.
    #[inline(always)]
    pub(super) fn upper(&self, simd: S) -> f32x8<S> {
        self.length.max(f32x8::splat(simd, 2.0 * LEAST)) + self.error
    }
}

/// A corner of eight triangles, from the point.
#[inline(always)]
fn seen<S: Simd>(simd: S, rows: LeafRows<'_>, v: Third, point: &[f32x8<S>; 3]) -> [f32x8<S>; 3] {
    [
        f32x8::simd_from(simd, *rows.axis(Third::A).corner(v)) - point[0],
        f32x8::simd_from(simd, *rows.axis(Third::B).corner(v)) - point[1],
        f32x8::simd_from(simd, *rows.axis(Third::C).corner(v)) - point[2],
    ]
}

#[inline(always)]
fn minus<S: Simd, F: Floats<S>>(a: [F; 3], b: [F; 3]) -> [F; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot<S: Simd, F: Floats<S>>(a: [F; 3], b: [F; 3]) -> F {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

/// Cut to 0..=1.
#[inline(always)]
fn unit<S: Simd>(simd: S, x: f32x8<S>) -> f32x8<S> {
    x.max(f32x8::splat(simd, 0.0)).min(f32x8::splat(simd, 1.0))
}

#[cfg(test)]
#[cfg(feature = "compact")]
mod tests {
    use super::*;
    use crate::geom::Triangle;
    use crate::simd::{InstructionSet, Row};
    use crate::structure::wide::foot::foot;
    use crate::structure::wide::ray::splat3;
    use crate::testing::Random;
    use fearless_simd::dispatch;

    /// Triangles of all shapes: fat, slivers, needles, edges, points; of all sizes, here and far away.
    fn triangles(random: &mut Random, scale: f32) -> [Triangle; 8] {
        std::array::from_fn(|shape| {
            let far = if random.signed() > 0.2 { 1e3 } else { 1.0 };
            let at: [f32; 3] = std::array::from_fn(|_| scale * far * random.signed());
            let mut corner = |size: f32| at.map(|x| x + size * scale * random.signed());
            let (a, b, c) = (corner(1.0), corner(1.0), corner(1.0));
            let near = corner(1e-6);
            let on = std::array::from_fn(|k| a[k] + 0.3 * (b[k] - a[k]));
            Triangle(match shape {
                0..3 => [a, b, c],
                3 => [a, b, on],
                4 => [a, near, c],
                5 => [on, a, b],
                6 => [a, a, b],
                _ => [near, near, near],
            })
        })
    }

    /// Points where mistakes show: on the triangle, a hair off it, beside it, far away.
    fn point(random: &mut Random, Triangle([a, b, c]): &Triangle) -> [f32; 3] {
        let (u, v) = (random.unit(), random.unit());
        let size = (0..3).fold(0.0_f32, |size, k| size.max((a[k] - b[k]).abs()));
        let off = [0.0, 1e-7, 1e-3, 1.0, 100.0][(random.unit() * 5.0) as usize % 5];
        std::array::from_fn(|k| {
            let place = a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]);
            place + off * size * random.signed()
        })
    }

    #[test]
    fn distances_lie_between_their_bounds_which_are_close() {
        let mut random = Random::new(7);
        let (mut asked, mut close) = (0, 0);
        for scale in [1e-30_f32, 1e-18, 1e-6, 1.0, 1e6, 1e14] {
            for _ in 0..400 {
                let eight = triangles(&mut random, scale);
                let mut rows: [Row; 9] = [[0.0; 8]; 9];
                for (lane, triangle) in eight.iter().enumerate() {
                    for (row, x) in triangle.0.as_flattened().iter().enumerate() {
                        rows[row][lane] = *x;
                    }
                }
                let pick = (random.unit() * 8.0) as usize % 8;
                let point = point(&mut random, &eight[pick]);
                let truth = eight.each_ref().map(|triangle| triangle.nearest(&point));
                for set in InstructionSet::available() {
                    let (lower, upper, is_far): (Row, Row, u32) = dispatch!(set.0, simd => {
                        let feet = Feet::new(simd, LeafRows::of(&rows), &splat3(simd, point));
                        let least = truth.iter().fold(f64::MAX, |least, foot| least.min(foot.squared));
                        let reach = (least.sqrt() * (1.0 + 1e-6)) as f32;
                        (feet.lower(simd).into(), feet.upper(simd).into(), !feet.within(simd, reach))
                    });
                    for lane in 0..8 {
                        let distance = truth[lane].squared.sqrt();
                        let (lower, upper) = (f64::from(lower[lane]), f64::from(upper[lane]));
                        let place =
                            format!("{} {scale} {lane} {point:?} {:?}", set.name(), eight[lane]);
                        assert!(
                            lower <= distance && distance <= upper,
                            "{lower} {distance} {upper} {place}"
                        );
                        asked += usize::from(distance > 1e-14);
                        close += usize::from(upper - lower <= 1e-3 * distance);
                    }
                    let nearest =
                        (0..8).min_by(|a, b| truth[*a].squared.total_cmp(&truth[*b].squared));
                    assert!(nearest.is_some_and(|lane| is_far >> lane & 1 == 0));
                }
            }
        }
        assert!(close * 10 > asked * 6, "{close} of {asked}");
    }

    #[test]
    fn feet_in_lanes_have_the_bits_of_the_definition() {
        let mut random = Random::new(7);
        for scale in [1e-37_f32, 1e-20, 1e-6, 1.0, 1e15, 1e29] {
            for _ in 0..400 {
                for triangle in triangles(&mut random, scale) {
                    let point = point(&mut random, &triangle);
                    let expected = triangle.nearest(&point);
                    let bits = |of: crate::geom::Foot| [of.squared, of.u, of.v].map(f64::to_bits);
                    for set in InstructionSet::available() {
                        let found = dispatch!(set.0, simd => foot(simd, &triangle, &point));
                        assert_eq!(
                            bits(found),
                            bits(expected),
                            "{} {triangle:?} {point:?}",
                            set.name()
                        );
                    }
                }
            }
        }
    }
}
