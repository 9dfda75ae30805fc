//! Merging clusters with their nearest neighbours along the curve.
//!
//! Meister and Bittner, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction", TVCG 2018; Benthin
//! et al., "H-PLOC: Hierarchical Parallel Locally-Ordered Clustering", 2024.

use super::super::fragment::{Fragment, Lanes};
use super::super::input::{LeafRule, filled, room};
use crate::error::BuildError;
use fearless_simd::{f32x8, i32x8, mask32x8, prelude::*};
use std::hint::select_unpredictable;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// How far along the curve a neighbour may be, on either side.
const RADIUS: usize = 8;
const LANES: usize = 8;
/// Room for boxes before and after all clusters that are nobody's nearest.
const MARGIN: usize = RADIUS + LANES;

/// All merges. A node below `leaves` is a fragment, others are merges. Which merge has which number depends on the threads;
/// the tree does not.
pub(super) struct Merges {
    leaves: u32,
    pairs: Vec<[AtomicU32; 2]>,
    next: AtomicU32,
}

/// Bit of the first child of a merge whose fragments had better be one leaf.
const LEAF: u32 = 1 << 31;

/// Most fragments: there are fewer than twice as many nodes, whose numbers leave [`LEAF`] free.
pub(super) const MAX_FRAGMENTS: usize = 1 << 30;

impl Merges {
    pub(super) fn new(leaves: usize) -> Result<Self, BuildError> {
        let mut pairs = room(leaves)?;
        pairs.resize_with(leaves, Default::default);
        Ok(Self {
            leaves: leaves as u32,
            pairs,
            next: AtomicU32::new(0),
        })
    }

    /// How many merges there are.
    pub(super) fn made(&self) -> usize {
        self.next.load(Relaxed) as usize
    }

    /// The children of a node and whether it had better be a leaf; `None` for a fragment.
    pub(super) fn children(&self, node: u32) -> Option<([u32; 2], bool)> {
        let pair = self.pairs.get(node.checked_sub(self.leaves)? as usize)?;
        let [a, b] = [&pair[0], &pair[1]].map(|child| child.load(Relaxed));
        Some(([a & !LEAF, b], a & LEAF != 0))
    }
}

/// Clusters in the order of the curve, boxes by coordinate: `-min` along each axis, then `max`.
pub(super) struct Clusters {
    bounds: [Vec<f32>; 6],
    node: Vec<u32>,
    count: Vec<u32>,
    cost: Vec<f32>,
    nearest: Vec<u32>,
    fresh: Vec<[u32; 2]>,
    len: usize,
}

impl Clusters {
    /// One cluster per fragment. `places` says where each of them lies among all, `scale` makes coordinates small enough
    /// for areas.
    pub(super) fn new(
        fragments: &[Fragment],
        places: &[u64],
        scale: f32,
        rule: &LeafRule,
        first: u32,
    ) -> Result<Self, BuildError> {
        let len = places.len();
        let mut clusters = Self::empty(len)?;
        clusters.len = len;
        for (i, &place) in places.iter().enumerate() {
            let [a, b, c, _, x, y, z, _] = fragments[place as usize].0;
            for (to, from) in clusters.bounds.iter_mut().zip([a, b, c, x, y, z]) {
                to[MARGIN + i] = from * scale;
            }
            let area = clusters.area(i);
            clusters.node[i] = first + i as u32;
            clusters.count[i] = 1;
            clusters.cost[i] = area * rule.cost.of(1);
        }
        Ok(clusters)
    }

    fn empty(len: usize) -> Result<Self, BuildError> {
        let mut bounds = [const { Vec::new() }; 6];
        for axis in &mut bounds {
            *axis = filled(FAR, len + 2 * MARGIN)?;
        }
        Ok(Self {
            bounds,
            node: filled(0, len)?,
            count: filled(0, len)?,
            cost: filled(0.0, len)?,
            nearest: filled(0, len + LANES)?,
            fresh: filled([0; 2], len / 2 + 1)?,
            len: 0,
        })
    }

