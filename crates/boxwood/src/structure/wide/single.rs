//! One ray at a time.

use super::batch::least;
use super::lanes::{boxes, candidates, leaf_test};
use super::layout::{Ref, triangle};
use super::ray::{EdgeLanes, SlabConstants, SlabLanes};
use super::{STACK, Wide};
use crate::geom::{Candidate, PreparedRay, Triangle};
use crate::prims::{Tested, Triangles};
use crate::query::NoObserver;
use crate::simd::{Arena, RowStack, Stack, prefetch};
use fearless_simd::{f32x8, i32x8, prelude::*};

/// The smallest `(t, primitive)` so far.
#[derive(Clone, Copy)]
pub(super) struct Best {
    pub(super) candidate: Candidate,
    /// `u32::MAX` if there is none.
    pub(super) prim: u32,
}

impl Best {
    /// Nothing yet; nothing beyond `t_max` will do.
    #[inline(always)]
    pub(super) const fn none(t_max: f32) -> Self {
        Self {
            candidate: Candidate {
                t: t_max,
                u: 0.0,
                v: 0.0,
            },
            prim: u32::MAX,
        }
    }

    /// Of a ray of which no more is known than whether it is blocked.
    #[inline(always)]
    pub(super) const fn blocked(is: bool) -> Self {
        let prim = if is { 0 } else { u32::MAX };
        Self {
            prim,
            ..Self::none(0.0)
        }
    }

    /// True if the candidate is the new best.
    #[inline(always)]
    pub(super) fn improve(&mut self, candidate: Candidate, prim: u32) -> bool {
        let best = self.candidate.t;
        let better = candidate.t < best || (candidate.t == best && prim < self.prim);
        if better {
            *self = Self { candidate, prim };
        }
        better
    }
}

#[inline(always)]
pub(super) fn exact(
    arena: &Arena,
    leaf: Ref,
    lane: usize,
    ray: &PreparedRay,
) -> (Option<Candidate>, u32) {
    let (corners, prim) = triangle(arena, leaf, lane);
    let t = Triangle(corners);
    (
        Tested::new::<Triangles>(t.intersect(ray), || t.bounds(), ray).candidate,
        prim,
    )
}

/// A closest hit in the making. Leaves with candidates wait here to be decided exactly when the traversal is over.
struct Search<'a, S: Simd> {
    arena: &'a Arena,
    ray: &'a PreparedRay,
    edges: EdgeLanes<S>,
    best: Best,
    bound: f32,
    leaves: [(Ref, u32); PENDING],
    lower: [[f32; 8]; PENDING],
    len: usize,
}
const PENDING: usize = 4;

impl<S: Simd> Search<'_, S> {
    #[inline(never)]
    fn settle(&mut self) {
        for i in 0..self.len {
            let (leaf, mut mask) = self.leaves[i];
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize & 7;
                mask &= mask - 1;
                if self.lower[i][lane] <= self.bound {
                    self.decide(leaf, lane);
                }
            }
        }
        self.len = 0;
    }

    #[inline(always)]
    fn decide(&mut self, leaf: Ref, lane: usize) {
        let (found, prim) = exact(self.arena, leaf, lane, self.ray);
        if let Some(candidate) = found {
            self.best.improve(candidate, prim);
        }
    }

    #[cold]
    fn decide_now(&mut self, leaf: Ref, mut mask: u32) {
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            self.decide(leaf, lane);
        }
        if self.best.candidate.t < self.bound {
            self.bound = self.best.candidate.t + 0.0;
        }
    }
}

#[inline(never)]
fn consider<S: Simd>(simd: S, search: &mut Search<'_, S>, leaf: Ref) {
    simd.vectorize(
        #[inline(always)]
        || {
            let test = leaf_test(simd, search.arena, leaf, &search.edges);
            let depths = test.depths(simd, &search.edges);
            let bound = f32x8::splat(simd, search.bound);
            let beyond = depths.lower.simd_gt(bound).to_bitmask() as u32;
            let unsure = depths.open & !depths.sure & !beyond;
            let sure = depths.sure & !beyond;
            if sure != 0 {
                if search.len == PENDING {
                    search.settle();
                }
                search.leaves[search.len] = (leaf, sure);
                search.lower[search.len] = depths.lower.into();
                search.len += 1;
                let sure = fearless_simd::mask32x8::from_bitmask(simd, u64::from(sure));
                search.bound = sure.select(depths.upper, bound).min(bound).reduce_min();
            }
            if unsure != 0 {
                search.decide_now(leaf, unsure);
            }
        },
    );
}

#[cold]
fn any_exact(arena: &Arena, leaf: Ref, mut mask: u32, ray: &PreparedRay) -> bool {
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize;
        mask &= mask - 1;
        if exact(arena, leaf, lane, ray).0.is_some() {
            return true;
        }
    }
    false
}

#[inline(never)]
fn blocks<S: Simd>(
    simd: S,
    arena: &Arena,
    leaf: Ref,
    ray: &PreparedRay,
    edges: &EdgeLanes<S>,
) -> bool {
    simd.vectorize(
        #[inline(always)]
        || {
            let test = leaf_test(simd, arena, leaf, edges);
            let depths = test.depths(simd, edges);
            let t_max = f32x8::splat(simd, ray.t_max);
            let before = depths.upper.simd_le(t_max).to_bitmask() as u32;
            if depths.sure & before != 0 {
                return true;
            }
            let beyond = depths.lower.simd_gt(t_max).to_bitmask() as u32;
            let unsure = depths.open & !beyond;
            unsure != 0 && any_exact(arena, leaf, unsure, ray)
        },
    )
}

