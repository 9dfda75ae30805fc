//! The nearest place of one triangle, in double precision: the same operations as `Triangle::nearest`, with candidates in lanes.

use crate::geom::{Foot, Triangle};
use fearless_simd::{f32x4, f64x4, prelude::*};

/// Four numbers along each axis.
type Vectors<S> = [f64x4<S>; 3];

/// The place that is nearest to `point`.
#[inline(always)]
pub(super) fn foot<S: Simd>(simd: S, triangle: &Triangle, point: &[f32; 3]) -> Foot {
    let Triangle([a, b, c]) = triangle;
    let zero = f64x4::splat(simd, 0.0);
    let one = f64x4::splat(simd, 1.0);
    // Edges ab, ac, bc and ac again; from where they start to the point, and from a to b.
    let start = vectors(simd, [a, a, b, a]);
    let edge = minus(vectors(simd, [b, c, c, c]), start);
    let way = minus(vectors(simd, [point, point, point, b]), start);
    let (length, along) = (dot(edge, edge), dot(edge, way));
    let share = along / length;
    let share = share.simd_lt(zero).select(zero, share);
    let share = share.simd_gt(one).select(one, share);
    let share: [f64; 4] = length.simd_gt(zero).select(share, zero).into();
    let (u, v, is_inside) = inside(length.into(), along.into());
    let [on_ab, on_ac, on_bc, _] = share;
    let weights = [
        [on_ab, 0.0],
        [0.0, on_ac],
        [1.0 - on_bc, on_bc],
        if is_inside { [u, v] } else { [0.0; 2] },
    ];
    let places = places(simd, weights, triangle);
    let point = vectors(simd, [point; 4]);
    let off = minus(point, vectors(simd, [a, b, c, a]));
    let corners: [f64; 4] = dot(off, off).into();
    let off = minus(point, places);
    let others: [f64; 4] = dot(off, off).into();
    // Of equally near ones the first, in the order of `Triangle::nearest`.
    let best = (corners[0], [0.0, 0.0]);
    let best = nearer(best, corners[1], [1.0, 0.0]);
    let best = nearer(best, corners[2], [0.0, 1.0]);
    let best = nearer(best, others[0], weights[0]);
    let best = nearer(best, others[1], weights[1]);
    let best = nearer(best, others[2], weights[2]);
    let (squared, [u, v]) = nearer(best, others[3], weights[3]);
    Foot { squared, u, v }
}

#[inline(always)]
fn nearer(best: (f64, [f64; 2]), squared: f64, weights: [f64; 2]) -> (f64, [f64; 2]) {
    if squared < best.0 {
        (squared, weights)
    } else {
        best
    }
}

/// The weights of the foot on the plane, and whether it lies inside.
#[inline(always)]
fn inside([bb, cc, ..]: [f64; 4], [bp, cp, _, bc]: [f64; 4]) -> (f64, f64, bool) {
    let area = bb * cc - bc * bc;
    let (u, v) = ((cc * bp - bc * cp) / area, (bb * cp - bc * bp) / area);
    let is_inside = (area > 0.0) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0);
    (u, v, is_inside)
}

/// Places by their weights, in the triangle's box.
#[inline(always)]
fn places<S: Simd>(simd: S, w: [[f64; 2]; 4], triangle: &Triangle) -> Vectors<S> {
    let u = f64x4::simd_from(simd, [w[0][0], w[1][0], w[2][0], w[3][0]]);
    let v = f64x4::simd_from(simd, [w[0][1], w[1][1], w[2][1], w[3][1]]);
    let weights = [f64x4::splat(simd, 1.0) - u - v, u, v];
    [
        coordinates(simd, weights, triangle, 0),
        coordinates(simd, weights, triangle, 1),
        coordinates(simd, weights, triangle, 2),
    ]
}

#[inline(always)]
fn coordinates<S: Simd>(
    simd: S,
    [rest, u, v]: Vectors<S>,
    Triangle([a, b, c]): &Triangle,
    k: usize,
) -> f64x4<S> {
    let a = f64x4::splat(simd, f64::from(a[k]));
    let b = f64x4::splat(simd, f64::from(b[k]));
    let c = f64x4::splat(simd, f64::from(c[k]));
    (rest * a + u * b + v * c)
        .max(a.min(b).min(c))
        .min(a.max(b).max(c))
}

/// Four vectors, exactly.
#[inline(always)]
fn vectors<S: Simd>(simd: S, of: [&[f32; 3]; 4]) -> Vectors<S> {
    [row(simd, of, 0), row(simd, of, 1), row(simd, of, 2)]
}

#[inline(always)]
fn row<S: Simd>(simd: S, [a, b, c, d]: [&[f32; 3]; 4], k: usize) -> f64x4<S> {
    let four = f32x4::simd_from(simd, [a[k], b[k], c[k], d[k]]);
    four.combine(four).widen().0
}

#[inline(always)]
fn minus<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> Vectors<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> f64x4<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
