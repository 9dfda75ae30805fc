//! A tree is improved: nodes are taken out and put where they cost least.
//!
//! Bittner, Hapala, Havran, "Fast Insertion-Based Optimization of Bounding Volume Hierarchies", CGF 2013; Meister and Bittner,
//! "Parallel Reinsertion for Bounding Volume Hierarchy Optimization", CGF 2018. The best places of a batch of nodes are
//! searched in parallel, in the tree as it was before the batch; then the nodes are moved one after the other, the
//! most rewarding first, unless what they touch has changed.

use super::fragment::Lanes;
use super::input::{Watch, filled, room};
use super::measure::Measure;
use super::top_down::PATIENCE;
use super::{BuildOptions, NodeMove, Topology, TopologyNode};
use crate::error::BuildError;
use fearless_simd::{Simd, SimdBase, dispatch};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Nodes of one batch. Larger: more for many threads to do, more moves in vain.
const BATCH: usize = 2048;

/// A round that saves a smaller share of the areas is the last one.
const ENOUGH: f32 = 0.001;

/// Improves a tree in up to `rounds` rounds over the `share` of its nodes with the largest area.
pub(super) fn optimize(
    tree: Topology,
    options: &BuildOptions,
    watch: &Watch<'_>,
) -> Result<Topology, BuildError> {
    optimize_told(tree, options, watch, &mut |_| {})
}

/// [`optimize`], telling of each move.
pub(super) fn optimize_told(
    tree: Topology,
    options: &BuildOptions,
    watch: &Watch<'_>,
    tell: &mut dyn FnMut(NodeMove),
) -> Result<Topology, BuildError> {
    if tree.nodes.len() < 5 || options.rounds == 0 {
        return Ok(tree);
    }
    dispatch!(options.instructions.0, simd => improved(simd, tree, options, watch, tell))
}

fn improved<S: Simd>(
    simd: S,
    tree: Topology,
    options: &BuildOptions,
    watch: &Watch<'_>,
    tell: &mut dyn FnMut(NodeMove),
) -> Result<Topology, BuildError> {
    let mut links = Links::new(simd, tree)?;
    let total: f32 = links.search.iter().map(|node| node.0[AREA]).sum();
    let count = (links.parents.len() as f64 * f64::from(options.round_share)) as usize;
    for round in 0..options.rounds {
        let mut gain = 0.0;
        let candidates = links.largest(count)?;
        for batch in candidates.chunks(BATCH) {
            watch.advance(0)?;
            gain += links.improve(batch, &mut |Move { node, to, gain }| {
                tell(NodeMove {
                    round,
                    node,
                    to,
                    gain,
                });
            })?;
        }
        if gain < ENOUGH * total {
            break;
        }
    }
    links.into_tree()
}

/// A tree whose nodes know their parents. Siblings stand side by side, but not always behind their parent.
struct Links<S: Simd> {
    simd: S,
    tree: Topology,
    /// The nodes as a search wants them: in the lanes to spare the first child, or [`NO_CHILD`], and the area.
    search: Vec<Lanes>,
    parents: Vec<u32>,
    /// The batch that last changed a node.
    changed: Vec<u32>,
    batch: u32,
    measure: Measure,
}

/// Lanes of a node in a search.
const CHILD: usize = 3;
const AREA: usize = 7;
const NO_CHILD: u32 = u32::MAX;

/// A node had better be a child of a new parent in the place of another.
#[derive(Clone, Copy)]
struct Move {
    node: u32,
    to: u32,
    gain: f32,
}

fn searched(node: &TopologyNode, measure: Measure) -> Lanes {
    let child = if node.is_leaf() { NO_CHILD } else { node.first };
    let mut lanes = Lanes::fragment(&node.bounds, child);
    lanes.0[AREA] = measure.area(&node.bounds);
    lanes
}

/// Siblings stand at an odd place and the even one after it.
#[inline(always)]
fn sibling(node: u32) -> u32 {
    ((node - 1) ^ 1) + 1
}

impl<S: Simd> Links<S> {
    fn new(simd: S, tree: Topology) -> Result<Self, BuildError> {
        let measure = Measure::new(&tree.nodes[0].bounds);
        let mut parents = filled(0, tree.nodes.len())?;
        let mut search = room(tree.nodes.len())?;
        for (node, index) in tree.nodes.iter().zip(0..) {
            if !node.is_leaf() {
                parents[node.first as usize..][..2].fill(index);
            }
            search.push(searched(node, measure));
        }
        Ok(Self {
            simd,
            search,
            changed: filled(0, tree.nodes.len())?,
            batch: 0,
            measure,
            parents,
            tree,
        })
    }

