//! The rays of a bundle by rows, and the beam around them.

use super::finish::FinishRows;
use super::lanes::{Floats, Planes};
use super::prepare::{Prepared, ray_rows};
use super::ray::EdgeLanes;
use crate::geom::Ray;
use crate::simd::{NodeRows, PlaneRow, Third};
use fearless_simd::{f32x8, i32x8, mask32x8, prelude::*, u32x8};

/// Rays of a bundle.
pub(super) const RAYS: usize = 64;

/// One number of each ray.
pub(super) type Column = [f32; RAYS];

/// The rays of a bundle, and what is known of their hits.
#[repr(C, align(64))]
pub(super) struct Columns {
    pub(super) recip: [Column; 3],
    near: [Column; 3],
    far: [Column; 3],
    t_min: Column,
    /// What begins beyond does not matter to the ray: the end of its range, the end of the interval in which its closest
    /// hit lies, or minus infinity if nothing matters to it.
    pub(super) bound: Column,
    /// Where the interval begins in which its closest hit lies; without one, the end of its range.
    pub(super) lower: Column,
    /// The triangle of the closest hit: bits of its leaf and lane.
    pub(super) leaf: Column,
    pub(super) lane: Column,
    origin: [Column; 3],
    dir: [Column; 3],
    t_max: Column,
    shear: [Column; 2],
    t_per_depth: Column,
    /// Bits of the main axis.
    axis: Column,
    pad: Column,
    /// Which rays have which main axis.
    pub(super) along: [u64; 3],
}

/// No triangle, as a leaf.
pub(super) const NONE: u32 = u32::MAX;

/// The packet of rays `p * F::LEN..`.
#[inline(always)]
pub(super) fn load<S: Simd, F: Floats<S>>(simd: S, column: &Column, p: usize) -> F {
    F::from_slice(simd, &column[p * F::LEN..][..F::LEN])
}

/// Its opposite.
#[inline(always)]
pub(super) fn store<S: Simd, F: Floats<S>>(value: F, column: &mut Column, p: usize) {
    value.store_slice(&mut column[p * F::LEN..][..F::LEN]);
}

#[inline(always)]
fn store3<S: Simd>([x, y, z]: [f32x8<S>; 3], columns: &mut [Column; 3], p: usize) {
    store(x, &mut columns[0], p);
    store(y, &mut columns[1], p);
    store(z, &mut columns[2], p);
}

#[inline(always)]
fn load3<S: Simd, F: Floats<S>>(simd: S, columns: &[Column; 3], p: usize) -> [F; 3] {
    [
        load(simd, &columns[0], p),
        load(simd, &columns[1], p),
        load(simd, &columns[2], p),
    ]
}

impl Columns {
    pub(super) const EMPTY: Self = Self {
        recip: [[0.0; RAYS]; 3],
        near: [[0.0; RAYS]; 3],
        far: [[0.0; RAYS]; 3],
        t_min: [0.0; RAYS],
        bound: [0.0; RAYS],
        lower: [0.0; RAYS],
        leaf: [0.0; RAYS],
        lane: [0.0; RAYS],
        origin: [[0.0; RAYS]; 3],
        dir: [[0.0; RAYS]; 3],
        t_max: [0.0; RAYS],
        shear: [[0.0; RAYS]; 2],
        t_per_depth: [0.0; RAYS],
        axis: [0.0; RAYS],
        pad: [0.0; RAYS],
        along: [0; 3],
    };

    /// Makes rays `8 * p..` ready.
    #[inline(always)]
    pub(super) fn prepare<S: Simd>(
        &mut self,
        simd: S,
        p: usize,
        rays: &[Ray; 8],
        size: f32,
    ) -> Prepared {
        let rows = ray_rows(simd, rays, size);
        store3(rows.recip, &mut self.recip, p);
        store3(rows.near, &mut self.near, p);
        store3(rows.far, &mut self.far, p);
        store(rows.t_min, &mut self.t_min, p);
        store(rows.t_max, &mut self.lower, p);
        store(f32x8::splat(simd, f32::from_bits(NONE)), &mut self.leaf, p);
        store3(rows.origin, &mut self.origin, p);
        store3(rows.dir, &mut self.dir, p);
        store(rows.t_max, &mut self.t_max, p);
        store(rows.shear[0], &mut self.shear[0], p);
        store(rows.shear[1], &mut self.shear[1], p);
        store(rows.t_per_depth, &mut self.t_per_depth, p);
        store(rows.axis.bitcast::<f32x8<S>>(), &mut self.axis, p);
        store(rows.pad, &mut self.pad, p);
        for axis in 0..3 {
            let along = rows
                .axis
                .simd_eq(u32x8::splat(simd, axis as u32))
                .to_bitmask();
            self.along[axis] |= along << (8 * p);
        }
        rows.prepared
    }