    /// Both, one after the other.
    pub(super) fn joined(parts: [Self; 2]) -> Result<Self, BuildError> {
        let mut all = Self::empty(parts[0].len + parts[1].len)?;
        for part in parts {
            let (at, end) = (all.len, all.len + part.len);
            for (to, from) in all.bounds.iter_mut().zip(&part.bounds) {
                to[MARGIN + at..MARGIN + end].copy_from_slice(&from[MARGIN..MARGIN + part.len]);
            }
            all.node[at..end].copy_from_slice(&part.node[..part.len]);
            all.count[at..end].copy_from_slice(&part.count[..part.len]);
            all.cost[at..end].copy_from_slice(&part.cost[..part.len]);
            all.len = end;
        }
        Ok(all)
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// The node of the only cluster.
    pub(super) fn root(&self) -> u32 {
        self.node[0]
    }

    /// Merges until at most `target` are left, at least 1.
    pub(super) fn reduce<S: Simd>(
        &mut self,
        simd: S,
        target: usize,
        rule: &LeafRule,
        merges: &Merges,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                while self.len > target.max(1) {
                    self.find_nearest(simd);
                    self.merge(rule, merges);
                }
            },
        );
    }

    /// One round of [`Clusters::reduce`], for explaining.
    pub(super) fn reduce_once<S: Simd>(&mut self, simd: S, rule: &LeafRule, merges: &Merges) {
        self.find_nearest(simd);
        self.merge(rule, merges);
    }

    /// For each cluster the one with which it has the smallest box. Of equals the one beside it in an even pair (2, 3), else
    /// the first: among all pairs of the smallest box one is mutual, and where all boxes are equal half of them are.
    #[inline(always)]
    fn find_nearest<S: Simd>(&mut self, simd: S) {
        let end = self.len + 2 * MARGIN;
        let [a, b, c, x, y, z] = &self.bounds;
        let bounds = [
            &a[..end],
            &b[..end],
            &c[..end],
            &x[..end],
            &y[..end],
            &z[..end],
        ];
        let [before, behind] =
            [RADIUS as i32 - 1, RADIUS as i32 + 1].map(|o| i32x8::splat(simd, o));
        let is_even = mask32x8::from_bitmask(simd, 0x55);
        for i in (0..self.len).step_by(LANES) {
            let own = load(simd, &bounds, MARGIN + i);
            let from = MARGIN + i - RADIUS;
            let area_before = area_with(&own, &load(simd, &bounds, from + RADIUS - 1));
            let area_behind = area_with(&own, &load(simd, &bounds, from + RADIUS + 1));
            let mut nearest = Nearest {
                area: is_even.select(area_behind, area_before),
                offset: is_even.select(behind, before),
            };
            for offset in 0..RADIUS - 1 {
                let area = area_with(&own, &load(simd, &bounds, from + offset));
                nearest.meet(area, i32x8::splat(simd, offset as i32));
            }
            nearest.meet(
                is_even.select(area_before, area_behind),
                is_even.select(before, behind),
            );
            for offset in RADIUS + 2..2 * RADIUS + 1 {
                let area = area_with(&own, &load(simd, &bounds, from + offset));
                nearest.meet(area, i32x8::splat(simd, offset as i32));
            }
            let offsets = nearest.offset.to_array();
            for lane in 0..LANES {
                // Lanes behind the last cluster may wrap, and are not read.
                let place = (i + lane) as u32;
                self.nearest[i + lane] = place
                    .wrapping_add(offsets[lane] as u32)
                    .wrapping_sub(RADIUS as u32);
            }
        }
    }

    /// Merges the clusters that are each other's nearest. Without branches: which ones those are cannot be guessed.
    #[inline(always)]
    fn merge(&mut self, rule: &LeafRule, merges: &Merges) {
        let len = self.len;
        let merged = (0..len).filter(|&i| self.partner(i) > i).count();
        let first = merges.next.fetch_add(merged as u32, Relaxed);
        let (mut to, mut fresh) = (0, 0);
        for i in 0..len {
            let partner = self.partner(i);
            let is_merge = partner > i;
            for axis in &mut self.bounds {
                let (a, b) = (axis[MARGIN + i], axis[MARGIN + partner]);
                axis[MARGIN + to] = if a > b { a } else { b };
            }
            let area = self.area(to);
            let count = self.count[i] + self.count[partner];
            let split = area * rule.node_cost + self.cost[i] + self.cost[partner];
            let leaf = area * rule.cost.of(count);
            let is_leaf = (count <= rule.max) & (leaf <= split);
            let mark = select_unpredictable(is_leaf, LEAF, 0);
            self.fresh[fresh] = [self.node[i] | mark, self.node[partner]];
            let cost = select_unpredictable(is_leaf, leaf, split);
            self.node[to] =
                select_unpredictable(is_merge, merges.leaves + first + fresh as u32, self.node[i]);
            self.count[to] = select_unpredictable(is_merge, count, self.count[i]);
            self.cost[to] = select_unpredictable(is_merge, cost, self.cost[i]);
            fresh += usize::from(is_merge);
            // The second of a pair is written over.
            to += usize::from(partner >= i);
        }
        let pairs = &merges.pairs[first as usize..];
        for (pair, fresh) in pairs.iter().zip(&self.fresh[..merged]) {
            pair[0].store(fresh[0], Relaxed);
            pair[1].store(fresh[1], Relaxed);
        }
        for axis in &mut self.bounds {
            axis[MARGIN + to..MARGIN + len].fill(FAR);
        }
        self.len = to;
    }

    /// The cluster that this one is merged with, or itself.
    #[inline(always)]
    fn partner(&self, i: usize) -> usize {
        let other = self.nearest[i] as usize;
        select_unpredictable(self.nearest[other] as usize == i, other, i)
    }

    #[inline(always)]
    fn area(&self, i: usize) -> f32 {
        let side = |k: usize| self.bounds[k][MARGIN + i] + self.bounds[k + 3][MARGIN + i];
        let [x, y, z] = [side(0), side(1), side(2)];
        x * (y + z) + y * z
    }
}

