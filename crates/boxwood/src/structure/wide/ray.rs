//! A ray made ready for rows of eight boxes and eight triangles.

use crate::geom::{Aabb, LEAST_PAD, LIFT, MAX_COORDINATE, MAX_DIR, MIN_DIR, PAD_PER_DIR};
use crate::geom::{PreparedRay, Ray};
use crate::simd::{PlaneRow, Third};
use fearless_simd::{f32x4, f32x8, prelude::*};
use std::marker::PhantomData;

/// Padding of boxes, of their reach: `32 u` as in `geom/slab.rs`.
pub(super) const PAD: f32 = 1.0 / (1 << 19) as f32;
/// Products below this overflow nowhere.
pub(super) const TAME: f32 = 1e38;

/// Constants of the slab test in fused form: `plane * recip + near` and `plane * recip + far`.
#[derive(Clone, Copy)]
pub(super) struct SlabConstants {
    pub(super) recip: [f32; 3],
    pub(super) near: [f32; 3],
    pub(super) far: [f32; 3],
    /// Row of the near plane along each axis; the far one is its [`PlaneRow::opposite`].
    pub(super) near_row: [PlaneRow; 3],
}

/// Largest coordinate, by size.
pub(super) fn size(bounds: &Aabb) -> f32 {
    let all = bounds.min.iter().chain(&bounds.max);
    if bounds.is_empty() {
        0.0
    } else {
        all.fold(0.0f32, |s, x| s.max(x.abs()))
    }
}

impl SlabConstants {
    /// `None` if a product could overflow.
    #[inline(always)]
    pub(super) fn new(ray: &PreparedRay, size: f32) -> Option<Self> {
        let [ox, oy, oz] = ray.origin;
        let reach = size + fmax(ox.abs(), fmax(oy.abs(), oz.abs()));
        let pad = reach * PAD + 2.0 * ray.pad_floor;
        let [rx, ry, rz] = ray.recip;
        let (ax, ay, az) = (rx.abs(), ry.abs(), rz.abs());
        if !((reach + pad) * fmax(ax, fmax(ay, az)) < TAME) {
            return None;
        }
        let (cx, cy, cz) = (-(ox * rx), -(oy * ry), -(oz * rz));
        let (px, py, pz) = (pad * ax, pad * ay, pad * az);
        Some(Self {
            recip: ray.recip,
            near: [cx - px, cy - py, cz - pz],
            far: [cx + px, cy + py, cz + pz],
            near_row: [
                PlaneRow::new(Third::A, rx < 0.0),
                PlaneRow::new(Third::B, ry < 0.0),
                PlaneRow::new(Third::C, rz < 0.0),
            ],
        })
    }
}

#[inline(always)]
fn fmax(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The same, eight times each.
#[derive(Clone, Copy)]
pub(super) struct SlabLanes<S: Simd> {
    pub(super) recip: [f32x8<S>; 3],
    pub(super) near: [f32x8<S>; 3],
    pub(super) far: [f32x8<S>; 3],
    pub(super) near_row: [PlaneRow; 3],
    pub(super) t_min: f32x8<S>,
}

impl<S: Simd> SlabLanes<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, c: &SlabConstants, t_min: f32) -> Self {
        Self {
            recip: splat3(simd, c.recip),
            near: splat3(simd, c.near),
            far: splat3(simd, c.far),
            near_row: c.near_row,
            t_min: f32x8::splat(simd, t_min),
        }
    }
}

#[inline(always)]
pub(super) fn splat3<S: Simd>(simd: S, [x, y, z]: [f32; 3]) -> [f32x8<S>; 3] {
    [
        f32x8::splat(simd, x),
        f32x8::splat(simd, y),
        f32x8::splat(simd, z),
    ]
}

/// Constants of the edge functions: of one ray in all lanes, or of a ray in each.
#[derive(Clone, Copy)]
pub(super) struct EdgeLanes<S: Simd, F = f32x8<S>> {
    pub(super) axes: [Third; 3],
    pub(super) origin: [F; 3],
    pub(super) shear: [F; 2],
    pub(super) recip: F,
    pub(super) t_min: F,
    pub(super) simd: PhantomData<S>,
}

/// By main axis, the axes in the order of the sheared space.
pub(super) const AXES: [[Third; 3]; 3] = [
    [Third::B, Third::C, Third::A],
    [Third::C, Third::A, Third::B],
    [Third::A, Third::B, Third::C],
];

/// The main axis by the comparisons x >= y, y >= z, x >= z (bits 0, 1, 2): the first of equals.
const MAIN: [Third; 8] = {
    let (x, y, z) = (Third::A, Third::B, Third::C);
    [z, z, y, y, z, x, y, x]
};

