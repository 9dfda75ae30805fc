//! A ray made ready for rows of eight boxes and eight triangles.

use crate::geom::{Aabb, PreparedRay};
use crate::simd::{PlaneRow, Third};
use fearless_simd::{f32x8, prelude::*};
use std::marker::PhantomData;

/// Constants of the slab test in fused form: `plane * recip + near` and `plane * recip + far`.
#[derive(Clone, Copy)]
pub(super) struct SlabConstants {
    pub(super) recip: [f32; 3],
    pub(super) near: [f32; 3],
    pub(super) far: [f32; 3],
    /// Row of the near plane along each axis; the far one is this `^ 1`.
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
        let pad = reach * (1.0 / (1 << 19) as f32) + 2.0 * ray.pad_floor;
        let [rx, ry, rz] = ray.recip;
        let (ax, ay, az) = (rx.abs(), ry.abs(), rz.abs());
        if !((reach + pad) * fmax(ax, fmax(ay, az)) < 1e38) {
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
        let splat = |v: [f32; 3]| {
            [
                f32x8::splat(simd, v[0]),
                f32x8::splat(simd, v[1]),
                f32x8::splat(simd, v[2]),
            ]
        };
        Self {
            recip: splat(c.recip),
            near: splat(c.near),
            far: splat(c.far),
            near_row: c.near_row,
            t_min: f32x8::splat(simd, t_min),
        }
    }
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

impl<S: Simd> EdgeLanes<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, ray: &PreparedRay) -> Self {
        let [kx, ky, kz] = ray.axes;
        let splat = |x: f32| f32x8::splat(simd, x);
        Self {
            axes: match kz {
                0 => [Third::B, Third::C, Third::A],
                1 => [Third::C, Third::A, Third::B],
                _ => [Third::A, Third::B, Third::C],
            },
            origin: [
                splat(ray.origin[kx]),
                splat(ray.origin[ky]),
                splat(ray.origin[kz]),
            ],
            shear: [splat(ray.shear[0]), splat(ray.shear[1])],
            recip: splat(ray.t_per_depth as f32),
            t_min: splat(ray.t_min),
            simd: PhantomData,
        }
    }
}
