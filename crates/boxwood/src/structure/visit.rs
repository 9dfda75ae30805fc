//! The three questions as visitors of a traversal.

use crate::geom::{Candidate, Hit, PreparedRay};
use crate::prims::{Primitives, Tested};
use crate::query::{Observer, PrimitiveTest, PrimitiveVerdict};
use std::ops::ControlFlow;

/// What a traversal reports to.
pub trait Visit {
    /// True if it pays to go front to back.
    const IN_ORDER: bool = true;

    /// Nothing beyond this matters any more.
    fn t_max(&self) -> f32;

    /// Where the primitive in this slot lies in memory, to be fetched ahead.
    fn address(&self, slot: u32) -> *const u8;

    /// The ray may hit the primitives in these slots. `Break` ends the traversal.
    fn leaf(&mut self, slots: impl Iterator<Item = u32>) -> ControlFlow<()>;

    /// Who watches: told of each volume and cell by the structure, of each primitive by the visitor.
    fn observer(&mut self) -> &mut impl Observer;
}

/// What every visitor knows: the primitives in slot order, their numbers, the ray, who watches.
pub(crate) struct Asked<'a, P, O> {
    pub(crate) prims: &'a P,
    pub(crate) ids: &'a [u32],
    pub(crate) ray: &'a PreparedRay,
    pub(crate) observer: &'a mut O,
}

impl<P: Primitives, O: Observer> Asked<'_, P, O> {
    /// Tests one primitive; `judge` says what the candidate means.
    #[inline]
    fn test(
        &mut self,
        slot: u32,
        judge: impl FnOnce(&Candidate, u32) -> PrimitiveVerdict,
    ) -> Option<(Candidate, u32)> {
        let Tested {
            candidate,
            flops,
            bytes,
        } = Tested::of(self.prims, slot as usize, self.ray);
        let prim = self.ids[slot as usize];
        let verdict = candidate
            .as_ref()
            .map_or(PrimitiveVerdict::Miss, |c| judge(c, prim));
        self.observer.primitive(PrimitiveTest {
            prim,
            candidate,
            verdict,
            flops,
            bytes,
        });
        candidate
            .filter(|_| verdict == PrimitiveVerdict::Closest)
            .map(|c| (c, prim))
    }
}

/// A hit before the scene knows which of its meshes the primitive belongs to.
#[inline]
pub(crate) fn hit(candidate: Candidate, prim: u32) -> Hit {
    let Candidate { t, u, v } = candidate;
    Hit {
        t,
        u,
        v,
        prim,
        geom: 0,
        inst: Hit::NO_INSTANCE,
    }
}

/// In the order of [`Hit::order`], each once: a primitive, or an instance, may have been asked twice.
pub(super) fn sort_once(hits: &mut Vec<Hit>) {
    hits.sort_unstable_by(Hit::order);
    // Copies of a hit are equal in all, hence neighbours.
    hits.dedup_by_key(|hit| (hit.inst, hit.geom, hit.prim));
}

/// Finds the smallest `(t, primitive)`.
pub struct ClosestHit<'a, P, O> {
    pub(crate) asked: Asked<'a, P, O>,
    best: Candidate,
    prim: u32,
}

impl<'a, P: Primitives, O: Observer> ClosestHit<'a, P, O> {
    pub(crate) fn new(asked: Asked<'a, P, O>) -> Self {
        let best = Candidate {
            t: asked.ray.t_max,
            u: 0.0,
            v: 0.0,
        };
        Self {
            asked,
            best,
            prim: u32::MAX,
        }
    }

    pub(crate) fn answer(self) -> Option<Hit> {
        (self.prim != u32::MAX).then(|| hit(self.best, self.prim))
    }
}

impl<P: Primitives, O: Observer> Visit for ClosestHit<'_, P, O> {
    #[inline(always)]
    fn address(&self, slot: u32) -> *const u8 {
        self.asked.prims.address(slot as usize)
    }

    #[inline]
    fn t_max(&self) -> f32 {
        self.best.t
    }

    #[inline]
    fn leaf(&mut self, slots: impl Iterator<Item = u32>) -> ControlFlow<()> {
        for slot in slots {
            let (best_t, best_prim) = (self.best.t, self.prim);
            let closer = |c: &Candidate, prim| {
                if c.t < best_t || (c.t == best_t && prim < best_prim) {
                    PrimitiveVerdict::Closest
                } else {
                    PrimitiveVerdict::Farther
                }
            };
            if let Some(found) = self.asked.test(slot, closer) {
                (self.best, self.prim) = found;
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn observer(&mut self) -> &mut impl Observer {
        &mut *self.asked.observer
    }
}

/// Stops at any hit.
pub struct Occluded<'a, P, O> {
    pub(crate) asked: Asked<'a, P, O>,
    pub(crate) found: bool,
}

impl<P: Primitives, O: Observer> Visit for Occluded<'_, P, O> {
    #[inline(always)]
    fn address(&self, slot: u32) -> *const u8 {
        self.asked.prims.address(slot as usize)
    }

    const IN_ORDER: bool = false;

    #[inline]
    fn t_max(&self) -> f32 {
        self.asked.ray.t_max
    }

    #[inline]
    fn leaf(&mut self, slots: impl Iterator<Item = u32>) -> ControlFlow<()> {
        for slot in slots {
            if self
                .asked
                .test(slot, |_, _| PrimitiveVerdict::Closest)
                .is_some()
            {
                self.found = true;
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn observer(&mut self) -> &mut impl Observer {
        &mut *self.asked.observer
    }
}

/// Collects every hit. A structure may hand out a primitive twice; the answer has it once.
pub struct AllHits<'a, P, O> {
    pub(crate) asked: Asked<'a, P, O>,
    pub(crate) hits: &'a mut Vec<Hit>,
}

impl<P: Primitives, O: Observer> AllHits<'_, P, O> {
    pub(crate) fn finish(self) {
        sort_once(self.hits);
    }
}

impl<P: Primitives, O: Observer> Visit for AllHits<'_, P, O> {
    #[inline(always)]
    fn address(&self, slot: u32) -> *const u8 {
        self.asked.prims.address(slot as usize)
    }

    const IN_ORDER: bool = false;

    #[inline]
    fn t_max(&self) -> f32 {
        self.asked.ray.t_max
    }

    #[inline]
    fn leaf(&mut self, slots: impl Iterator<Item = u32>) -> ControlFlow<()> {
        for slot in slots {
            if let Some((candidate, prim)) = self.asked.test(slot, |_, _| PrimitiveVerdict::Closest)
            {
                self.hits.push(hit(candidate, prim));
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn observer(&mut self) -> &mut impl Observer {
        &mut *self.asked.observer
    }
}
