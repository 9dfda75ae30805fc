//! The frame of every builder here: split a set in two, again and again.

use super::{AxisRule, BuildOptions, Topology, TopologyNode};
use crate::geom::Aabb;
use glam::Vec3A;

/// No node is deeper. After [`PATIENCE`] levels a builder's own rule gives way to halving, which ends in 32 more.
pub(crate) const MAX_DEPTH: usize = PATIENCE + 33;
const PATIENCE: usize = 63;

/// A primitive on its way into the tree: 28 bytes, moved rather than pointed to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference {
    pub(crate) bounds: Aabb,
    pub(crate) prim: u32,
}

impl Reference {
    /// Twice the centre of the box.
    #[inline]
    pub(crate) fn center2(&self) -> Vec3A {
        Vec3A::from(self.bounds.min) + Vec3A::from(self.bounds.max)
    }

    /// Twice the centre of the box along one axis.
    #[inline]
    pub(crate) fn center2_along(&self, axis: usize) -> f32 {
        self.bounds.min[axis] + self.bounds.max[axis]
    }
}

/// A set that is to be split.
pub(crate) struct Set<'a> {
    pub(crate) refs: &'a mut [Reference],
    pub(crate) depth: usize,
}

impl Set<'_> {
    /// The box around everything, and the box around the doubled centres.
    pub(crate) fn bounds(&self) -> (Aabb, Aabb) {
        let empty = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        let (mut all, mut centers) = (empty, empty);
        for r in self.refs.iter() {
            let (min, max) = (Vec3A::from(r.bounds.min), Vec3A::from(r.bounds.max));
            all = (all.0.min(min), all.1.max(max));
            centers = (centers.0.min(min + max), centers.1.max(min + max));
        }
        [all, centers]
            .map(|(min, max)| Aabb {
                min: min.to_array(),
                max: max.to_array(),
            })
            .into()
    }

    /// Brings the half with the smaller centres to the front and returns its length. Equal centres are told apart by
    /// the primitive's number, so the outcome does not depend on the order before.
    pub(crate) fn halve(&mut self, axis: usize) -> usize {
        let middle = self.refs.len() / 2;
        self.refs.select_nth_unstable_by(middle, |a, b| {
            a.center2_along(axis)
                .total_cmp(&b.center2_along(axis))
                .then(a.prim.cmp(&b.prim))
        });
        middle
    }

    /// Brings those for which `left` holds to the front and returns how many they are.
    pub(crate) fn partition(&mut self, left: impl Fn(&Reference) -> bool) -> usize {
        let (mut i, mut j) = (0, self.refs.len());
        loop {
            while i < j && left(&self.refs[i]) {
                i += 1;
            }
            while i < j && !left(&self.refs[j - 1]) {
                j -= 1;
            }
            if i >= j {
                return i;
            }
            self.refs.swap(i, j - 1);
        }
    }

    /// The axis that the rule picks.
    pub(crate) fn axis(&self, rule: AxisRule, centers: &Aabb) -> usize {
        match rule {
            AxisRule::RoundRobin => self.depth % 3,
            AxisRule::Longest => longest(centers),
        }
    }
}

