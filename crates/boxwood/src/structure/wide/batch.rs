//! Many rays in flight.

use super::bundle::{self, Bundle};
use super::every::{Certain, take_all};
use super::finish::{Finished, evaluate};
use super::form::Form;
use super::lanes::{boxes, leaf_test, nearest};
use super::layout::Ref;
use super::pending::{Best, Left, Pending, blocks};
use super::prepare::{Record, prepare};
use super::ray::{AXES, EdgeLanes, SlabLanes, splat3};
use super::{STACK, Wide, single};
use crate::geom::{Candidate, Hit, PreparedRay, Ray};
use crate::query::NoObserver;
use crate::simd::prefetch;
use fearless_simd::{dispatch, f32x8, mask32x8, prelude::*, u32x8};
use std::marker::PhantomData;

/// Rays in flight.
const SLOTS: usize = 16;
/// Rays made ready at a time.
const WINDOW: usize = 64;
/// References that wait in most trees; 8 fewer than a power of two.
const SHALLOW: usize = 120;
/// References that wait in the deepest.
const DEEP: usize = STACK.next_power_of_two();
/// Bytes of a tree from which on nodes are fetched ahead: it does not fit into the cache that a core has for itself.
const FETCH_FROM: usize = 1 << 20;
/// Marks the bottom of a stack. A leaf, for the lists.
const DONE: u32 = u32::MAX;

#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Slot<const LEN: usize> {
    record: Record,
    ray: usize,
    at: u32,
    top: u32,
    pending: Pending,
    /// What waits, and where it begins. `LEN` is a power of two and 8.
    refs: [u32; LEN],
    near: [f32; LEN],
}

/// Where answers go.
pub(super) trait Answers {
    /// True if any hit will do, so that nothing shortens a ray: only whether `Best::prim` is `u32::MAX` matters.
    const ANY: bool;
    /// True if any hit will do but does not end the ray: then the hits are told one by one, and there is no answer to give.
    const ALL: bool = false;
    /// The answer of a ray.
    fn give(&mut self, _ray: usize, _best: Best) {}
    /// Of all hits: triangles that are hit for certain.
    #[inline(always)]
    fn certain<S: Simd, M: Form>(&mut self, _simd: S, _found: &Certain<'_, M>) {}
    /// Of all hits: one that the exact test has found.
    fn decided(&mut self, _ray: usize, _candidate: Candidate, _prim: u32) {}
    /// Of all hits: there are no more.
    #[inline(always)]
    fn end<S: Simd, M: Form>(&mut self, _simd: S, _wide: &Wide<M>, _rays: &[Ray]) {}
}

impl Record {
    #[inline(always)]
    fn slabs<S: Simd>(&self, simd: S) -> SlabLanes<S> {
        SlabLanes {
            recip: splat3(simd, self.recip),
            near: splat3(simd, self.near),
            far: splat3(simd, self.far),
            near_row: [self.rows[0], self.rows[1], self.rows[2]],
            t_min: f32x8::splat(simd, self.t_min),
        }
    }

    #[inline(always)]
    fn edges<S: Simd>(&self, simd: S, ray: &Ray) -> EdgeLanes<S> {
        let splat = |x: f32| f32x8::splat(simd, x);
        let axes = AXES[(self.axis as usize).min(2)];
        let [kx, ky, kz] = axes.map(|axis| axis as usize);
        EdgeLanes {
            axes,
            origin: splat3(simd, [ray.origin[kx], ray.origin[ky], ray.origin[kz]]),
            shear: [splat(self.shear[0]), splat(self.shear[1])],
            recip: splat(self.t_per_depth),
            t_min: splat(self.t_min),
            simd: PhantomData,
        }
    }
}

impl<const LEN: usize> Slot<LEN> {
    const EMPTY: Self = Self {
        record: Record::EMPTY,
        ray: 0,
        at: 0,
        top: 0,
        pending: Pending::none(0.0),
        refs: [DONE; LEN],
        near: [0.0; LEN],
    };