    /// Which rays of packet `p` enter the box.
    #[inline(always)]
    pub(super) fn enter<S: Simd, F: Floats<S>>(
        &self,
        simd: S,
        p: usize,
        planes: &Planes<F>,
    ) -> u32 {
        let recip = load3::<S, F>(simd, &self.recip, p);
        let [nx, ny, nz] = load3::<S, F>(simd, &self.near, p);
        let [fx, fy, fz] = load3::<S, F>(simd, &self.far, p);
        let (nx, fx) = (
            planes.near[0].mul_add(recip[0], nx),
            planes.far[0].mul_add(recip[0], fx),
        );
        let (ny, fy) = (
            planes.near[1].mul_add(recip[1], ny),
            planes.far[1].mul_add(recip[1], fy),
        );
        let (nz, fz) = (
            planes.near[2].mul_add(recip[2], nz),
            planes.far[2].mul_add(recip[2], fz),
        );
        let enter = nx.max(ny).max(nz.max(load::<S, F>(simd, &self.t_min, p)));
        let exit = fx.min(fy).min(fz.min(load::<S, F>(simd, &self.bound, p)));
        enter.simd_le(exit).to_bitmask() as u32
    }

    /// Constants of the edge functions of packet `p`, for those of its rays that run along one main axis.
    #[inline(always)]
    pub(super) fn edges<S: Simd, F: Floats<S>>(
        &self,
        simd: S,
        p: usize,
        axis: usize,
    ) -> EdgeLanes<S, F> {
        let [kx, ky, kz] = AXES[axis];
        EdgeLanes {
            axes: [Third::A; 3],
            origin: [
                load(simd, &self.origin[kx], p),
                load(simd, &self.origin[ky], p),
                load(simd, &self.origin[kz], p),
            ],
            shear: [load(simd, &self.shear[0], p), load(simd, &self.shear[1], p)],
            recip: load(simd, &self.t_per_depth, p),
            t_min: load(simd, &self.t_min, p),
            simd: std::marker::PhantomData,
        }
    }

    /// Rays `8 * p..` for the second half of the exact test.
    #[inline(always)]
    pub(super) fn finish_rows<S: Simd>(&self, simd: S, p: usize) -> FinishRows<S> {
        FinishRows {
            origin: load3(simd, &self.origin, p),
            dir: load3(simd, &self.dir, p),
            t_min: load(simd, &self.t_min, p),
            t_max: load(simd, &self.t_max, p),
            recip: load3(simd, &self.recip, p),
            shear: [load(simd, &self.shear[0], p), load(simd, &self.shear[1], p)],
            axis: load::<S, f32x8<S>>(simd, &self.axis, p).bitcast::<u32x8<S>>(),
        }
    }
}

/// By main axis, the axes in the order of the sheared space.
pub(super) const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// What all rays of a group lie in: a box of origins and, along each axis, an interval of reciprocals of one sign.
///
/// Where a ray crosses a plane `x`, `t = (x - origin) * recip` is linear in each of the two, so over the beam its extremes are at the ends of
/// the intervals: of the origins at the one that is nearer to (or farther from) the plane in the direction of the rays, of the
/// reciprocals at either. Both ends are treated as rays of their own, with the padding of the group's largest; the argument
/// in `geom/slab.rs` (rounding is covered by the padding) does not ask that a reciprocal belongs to a direction.
pub(super) struct Beam<S: Simd> {
    recip: [[f32x8<S>; 2]; 3],
    near: [[f32x8<S>; 2]; 3],
    far: [[f32x8<S>; 2]; 3],
    t_min: f32x8<S>,
    pub(super) rows: [PlaneRow; 3],
    /// The origin of all rays, if it is the same.
    pub(super) origin: Option<[f32; 3]>,
}

/// The smallest lane of each.
#[inline(always)]
fn lowest<S: Simd>(rows: &[f32x8<S>; 6]) -> [f32; 6] {
    [
        rows[0].reduce_min(),
        rows[1].reduce_min(),
        rows[2].reduce_min(),
        rows[3].reduce_min(),
        rows[4].reduce_min(),
        rows[5].reduce_min(),
    ]
}

/// The largest lane of each.
#[inline(always)]
fn highest<S: Simd>(rows: &[f32x8<S>; 6]) -> [f32; 6] {
    [
        rows[0].reduce_max(),
        rows[1].reduce_max(),
        rows[2].reduce_max(),
        rows[3].reduce_max(),
        rows[4].reduce_max(),
        rows[5].reduce_max(),
    ]
}

