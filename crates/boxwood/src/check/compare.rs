//! The right answers, and one structure against them.

use super::Rays;
use super::bits::{digest, same};
use super::report::{Parity, Question, Tally};
use crate::geom::{Hit, Ray};
use crate::query::Query;
use std::ops::Range;

/// Every so many rays one is asked for all its hits.
pub(super) const ALL_HITS_EVERY: u64 = 8;
/// Rays of one slice.
const BLOCK: u64 = 1 << 10;
/// The right answers to a row of rays.
#[derive(Default)]
pub(super) struct Reference {
    pub(super) closest: Vec<Option<Hit>>,
    /// A digest of all hits of every eighth ray: 0 for none.
    all_hits: Vec<u64>,
}

impl Reference {
    pub(super) fn with_capacity(rays: usize) -> Self {
        let all_hits = Vec::with_capacity(rays / ALL_HITS_EVERY as usize + 1);
        Self {
            closest: Vec::with_capacity(rays),
            all_hits,
        }
    }

    /// Asks `right(i)` about ray `i`. The range begins at a multiple of eight, as all blocks do.
    pub(super) fn of<'q>(
        range: Range<u64>,
        rays: &Rays<'_>,
        right: impl Fn(u64) -> &'q dyn Query,
    ) -> Self {
        let mut hits = Vec::new();
        let mut reference = Self::default();
        for index in range {
            let (ray, query) = (rays.ray(index), right(index));
            reference.closest.push(query.closest_hit(&ray));
            if index.is_multiple_of(ALL_HITS_EVERY) {
                query.all_hits(&ray, &mut hits);
                reference.all_hits.push(digest(&hits));
            }
        }
        reference
    }

    pub(super) fn append(&mut self, mut next: Self) {
        self.closest.append(&mut next.closest);
        self.all_hits.append(&mut next.all_hits);
    }

    /// The last answers.
    pub(super) fn last(&self, count: u64) -> &[Option<Hit>] {
        &self.closest[self.closest.len() - count as usize..]
    }
}

/// Asks every question about a block of rays. `first` is the ray of the first known answer.
pub(super) fn block(
    query: &dyn Query,
    range: Range<u64>,
    first: u64,
    rays: &Rays<'_>,
    known: &Reference,
) -> Tally {
    let batch: Vec<Ray> = range.clone().map(|index| rays.ray(index)).collect();
    let (mut closest, mut occluded) = (vec![None; batch.len()], vec![false; batch.len()]);
    query.closest_hits(&batch, &mut closest);
    query.occluded_each(&batch, &mut occluded);
    let mut tally = Tally::default();
    let mut all = Vec::new();
    #[cfg(feature = "lists")]
    let mut lists = Lists::of(query, &batch);
    let mut wrong = Vec::new();
    for (slot, (index, ray)) in range.zip(&batch).enumerate() {
        let right = known.closest[(index - first) as usize].as_ref();
        let mut lost = false;
        let mut hit = |question, answer: Option<Hit>| {
            lost |= right.is_some() && answer.is_none();
            (!same(answer.as_ref(), right)).then(|| (question, format!("{answer:?}")))
        };
        wrong.clear();
        wrong.extend(hit(Question::ClosestHit, query.closest_hit(ray)));
        wrong.extend(hit(Question::ClosestHits, closest[slot]));
        let mut any = |question, answer: bool| {
            lost |= right.is_some() && !answer;
            (answer != right.is_some()).then(|| (question, format!("{answer}")))
        };
        wrong.extend(any(Question::Occluded, query.occluded(ray)));
        wrong.extend(any(Question::OccludedEach, occluded[slot]));
        if index.is_multiple_of(ALL_HITS_EVERY) {
            query.all_hits(ray, &mut all);
            let right_all = known.all_hits[((index - first) / ALL_HITS_EVERY) as usize];
            if digest(&all) != right_all || !same(all.first(), right) {
                wrong.push((Question::AllHits, format!("{all:?}")));
            }
            #[cfg(feature = "lists")]
            {
                let (list, count) = lists.next();
                if digest(list) != right_all || count != list.len() {
                    wrong.push((Question::Lists, format!("{count}: {list:?}")));
                }
            }
        }
        tally.misses += u64::from(lost);
        tally.book(index, ray, right, &wrong);
    }
    tally
}