#[inline(always)]
pub(super) fn closest<S: Simd>(simd: S, wide: &Wide, ray: &PreparedRay) -> Best {
    let Some(root) = wide.root else {
        return Best::none(0.0);
    };
    let Some(slabs) = SlabConstants::new(ray, wide.size) else {
        return wide.closest_walked(ray, &mut NoObserver);
    };
    let arena = &wide.arena;
    // Minus zero becomes zero here and below: the slab test compares as integers.
    let t_end = ray.t_max + 0.0;
    let lanes = SlabLanes::new(simd, &slabs, ray.t_min);
    let mut search = Search {
        arena,
        ray,
        edges: EdgeLanes::new(simd, ray),
        best: Best::none(ray.t_max),
        bound: t_end,
        leaves: [(Ref(0), 0); PENDING],
        lower: [[0.0; 8]; PENDING],
        len: 0,
    };
    let mut stack = RowStack::<STACK>::new();
    let mut at = root;
    let mut t_max = f32x8::splat(simd, t_end);
    'all: loop {
        if at.is_leaf() {
            let found = candidates(simd, arena, at, &search.edges);
            if found != 0 {
                consider(simd, &mut search, at);
                t_max = f32x8::splat(simd, search.bound);
            }
        } else {
            let node = arena.node(at.granule());
            let (mask, enter) = boxes(simd, node, &lanes, t_max);
            let (hit, mask) = (mask, mask.to_bitmask() as u32);
            let child = |lane: usize| node.refs()[lane & 7];
            if mask != 0 {
                if mask & (mask - 1) == 0 {
                    let refs = node.refs();
                    macro_rules! only { ($($lane:literal)*) => { $(if mask == 1 << $lane { at = Ref(refs[$lane]); } else)* { unreachable!() } } }
                    only!(0 1 2 3 4 5 6 7);
                    continue;
                }
                // The nearest goes on, the others wait in any order.
                let numbers = i32x8::simd_from(simd, [0, 1, 2, 3, 4, 5, 6, 7]);
                let key = hit.select(
                    (enter & i32x8::splat(simd, !7)) | numbers,
                    i32x8::splat(simd, i32::MAX),
                );
                let nearest = least(simd, key);
                let others = key.simd_gt(nearest) & hit;
                let refs = fearless_simd::u32x8::simd_from(simd, *node.refs());
                stack.push(
                    refs.compress(others).into(),
                    enter.compress(others).bitcast::<f32x8<S>>().into(),
                    mask.count_ones() as usize - 1,
                );
                let lane = nearest[0] & 7;
                let refs = node.refs();
                macro_rules! is { ($($lane:literal)*) => { $(if lane == $lane { at = Ref(refs[$lane]); } else)* { at = Ref(refs[7]); } } }
                is!(0 1 2 3 4 5 6);
                if wide.fetch {
                    let mut waiting = others.to_bitmask() as u32;
                    while waiting != 0 {
                        let place =
                            arena.address(Ref(child(waiting.trailing_zeros() as usize)).granule());
                        waiting &= waiting - 1;
                        (0..4).for_each(|line| prefetch(place.wrapping_add(64 * line)));
                    }
                }
                continue;
            }
        }
        loop {
            let Some((below, near)) = stack.pop() else {
                break 'all;
            };
            if near <= search.bound {
                at = Ref(below);
                break;
            }
        }
    }
    if search.len > 0 {
        search.settle();
    }
    search.best
}

#[inline(always)]
pub(super) fn occluded<S: Simd>(simd: S, wide: &Wide, ray: &PreparedRay) -> bool {
    let Some(root) = wide.root else {
        return false;
    };
    let Some(slabs) = SlabConstants::new(ray, wide.size) else {
        return wide.occluded_walked(ray, &mut NoObserver);
    };
    let arena = &wide.arena;
    let lanes = SlabLanes::new(simd, &slabs, ray.t_min);
    let edges = EdgeLanes::new(simd, ray);
    let mut memory = Stack::memory::<STACK>();
    let mut stack = Stack::<u32>::new(&mut memory);
    let mut at = root;
    let t_max = f32x8::splat(simd, ray.t_max + 0.0);
    loop {
        if at.is_leaf() {
            if candidates(simd, arena, at, &edges) != 0 && blocks(simd, arena, at, ray, &edges) {
                return true;
            }
        } else {
            let node = arena.node(at.granule());
            let (mask, _) = boxes(simd, node, &lanes, t_max);
            let mut mask = mask.to_bitmask() as u32;
            let child = |lane: usize| node.refs()[lane & 7];
            if mask != 0 {
                let refs = node.refs();
                // Branches, not a computed lane: where they are guessed, the next node is read before this test has ended.
                macro_rules! first { ($($lane:literal)*) => { $(if mask & (1 << $lane) != 0 { at = Ref(refs[$lane]); mask &= !(1 << $lane); } else)* { unreachable!() } } }
                first!(0 1 2 3 4 5 6 7);
                while mask != 0 {
                    stack.push(child(mask.trailing_zeros() as usize));
                    mask &= mask - 1;
                }
                continue;
            }
        }
        let Some(next) = stack.pop() else {
            return false;
        };
        at = Ref(next);
    }
}
