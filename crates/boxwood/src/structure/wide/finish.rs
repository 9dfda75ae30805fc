//! The second half of the exact test, for eight rays at a time: the hits that remain when their traversals are over.

use super::form::{Form, Store};
use super::lanes::Floats;
use super::layout::Ref;
use super::pending::Best;
use super::prepare::{Record, rows_of, transpose};
use crate::geom::{Candidate, LEAST_PAD, OWN_PAD, PAD_PER_DIR, Ray};
use fearless_simd::{f32x8, f64x4, mask32x8, prelude::*, u32x8};

/// A triangle that its ray hits for certain.
#[derive(Clone, Copy)]
pub(super) struct Finished {
    pub(super) record: Record,
    pub(super) ray: usize,
    pub(super) leaf: Ref,
    pub(super) lane: u32,
}

impl Finished {
    pub(super) const NONE: Self = Self {
        record: Record::EMPTY,
        ray: 0,
        leaf: Ref(0),
        lane: 0,
    };
}

/// `a` or `b` or `c` for main axis 0, 1, 2.
#[inline(always)]
fn pick<S: Simd>(is_x: mask32x8<S>, is_y: mask32x8<S>, of: [f32x8<S>; 3]) -> f32x8<S> {
    is_x.select(of[0], is_y.select(of[1], of[2]))
}

/// Two halves in double precision.
#[derive(Clone, Copy)]
struct Wide64<S: Simd>(f64x4<S>, f64x4<S>);

impl<S: Simd> Wide64<S> {
    #[inline(always)]
    fn of(v: f32x8<S>) -> Self {
        let (a, b) = v.widen();
        Self(a, b)
    }
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0, self.1 * o.1)
    }
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1)
    }
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0, self.1 - o.1)
    }
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        Self(self.0 / o.0, self.1 / o.1)
    }
    #[inline(always)]
    fn edge(a: [Self; 3], b: [Self; 3]) -> Self {
        a[0].mul(b[1]).sub(a[1].mul(b[0]))
    }
    #[inline(always)]
    fn narrow(self) -> f32x8<S> {
        self.0.narrow(self.1)
    }
}

/// The space where each ray starts at the origin and runs along its main axis.
struct Frame<S: Simd> {
    is_x: mask32x8<S>,
    is_y: mask32x8<S>,
    origin: [f32x8<S>; 3],
    shear: [f32x8<S>; 2],
}

impl<S: Simd> Frame<S> {
    /// A corner there, in double precision.
    #[inline(always)]
    fn shear(&self, [x, y, z]: [f32x8<S>; 3]) -> [Wide64<S>; 3] {
        let depth = pick(self.is_x, self.is_y, [x, y, z]) - self.origin[2];
        let first =
            (pick(self.is_x, self.is_y, [y, z, x]) - self.origin[0]) - self.shear[0] * depth;
        let second =
            (pick(self.is_x, self.is_y, [z, x, y]) - self.origin[1]) - self.shear[1] * depth;
        [Wide64::of(first), Wide64::of(second), Wide64::of(depth)]
    }
}

/// Eight rays, as far as the second half needs them.
pub(super) struct FinishRows<S: Simd> {
    pub(super) origin: [f32x8<S>; 3],
    pub(super) dir: [f32x8<S>; 3],
    pub(super) t_min: f32x8<S>,
    pub(super) t_max: f32x8<S>,
    pub(super) recip: [f32x8<S>; 3],
    pub(super) shear: [f32x8<S>; 2],
    /// The main axis.
    pub(super) axis: u32x8<S>,
}

