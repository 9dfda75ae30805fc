//! A build explained: its steps as data.

use super::Topology;
use crate::geom::Aabb;
use std::collections::VecDeque;
use std::ops::Range;

/// How a structure came to be, in order.
///
/// A tree is grown by splits ([`BuildStep::Set`]) or by merges ([`BuildStep::Merge`]), then some builders move nodes
/// ([`BuildStep::Move`]). A grid tries resolutions ([`BuildStep::Grid`]). A list has no steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildWalk {
    /// The steps that are told. Of splits, where not all are told, those of the nodes nearest to the root.
    pub steps: Vec<BuildStep>,
    /// How many steps there are.
    pub step_count: usize,
    /// Slot to primitive as the splits left it: what [`SetStep::slots`] refers to. The order of `tree` differs from it where
    /// nodes were moved, or a primitive was split and met itself in a leaf.
    pub order: Vec<u32>,
    /// The curve along which neighbours are merged; empty for other builders.
    pub curve: Vec<CurvePlace>,
    /// What [`Builder::build`](super::Builder::build) gives, bit for bit.
    pub tree: Topology,
}

/// One step of a [`BuildWalk`].
#[derive(Clone, Debug, PartialEq)]
pub enum BuildStep {
    /// A set of primitives became a leaf, or was split.
    Set(SetStep),
    /// Two clusters became one.
    Merge(MergeStep),
    /// A node was moved to where it costs less.
    Move(NodeMove),
    /// A grid was tried.
    Grid(GridTry),
}

/// A set of primitives becomes a node.
#[derive(Clone, Debug, PartialEq)]
pub struct SetStep {
    /// Its number, as in the tree if nothing is moved later. The root is 0, children come after their parents.
    pub node: u32,
    /// The set that it was split from.
    pub parent: Option<u32>,
    /// 0 for the root.
    pub depth: u32,
    /// Its primitives, as places in [`BuildWalk::order`].
    pub slots: Range<u32>,
    /// The box around it.
    pub bounds: Aabb,
    /// The box around the centres of its primitives' boxes.
    pub centers: Aabb,
    /// Where it might be split: what was weighed, axis by axis.
    pub planes: Vec<Plane>,
    /// How many planes were weighed. Of a set of more than 64 primitives `sweep` tells only every so many, and the best.
    pub weighed: u32,
    /// What it costs as a leaf, where a node costs 1; `None` if the builder weighs no costs.
    pub leaf_cost: Option<f32>,
    /// What became of it.
    pub choice: Choice,
}

/// Where a set may be split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// The coordinate that parts the centres of the boxes. Centres that lie on it to the bit may be on either side.
    pub at: f32,
    /// Primitives on the left side.
    pub left: u32,
    /// What the split costs, in the unit of [`SetStep::leaf_cost`]; `None` if the builder weighs no costs, or of a set without
    /// area.
    pub cost: Option<f32>,
}

/// What became of a set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Choice {
    /// A leaf.
    Leaf(Why),
    /// Two sets.
    Split {
        /// Where.
        plane: Plane,
        /// Why there.
        why: Why,
        /// Their nodes: left and right.
        children: [u32; 2],
    },
}

/// Why a set is split or is a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// It is so small that the builder does not look further: a leaf.
    Few,
    /// It is small enough for a leaf, and the best split costs no less.
    Cheaper,
    /// The builder's own rule: half of the primitives, half of the space, the least cost.
    Rule,
    /// The builder's rule does not tell the primitives apart: a leaf if they are few enough, else halved by their numbers.
    Alike,
    /// The tree is so deep that sets are only halved from here on, until they are small enough for a leaf.
    Deep,
}

/// A place on the curve of `morton`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CurvePlace {
    /// Number of the primitive.
    pub prim: u32,
    /// 11 bits for each axis, in turn: the cell of its centre.
    pub code: u64,
}

/// Two neighbours on the curve become one cluster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MergeStep {
    /// Merges of one round know nothing of each other. Counted from 0.
    pub round: u32,
    /// Number of the cluster. Those below the number of places on the curve are single primitives, by their place.
    pub cluster: u32,
    /// What it is made of.
    pub parts: [u32; 2],
    /// The box around both.
    pub bounds: Aabb,
    /// Primitives in it.
    pub count: u32,
    /// True if it had better be one leaf.
    pub is_leaf: bool,
    /// Its number in the tree; `None` inside of a leaf.
    pub node: Option<u32>,
}

/// A node is taken out with its parent and put beside another one.
///
/// Numbers are places in the array of nodes as the moves before left it. The sibling of `node` takes the place of the
/// parent of both; what stands at `to` takes the sibling's old place, and `to` becomes the parent of that pair.
/// After the last move nodes are numbered anew, depth first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeMove {
    /// From 0.
    pub round: u32,
    /// Which.
    pub node: u32,
    /// Where to.
    pub to: u32,
    /// By how much the sum of all half areas shrinks, in squares of the scene's longest side.
    pub gain: f32,
}

/// A resolution that a grid tries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridTry {
    /// Cells per primitive that are aimed at.
    pub density: f64,
    /// Cells along each axis.
    pub cells: [u32; 3],
    /// The box of all cells.
    pub bounds: Aabb,
    /// References from cells to primitives; `None`: more than `limit`, so the next try is coarser.
    pub references: Option<usize>,
    /// Most references that are taken.
    pub limit: usize,
}

impl BuildWalk {
    /// Adds the moves, as far as the limit goes.
    pub(super) fn add_moves(&mut self, moves: Vec<NodeMove>, limit: usize) {
        self.step_count += moves.len();
        let left = limit.saturating_sub(self.steps.len());
        let told = moves.into_iter().take(left).map(BuildStep::Move);
        self.steps.extend(told);
    }
}

/// The nodes of a tree that are told: up to `limit`, those nearest to the root.
pub(super) fn told(tree: &Topology, limit: usize) -> Vec<bool> {
    let mut told = vec![false; tree.nodes.len()];
    let mut waiting: VecDeque<usize> = (0..tree.nodes.len().min(1)).collect();
    for _ in 0..limit {
        let Some(index) = waiting.pop_front() else {
            break;
        };
        told[index] = true;
        let node = &tree.nodes[index];
        if !node.is_leaf() {
            waiting.extend([node.first as usize, node.first as usize + 1]);
        }
    }
    told
}
