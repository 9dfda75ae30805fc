//! One ray at a time.

use super::finish_one::evaluate_one;
use super::form::{Form, Store};
use super::lanes::{LeafTest, boxes, leaf_test, nearest};
use super::layout::Ref;
use super::pending::{Best, Left, Pending, blocks};
use super::ray::{EdgeLanes, Ready, ready};
use super::{STACK, Wide};
use crate::geom::{PreparedRay, Ray};
use crate::query::NoObserver;
use crate::simd::{RowStack, Stack, prefetch};
use fearless_simd::{f32x8, prelude::*, u32x8};

/// One of eight, by the lowest bit. Branches, not a computed lane: where they are guessed, what it refers to is read before it is
/// known.
#[inline(always)]
fn guessed(refs: &[u32; 8], mask: u32) -> Ref {
    let bit = |lane: u32| mask & 1 << lane != 0;
    Ref(if bit(0) {
        refs[0]
    } else if bit(1) {
        refs[1]
    } else if bit(2) {
        refs[2]
    } else if bit(3) {
        refs[3]
    } else if bit(4) {
        refs[4]
    } else if bit(5) {
        refs[5]
    } else if bit(6) {
        refs[6]
    } else {
        refs[7]
    })
}

/// Bytes of a tree from which on children are fetched ahead: below, it costs more than it saves.
const FETCH_FROM: usize = 4 << 20;

/// Asks for the nodes that wait.
#[inline(always)]
fn fetch_all<M: Form>(store: &Store<M>, refs: &[u32; 8], mut waiting: u32) {
    while waiting != 0 {
        let place = store.address(Ref(refs[waiting.trailing_zeros() as usize & 7]));
        waiting &= waiting - 1;
        (0..4).for_each(|line| prefetch(place.wrapping_add(64 * line)));
    }
}

/// The rare leaf with candidates, apart from the loop: it would take the loop's registers. Returns the new bound.
#[inline(never)]
#[expect(
    clippy::too_many_arguments,
    reason = "all that a leaf's candidates need"
)]
fn consider<S: Simd, M: Form>(
    simd: S,
    store: &Store<M>,
    ray: &PreparedRay,
    leaf: Ref,
    test: &LeafTest<f32x8<S>>,
    edges: &EdgeLanes<S>,
    pending: &mut Pending,
    bound: f32,
) -> f32 {
    simd.vectorize(
        #[inline(always)]
        || pending.consider(simd, store, ray, leaf, test, edges, bound),
    )
}

/// The same for any hit.
#[inline(never)]
fn is_blocking<S: Simd, M: Form>(
    simd: S,
    store: &Store<M>,
    ray: &Ray,
    leaf: Ref,
    test: &LeafTest<f32x8<S>>,
    edges: &EdgeLanes<S>,
) -> bool {
    simd.vectorize(
        #[inline(always)]
        || blocks(simd, store, ray, leaf, test, edges, ray.t_max),
    )
}

#[cold]
fn closest_in_no_hurry<M: Form>(wide: &Wide<M>, ray: &Ray) -> Best {
    match PreparedRay::new(ray) {
        Some(ray) => wide.closest_walked(&ray, &mut NoObserver),
        None => Best::none(0.0),
    }
}

#[cold]
fn is_occluded_in_no_hurry<M: Form>(wide: &Wide<M>, ray: &Ray) -> bool {
    PreparedRay::new(ray).is_some_and(|ray| wide.occluded_walked(&ray, &mut NoObserver))
}

