//! Eight rays at a time made ready.

use super::ray::{PAD, TAME};
use crate::geom::{LEAST_PAD, LIFT, MAX_COORDINATE, MAX_DIR, MIN_DIR, PAD_PER_DIR, Ray};
use crate::simd::PlaneRow;
use fearless_simd::{f32x8, prelude::*, u32x8};

/// What the batch kernels need of a ray: a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Record {
    pub(super) recip: [f32; 3],
    pub(super) near: [f32; 3],
    pub(super) far: [f32; 3],
    pub(super) t_min: f32,
    pub(super) t_max: f32,
    pub(super) shear: [f32; 2],
    pub(super) t_per_depth: f32,
    /// The main axis.
    pub(super) axis: u32,
    /// For each axis, where the row of the near planes begins in a node.
    pub(super) rows: [PlaneRow; 4],
}

impl Record {
    pub(super) const EMPTY: Self = Self {
        recip: [0.0; 3],
        near: [0.0; 3],
        far: [0.0; 3],
        t_min: 0.0,
        t_max: 0.0,
        shear: [0.0; 2],
        t_per_depth: 0.0,
        axis: 0,
        rows: [PlaneRow::at(0); 4],
    };

    #[inline(always)]
    fn of(a: [f32; 8], b: [f32; 8]) -> Self {
        Self {
            recip: [a[0], a[1], a[2]],
            near: [a[3], a[4], a[5]],
            far: [a[6], a[7], b[0]],
            t_min: b[1],
            t_max: b[2],
            shear: [b[3], b[4]],
            t_per_depth: b[5],
            axis: b[6].to_bits(),
            rows: b[7].to_bits().to_le_bytes().map(PlaneRow::at),
        }
    }
}

#[inline(always)]
pub(super) fn transpose<S: Simd>(mut v: [f32x8<S>; 8]) -> [f32x8<S>; 8] {
    for _ in 0..3 {
        let (a, b) = v[0].interleave(v[4]);
        let (c, d) = v[1].interleave(v[5]);
        let (e, f) = v[2].interleave(v[6]);
        let (g, h) = v[3].interleave(v[7]);
        v = [a, b, c, d, e, f, g, h];
    }
    v
}

/// Which rays are rays, and which of them have products that could overflow.
pub(super) struct Prepared {
    pub(super) valid: u32,
    pub(super) extreme: u32,
}

/// Eight rays by rows: lane k is ray k.
pub(super) struct RayRows<S: Simd> {
    pub(super) origin: [f32x8<S>; 3],
    pub(super) dir: [f32x8<S>; 3],
    pub(super) t_min: f32x8<S>,
    pub(super) t_max: f32x8<S>,
    pub(super) recip: [f32x8<S>; 3],
    /// Constants of the slab test, as in `SlabConstants`.
    pub(super) near: [f32x8<S>; 3],
    pub(super) far: [f32x8<S>; 3],
    pub(super) shear: [f32x8<S>; 2],
    pub(super) t_per_depth: f32x8<S>,
    /// The main axis.
    pub(super) axis: u32x8<S>,
    /// By how much boxes are padded.
    pub(super) pad: f32x8<S>,
    pub(super) prepared: Prepared,
}

/// Eight rays by rows: origins, smallest `t`, directions, largest `t`.
#[inline(always)]
pub(super) fn rows_of<S: Simd>(simd: S, rays: [&Ray; 8]) -> [f32x8<S>; 8] {
    let [a, b, c, d, e, f, g, h] = rays;
    transpose([
        row(simd, a),
        row(simd, b),
        row(simd, c),
        row(simd, d),
        row(simd, e),
        row(simd, f),
        row(simd, g),
        row(simd, h),
    ])
}

#[inline(always)]
fn row<S: Simd>(simd: S, ray: &Ray) -> f32x8<S> {
    let (o, d) = (ray.origin, ray.dir);
    f32x8::simd_from(
        simd,
        [o[0], o[1], o[2], ray.t_min, d[0], d[1], d[2], ray.t_max],
    )
}