/// The axis of the largest extent, the first of equals.
pub(crate) fn longest(bounds: &Aabb) -> usize {
    let [x, y, z] = bounds.extent();
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// Where to split: reorders the set and returns the length of its first part, or `None` for a leaf. A set larger
/// than the leaf limit is never a leaf; if the answer for it is not a real split, it is halved.
pub(crate) trait Split: Sync {
    fn split(&self, set: &mut Set<'_>) -> Option<usize>;
}

/// Runs the frame. `O(n log n)` calls of constant work per primitive; the scratch memory is 28 bytes per primitive.
pub(crate) fn top_down(boxes: &[Aabb], options: &BuildOptions, split: &impl Split) -> Topology {
    let finite = |b: &Aabb| !b.is_empty() && b.min.iter().chain(&b.max).all(|x| x.is_finite());
    let mut refs: Vec<Reference> = boxes
        .iter()
        .zip(0..)
        .filter(|(bounds, _)| finite(bounds))
        .map(|(bounds, prim)| Reference {
            bounds: *bounds,
            prim,
        })
        .collect();
    if refs.is_empty() {
        return Topology::default();
    }
    let frame = Frame {
        split,
        leaf_limit: options.leaf_limit(),
    };
    let mut nodes = Vec::with_capacity(refs.len());
    nodes.push(PLACEHOLDER);
    frame.grow(
        &mut nodes,
        0,
        Set {
            refs: &mut refs,
            depth: 0,
        },
        0,
    );
    Topology {
        nodes,
        order: refs.iter().map(|r| r.prim).collect(),
    }
}

const PLACEHOLDER: TopologyNode = TopologyNode { first: 0, count: 0 };

/// Sets above this size are worth a thread.
#[cfg(feature = "rayon")]
const PARALLEL: usize = 4096;

struct Frame<'a, S> {
    split: &'a S,
    leaf_limit: usize,
}

impl<S: Split> Frame<'_, S> {
    /// Makes `nodes[at]` the root of the tree over `set`, whose first reference is in slot `slot`.
    fn grow(&self, nodes: &mut Vec<TopologyNode>, at: usize, mut set: Set<'_>, slot: u32) {
        let count = set.refs.len();
        let Some(middle) = self.place(&mut set) else {
            nodes[at] = TopologyNode {
                first: slot,
                count: count as u32,
            };
            return;
        };
        let children = nodes.len();
        nodes[at] = TopologyNode {
            first: children as u32,
            count: 0,
        };
        nodes.extend([PLACEHOLDER; 2]);
        let depth = set.depth + 1;
        let (left, right) = set.refs.split_at_mut(middle);
        let (left, right) = (Set { refs: left, depth }, Set { refs: right, depth });
        let right_slot = slot + middle as u32;
        #[cfg(feature = "rayon")]
        if count > PARALLEL {
            let (a, b) = rayon::join(
                || self.grow_apart(left, slot),
                || self.grow_apart(right, right_slot),
            );
            graft(nodes, children, &a);
            graft(nodes, children + 1, &b);
            return;
        }
        self.grow(nodes, children, left, slot);
        self.grow(nodes, children + 1, right, right_slot);
    }

    /// The split of a set, by the builder's rule while that keeps the tree shallow.
    fn place(&self, set: &mut Set<'_>) -> Option<usize> {
        let count = set.refs.len();
        if count == 1 {
            return None;
        }
        if set.depth < PATIENCE {
            match self.split.split(set) {
                None if count <= self.leaf_limit => return None,
                Some(middle) if middle > 0 && middle < count => return Some(middle),
                _ => {}
            }
        } else if count <= self.leaf_limit {
            return None;
        }
        let axis = longest(&set.bounds().1);
        Some(set.halve(axis))
    }

    #[cfg(feature = "rayon")]
    fn grow_apart(&self, set: Set<'_>, slot: u32) -> Vec<TopologyNode> {
        let mut nodes = Vec::with_capacity(set.refs.len());
        nodes.push(PLACEHOLDER);
        self.grow(&mut nodes, 0, set, slot);
        nodes
    }
}

/// Puts a tree that was grown apart in the place where growing in sequence would have put it.
#[cfg(feature = "rayon")]
fn graft(nodes: &mut Vec<TopologyNode>, at: usize, branch: &[TopologyNode]) {
    let shift = nodes.len() as u32 - 1;
    nodes[at] = shifted(&branch[0], shift);
    nodes.extend(branch[1..].iter().map(|node| shifted(node, shift)));
}

#[cfg(feature = "rayon")]
fn shifted(node: &TopologyNode, shift: u32) -> TopologyNode {
    let first = if node.is_leaf() {
        node.first
    } else {
        node.first + shift
    };
    TopologyNode { first, ..*node }
}