#[inline(always)]
pub(super) fn closest<S: Simd, M: Form>(simd: S, wide: &Wide<M>, ray: &Ray) -> Best {
    let Some(root) = wide.root else {
        return Best::none(0.0);
    };
    let (slabs, edges, exact) = match ready(simd, ray, wide.size) {
        Ready::Tame(slabs, edges, exact) => (slabs, edges, exact),
        Ready::Not => return Best::none(0.0),
        Ready::Extreme => return closest_in_no_hurry(wide, ray),
    };
    let store = &wide.store;
    // Minus zero becomes zero here and below: the slab test compares as integers.
    let mut bound = ray.t_max + 0.0;
    let mut t_max = f32x8::splat(simd, bound);
    let mut pending = Pending::none(ray.t_max);
    let mut room = M::NODE_ROOM;
    let mut stack = RowStack::<STACK>::new();
    let mut at = root;
    'all: loop {
        if at.is_leaf() {
            let test = leaf_test(simd, store, at, &edges);
            if test.candidates != 0 {
                bound = consider(simd, store, &exact, at, &test, &edges, &mut pending, bound);
                t_max = f32x8::splat(simd, bound);
            }
        } else {
            let node = store.node(simd, at.granule(), &mut room);
            let (hit, enter) = boxes(simd, node, &slabs, t_max);
            let mask = hit.to_bitmask() as u32;
            if mask != 0 {
                if mask & (mask - 1) == 0 {
                    at = guessed(node.refs(), mask);
                    continue;
                }
                // The nearest goes on, the others wait in any order.
                let (lane, others) = nearest(simd, hit, enter);
                let refs = u32x8::simd_from(simd, *node.refs());
                stack.push(
                    refs.compress(others).into(),
                    enter.compress(others).bitcast::<f32x8<S>>().into(),
                    mask.count_ones() as usize - 1,
                );
                at = guessed(node.refs(), 1 << lane);
                if store.len() > FETCH_FROM {
                    fetch_all(store, node.refs(), others.to_bitmask() as u32);
                }
                continue;
            }
        }
        loop {
            let Some((below, near)) = stack.pop() else {
                break 'all;
            };
            if near <= bound {
                at = Ref(below);
                break;
            }
        }
    }
    match pending.left(simd, bound) {
        Left::Decided => pending.best,
        Left::Only(leaf, lane) => match evaluate_one(simd, store, &exact, leaf, lane as usize) {
            Some(best) => best,
            // Not hit after all, but it has hidden others: once more without any doubt. Never seen yet.
            None => closest_in_no_hurry(wide, ray),
        },
        Left::Several => settled(&mut pending, store, &exact, bound),
    }
}

#[inline(never)]
fn settled<M: Form>(
    pending: &mut Pending,
    store: &Store<M>,
    ray: &PreparedRay,
    bound: f32,
) -> Best {
    pending.settle(store, ray, bound);
    pending.best
}

#[inline(always)]
pub(super) fn occluded<S: Simd, M: Form>(simd: S, wide: &Wide<M>, ray: &Ray) -> bool {
    let Some(root) = wide.root else {
        return false;
    };
    let (slabs, edges) = match ready(simd, ray, wide.size) {
        Ready::Tame(slabs, edges, _) => (slabs, edges),
        Ready::Not => return false,
        Ready::Extreme => return is_occluded_in_no_hurry(wide, ray),
    };
    let store = &wide.store;
    let mut room = M::NODE_ROOM;
    let mut memory = Stack::memory::<STACK>();
    let mut stack = Stack::<u32>::new(&mut memory);
    let mut at = root;
    let t_max = f32x8::splat(simd, ray.t_max + 0.0);
    loop {
        if at.is_leaf() {
            let test = leaf_test(simd, store, at, &edges);
            if test.candidates != 0 && is_blocking(simd, store, ray, at, &test, &edges) {
                return true;
            }
        } else {
            let node = store.node(simd, at.granule(), &mut room);
            let (hit, _) = boxes(simd, node, &slabs, t_max);
            let mut mask = hit.to_bitmask() as u32;
            if mask != 0 {
                let refs = node.refs();
                at = guessed(refs, mask);
                mask &= mask - 1;
                while mask != 0 {
                    stack.push(refs[mask.trailing_zeros() as usize & 7]);
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