/// Eight rays made ready for boxes of coordinates up to `size`.
#[inline(always)]
pub(super) fn ray_rows<S: Simd>(simd: S, rays: &[Ray; 8], size: f32) -> RayRows<S> {
    let [ox, oy, oz, t0, dx, dy, dz, t1] = rows_of(simd, rays.each_ref());
    let splat = |x: f32| f32x8::splat(simd, x);
    let (ax, ay, az) = (dx.abs(), dy.abs(), dz.abs());
    let largest = ax.max(ay).max(az);
    let far = splat(MAX_COORDINATE);
    let long = splat(MAX_DIR);
    let valid = ox.abs().simd_le(far)
        & oy.abs().simd_le(far)
        & oz.abs().simd_le(far)
        & ax.simd_le(long)
        & ay.simd_le(long)
        & az.simd_le(long)
        & largest.simd_ge(splat(MIN_DIR))
        & t0.simd_eq(t0)
        & t1.simd_eq(t1);
    let lift = largest * splat(LIFT);
    let one = splat(1.0);
    let rx = one / ax.simd_lt(lift).select(lift.copysign(dx), dx);
    let ry = one / ay.simd_lt(lift).select(lift.copysign(dy), dy);
    let rz = one / az.simd_lt(lift).select(lift.copysign(dz), dz);
    let is_x = ax.simd_ge(ay) & ax.simd_ge(az);
    let is_y = ay.simd_ge(az);
    let main = is_x.select(dx, is_y.select(dy, dz));
    let first = is_x.select(dy, is_y.select(dz, dx));
    let second = is_x.select(dz, is_y.select(dx, dy));
    let zero = splat(0.0);
    let t_min = t0.simd_gt(zero).select(t0, zero);
    let reach = splat(size) + ox.abs().max(oy.abs()).max(oz.abs());
    let [a, b] = PAD_PER_DIR;
    let floor = (largest * splat(a) * splat(b)).max(splat(LEAST_PAD));
    let pad = reach * splat(PAD) + (floor + floor);
    let (arx, ary, arz) = (rx.abs(), ry.abs(), rz.abs());
    let tame = ((reach + pad) * arx.max(ary).max(arz)).simd_lt(splat(TAME));
    let (cx, cy, cz) = (-(ox * rx), -(oy * ry), -(oz * rz));
    let (px, py, pz) = (pad * arx, pad * ary, pad * arz);
    let bit = |v: u32| u32x8::splat(simd, v);
    RayRows {
        origin: [ox, oy, oz],
        dir: [dx, dy, dz],
        t_min,
        // Minus zero becomes zero: the slab test compares as integers.
        t_max: t1 + zero,
        recip: [rx, ry, rz],
        near: [cx - px, cy - py, cz - pz],
        far: [cx + px, cy + py, cz + pz],
        shear: [first / main, second / main],
        // The largest component is not lifted.
        t_per_depth: is_x.select(rx, is_y.select(ry, rz)),
        axis: is_x.select(bit(0), is_y.select(bit(1), bit(2))),
        pad,
        prepared: Prepared {
            valid: valid.to_bitmask() as u32,
            extreme: !(tame.to_bitmask() as u32) & 0xff,
        },
    }
}

/// The same as records.
#[inline(always)]
pub(super) fn prepare<S: Simd>(
    simd: S,
    rays: &[Ray; 8],
    size: f32,
    records: &mut [Record; 8],
) -> Prepared {
    let rows = ray_rows(simd, rays, size);
    let zero = f32x8::splat(simd, 0.0);
    let bit = |v: u32| u32x8::splat(simd, v);
    let plane_row = |k: usize, at: u32| {
        rows.recip[k]
            .simd_lt(zero)
            .select(bit((at + 32) << (8 * k)), bit(at << (8 * k)))
    };
    let planes = plane_row(0, 0) | plane_row(1, 64) | plane_row(2, 128);
    let ([rx, ry, rz], [nx, ny, nz], [fx, fy, fz]) = (rows.recip, rows.near, rows.far);
    let a = transpose([rx, ry, rz, nx, ny, nz, fx, fy]);
    let b = transpose([
        fz,
        rows.t_min,
        rows.t_max,
        rows.shear[0],
        rows.shear[1],
        rows.t_per_depth,
        rows.axis.bitcast::<f32x8<S>>(),
        planes.bitcast::<f32x8<S>>(),
    ]);
    for k in 0..8 {
        records[k] = Record::of(a[k].into(), b[k].into());
    }
    rows.prepared
}