/// All hits of every eighth ray, asked together.
#[cfg(feature = "lists")]
struct Lists {
    hits: Vec<Hit>,
    lengths: Vec<u32>,
    counts: Vec<u32>,
    ray: usize,
    hit: usize,
}

#[cfg(feature = "lists")]
impl Lists {
    fn of(query: &dyn Query, rays: &[Ray]) -> Self {
        let rays: Vec<Ray> = rays
            .iter()
            .step_by(ALL_HITS_EVERY as usize)
            .copied()
            .collect();
        let mut lists = Self {
            hits: Vec::new(),
            lengths: vec![0; rays.len()],
            counts: vec![0; rays.len()],
            ray: 0,
            hit: 0,
        };
        query.list_each(&rays, &mut lists.hits, &mut lists.lengths);
        query.count_each(&rays, &mut lists.counts);
        lists
    }

    /// The hits of the next ray, and how many there are said to be.
    fn next(&mut self) -> (&[Hit], usize) {
        let (ray, start) = (self.ray, self.hit);
        self.ray += 1;
        self.hit += self.lengths[ray] as usize;
        (&self.hits[start..self.hit], self.counts[ray] as usize)
    }
}

/// Asks for the closest hits of all the rays at once, on the calling thread.
pub(super) fn one_slice(
    query: &dyn Query,
    range: Range<u64>,
    rays: &Rays<'_>,
    known: &Reference,
) -> Tally {
    let batch: Vec<Ray> = range.clone().map(|index| rays.ray(index)).collect();
    let mut closest = vec![None; batch.len()];
    query.closest_hits(&batch, &mut closest);
    let mut tally = Tally::default();
    for (((index, ray), answer), right) in range.zip(&batch).zip(&closest).zip(&known.closest) {
        if !same(answer.as_ref(), right.as_ref()) {
            tally.misses += u64::from(answer.is_none());
            tally.book(
                index,
                ray,
                right.as_ref(),
                &[(Question::OneThread, format!("{answer:?}"))],
            );
        }
    }
    tally
}

/// Tests the whole lines of valid rays, if the mesh is closed.
pub(super) fn parity(
    range: Range<u64>,
    rays: &Rays<'_>,
    query: &dyn Query,
    is_closed: bool,
) -> Parity {
    let mut parity = Parity::default();
    for (index, ray) in range.map(|index| (index, rays.ray(index))) {
        if is_closed && ray.is_valid() {
            parity.lines += 1;
            let hits = hits_of_line(query, &ray);
            if !hits.is_multiple_of(2) {
                parity.odd.push((index, ray, hits));
            }
        }
    }
    parity
}

/// Every triangle that the whole line through the ray meets, before and behind its origin, once.
///
/// The exact test sees the same line both ways, bit for bit, so each hit has `t >= 0` in one of the two.
fn hits_of_line(query: &dyn Query, ray: &Ray) -> usize {
    let line = ray.with_range(0.0, f32::INFINITY);
    let mut found = Vec::new();
    let mut hits = Vec::new();
    for dir in [ray.dir, ray.dir.map(|d| -d)] {
        query.all_hits(&Ray { dir, ..line }, &mut hits);
        found.extend(hits.iter().map(|hit| (hit.inst, hit.geom, hit.prim)));
    }
    found.sort_unstable();
    found.dedup();
    found.len()
}

/// Cuts a range into blocks and works on them, on all threads where that is compiled in.
pub(super) fn in_blocks<T: Send>(
    range: Range<u64>,
    work: impl Fn(Range<u64>) -> T + Sync,
) -> Vec<T> {
    let end = range.end;
    let starts: Vec<u64> = range.step_by(BLOCK as usize).collect();
    let work_from = |&start: &u64| work(start..end.min(start + BLOCK));
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        starts.par_iter().map(work_from).collect()
    }
    #[cfg(not(feature = "rayon"))]
    starts.iter().map(work_from).collect()
}

/// Runs `work` where rayon has a single thread.
pub(super) fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    #[cfg(feature = "rayon")]
    if let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        return pool.install(work);
    }
    work()
}
