//! Eight boxes against a ray, eight triangles against a ray.

use super::form::{Form, Store};
use super::layout::Ref;
use super::ray::{EdgeLanes, SlabLanes};
use crate::simd::{AxisRows, NodeRows, PlaneRow, Third};
use fearless_simd::{f32x8, i32x8, mask32x8, prelude::*};

/// Which children the ray enters, and where.
///
/// Numbers are compared as integers, which is quicker: the same order, since the larger of a number and `t_min >= 0` is
/// never one of two negative ones, and an exit before 0 is before every entry whatever its order among its like.
#[inline(always)]
pub(super) fn boxes<S: Simd>(
    simd: S,
    node: NodeRows<'_>,
    ray: &SlabLanes<S>,
    t_max: f32x8<S>,
) -> (mask32x8<S>, i32x8<S>) {
    let [x, y, z] = ray.near_row;
    let t_min = ray.t_min.bitcast::<i32x8<S>>();
    let t_max = t_max.bitcast::<i32x8<S>>();
    let enter = near(simd, node, x, 0, ray)
        .max(near(simd, node, y, 1, ray))
        .max(near(simd, node, z, 2, ray).max(t_min));
    let exit = far(simd, node, x, 0, ray)
        .min(far(simd, node, y, 1, ray))
        .min(far(simd, node, z, 2, ray).min(t_max));
    (enter.simd_le(exit), enter)
}

/// The lane of the child that is entered first, and all others that are entered.
#[inline(always)]
pub(super) fn nearest<S: Simd>(simd: S, hit: mask32x8<S>, enter: i32x8<S>) -> (usize, mask32x8<S>) {
    // The number of the lane in the last bits: which of neighbours comes first does not matter.
    let numbers = i32x8::simd_from(simd, [0, 1, 2, 3, 4, 5, 6, 7]);
    let key = hit.select(
        (enter & i32x8::splat(simd, !7)) | numbers,
        i32x8::splat(simd, i32::MAX),
    );
    let first = least(key);
    (first[0] as usize & 7, key.simd_gt(first) & hit)
}

/// The smallest of all lanes, in all lanes.
#[inline(always)]
fn least<S: Simd>(v: i32x8<S>) -> i32x8<S> {
    let (a, b) = v.split();
    let m = a.min(b);
    let m = m.min(m.slide::<2>(m));
    i32x8::block_splat(m.min(m.slide::<1>(m)))
}

/// Where the line enters and leaves the boxes of all children, without regard to the ray's range.
#[inline(always)]
pub(super) fn planes<S: Simd>(
    simd: S,
    node: NodeRows<'_>,
    ray: &SlabLanes<S>,
) -> (f32x8<S>, f32x8<S>) {
    let [x, y, z] = ray.near_row;
    let float = |v: i32x8<S>| v.bitcast::<f32x8<S>>();
    let near = float(near(simd, node, x, 0, ray))
        .max(float(near(simd, node, y, 1, ray)))
        .max(float(near(simd, node, z, 2, ray)));
    let far = float(far(simd, node, x, 0, ray))
        .min(float(far(simd, node, y, 1, ray)))
        .min(float(far(simd, node, z, 2, ray)));
    (near, far)
}

#[inline(always)]
fn near<S: Simd>(
    simd: S,
    node: NodeRows<'_>,
    row: PlaneRow,
    k: usize,
    ray: &SlabLanes<S>,
) -> i32x8<S> {
    f32x8::simd_from(simd, *node.plane(row))
        .mul_add(ray.recip[k], ray.near[k])
        .bitcast::<i32x8<S>>()
}

#[inline(always)]
fn far<S: Simd>(
    simd: S,
    node: NodeRows<'_>,
    row: PlaneRow,
    k: usize,
    ray: &SlabLanes<S>,
) -> i32x8<S> {
    f32x8::simd_from(simd, *node.plane(row.opposite()))
        .mul_add(ray.recip[k], ray.far[k])
        .bitcast::<i32x8<S>>()
}