/// The best neighbours of eight clusters so far.
struct Nearest<S: Simd> {
    area: f32x8<S>,
    offset: i32x8<S>,
}

impl<S: Simd> Nearest<S> {
    #[inline(always)]
    fn meet(&mut self, area: f32x8<S>, offset: i32x8<S>) {
        let is_less = area.simd_lt(self.area);
        self.area = is_less.select(area, self.area);
        self.offset = is_less.select(offset, self.offset);
    }
}

/// Half the area of the box around both, for eight pairs.
#[inline(always)]
fn area_with<S: Simd>(own: &[f32x8<S>; 6], other: &[f32x8<S>; 6]) -> f32x8<S> {
    let x = own[0].max(other[0]) + own[3].max(other[3]);
    let y = own[1].max(other[1]) + own[4].max(other[4]);
    let z = own[2].max(other[2]) + own[5].max(other[5]);
    x * (y + z) + y * z
}

/// Eight boxes, from one place on. Written out: a closure over the axes would not be inlined.
#[inline(always)]
fn load<S: Simd>(simd: S, bounds: &[&[f32]; 6], at: usize) -> [f32x8<S>; 6] {
    [
        f32x8::from_slice(simd, &bounds[0][at..at + LANES]),
        f32x8::from_slice(simd, &bounds[1][at..at + LANES]),
        f32x8::from_slice(simd, &bounds[2][at..at + LANES]),
        f32x8::from_slice(simd, &bounds[3][at..at + LANES]),
        f32x8::from_slice(simd, &bounds[4][at..at + LANES]),
        f32x8::from_slice(simd, &bounds[5][at..at + LANES]),
    ]
}

/// Faces of a box in the margin: larger than any other.
const FAR: f32 = 1e18;

/// What makes coordinates at most 1, exactly.
pub(super) fn scale_of(all: &Lanes) -> f32 {
    let largest = all.0[..3]
        .iter()
        .chain(&all.0[4..7])
        .fold(0.0f32, |m, x| m.max(x.abs()));
    // The exponent alone, so that products are exact.
    let power = f32::from_bits(largest.to_bits() & 0x7F80_0000);
    if power > 0.0 { 0.5 / power } else { 1.0 }
}
