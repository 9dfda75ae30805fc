//! From a tree of boxes to the arena.

use super::Payload;
use super::form::{Form, Store};
use super::layout::{Ref, WIDTH};
use crate::build::{TopologyNode, WideTopology};
use crate::error::BuildError;
use crate::simd::{Arena, GRANULE};

/// A tree in its arena.
pub(super) struct Emitted<M> {
    pub(super) store: Store<M>,
    pub(super) root: Option<Ref>,
    /// Most references that wait in a traversal.
    pub(super) stack_need: usize,
}

/// Granules to which nodes are aligned: a cache line.
pub(super) const LINE: u64 = 64 / GRANULE as u64;
/// What a leaf of few triangles may be read beyond its end.
pub(super) const SLACK: usize = 64;

/// Lays the tree out depth first: a node, its leaves, its inner children.
///
/// # Errors
/// [`BuildError::TooLarge`] if that takes `limit` granules, [`BuildError::OutOfMemory`].
pub(super) fn emit<M: Form>(
    tree: &WideTopology,
    payload: &Payload<'_>,
    limit: u32,
) -> Result<Emitted<M>, BuildError> {
    let (places, granules) = places::<M>(tree, payload, limit)?;
    let bytes = granules as usize * GRANULE + SLACK;
    let mut arena = Arena::new(bytes).ok_or(BuildError::OutOfMemory { bytes })?;
    for (index, place) in places.iter().enumerate() {
        let node = tree.node(index);
        let mut refs = [Ref(0); WIDTH];
        let mut leaf_at = place + M::NODE_GRANULES;
        for (child, reference) in node.iter().zip(&mut refs) {
            *reference = match payload {
                _ if !child.is_leaf() => Ref::node(places[child.first as usize]),
                Payload::Slots => Ref::leaf(child.first, child.count as usize),
                Payload::Triangles(triangles) => {
                    let leaf = Ref::leaf(leaf_at, child.count as usize);
                    let order = in_leaf(tree, child);
                    M::write_leaf(&mut arena, leaf, order, triangles);
                    leaf_at += M::leaf_granules(order, triangles);
                    leaf
                }
            };
        }
        M::write_node(&mut arena, *place, node, refs);
    }
    Ok(Emitted {
        store: Store::new(arena),
        root: places.first().map(|place| Ref::node(*place)),
        stack_need: stack_need(tree),
    })
}

/// The primitives of a leaf.
fn in_leaf<'a>(tree: &'a WideTopology, leaf: &TopologyNode) -> &'a [u32] {
    let slots = leaf.slots();
    &tree.order[slots.start as usize..slots.end as usize]
}

/// Where each node goes, and how many granules that takes.
fn places<M: Form>(
    tree: &WideTopology,
    payload: &Payload<'_>,
    limit: u32,
) -> Result<(Vec<u32>, u64), BuildError> {
    let out_of_memory = BuildError::OutOfMemory {
        bytes: tree.node_count() * size_of::<u32>(),
    };
    let mut places = Vec::new();
    places
        .try_reserve_exact(tree.node_count())
        .map_err(|_| out_of_memory)?;
    let mut next = 0_u64;
    for index in 0..tree.node_count() {
        next = next.next_multiple_of(LINE);
        // A place beyond the limit is never used: the sum is checked below.
        places.push(next as u32);
        next += u64::from(M::NODE_GRANULES);
        if let Payload::Triangles(triangles) = payload {
            let leaves = tree.node(index).iter().filter(|child| child.is_leaf());
            next += leaves
                .map(|leaf| u64::from(M::leaf_granules(in_leaf(tree, leaf), triangles)))
                .sum::<u64>();
        }
    }
    // Slots are not in the arena, but named by the same bits.
    let needed = match payload {
        Payload::Slots => next.max(tree.order.len() as u64),
        Payload::Triangles(_) => next,
    };
    if needed >= u64::from(limit) {
        return Err(BuildError::TooLarge {
            bytes: needed * GRANULE as u64,
            limit: u64::from(limit) * GRANULE as u64,
        });
    }
    Ok((places, next))
}

/// Of each node on a way down, all children but one wait. Children come after their parents.
fn stack_need(tree: &WideTopology) -> usize {
    let mut waiting = vec![0_usize; tree.node_count()];
    for index in 0..tree.node_count() {
        let node = tree.node(index);
        let below = waiting[index] + node.len() - 1;
        for child in node.iter().filter(|child| !child.is_leaf()) {
            waiting[child.first as usize] = below;
        }
        waiting[index] = below;
    }
    waiting.into_iter().max().unwrap_or(0) + 1
}