impl<S: Simd> Beam<S> {
    /// Around the rays of `group`, which are of one octant and from now on alone take part. `None`: a product could overflow.
    #[inline(always)]
    pub(super) fn around(simd: S, rays: &mut Columns, group: u64, size: f32) -> Option<Self> {
        let splat = |x: f32| f32x8::splat(simd, x);
        let (inf, zero) = (splat(f32::INFINITY), splat(0.0));
        let (mut least, mut most) = ([inf; 6], [-inf; 6]);
        let (mut t_min, mut pad) = (inf, zero);
        for p in 0..RAYS / 8 {
            let group = mask32x8::from_bitmask(simd, group >> (8 * p) & 0xff);
            for k in 0..3 {
                for (at, column) in [(k, &rays.recip[k]), (3 + k, &rays.origin[k])] {
                    let value: f32x8<S> = load(simd, column, p);
                    least[at] = least[at].min(group.select(value, inf));
                    most[at] = most[at].max(group.select(value, -inf));
                }
            }
            t_min = t_min.min(group.select(load(simd, &rays.t_min, p), inf));
            pad = pad.max(group.select(load(simd, &rays.pad, p), zero));
            store(
                group.select(load(simd, &rays.t_max, p), -inf),
                &mut rays.bound,
                p,
            );
        }
        let (least, most) = (lowest(&least), highest(&most));
        let pad = pad.reduce_max();
        let same = least[3] == most[3] && least[4] == most[4] && least[5] == most[5];
        let mut beam = Self {
            recip: [[zero; 2]; 3],
            near: [[zero; 2]; 3],
            far: [[zero; 2]; 3],
            t_min: splat(t_min.reduce_min()),
            rows: [PlaneRow::at(0); 3],
            origin: same.then_some([least[3], least[4], least[5]]),
        };
        let mut tame = true;
        for k in 0..3 {
            let backward = most[k] < 0.0;
            // The origin that is nearest to what lies ahead, and the farthest.
            let (ahead, behind) = if backward {
                (least[3 + k], most[3 + k])
            } else {
                (most[3 + k], least[3 + k])
            };
            for (end, recip) in [least[k], most[k]].into_iter().enumerate() {
                let pad = pad * recip.abs();
                beam.recip[k][end] = splat(recip);
                beam.near[k][end] = splat(-(ahead * recip) - pad);
                beam.far[k][end] = splat(-(behind * recip) + pad);
                tame &= (size + ahead.abs().max(behind.abs())) * recip.abs() < 1e38;
            }
            beam.rows[k] = PlaneRow::new([Third::A, Third::B, Third::C][k], backward);
        }
        tame.then_some(beam)
    }

    /// Which children the beam may enter before `bound`, and where at the earliest. As in `lanes::boxes`, integers serve as
    /// numbers: what is negative counts as less than any `t_min`.
    #[inline(always)]
    pub(super) fn boxes(
        &self,
        simd: S,
        node: NodeRows<'_>,
        bound: f32x8<S>,
    ) -> (mask32x8<S>, i32x8<S>) {
        let enter = self.near(simd, node, 0).max(self.near(simd, node, 1)).max(
            self.near(simd, node, 2)
                .max(self.t_min.bitcast::<i32x8<S>>()),
        );
        let exit = self
            .far(simd, node, 0)
            .min(self.far(simd, node, 1))
            .min(self.far(simd, node, 2).min(bound.bitcast::<i32x8<S>>()));
        (enter.simd_le(exit), enter)
    }

    #[inline(always)]
    fn near(&self, simd: S, node: NodeRows<'_>, k: usize) -> i32x8<S> {
        let plane = f32x8::simd_from(simd, *node.plane(self.rows[k]));
        let [a, b] = self.recip[k];
        let a = plane.mul_add(a, self.near[k][0]).bitcast::<i32x8<S>>();
        let b = plane.mul_add(b, self.near[k][1]).bitcast::<i32x8<S>>();
        a.min(b)
    }

    #[inline(always)]
    fn far(&self, simd: S, node: NodeRows<'_>, k: usize) -> i32x8<S> {
        let plane = f32x8::simd_from(simd, *node.plane(self.rows[k].opposite()));
        let [a, b] = self.recip[k];
        let a = plane.mul_add(a, self.far[k][0]).bitcast::<i32x8<S>>();
        let b = plane.mul_add(b, self.far[k][1]).bitcast::<i32x8<S>>();
        a.max(b)
    }
}
