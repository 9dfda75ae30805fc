//! What a builder gives: the shape of a binary tree, with a box per node.

use crate::geom::Aabb;

/// The shape of a binary tree: structures dress it with their volumes or collapse it to wider nodes.
///
/// The root is node 0. Siblings stand side by side after their parent, and everything below a node stands in one range of
/// nodes and one range of slots. At most `2 k - 1` nodes for `k` slots, at most 96 deep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    /// The root first, children after their parents. None if there is nothing to hit.
    pub nodes: Vec<TopologyNode>,
    /// Slot to primitive: leaves are ranges of slots. A builder that splits primitives names some of them more than once.
    pub order: Vec<u32>,
    /// True if `order` may name a primitive more than once; never twice in one leaf.
    pub is_split: bool,
}

/// A node of a [`Topology`]: 32 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct TopologyNode {
    /// The box around everything below. Of a primitive that was split it holds the part that belongs here.
    pub bounds: Aabb,
    /// Leaf: its first slot. Inner node: its first child; the second stands beside it.
    pub first: u32,
    /// Primitives of a leaf, 0 for an inner node.
    pub count: u32,
}

impl TopologyNode {
    /// A node that is still to be filled in.
    pub(crate) const PLACEHOLDER: Self = Self {
        bounds: Aabb::EMPTY,
        first: 0,
        count: 0,
    };

    /// A leaf over `count` slots.
    #[inline]
    pub fn leaf(bounds: Aabb, first: u32, count: u32) -> Self {
        Self {
            bounds,
            first,
            count,
        }
    }

    /// An inner node whose children are `first` and `first + 1`.
    #[inline]
    pub fn inner(bounds: Aabb, first: u32) -> Self {
        Self {
            bounds,
            first,
            count: 0,
        }
    }

    /// The slots of a leaf, empty for an inner node.
    #[inline]
    pub fn slots(&self) -> std::ops::Range<u32> {
        self.first..self.first + self.count
    }

    /// True if it holds primitives.
    #[inline]
    pub fn is_leaf(&self) -> bool {
        self.count > 0
    }
}

impl Topology {
    /// The slots under every node; they are consecutive. `O(nodes)`.
    pub(crate) fn slots_below(&self) -> Vec<std::ops::Range<u32>> {
        let mut slots = vec![0..0; self.nodes.len()];
        for (i, node) in self.nodes.iter().enumerate().rev() {
            slots[i] = if node.is_leaf() {
                node.slots()
            } else {
                let first = node.first as usize;
                slots[first].start..slots[first + 1].end
            };
        }
        slots
    }
}