    #[inline(always)]
    fn place(i: usize) -> usize {
        i & (LEN - 8 - 1)
    }
    #[inline(always)]
    fn refs8(&mut self, i: usize) -> &mut [u32; 8] {
        let i = Self::place(i);
        (&mut self.refs[i..i + 8]).try_into().unwrap()
    }
    #[inline(always)]
    fn near8(&mut self, i: usize) -> &mut [f32; 8] {
        let i = Self::place(i);
        (&mut self.near[i..i + 8]).try_into().unwrap()
    }
}

/// Slots by what they do next, as bits: test a node, or something else.
struct Turns {
    nodes: u32,
    others: u32,
}

impl Turns {
    #[inline(always)]
    fn add(&mut self, slot: usize, at: u32) {
        let other = at >> 31;
        self.nodes |= (other ^ 1) << slot;
        self.others |= other << slot;
    }
}

/// Answers all rays.
pub(super) fn trace<M: Form, A: Answers>(wide: &Wide<M>, rays: &[Ray], answers: &mut A) {
    let Some(root) = wide.root else {
        return (0..rays.len()).for_each(|ray| answers.give(ray, Best::none(0.0)));
    };
    if !A::ALL && !wide.level.has_eight_lanes() {
        // Eight lanes of two halves each: keeping rays in flight costs more than it hides.
        return dispatch!(wide.level.0, simd => one_by_one(simd, wide, rays, answers));
    }
    dispatch!(wide.level.0, simd => match (wide.stack_need <= SHALLOW, wide.store.len() > FETCH_FROM) {
        (true, false) if M::HAS_SMALL_KERNELS => {
            run::<_, M, A, false, { SHALLOW + 16 }>(simd, wide, root, rays, answers);
        }
        (true, _) => run::<_, M, A, true, { SHALLOW + 16 }>(simd, wide, root, rays, answers),
        (false, _) => run::<_, M, A, true, { DEEP + 8 }>(simd, wide, root, rays, answers),
    });
}

/// Tiles that are alike as bundles, all other rays one after the other.
#[inline(always)]
fn one_by_one<S: Simd, M: Form, A: Answers>(
    simd: S,
    wide: &Wide<M>,
    rays: &[Ray],
    answers: &mut A,
) {
    let mut bundle = Bundle::EMPTY;
    let mut next = 0;
    while next < rays.len() {
        let tile = rays[next..].first_chunk();
        let end = rays.len().min(next + bundle::RAYS);
        let done = match tile {
            Some(tile) => bundle::trace(simd, wide, &mut bundle, tile, next, answers),
            None => false,
        };
        if !done {
            for at in next..end {
                answers.give(at, alone::<S, M, A>(simd, wide, &rays[at]));
            }
        }
        next = end;
    }
}

#[inline(always)]
fn alone<S: Simd, M: Form, A: Answers>(simd: S, wide: &Wide<M>, ray: &Ray) -> Best {
    if A::ANY {
        Best::blocked(single::occluded(simd, wide, ray))
    } else {
        single::closest(simd, wide, ray)
    }
}

#[inline(never)]
fn run<S: Simd, M: Form, A: Answers, const FETCH: bool, const LEN: usize>(
    simd: S,
    wide: &Wide<M>,
    root: Ref,
    rays: &[Ray],
    answers: &mut A,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let mut slots = [Slot::<LEN>::EMPTY; SLOTS];
            let mut turns = Turns {
                nodes: 0,
                others: 0,
            };
            let mut source = Source {
                rays,
                bundle: Bundle::EMPTY,
                next: 0,
                records: [Record::EMPTY; WINDOW],
                ready: [0; WINDOW],
                ready_next: 0,
                ready_count: 0,
            };
            let mut queue = Queue {
                done: [Finished::NONE; 8],
                count: 0,
            };
            for s in 0..SLOTS {
                if refill(simd, wide, root, &mut source, &mut slots[s], answers) {
                    turns.add(s, slots[s].at);
                }
            }
            while turns.nodes | turns.others != 0 {
                let (nodes, mut left) = (turns.nodes, turns.nodes);
                let mut moved = 0;
                while left != 0 {
                    let s = left.trailing_zeros() as usize & (SLOTS - 1);
                    left &= left - 1;
                    let at = node_step::<S, M, A, FETCH, LEN>(simd, wide, &mut slots[s]);
                    moved |= (at >> 31) << s;
                }
                turns.nodes = nodes & !moved;
                let mut left = turns.others | moved;
                turns.others = 0;
                while left != 0 {
                    let s = left.trailing_zeros() as usize & (SLOTS - 1);
                    left &= left - 1;
                    let slot = &mut slots[s];
                    if slot.at != DONE {
                        let at = leaf_step::<S, M, A, FETCH, LEN>(simd, wide, rays, slot, answers);
                        turns.add(s, at);
                    } else {
                        finish::<S, M, A, LEN>(simd, wide, rays, slot, &mut queue, answers);
                        if refill(simd, wide, root, &mut source, slot, answers) {
                            turns.add(s, slot.at);
                        }
                    }
                }
            }
            if queue.count > 0 {
                flush(simd, wide, rays, &mut queue, answers);
            }
            answers.end(simd, wide, rays);
        },
    );
}

#[inline(always)]
pub(super) fn fetch<M: Form, const FETCH: bool>(wide: &Wide<M>, at: u32) {
    if FETCH {
        let p = wide.store.address(Ref(at));
        prefetch(p);
        prefetch(p.wrapping_add(64));
        prefetch(p.wrapping_add(128));
        prefetch(p.wrapping_add(192));
    }
}