    #[inline(always)]
    fn node(&self, index: u32) -> &TopologyNode {
        &self.tree.nodes[index as usize]
    }

    /// The nodes of the largest area that have a grandparent, the largest first: parents come before their children, so the
    /// rest of the tree is not looked at.
    fn largest(&self, count: usize) -> Result<Vec<u32>, BuildError> {
        let mut largest = room(count.min(self.parents.len()))?;
        // Each node makes room for its two children; the root and its children come on top.
        let mut waiting = BinaryHeap::from(room(count.min(self.parents.len()) + 5)?);
        waiting.push((u32::MAX, Reverse(0)));
        while let Some((_, Reverse(index))) = waiting.pop() {
            if index != 0 && self.parents[index as usize] != 0 {
                if largest.len() >= count {
                    break;
                }
                largest.push(index);
            }
            let node = self.node(index);
            if !node.is_leaf() {
                // Areas are not negative, so their bits are in their order.
                let area = |i: u32| self.search[i as usize].0[AREA].to_bits();
                waiting.extend([node.first, node.first + 1].map(|i| (area(i), Reverse(i))));
            }
        }
        Ok(largest)
    }

    /// Moves nodes to better places; returns by how much areas shrink.
    fn improve(&mut self, batch: &[u32], tell: &mut dyn FnMut(Move)) -> Result<f32, BuildError> {
        let mut moves = self.best_moves(batch)?;
        moves.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.node.cmp(&b.node)));
        self.batch += 1;
        let mut apply = |step: Move| {
            let gain = self.apply(step);
            if gain > 0.0 {
                tell(step);
            }
            gain
        };
        Ok(moves.into_iter().map(&mut apply).sum())
    }

    fn best_moves(&self, batch: &[u32]) -> Result<Vec<Move>, BuildError> {
        let mut moves = room(batch.len())?;
        let best_move = |waiting: &mut Vec<(f32, u32)>, node: &u32| {
            self.simd.vectorize(
                #[inline(always)]
                || self.best_move(*node, waiting),
            )
        };
        #[cfg(feature = "rayon")]
        {
            use rayon::prelude::*;
            let found = batch.par_iter().with_min_len(32);
            found
                .map_init(Vec::new, best_move)
                .collect_into_vec(&mut moves);
        }
        #[cfg(not(feature = "rayon"))]
        {
            let mut waiting = Vec::new();
            moves.extend(batch.iter().map(|node| best_move(&mut waiting, node)));
        }
        moves.retain(|step: &Move| step.gain > 0.0);
        Ok(moves)
    }

    /// Searches the whole tree for the best place of a node, branch and bound: what the way to a place adds can only grow.
    #[inline(always)]
    fn best_move(&self, node: u32, waiting: &mut Vec<(f32, u32)>) -> Move {
        let simd = self.simd;
        let area = |index: u32| self.search[index as usize].0[AREA];
        let bounds = self.search[node as usize].load(simd);
        let own = area(node);
        let mut best = Move {
            node,
            to: node,
            gain: 0.0,
        };
        let parent = self.parents[node as usize];
        // What is gained above: the parent goes away, ancestors shrink.
        let mut saved = area(parent);
        let mut beside = sibling(node);
        let mut pivot = parent;
        let mut shrunk = Lanes::EMPTY.load(simd);
        loop {
            waiting.push((saved, beside));
            while let Some((saved, place)) = waiting.pop() {
                if saved - own <= best.gain {
                    continue;
                }
                let there = &self.search[place as usize];
                let gain = saved - self.measure.area_of(there.load(simd).max(bounds));
                // In the place of its sibling it would be where it is.
                if gain > best.gain && (pivot != parent || place != beside) {
                    (best.to, best.gain) = (place, gain);
                }
                let (child, below) = (there.0[CHILD].to_bits(), gain + there.0[AREA]);
                if child != NO_CHILD && below - own > best.gain {
                    waiting.extend([(below, child), (below, child + 1)]);
                }
            }
            if pivot == 0 {
                return best;
            }
            shrunk = shrunk.max(self.search[beside as usize].load(simd));
            if pivot != parent {
                saved += area(pivot) - self.measure.area_of(shrunk);
            }
            beside = sibling(pivot);
            pivot = self.parents[pivot as usize];
        }
    }

    /// Moves a node, unless this batch has already changed what the move rests on; returns what that saves.
    fn apply(&mut self, step: Move) -> f32 {
        let Move { node, to, gain } = step;
        let left = sibling(node);
        let parent = self.parents[node as usize];
        let touched = [
            node,
            left,
            parent,
            self.parents[parent as usize],
            to,
            self.parents[to as usize],
        ];
        if to == left
            || to == parent
            || touched
                .iter()
                .any(|&n| self.changed[n as usize] == self.batch)
        {
            return 0.0;
        }
        for touched in touched {
            self.changed[touched as usize] = self.batch;
        }
        // The sibling takes the parent's place; its own place is free for what stands at the goal, which becomes the parent
        // of both.
        self.put(parent, *self.node(left));
        self.put(left, *self.node(to));
        let pair = node.min(left);
        let bounds = self.node(node).bounds.union(&self.node(left).bounds);
        self.put(to, TopologyNode::inner(bounds, pair));
        self.fit_from(self.parents[parent as usize]);
        self.fit_from(self.parents[to as usize]);
        gain
    }

    /// Writes a node to a place and tells its children.
    fn put(&mut self, place: u32, node: TopologyNode) {
        self.tree.nodes[place as usize] = node;
        self.search[place as usize] = searched(&node, self.measure);
        if !node.is_leaf() {
            self.parents[node.first as usize..][..2].fill(place);
        }
    }

    /// Boxes from a node up, until one does not change.
    fn fit_from(&mut self, from: u32) {
        let mut index = from;
        loop {
            let first = self.node(index).first;
            let bounds = self.node(first).bounds.union(&self.node(first + 1).bounds);
            if bounds == self.node(index).bounds {
                return;
            }
            self.tree.nodes[index as usize].bounds = bounds;
            self.search[index as usize] = searched(self.node(index), self.measure);
            if index == 0 {
                return;
            }
            index = self.parents[index as usize];
        }
    }

    /// The tree with nodes and slots depth first. What is too deep is halved.
    fn into_tree(self) -> Result<Topology, BuildError> {
        let mut tree = Topology {
            nodes: room(self.tree.nodes.len())?,
            order: room(self.tree.order.len())?,
            is_split: self.tree.is_split,
        };
        tree.nodes.push(TopologyNode::PLACEHOLDER);
        self.copy(0, 0, 0, &mut tree);
        Ok(tree)
    }

    fn copy(&self, from: u32, at: usize, depth: usize, tree: &mut Topology) {
        let node = *self.node(from);
        if node.is_leaf() {
            return self.copy_leaf(&node, at, tree);
        }
        if depth >= PATIENCE {
            let mut leaves = Vec::new();
            let mut waiting = vec![from];
            while let Some(index) = waiting.pop() {
                let node = self.node(index);
                if node.is_leaf() {
                    leaves.push(*node);
                } else {
                    waiting.extend([node.first + 1, node.first]);
                }
            }
            return self.halve(&leaves, at, tree);
        }
        let first = tree.nodes.len();
        tree.nodes[at] = TopologyNode::inner(node.bounds, first as u32);
        tree.nodes.extend([TopologyNode::PLACEHOLDER; 2]);
        self.copy(node.first, first, depth + 1, tree);
        self.copy(node.first + 1, first + 1, depth + 1, tree);
    }

    fn copy_leaf(&self, leaf: &TopologyNode, at: usize, tree: &mut Topology) {
        let slot = tree.order.len() as u32;
        let slots = leaf.first as usize..(leaf.first + leaf.count) as usize;
        tree.order.extend_from_slice(&self.tree.order[slots]);
        tree.nodes[at] = TopologyNode::leaf(leaf.bounds, slot, leaf.count);
    }

    /// A balanced tree over leaves.
    fn halve(&self, leaves: &[TopologyNode], at: usize, tree: &mut Topology) {
        if let [leaf] = leaves {
            return self.copy_leaf(leaf, at, tree);
        }
        let bounds = crate::geom::Aabb::of_boxes(leaves.iter().map(|leaf| &leaf.bounds));
        let first = tree.nodes.len();
        tree.nodes[at] = TopologyNode::inner(bounds, first as u32);
        tree.nodes.extend([TopologyNode::PLACEHOLDER; 2]);
        let (left, right) = leaves.split_at(leaves.len() / 2);
        self.halve(left, first, tree);
        self.halve(right, first + 1, tree);
    }
}