/// What becomes of a ray.
pub(super) enum Ready<S: Simd> {
    /// It is none.
    Not,
    /// A product could overflow.
    Extreme,
    /// Constants for boxes, for triangles, and for the exact test.
    Tame(SlabLanes<S>, EdgeLanes<S>, PreparedRay),
}

/// The largest of the first three lanes, in all lanes.
#[inline(always)]
fn largest3<S: Simd>(simd: S, v: f32x4<S>) -> f32x4<S> {
    let most = v.max(v.slide::<1>(v)).max(v.slide::<2>(v));
    f32x4::splat(simd, most[0])
}

/// Makes one ray ready for boxes of coordinates up to `size`: the same numbers as `PreparedRay` and `SlabConstants`, with x, y, z in
/// lanes. The first box test waits for all of this, so what it needs comes first and depends on little.
#[inline(always)]
pub(super) fn ready<S: Simd>(simd: S, ray: &Ray, size: f32) -> Ready<S> {
    let splat = |x: f32| f32x4::splat(simd, x);
    // Named one by one: a copy of the arrays would be made, and waited for.
    let (o, d) = (&ray.origin, &ray.dir);
    let origin = f32x4::simd_from(simd, [o[0], o[1], o[2], ray.t_min]);
    let dir = f32x4::simd_from(simd, [d[0], d[1], d[2], ray.t_max]);
    let mut recip = splat(1.0) / dir;
    let (distance, length) = (origin.abs(), dir.abs());
    let most = |of: f32| f32x4::simd_from(simd, [of, of, of, f32::INFINITY]);
    // Every comparison is false on NaN.
    let valid = distance.simd_le(most(MAX_COORDINATE)) & length.simd_le(most(MAX_DIR));
    let largest = largest3(simd, length);
    if valid.to_bitmask() != 0xf || !(largest[0] >= MIN_DIR) {
        return Ready::Not;
    }
    let lift = largest * splat(LIFT);
    let flat = length.simd_lt(lift);
    if flat.to_bitmask() & 7 != 0 {
        recip = splat(1.0) / flat.select(lift.copysign(dir), dir);
    }
    let reach = splat(size) + largest3(simd, distance);
    let [a, b] = PAD_PER_DIR;
    let floor = (largest * splat(a) * splat(b)).max(splat(LEAST_PAD));
    let pad = reach * splat(PAD) + (floor + floor);
    let steepness = recip.abs();
    if !(((reach + pad) * largest3(simd, steepness))[0] < TAME) {
        return Ready::Extreme;
    }
    let neighbours = length.simd_ge(length.slide::<1>(length)).to_bitmask();
    let ends = length.simd_ge(length.slide::<2>(length)).to_bitmask();
    let axes = AXES[MAIN[(neighbours & 3 | (ends & 1) << 2) as usize] as usize];
    let [kx, ky, kz] = axes.map(|axis| axis as usize);
    let shear = f32x4::simd_from(simd, [d[kx], d[ky], 1.0, 1.0]) / splat(d[kz]);
    let at = -(origin * recip);
    let pad = pad * steepness;
    let (near, far) = (at - pad, at + pad);
    let negative = recip.simd_lt(splat(0.0)).to_bitmask();
    let t_min = f32x8::splat(simd, if ray.t_min > 0.0 { ray.t_min } else { 0.0 });
    let first = |v: f32x4<S>| splat3(simd, [v[0], v[1], v[2]]);
    let slabs = SlabLanes {
        recip: first(recip),
        near: first(near),
        far: first(far),
        near_row: [
            PlaneRow::new(Third::A, negative & 1 != 0),
            PlaneRow::new(Third::B, negative & 2 != 0),
            PlaneRow::new(Third::C, negative & 4 != 0),
        ],
        t_min,
    };
    let edges = EdgeLanes {
        axes,
        origin: splat3(simd, [o[kx], o[ky], o[kz]]),
        shear: [f32x8::splat(simd, shear[0]), f32x8::splat(simd, shear[1])],
        recip: f32x8::splat(simd, shear[2]),
        t_min,
        simd: PhantomData,
    };
    let prepared = PreparedRay {
        origin: *o,
        dir: *d,
        t_min: t_min[0],
        t_max: ray.t_max,
        limit: ray.t_max,
        mask: u32::MAX,
        axes: [kx, ky, kz],
        shear: [shear[0], shear[1]],
        t_per_depth: 1.0 / f64::from(d[kz]),
        recip: [recip[0], recip[1], recip[2]],
        pad_floor: floor[0],
    };
    Ready::Tame(slabs, edges, prepared)
}
