//! The leaves of a bundle's way: packets of its rays meet triangles.

use super::Wide;
use super::batch::Answers;
use super::bundle::Bundle;
use super::form::Form;
use super::lanes::{Depths, Floats, LeafTest, Planes, sheared, turned};
use super::layout::Ref;
use super::packet::{AXES, Beam, Columns, NONE, RAYS, load, store};
use super::pending::exact;
use crate::geom::{PreparedRay, Ray};
use crate::simd::{AxisRows, Third};
use core::ops::Range;
use fearless_simd::prelude::*;

/// More packets than there are with any width of registers.
pub(super) const PACKETS: usize = RAYS / 4;

/// Some rays of a packet that enter a leaf, or meet a triangle of it, or may.
#[derive(Clone, Copy)]
struct Meeting {
    packet: u8,
    lane: u8,
    rays: u16,
}

/// A list that is filled without a branch.
pub(super) struct List<const N: usize> {
    items: [Meeting; N],
    len: usize,
}

impl<const N: usize> List<N> {
    pub(super) const EMPTY: Self = Self {
        items: [Meeting {
            packet: 0,
            lane: 0,
            rays: 0,
        }; N],
        len: 0,
    };

    #[inline(always)]
    fn push_if(&mut self, real: bool, item: Meeting) {
        self.items[self.len & (N - 1)] = item;
        self.len += usize::from(real);
    }

    #[inline(always)]
    fn items(&self) -> &[Meeting] {
        &self.items[..self.len.min(N)]
    }
}

/// The packets that enter a leaf meet its triangles. True if anything was hit.
#[inline(always)]
#[expect(
    clippy::too_many_arguments,
    reason = "one step of `walk`, apart to be read"
)]
pub(super) fn visit_leaf<S: Simd, M: Form, F: Floats<S>, A: Answers>(
    simd: S,
    wide: &Wide<M>,
    bundle: &mut Bundle,
    rays: &[Ray; RAYS],
    leaf: Ref,
    planes: &Planes<F>,
    packets: Range<usize>,
    beam: &Beam<S>,
) -> bool {
    bundle.entered.len = 0;
    for p in packets {
        let rays = bundle.columns.enter(simd, p, planes) as u16;
        bundle.entered.push_if(
            rays != 0,
            Meeting {
                packet: p as u8,
                lane: 0,
                rays,
            },
        );
        bundle.worth.rays += rays.count_ones();
    }
    bundle.worth.leaves += 1;
    if bundle.entered.len == 0 {
        return false;
    }
    let mut any = false;
    for axis in 0..3 {
        if bundle.columns.along[axis] != 0 {
            match beam.origin {
                Some(origin) => meet::<S, M, F, true>(simd, wide, bundle, leaf, axis, origin),
                None => meet::<S, M, F, false>(simd, wide, bundle, leaf, axis, [0.0; 3]),
            }
            any |= settle::<S, M, F, A>(simd, wide, bundle, rays, leaf, axis);
        }
    }
    any
}

/// Lists which packets meet which triangles, as far as rays of one main axis go: whether they do cannot be guessed, so what follows from it
/// waits. From one origin (`SAME`), the corners are moved there once for all rays.
#[inline(always)]
fn meet<S: Simd, M: Form, F: Floats<S>, const SAME: bool>(
    simd: S,
    wide: &Wide<M>,
    bundle: &mut Bundle,
    leaf: Ref,
    axis: usize,
    origin: [f32; 3],
) {
    let Bundle {
        columns,
        entered,
        met,
        ..
    } = bundle;
    let [kx, ky, kz] = AXES[axis];
    let origin = [
        F::splat(simd, origin[kx]),
        F::splat(simd, origin[ky]),
        F::splat(simd, origin[kz]),
    ];
    met.len = 0;
    // Once for the leaf: to unpack it takes time in some forms.
    let mut room = M::LEAF_ROOM;
    let rows = rows(wide, leaf, axis, &mut room);
    for lane in 0..leaf.count() {
        let corners = corners::<S, F>(simd, rows, lane);
        let [a, b, c] = if SAME {
            [
                from(corners[0], origin),
                from(corners[1], origin),
                from(corners[2], origin),
            ]
        } else {
            corners
        };
        for of in entered.items() {
            let p = usize::from(of.packet);
            let ray = columns.edges::<S, F>(simd, p, axis);
            let corners = if SAME {
                [turned(a, &ray), turned(b, &ray), turned(c, &ray)]
            } else {
                [sheared(a, &ray), sheared(b, &ray), sheared(c, &ray)]
            };
            let along = (columns.along[axis] >> ((p * F::LEN) & 63)) as u32;
            let rays = LeafTest::new(simd, corners, u32::from(of.rays) & along).candidates as u16;
            met.push_if(
                rays != 0,
                Meeting {
                    packet: of.packet,
                    lane: lane as u8,
                    rays,
                },
            );
        }
    }
}