#[inline(always)]
fn node_step<S: Simd, M: Form, A: Answers, const FETCH: bool, const LEN: usize>(
    simd: S,
    wide: &Wide<M>,
    slot: &mut Slot<LEN>,
) -> u32 {
    let mut room = M::NODE_ROOM;
    let node = wide.store.node(simd, Ref(slot.at).granule(), &mut room);
    // After the node, whose place is checked: numbers read before a branch are not broadcast as they are read.
    let slabs = slot.record.slabs(simd);
    let (hit, enter) = boxes(simd, node, &slabs, f32x8::splat(simd, slot.record.t_max));
    let refs = u32x8::simd_from(simd, *node.refs());
    let top = slot.top as usize;
    let mask = hit.to_bitmask() as u32;
    let count = mask.count_ones();
    if A::ANY {
        *slot.refs8(top) = refs.compress(hit).into();
        slot.top = (slot.top + count) - 1;
        slot.at = slot.refs[Slot::<LEN>::place(slot.top as usize)];
    } else {
        // The nearest goes on, the others wait.
        let (lane, others) = nearest(simd, hit, enter);
        *slot.refs8(top) = refs.compress(others).into();
        *slot.near8(top) = enter.compress(others).bitcast::<f32x8<S>>().into();
        // Pushed and popped at once: a selection would become a branch, which cannot be guessed. With no child hit it is
        // written above the top, and what was below is popped.
        let base = Slot::<LEN>::place(top);
        slot.refs[base + (count as usize).wrapping_sub(1) % 8] = node.child(lane);
        slot.at = slot.refs[Slot::<LEN>::place(base + count as usize - 1)];
        slot.top = (slot.top + count) - 1;
    }
    fetch::<M, FETCH>(wide, slot.at);
    slot.at
}

#[inline(always)]
fn leaf_step<S: Simd, M: Form, A: Answers, const FETCH: bool, const LEN: usize>(
    simd: S,
    wide: &Wide<M>,
    rays: &[Ray],
    slot: &mut Slot<LEN>,
    answers: &mut A,
) -> u32 {
    let leaf = Ref(slot.at);
    let edges = slot.record.edges(simd, &rays[slot.ray]);
    let (store, ray) = (&wide.store, &rays[slot.ray]);
    let test = leaf_test(simd, store, leaf, &edges);
    if test.candidates != 0 {
        if A::ALL {
            let found = Certain {
                wide,
                rays,
                record: &slot.record,
                ray: slot.ray,
                leaf,
                lanes: 0,
            };
            take_all(simd, &test, &edges, found, answers);
        } else if A::ANY {
            if blocks(simd, store, ray, leaf, &test, &edges, ray.t_max) {
                slot.pending.best.prim = 0;
                slot.at = DONE;
                return DONE;
            }
        } else {
            let before = slot.record.t_max;
            let pending = &mut slot.pending;
            let bound = pending.consider(simd, store, ray, leaf, &test, &edges, before);
            slot.record.t_max = bound;
            if bound < before {
                drop_farther(simd, slot);
            }
        }
    }
    slot.top -= 1;
    slot.at = slot.refs[Slot::<LEN>::place(slot.top as usize)];
    fetch::<M, FETCH>(wide, slot.at);
    slot.at
}

/// Takes out of the stack what begins beyond the bound.
#[inline(always)]
fn drop_farther<S: Simd, const LEN: usize>(simd: S, slot: &mut Slot<LEN>) {
    let top = slot.top as usize;
    let bound = f32x8::splat(simd, slot.record.t_max);
    let (mut from, mut to) = (1, 1);
    while from < top {
        let r = u32x8::simd_from(simd, *slot.refs8(from));
        let n = f32x8::simd_from(simd, *slot.near8(from));
        let real = (1u32 << (top - from).min(8)) - 1;
        let keep = n.simd_le(bound).to_bitmask() as u32 & real;
        let mask = mask32x8::from_bitmask(simd, u64::from(keep));
        *slot.refs8(to) = r.compress(mask).into();
        *slot.near8(to) = n.compress(mask).into();
        to += keep.count_ones() as usize;
        from += 8;
    }
    slot.top = to as u32;
}

/// Hits that wait to be evaluated together.
struct Queue {
    done: [Finished; 8],
    count: usize,
}

#[inline(always)]
fn finish<S: Simd, M: Form, A: Answers, const LEN: usize>(
    simd: S,
    wide: &Wide<M>,
    rays: &[Ray],
    slot: &mut Slot<LEN>,
    queue: &mut Queue,
    answers: &mut A,
) {
    let bound = slot.record.t_max;
    if !A::ANY {
        match slot.pending.left(simd, bound) {
            Left::Decided => {}
            Left::Several => slot.pending.settle(&wide.store, &rays[slot.ray], bound),
            Left::Only(leaf, lane) => {
                queue.done[queue.count] = Finished {
                    record: slot.record,
                    ray: slot.ray,
                    leaf,
                    lane,
                };
                queue.count += 1;
                if queue.count == 8 {
                    flush(simd, wide, rays, queue, answers);
                }
                return;
            }
        }
    }
    if !A::ALL {
        answers.give(slot.ray, slot.pending.best);
    }
}