/// A corner of eight triangles in the space where the ray starts at the origin and runs along the last axis; the same
/// operations as `Triangle::intersect`.
#[inline(always)]
fn corner<S: Simd>(
    simd: S,
    rows: [AxisRows<'_>; 3],
    v: Third,
    ray: &EdgeLanes<S>,
) -> [f32x8<S>; 3] {
    let [x, y, z] = rows;
    sheared(
        [
            f32x8::simd_from(simd, *x.corner(v)),
            f32x8::simd_from(simd, *y.corner(v)),
            f32x8::simd_from(simd, *z.corner(v)),
        ],
        ray,
    )
}

/// Numbers in lanes, as many as may be.
pub(super) trait Floats<S: Simd>: SimdFloat<S, Element = f32> {}
impl<S: Simd, F: SimdFloat<S, Element = f32>> Floats<S> for F {}

/// The same for a corner `[kx, ky, kz]`.
#[inline(always)]
pub(super) fn sheared<S: Simd, F: Floats<S>>([x, y, z]: [F; 3], ray: &EdgeLanes<S, F>) -> [F; 3] {
    turned(
        [x - ray.origin[0], y - ray.origin[1], z - ray.origin[2]],
        ray,
    )
}

/// The same for a corner as seen from the ray's origin.
#[inline(always)]
pub(super) fn turned<S: Simd, F: Floats<S>>(
    [x, y, depth]: [F; 3],
    ray: &EdgeLanes<S, F>,
) -> [F; 3] {
    [x - ray.shear[0] * depth, y - ray.shear[1] * depth, depth]
}

/// Triangles after the first half of the exact test.
pub(super) struct LeafTest<F> {
    corners: [[F; 3]; 3],
    edges: [F; 3],
    /// Lanes that the edge functions do not rule out.
    pub(super) candidates: u32,
}

#[inline(always)]
fn edge<S: Simd, F: Floats<S>>(a: [F; 3], b: [F; 3]) -> F {
    a[0] * b[1] - a[1] * b[0]
}

#[inline(always)]
pub(super) fn leaf_test<S: Simd, M: Form>(
    simd: S,
    store: &Store<M>,
    leaf: Ref,
    ray: &EdgeLanes<S>,
) -> LeafTest<f32x8<S>> {
    let mut room = M::LEAF_ROOM;
    let rows = store.leaf(leaf, &mut room);
    let rows = [
        rows.axis(ray.axes[0]),
        rows.axis(ray.axes[1]),
        rows.axis(ray.axes[2]),
    ];
    let a = corner(simd, rows, Third::A, ray);
    let b = corner(simd, rows, Third::B, ray);
    let c = corner(simd, rows, Third::C, ray);
    LeafTest::new(simd, [a, b, c], (2 << (leaf.count() - 1)) - 1)
}

/// Where candidates are hit, as far as single precision can tell.
///
/// # Why the bounds hold
///
/// The corners are those of the exact test, bit for bit; what it makes of them in double precision is exact here, up to one
/// rounding. Let `u = 2^-24`, `e` the three edge functions (all of one sign), `D` their sum, `z` the depths of the corners,
/// `d = sum(e z) / D` and `size` the sum of the sizes of all six products.
///
/// * An edge, two products and a difference, errs by `2 u` of its products. With edges `e + h` instead of `e` the depth changes by
///   exactly `sum(h (z - d)) / (D + sum(h))`, and no `z` is farther from `d` than `spread`, the largest depth less the smallest:
///   together `2 u size spread / |D|`. The factor 3 instead of 2 covers the rounding of this bound itself.
/// * All else rounds relative to `far`, the largest depth by size: the sum of three products 3 times, `D` twice, its reciprocal,
///   the product with it, and `t` from depth once each, its factor and the exact test's own end once each: `10 u`, for which 14 stands.
/// * Underflow: [`LOST`] and [`NEAREST`].
pub(super) struct Depths<F> {
    pub(super) lower: F,
    pub(super) upper: F,
    /// Hit for certain (if in range), and the bounds hold.
    pub(super) sure: u32,
    /// Candidates that are not before the ray's range for certain.
    pub(super) open: u32,
}

/// The unit roundoff.
const U: f32 = 1.0 / (1 << 24) as f32;
/// What the sum of edges times depths may lose to underflow: each of three steps less than the smallest normal number, even
/// where smaller ones are flushed to zero.
const LOST: f32 = 4.0 * f32::MIN_POSITIVE;
/// Depths below this count as this much, so that their share of the error, `14 U`, covers what the last two products lose to
/// underflow: 2^-104.
const NEAREST: f32 = f32::MIN_POSITIVE * (1 << 22) as f32;

impl<F> LeafTest<F> {
    /// Of sheared corners, for the lanes of `among`.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, corners: [[F; 3]; 3], among: u32) -> Self
    where
        F: Floats<S>,
    {
        let [a, b, c] = corners;
        let (ea, eb, ec) = (edge(b, c), edge(c, a), edge(a, b));
        // A NaN is on neither side, or lost: both leave the lane in.
        let (least, most) = (ea.min(eb).min(ec), ea.max(eb).max(ec));
        let zero = F::splat(simd, 0.0);
        let out = least.simd_lt(zero) & most.simd_gt(zero);
        let candidates = !(out.to_bitmask() as u32) & among;
        Self {
            corners,
            edges: [ea, eb, ec],
            candidates,
        }
    }

    #[inline(always)]
    pub(super) fn depths<S: Simd>(&self, simd: S, ray: &EdgeLanes<S, F>) -> Depths<F>
    where
        F: Floats<S>,
    {
        let [a, b, c] = self.corners;
        let [ea, eb, ec] = self.edges;
        let (za, zb, zc) = (a[2], b[2], c[2]);
        let det = (ea + eb) + ec;
        let num = ec.mul_add(zc, eb.mul_add(zb, ea * za));
        let inv = F::splat(simd, 1.0) / det;
        let abs_inv = inv.abs();
        let (least, most) = (za.min(zb).min(zc), za.max(zb).max(zc));
        let size = products(b, c) + products(c, a) + products(a, b);
        let spread = (most - least) * abs_inv;
        let far = least.abs().max(most.abs()).max(F::splat(simd, NEAREST));
        let error = abs_inv.mul_add(
            F::splat(simd, LOST),
            (size * spread).mul_add(F::splat(simd, 3.0 * U), far * F::splat(simd, 14.0 * U)),
        );
        let depth = num * inv;
        let t = depth * ray.recip;
        let error = error.mul_add(ray.recip.abs(), F::splat(simd, f32::MIN_POSITIVE));
        // The bounds hold where the edges have strictly one sign and nothing came near overflow or underflow.
        let (zero, infinity) = (F::splat(simd, 0.0), F::splat(simd, f32::INFINITY));
        let strict = ea.min(eb).min(ec).simd_gt(zero) | ea.max(eb).max(ec).simd_lt(zero);
        let normal = abs_inv.simd_lt(F::splat(simd, 1e27)) & abs_inv.simd_gt(F::splat(simd, 1e-27));
        let (lower, upper) = (t - error, t + error);
        let holds = strict & normal & upper.simd_lt(infinity) & lower.simd_gt(-infinity);
        let lower = holds.select(lower, -infinity);
        let upper = holds.select(upper, infinity);
        let sure = lower.simd_ge(ray.t_min) & holds;
        let before = upper.simd_lt(ray.t_min);
        Depths {
            lower,
            upper,
            sure: sure.to_bitmask() as u32 & self.candidates,
            open: self.candidates & !(before.to_bitmask() as u32),
        }
    }
}

#[inline(always)]
fn products<S: Simd, F: Floats<S>>(a: [F; 3], b: [F; 3]) -> F {
    (a[0] * b[1]).abs() + (a[1] * b[0]).abs()
}

/// One box, in all lanes: the planes that rays of one octant cross first, and those that they cross last.
pub(super) struct Planes<F> {
    pub(super) near: [F; 3],
    pub(super) far: [F; 3],
}

impl<F> Planes<F> {
    /// Of a child, for rays whose near planes are in `rows`.
    #[inline(always)]
    pub(super) fn of<S: Simd>(simd: S, node: NodeRows<'_>, lane: usize, rows: [PlaneRow; 3]) -> Self
    where
        F: Floats<S>,
    {
        let [x, y, z] = rows;
        let plane = |row: PlaneRow| F::splat(simd, node.plane(row)[lane & 7]);
        Self {
            near: [plane(x), plane(y), plane(z)],
            far: [
                plane(x.opposite()),
                plane(y.opposite()),
                plane(z.opposite()),
            ],
        }
    }
}