/// A corner as seen from an origin.
#[inline(always)]
fn from<S: Simd, F: Floats<S>>([x, y, z]: [F; 3], origin: [F; 3]) -> [F; 3] {
    [x - origin[0], y - origin[1], z - origin[2]]
}

/// The rows of a leaf, axes in the order for rays of one main axis.
#[inline(always)]
fn rows<'a, M: Form>(
    wide: &'a Wide<M>,
    leaf: Ref,
    axis: usize,
    room: &'a mut M::LeafRoom,
) -> [AxisRows<'a>; 3] {
    let rows = wide.store.leaf(leaf, room);
    let [kx, ky, kz] = super::ray::AXES[axis];
    [rows.axis(kx), rows.axis(ky), rows.axis(kz)]
}

/// The corners of a triangle in all lanes.
#[inline(always)]
fn corners<S: Simd, F: Floats<S>>(simd: S, rows: [AxisRows<'_>; 3], lane: usize) -> [[F; 3]; 3] {
    [
        corner(simd, rows, Third::A, lane),
        corner(simd, rows, Third::B, lane),
        corner(simd, rows, Third::C, lane),
    ]
}

#[inline(always)]
fn corner<S: Simd, F: Floats<S>>(
    simd: S,
    [x, y, z]: [AxisRows<'_>; 3],
    v: Third,
    lane: usize,
) -> [F; 3] {
    [
        F::splat(simd, x.corner(v)[lane & 7]),
        F::splat(simd, y.corner(v)[lane & 7]),
        F::splat(simd, z.corner(v)[lane & 7]),
    ]
}

/// Decides what was met. True if anything was hit.
#[inline(always)]
fn settle<S: Simd, M: Form, F: Floats<S>, A: Answers>(
    simd: S,
    wide: &Wide<M>,
    bundle: &mut Bundle,
    rays: &[Ray; RAYS],
    leaf: Ref,
    axis: usize,
) -> bool {
    let Bundle {
        columns,
        met,
        blocked,
        ..
    } = bundle;
    let mut any = false;
    let mut room = M::LEAF_ROOM;
    let rows = rows(wide, leaf, axis, &mut room);
    for of in met.items() {
        let packet = usize::from(of.packet);
        let target = Target {
            wide,
            leaf,
            lane: usize::from(of.lane),
            packet,
            first: packet * F::LEN,
        };
        let left = u32::from(of.rays) & !(*blocked >> (target.first & 63)) as u32;
        if A::ANY && left == 0 {
            continue;
        }
        let [a, b, c] = corners::<S, F>(simd, rows, target.lane);
        let ray = columns.edges::<S, F>(simd, packet, axis);
        let depths = LeafTest::new(
            simd,
            [sheared(a, &ray), sheared(b, &ray), sheared(c, &ray)],
            left,
        )
        .depths(simd, &ray);
        if A::ANY {
            let hit = target.block(simd, columns, rays, &depths);
            *blocked |= u64::from(hit) << (target.first & 63);
            any |= hit != 0;
        } else {
            any |= target.consider(simd, columns, rays, &depths);
        }
    }
    any
}

/// A triangle, and a packet that may meet it.
struct Target<'a, M> {
    wide: &'a Wide<M>,
    leaf: Ref,
    lane: usize,
    packet: usize,
    /// The packet's first ray.
    first: usize,
}

impl<M: Form> Target<'_, M> {
    /// Which rays are blocked; they take no further part.
    #[inline(always)]
    fn block<S: Simd, F: Floats<S>>(
        &self,
        simd: S,
        columns: &mut Columns,
        rays: &[Ray; RAYS],
        depths: &Depths<F>,
    ) -> u32 {
        let bound: F = load(simd, &columns.bound, self.packet);
        let before = depths.upper.simd_le(bound).to_bitmask() as u32;
        let beyond = depths.lower.simd_gt(bound).to_bitmask() as u32;
        let mut blocked = depths.sure & before;
        let unsure = depths.open & !beyond & !blocked;
        if unsure != 0 {
            blocked |= self.exactly(rays, unsure);
        }
        let mask = F::Mask::from_bitmask(simd, u64::from(blocked));
        store(
            mask.select(F::splat(simd, f32::NEG_INFINITY), bound),
            &mut columns.bound,
            self.packet,
        );
        blocked
    }

    /// Which of the rays hit.
    #[cold]
    fn exactly(&self, rays: &[Ray; RAYS], unsure: u32) -> u32 {
        let hit = |k: &usize| {
            unsure >> k & 1 != 0
                && PreparedRay::new(&rays[self.first + k]).is_some_and(|ray| {
                    exact(&self.wide.store, self.leaf, self.lane, &ray)
                        .0
                        .is_some()
                })
        };
        (0..16).filter(hit).fold(0, |mask, k| mask | 1 << k)
    }

    /// Rays whose hit here is for certain before all others remember it. What may be on either side of another hit, or of the
    /// end of the range, is decided exactly.
    #[inline(always)]
    fn consider<S: Simd, F: Floats<S>>(
        &self,
        simd: S,
        columns: &mut Columns,
        rays: &[Ray; RAYS],
        depths: &Depths<F>,
    ) -> bool {
        let p = self.packet;
        let bound: F = load(simd, &columns.bound, p);
        let lower: F = load(simd, &columns.lower, p);
        let open = depths.open & !(depths.lower.simd_gt(bound).to_bitmask() as u32);
        let clear = open & depths.sure & depths.upper.simd_lt(lower).to_bitmask() as u32;
        let mask = F::Mask::from_bitmask(simd, u64::from(clear));
        store(mask.select(depths.upper, bound), &mut columns.bound, p);
        store(mask.select(depths.lower, lower), &mut columns.lower, p);
        store(
            mask.select(
                F::splat(simd, f32::from_bits(self.leaf.0)),
                load(simd, &columns.leaf, p),
            ),
            &mut columns.leaf,
            p,
        );
        store(
            mask.select(
                F::splat(simd, f32::from_bits(self.lane as u32)),
                load(simd, &columns.lane, p),
            ),
            &mut columns.lane,
            p,
        );
        if open != clear {
            self.contest(columns, rays, open & !clear);
        }
        open != 0
    }

    /// Decides between this triangle and the hit so far by the definition.
    #[cold]
    fn contest(&self, columns: &mut Columns, rays: &[Ray; RAYS], mut contested: u32) {
        let store = &self.wide.store;
        while contested != 0 {
            let k = self.first + contested.trailing_zeros() as usize;
            contested &= contested - 1;
            let Some(ray) = PreparedRay::new(&rays[k]) else {
                continue;
            };
            let (Some(new), prim) = exact(store, self.leaf, self.lane, &ray) else {
                continue;
            };
            let (leaf, lane) = (columns.leaf[k].to_bits(), columns.lane[k].to_bits());
            if leaf != NONE
                && let (Some(old), old_prim) = exact(store, Ref(leaf), lane as usize, &ray)
                && (old.t, old_prim) < (new.t, prim)
            {
                (columns.lower[k], columns.bound[k]) = (old.t, old.t + 0.0);
                continue;
            }
            (columns.leaf[k], columns.lane[k]) = (
                f32::from_bits(self.leaf.0),
                f32::from_bits(self.lane as u32),
            );
            (columns.lower[k], columns.bound[k]) = (new.t, new.t + 0.0);
        }
    }
}