/// What each ray hits.
#[inline(always)]
pub(super) fn evaluate<S: Simd, M: Form>(
    simd: S,
    store: &Store<M>,
    rays: &[Ray],
    done: &[Finished; 8],
    best: &mut [Best; 8],
) -> u32 {
    let [ox, oy, oz, _, dx, dy, dz, t_max] =
        rows_of(simd, done.each_ref().map(|done| &rays[done.ray]));
    let row = |k: usize| {
        let r = &done[k].record;
        f32x8::simd_from(
            simd,
            [
                r.recip[0],
                r.recip[1],
                r.recip[2],
                r.shear[0],
                r.shear[1],
                r.t_min,
                f32::from_bits(r.axis),
                0.0,
            ],
        )
    };
    let [rx, ry, rz, shear_x, shear_y, t_min, axis, _] = transpose([
        row(0),
        row(1),
        row(2),
        row(3),
        row(4),
        row(5),
        row(6),
        row(7),
    ]);
    let rows = FinishRows {
        origin: [ox, oy, oz],
        dir: [dx, dy, dz],
        t_min,
        t_max,
        recip: [rx, ry, rz],
        shear: [shear_x, shear_y],
        axis: axis.bitcast::<u32x8<S>>(),
    };
    evaluate_rows(
        simd,
        &rows,
        &Corners::gather(simd, store, &done.map(|d| (d.leaf, d.lane))),
        best,
    )
}

/// A triangle for each of eight rays.
pub(super) struct Corners<S: Simd> {
    at: [[f32x8<S>; 3]; 3],
    prims: [u32; 8],
}

impl<S: Simd> Corners<S> {
    /// Those that (leaf, lane) name.
    #[inline(always)]
    pub(super) fn gather<M: Form>(simd: S, store: &Store<M>, done: &[(Ref, u32); 8]) -> Self {
        let mut corners = [[[0.0f32; 8]; 3]; 3];
        let mut prims = [0u32; 8];
        for k in 0..8 {
            let (leaf, lane) = done[k];
            let (triangle, prim) = store.triangle(leaf, lane as usize);
            for v in 0..3 {
                for axis in 0..3 {
                    corners[v][axis][k] = triangle[v][axis];
                }
            }
            prims[k] = prim;
        }
        let at = |v: usize| {
            [
                f32x8::simd_from(simd, corners[v][0]),
                f32x8::simd_from(simd, corners[v][1]),
                f32x8::simd_from(simd, corners[v][2]),
            ]
        };
        Self {
            at: [at(0), at(1), at(2)],
            prims,
        }
    }

    /// The same for all.
    #[inline(always)]
    pub(super) fn same<M: Form>(simd: S, store: &Store<M>, leaf: Ref, lane: u32) -> Self {
        let (corners, prim) = store.triangle(leaf, lane as usize);
        let at = |v: usize| {
            [
                f32x8::splat(simd, corners[v][0]),
                f32x8::splat(simd, corners[v][1]),
                f32x8::splat(simd, corners[v][2]),
            ]
        };
        Self {
            at: [at(0), at(1), at(2)],
            prims: [prim; 8],
        }
    }
}

