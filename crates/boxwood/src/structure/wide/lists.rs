//! What is made of all hits of many rays: lists, or numbers alone.

use super::Wide;
use super::batch::Answers;
use super::every::Certain;
use super::finish::{Finished, evaluate};
use super::form::Form;
use super::pending::Best;
use crate::geom::{Candidate, Hit, Ray};
use crate::structure::visit::hit;
use fearless_simd::prelude::*;

/// Every hit, and whose it is.
pub(super) struct Lists {
    found: Vec<(usize, Best)>,
    queue: [Finished; 8],
    count: usize,
}

impl Lists {
    pub(super) const NEW: Self = Self {
        found: Vec::new(),
        queue: [Finished::NONE; 8],
        count: 0,
    };

    /// Evaluates what waits.
    #[inline(never)]
    fn flush<S: Simd, M: Form>(&mut self, simd: S, wide: &Wide<M>, rays: &[Ray]) {
        simd.vectorize(
            #[inline(always)]
            || {
                for k in self.count..8 {
                    self.queue[k] = self.queue[0];
                }
                let mut best = [Best::none(0.0); 8];
                let good = evaluate(simd, &wide.store, rays, &self.queue, &mut best);
                for k in 0..self.count {
                    if good >> k & 1 == 1 {
                        self.found.push((self.queue[k].ray, best[k]));
                    }
                }
                self.count = 0;
            },
        );
    }

    /// Appends the hits to `hits`, ray by ray and sorted, and how many each ray has to `counts`.
    pub(super) fn give(self, hits: &mut Vec<Hit>, counts: &mut [u32]) {
        counts.fill(0);
        for (ray, _) in &self.found {
            counts[*ray] += 1;
        }
        let first = hits.len();
        let mut ends: Vec<usize> = counts
            .iter()
            .scan(first, |end, count| {
                let start = *end;
                *end += *count as usize;
                Some(start)
            })
            .collect();
        let nothing = hit(Best::none(0.0).candidate, 0);
        hits.resize(first + self.found.len(), nothing);
        for (ray, best) in self.found {
            hits[ends[ray]] = hit(best.candidate, best.prim);
            ends[ray] += 1;
        }
        let mut start = first;
        let mut kept = first;
        for (end, count) in ends.into_iter().zip(counts) {
            hits[start..end].sort_unstable_by(Hit::order);
            let before = kept;
            for k in start..end {
                // A primitive that was split has equal hits, hence neighbours.
                if k == start || hits[k].prim != hits[k - 1].prim {
                    hits[kept] = hits[k];
                    kept += 1;
                }
            }
            *count = (kept - before) as u32;
            start = end;
        }
        hits.truncate(kept);
    }
}

impl Answers for Lists {
    const ANY: bool = true;
    const ALL: bool = true;

    #[inline(always)]
    fn certain<S: Simd, M: Form>(&mut self, simd: S, found: &Certain<'_, M>) {
        let mut lanes = found.lanes;
        while lanes != 0 {
            self.queue[self.count & 7] = Finished {
                record: *found.record,
                ray: found.ray,
                leaf: found.leaf,
                lane: lanes.trailing_zeros() & 7,
            };
            lanes &= lanes - 1;
            self.count += 1;
            if self.count == 8 {
                self.flush(simd, found.wide, found.rays);
            }
        }
    }

    fn decided(&mut self, ray: usize, candidate: Candidate, prim: u32) {
        self.found.push((ray, Best { candidate, prim }));
    }

    #[inline(always)]
    fn end<S: Simd, M: Form>(&mut self, simd: S, wide: &Wide<M>, rays: &[Ray]) {
        if self.count > 0 {
            self.flush(simd, wide, rays);
        }
    }
}

/// How many hits each ray has, in a tree that has each triangle once.
pub(super) struct Numbers<'a>(pub(super) &'a mut [u32]);

impl Answers for Numbers<'_> {
    const ANY: bool = true;
    const ALL: bool = true;

    #[inline(always)]
    fn certain<S: Simd, M: Form>(&mut self, _: S, found: &Certain<'_, M>) {
        self.0[found.ray] += found.lanes.count_ones();
    }

    fn decided(&mut self, ray: usize, _: Candidate, _: u32) {
        self.0[ray] += 1;
    }
}

/// The same in a tree that may have a triangle more than once.
pub(super) struct Names(Vec<u64>);

impl Names {
    pub(super) const NEW: Self = Self(Vec::new());

    #[inline(always)]
    fn add(&mut self, ray: usize, prim: u32) {
        self.0.push((ray as u64) << 32 | u64::from(prim));
    }

    pub(super) fn give(mut self, counts: &mut [u32]) {
        counts.fill(0);
        self.0.sort_unstable();
        self.0.dedup();
        for name in self.0 {
            counts[(name >> 32) as usize] += 1;
        }
    }
}

impl Answers for Names {
    const ANY: bool = true;
    const ALL: bool = true;

    #[inline(always)]
    fn certain<S: Simd, M: Form>(&mut self, _: S, found: &Certain<'_, M>) {
        let mut lanes = found.lanes;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 7;
            lanes &= lanes - 1;
            let (_, prim) = found.wide.store.triangle(found.leaf, lane);
            self.add(found.ray, prim);
        }
    }

    fn decided(&mut self, ray: usize, _: Candidate, prim: u32) {
        self.add(ray, prim);
    }
}
