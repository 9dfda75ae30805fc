//! The triangle that is nearest to a point: nearer boxes first, and none that begins beyond the nearest triangle known.
//!
//! Boxes are measured in single precision, eight at a time, triangles in double precision, one by one; what rounding may have
//! done to a box is allowed for, so that the answer is that of asking every triangle.

use super::Wide;
use super::form::Form;
use super::layout::{Ref, WIDTH, bounds};
use crate::geom::{Aabb, Nearest, Triangle};
use crate::simd::{AxisRows, NodeRows, PlaneRow, Stack, Third};
use crate::structure::nearest::{NearestPlace, is_in_domain};
use fearless_simd::{f32x8, prelude::*};

/// Points and scenes beyond this have squares that single precision has not.
const MOST: f32 = 1e18;

/// The nearest triangle of each point.
#[inline(always)]
pub(super) fn nearest_of_each<S: Simd, M: Form>(
    simd: S,
    wide: &Wide<M>,
    points: &[[f32; 3]],
    answers: &mut [Option<Nearest>],
) {
    let mut known = NearestPlace::none();
    for (point, answer) in points.iter().zip(answers) {
        if is_in_domain(point) {
            known = known.for_another(point);
            search(simd, wide, point, &mut known);
            *answer = known.answer();
        } else {
            *answer = None;
        }
    }
}

/// Looks at every triangle that may be nearer than the one known.
#[inline(always)]
fn search<S: Simd, M: Form>(simd: S, wide: &Wide<M>, point: &[f32; 3], known: &mut NearestPlace) {
    let Some(root) = wide.root else { return };
    let is_large = wide.size > MOST || point.iter().any(|x| x.abs() > MOST);
    let mut node_room = M::NODE_ROOM;
    let mut leaf_room = M::LEAF_ROOM;
    let mut memory = Stack::memory::<{ super::STACK }>();
    let mut stack = Stack::<u64>::new(&mut memory);
    stack.push(u64::from(root.0));
    while let Some(next) = stack.pop() {
        let (at, squared) = (Ref(next as u32), f32::from_bits((next >> 32) as u32));
        if squared > known.reach {
            continue;
        }
        if at.is_leaf() {
            let rows = wide.store.leaf(at, &mut leaf_room);
            let axes = [Third::A, Third::B, Third::C].map(|axis| rows.axis(axis));
            let squares = if is_large {
                [0.0; WIDTH]
            } else {
                squares_of_triangles(simd, axes, point)
            };
            for (lane, square) in squares.iter().enumerate().take(at.count()) {
                if *square <= known.reach {
                    let (corners, prim) = wide.store.triangle(at, lane);
                    known.look(&Triangle(corners), prim, point);
                }
            }
            continue;
        }
        let node = wide.store.node(simd, at.granule(), &mut node_room);
        let squares = if is_large {
            large_squares(node, point)
        } else {
            squares_of_boxes(simd, node, point)
        };
        let base = stack.len();
        for lane in 0..WIDTH {
            // Empty lanes are infinitely far.
            if squares[lane] <= known.reach {
                let child = node.refs()[lane];
                stack.insert_descending(
                    base,
                    u64::from(squares[lane].to_bits()) << 32 | u64::from(child),
                );
            }
        }
    }
}

/// Distances to eight boxes, squared.
#[inline(always)]
fn squares_of_boxes<S: Simd>(simd: S, node: NodeRows<'_>, point: &[f32; 3]) -> [f32; WIDTH] {
    let x = square_to_boxes(simd, node, Third::A, point);
    let y = square_to_boxes(simd, node, Third::B, point);
    let z = square_to_boxes(simd, node, Third::C, point);
    (x + y + z).into()
}

/// The part of one axis.
#[inline(always)]
fn square_to_boxes<S: Simd>(
    simd: S,
    node: NodeRows<'_>,
    axis: Third,
    point: &[f32; 3],
) -> f32x8<S> {
    let low = f32x8::simd_from(simd, *node.plane(PlaneRow::new(axis, false)));
    let high = f32x8::simd_from(simd, *node.plane(PlaneRow::new(axis, true)));
    square_outside(simd, low, high, point[axis as usize])
}

/// Distances to the boxes of eight triangles, squared; those after the leaf's last mean nothing.
#[inline(always)]
fn squares_of_triangles<S: Simd>(
    simd: S,
    axes: [AxisRows<'_>; 3],
    point: &[f32; 3],
) -> [f32; WIDTH] {
    let [x, y, z] = axes;
    let x = square_to_triangles(simd, x, point[0]);
    let y = square_to_triangles(simd, y, point[1]);
    let z = square_to_triangles(simd, z, point[2]);
    (x + y + z).into()
}

/// The part of one axis.
#[inline(always)]
fn square_to_triangles<S: Simd>(simd: S, axis: AxisRows<'_>, x: f32) -> f32x8<S> {
    let a = f32x8::simd_from(simd, *axis.corner(Third::A));
    let b = f32x8::simd_from(simd, *axis.corner(Third::B));
    let c = f32x8::simd_from(simd, *axis.corner(Third::C));
    square_outside(simd, a.min(b).min(c), a.max(b).max(c), x)
}

/// How far a coordinate is outside of eight intervals, squared.
#[inline(always)]
fn square_outside<S: Simd>(simd: S, low: f32x8<S>, high: f32x8<S>, x: f32) -> f32x8<S> {
    let x = f32x8::splat(simd, x);
    let outside = (low - x).max(x - high).max(f32x8::splat(simd, 0.0));
    outside * outside
}

/// The same where squares are too large: in double precision, cut to what single precision has.
fn large_squares(node: NodeRows<'_>, point: &[f32; 3]) -> [f32; WIDTH] {
    std::array::from_fn(|lane| {
        let bounds = bounds(node, lane);
        if bounds.is_empty() {
            return f32::INFINITY;
        }
        (square_to(&bounds, point) as f32).min(f32::MAX)
    })
}

fn square_to(bounds: &Aabb, point: &[f32; 3]) -> f64 {
    (0..3)
        .map(|k| {
            let x = f64::from(point[k]);
            let outside = (f64::from(bounds.min[k]) - x)
                .max(x - f64::from(bounds.max[k]))
                .max(0.0);
            outside * outside
        })
        .sum()
}
