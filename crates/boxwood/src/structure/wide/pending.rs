//! A closest hit in the making, and whether anything is hit: what becomes of a leaf's candidates.
//!
//! Candidates that single precision is sure of shorten the ray to the upper bound of their `t`, and wait; when the traversal is over, few of them
//! are left to be decided exactly. What it is not sure of is decided at once.

use super::form::{Form, Store};
use super::lanes::LeafTest;
use super::layout::Ref;
use super::ray::EdgeLanes;
use crate::geom::{Candidate, PreparedRay, Ray, Triangle};
use crate::prims::{Tested, Triangles};
use fearless_simd::{f32x8, mask32x8, prelude::*};

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

/// A ray that the exact test is asked for, rarely or once: made ready for it already, or when asked.
pub(super) trait Asked {
    /// `None` if it is no ray.
    fn prepared(&self) -> Option<PreparedRay>;
}

impl Asked for Ray {
    #[inline(always)]
    fn prepared(&self) -> Option<PreparedRay> {
        PreparedRay::new(self)
    }
}

impl Asked for PreparedRay {
    #[inline(always)]
    fn prepared(&self) -> Option<PreparedRay> {
        Some(*self)
    }
}

/// Leaves that may wait.
const ROOM: usize = 4;

/// The closest hit of one ray in the making.
#[derive(Clone, Copy)]
pub(super) struct Pending {
    pub(super) best: Best,
    len: u32,
    /// Leaves with their candidates, as bits.
    leaves: [(Ref, u32); ROOM],
    /// Where these are hit at the earliest.
    lower: [[f32; 8]; ROOM],
}

/// What is left to decide when the traversal is over.
pub(super) enum Left {
    /// Nothing.
    Decided,
    /// One triangle, which is hit for certain, and nothing else was: its leaf and lane.
    Only(Ref, u32),
    /// More.
    Several,
}

impl Pending {
    #[inline(always)]
    pub(super) const fn none(t_max: f32) -> Self {
        Self {
            best: Best::none(t_max),
            len: 0,
            leaves: [(Ref(0), 0); ROOM],
            lower: [[0.0; 8]; ROOM],
        }
    }

    /// Begins anew.
    #[inline(always)]
    pub(super) fn clear(&mut self, t_max: f32) {
        self.len = 0;
        self.best.prim = u32::MAX;
        self.best.candidate.t = t_max;
    }

    /// Takes in the candidates of a leaf. Nothing beyond `bound` matters; returns the new bound.
    #[inline(always)]
    #[expect(
        clippy::too_many_arguments,
        reason = "all that a leaf's candidates need"
    )]
    pub(super) fn consider<S: Simd, M: Form>(
        &mut self,
        simd: S,
        store: &Store<M>,
        ray: &impl Asked,
        leaf: Ref,
        test: &LeafTest<f32x8<S>>,
        edges: &EdgeLanes<S>,
        mut bound: f32,
    ) -> f32 {
        let depths = test.depths(simd, edges);
        let end = f32x8::splat(simd, bound);
        let beyond = depths.lower.simd_gt(end).to_bitmask() as u32;
        let unsure = depths.open & !depths.sure & !beyond;
        let sure = depths.sure & !beyond;
        if sure != 0 {
            if self.len as usize == ROOM {
                self.settle(store, ray, bound);
            }
            self.leaves[self.len as usize] = (leaf, sure);
            self.lower[self.len as usize] = depths.lower.into();
            self.len += 1;
            let sure = mask32x8::from_bitmask(simd, u64::from(sure));
            bound = sure.select(depths.upper, end).min(end).reduce_min();
        }
        if unsure != 0 {
            bound = self.decide_now(store, ray, leaf, unsure, bound);
        }
        bound
    }

    /// Decides what waits and is not beyond `bound`.
    #[inline(never)]
    pub(super) fn settle<M: Form>(&mut self, store: &Store<M>, ray: &impl Asked, bound: f32) {
        if self.len == 0 {
            return;
        }
        let Some(ray) = ray.prepared() else {
            return;
        };
        for i in 0..self.len as usize {
            let (leaf, mut mask) = self.leaves[i];
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize & 7;
                mask &= mask - 1;
                if self.lower[i][lane] <= bound {
                    self.decide(store, leaf, lane, &ray);
                }
            }
        }
        self.len = 0;
    }

    #[inline(always)]
    fn decide<M: Form>(&mut self, store: &Store<M>, leaf: Ref, lane: usize, ray: &PreparedRay) {
        let (found, prim) = exact(store, leaf, lane, ray);
        if let Some(candidate) = found {
            self.best.improve(candidate, prim);
        }
    }

    #[cold]
    fn decide_now<M: Form>(
        &mut self,
        store: &Store<M>,
        ray: &impl Asked,
        leaf: Ref,
        mut mask: u32,
        bound: f32,
    ) -> f32 {
        let Some(ray) = ray.prepared() else {
            return bound;
        };
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            self.decide(store, leaf, lane, &ray);
        }
        // Never minus zero: the slab test compares as integers.
        bound.min(self.best.candidate.t + 0.0)
    }

    /// What is left to decide. Usually there is one.
    #[inline(always)]
    pub(super) fn left<S: Simd>(&self, simd: S, bound: f32) -> Left {
        let (mut last, mut count) = ((Ref(0), 0), 0);
        for i in 0..self.len as usize {
            let near = f32x8::simd_from(simd, self.lower[i])
                .simd_le(f32x8::splat(simd, bound))
                .to_bitmask() as u32;
            let mask = self.leaves[i].1 & near;
            last = if mask != 0 {
                (self.leaves[i].0, mask)
            } else {
                last
            };
            count += mask.count_ones();
        }
        match count {
            0 => Left::Decided,
            1 if self.best.prim == u32::MAX => Left::Only(last.0, last.1.trailing_zeros()),
            _ => Left::Several,
        }
    }
}

/// One triangle of a leaf by the exact test, and which it is.
#[inline(always)]
pub(super) fn exact<M: Form>(
    store: &Store<M>,
    leaf: Ref,
    lane: usize,
    ray: &PreparedRay,
) -> (Option<Candidate>, u32) {
    let (corners, prim) = store.triangle(leaf, lane);
    let t = Triangle(corners);
    (
        Tested::new::<Triangles>(t.intersect(ray), || t.bounds(), ray).candidate,
        prim,
    )
}

/// True if any candidate of a leaf blocks the ray, whose range ends at `t_max`.
#[inline(always)]
pub(super) fn blocks<S: Simd, M: Form>(
    simd: S,
    store: &Store<M>,
    ray: &impl Asked,
    leaf: Ref,
    test: &LeafTest<f32x8<S>>,
    edges: &EdgeLanes<S>,
    t_max: f32,
) -> bool {
    let depths = test.depths(simd, edges);
    let t_max = f32x8::splat(simd, t_max);
    let before = depths.upper.simd_le(t_max).to_bitmask() as u32;
    if depths.sure & before != 0 {
        return true;
    }
    let beyond = depths.lower.simd_gt(t_max).to_bitmask() as u32;
    let unsure = depths.open & !beyond;
    unsure != 0 && any_exact(store, leaf, unsure, ray)
}

#[cold]
fn any_exact<M: Form>(store: &Store<M>, leaf: Ref, mut mask: u32, ray: &impl Asked) -> bool {
    let Some(ray) = ray.prepared() else {
        return false;
    };
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize;
        mask &= mask - 1;
        if exact(store, leaf, lane, &ray).0.is_some() {
            return true;
        }
    }
    false
}