#[inline(never)]
fn flush<S: Simd, M: Form, A: Answers>(
    simd: S,
    wide: &Wide<M>,
    rays: &[Ray],
    queue: &mut Queue,
    answers: &mut A,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let mut best = [Best::none(0.0); 8];
            for k in queue.count..8 {
                queue.done[k] = queue.done[0];
            }
            let good = evaluate(simd, &wide.store, rays, &queue.done, &mut best);
            for k in 0..queue.count {
                let ray = queue.done[k].ray;
                let best = if good >> k & 1 == 1 {
                    best[k]
                } else {
                    slow::<M, A>(wide, &rays[ray])
                };
                answers.give(ray, best);
            }
            queue.count = 0;
        },
    );
}

/// The answer without any doubt and in no hurry: what is no ray, what is too extreme for the fast tests.
#[cold]
pub(super) fn slow<M: Form, A: Answers>(wide: &Wide<M>, ray: &Ray) -> Best {
    let Some(ray) = PreparedRay::new(ray) else {
        return Best::none(0.0);
    };
    if A::ANY {
        Best::blocked(wide.occluded_walked(&ray, &mut NoObserver))
    } else {
        wide.closest_walked(&ray, &mut NoObserver)
    }
}

/// The same for all hits.
#[cold]
fn all_slow<M: Form, A: Answers>(wide: &Wide<M>, number: usize, ray: &Ray, answers: &mut A) {
    let Some(ray) = PreparedRay::new(ray) else {
        return;
    };
    let mut hits = Vec::new();
    wide.all_walked(&ray, &mut hits, &mut NoObserver);
    for Hit { t, u, v, prim, .. } in hits {
        answers.decided(number, Candidate { t, u, v }, prim);
    }
}

/// Rays waiting for a slot.
struct Source<'a> {
    rays: &'a [Ray],
    bundle: Bundle,
    next: usize,
    records: [Record; WINDOW],
    ready: [usize; WINDOW],
    ready_next: usize,
    ready_count: usize,
}

#[inline(never)]
fn fill<S: Simd, M: Form, A: Answers>(
    simd: S,
    wide: &Wide<M>,
    source: &mut Source<'_>,
    answers: &mut A,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            source.ready_next = 0;
            source.ready_count = 0;
            while !A::ALL
                && let Some(Some(tile)) = source.rays.get(source.next..).map(<[Ray]>::first_chunk)
            {
                if !bundle::trace(simd, wide, &mut source.bundle, tile, source.next, answers) {
                    break;
                }
                source.next += bundle::RAYS;
            }
            let end = source.rays.len().min(source.next + WINDOW);
            while source.next < end {
                let rest = &source.rays[source.next..];
                let count = rest.len().min(8);
                let mut eight = [rest[0]; 8];
                let eight = if count == 8 {
                    rest[..8].try_into().unwrap()
                } else {
                    eight[..count].copy_from_slice(&rest[..count]);
                    &eight
                };
                let mut records = [Record::EMPTY; 8];
                let prepared = prepare(simd, eight, wide.size, &mut records);
                for k in 0..count {
                    let ray = source.next + k;
                    if prepared.valid & !prepared.extreme & (1 << k) != 0 {
                        source.records[source.ready_count] = records[k];
                        source.ready[source.ready_count] = ray;
                        source.ready_count += 1;
                    } else if A::ALL {
                        all_slow(wide, ray, &source.rays[ray], answers);
                    } else {
                        answers.give(ray, slow::<M, A>(wide, &source.rays[ray]));
                    }
                }
                source.next += count;
            }
        },
    );
}

/// False if there are no more rays.
#[inline(always)]
fn refill<S: Simd, M: Form, A: Answers, const LEN: usize>(
    simd: S,
    wide: &Wide<M>,
    root: Ref,
    source: &mut Source<'_>,
    slot: &mut Slot<LEN>,
    answers: &mut A,
) -> bool {
    if source.ready_next == source.ready_count {
        while source.next < source.rays.len() {
            fill(simd, wide, source, answers);
            if source.ready_count > 0 {
                break;
            }
        }
        if source.ready_next == source.ready_count {
            return false;
        }
    }
    slot.record = source.records[source.ready_next & (WINDOW - 1)];
    slot.ray = source.ready[source.ready_next & (WINDOW - 1)];
    source.ready_next += 1;
    slot.at = root.0;
    slot.top = 1;
    slot.pending.clear(slot.record.t_max);
    true
}