/// What each ray hits, if it is that triangle: the same operations as `Triangle::intersect` and `Aabb::bind`. Bit k of the result is
/// 0 if the ray's range says otherwise.
#[inline(always)]
pub(super) fn evaluate_rows<S: Simd>(
    simd: S,
    rays: &FinishRows<S>,
    corners: &Corners<S>,
    best: &mut [Best; 8],
) -> u32 {
    let ([ox, oy, oz], [dx, dy, dz], [rx, ry, rz]) = (rays.origin, rays.dir, rays.recip);
    let ([shear_x, shear_y], axis, t_min, t_max) = (rays.shear, rays.axis, rays.t_min, rays.t_max);
    let is_x = axis.simd_eq(u32x8::splat(simd, 0));
    let is_y = axis.simd_eq(u32x8::splat(simd, 1));
    let [pa, pb, pc] = corners.at;
    let prims = corners.prims;
    let (okx, oky, okz) = (
        pick(is_x, is_y, [oy, oz, ox]),
        pick(is_x, is_y, [oz, ox, oy]),
        pick(is_x, is_y, [ox, oy, oz]),
    );
    let frame = Frame {
        is_x,
        is_y,
        origin: [okx, oky, okz],
        shear: [shear_x, shear_y],
    };
    let (a, b, c) = (frame.shear(pa), frame.shear(pb), frame.shear(pc));
    let (ea, eb, ec) = (Wide64::edge(b, c), Wide64::edge(c, a), Wide64::edge(a, b));
    let det = ea.add(eb).add(ec);
    let depth = ea.mul(a[2]).add(eb.mul(b[2])).add(ec.mul(c[2])).div(det);
    let one = f64x4::splat(simd, 1.0);
    let t_per_depth = Wide64(one, one).div(Wide64::of(pick(is_x, is_y, [dx, dy, dz])));
    let t = depth.mul(t_per_depth).narrow() + f32x8::splat(simd, 0.0);
    let (u, v) = (eb.div(det).narrow().abs(), ec.div(det).narrow().abs());
    // Bound to its own box.
    let (x, y, z) = (
        Span::around(pa[0], pb[0], pc[0], ox),
        Span::around(pa[1], pb[1], pc[1], oy),
        Span::around(pa[2], pb[2], pc[2], oz),
    );
    let reach = larger(larger(x.reach(), y.reach()), z.reach());
    let largest = larger(dx.abs(), larger(dy.abs(), dz.abs()));
    let splat = |x: f32| f32x8::splat(simd, x);
    let [per_dir, rest] = PAD_PER_DIR;
    let floor = larger(largest * splat(per_dir) * splat(rest), splat(LEAST_PAD));
    let pad = reach * splat(OWN_PAD) + floor;
    let (x, y, z) = (x.slab(pad, rx), y.slab(pad, ry), z.slab(pad, rz));
    let near = larger(larger(x.0, y.0), z.0);
    let far = smaller(smaller(x.1, y.1), z.1);
    let t = larger(near, smaller(far, t));
    let good = near.simd_le(far)
        & t.simd_ge(t_min)
        & t.simd_le(t_max)
        & t.simd_lt(f32x8::splat(simd, f32::INFINITY));
    let (t, u, v): ([f32; 8], [f32; 8], [f32; 8]) = (t.into(), u.into(), v.into());
    for k in 0..8 {
        best[k] = Best {
            candidate: Candidate {
                t: t[k],
                u: u[k],
                v: v[k],
            },
            prim: prims[k],
        };
    }
    good.to_bitmask() as u32
}

/// A box along one axis, as seen from the origin. Methods, not closures, which would not be compiled for the instruction set.
struct Span<S: Simd> {
    lo: f32x8<S>,
    hi: f32x8<S>,
}

impl<S: Simd> Span<S> {
    #[inline(always)]
    fn around(a: f32x8<S>, b: f32x8<S>, c: f32x8<S>, origin: f32x8<S>) -> Self {
        Self {
            lo: smaller(smaller(a, b), c) - origin,
            hi: larger(larger(a, b), c) - origin,
        }
    }
    #[inline(always)]
    fn reach(&self) -> f32x8<S> {
        larger(self.lo.abs(), self.hi.abs())
    }
    /// Where the line enters and leaves it, padded.
    #[inline(always)]
    fn slab(&self, pad: f32x8<S>, recip: f32x8<S>) -> (f32x8<S>, f32x8<S>) {
        let (a, b) = ((self.lo - pad) * recip, (self.hi + pad) * recip);
        (smaller(a, b), larger(a, b))
    }
}

/// `geom::float::max`, by lanes.
#[inline(always)]
pub(super) fn larger<S: Simd, F: Floats<S>>(a: F, b: F) -> F {
    b.simd_gt(a).select(b, a)
}

/// `geom::float::min`, by lanes.
#[inline(always)]
pub(super) fn smaller<S: Simd, F: Floats<S>>(a: F, b: F) -> F {
    b.simd_lt(a).select(b, a)
}
