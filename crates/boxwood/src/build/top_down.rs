//! The frame of every builder here: split a set in two, again and again.

mod explain;

pub(crate) use explain::{Look, between, explain, halved};

use super::input::{Watch, room};
use super::{AxisRule, BuildInput, BuildOptions, Topology, TopologyNode};
use crate::error::BuildError;
use crate::geom::Aabb;
use glam::Vec3A;

/// No node is deeper. After [`PATIENCE`] levels a builder's own rule gives way to halving, which ends in 32 more.
pub(crate) const MAX_DEPTH: usize = PATIENCE + 33;
pub(super) const PATIENCE: usize = 63;

/// A primitive on its way into the tree: 28 bytes, moved rather than pointed to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference {
    pub(crate) bounds: Aabb,
    pub(crate) prim: u32,
}

impl Reference {
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
    /// The box around everything.
    pub(crate) bounds: Aabb,
    /// The box around the doubled centres.
    pub(crate) centers: Aabb,
}

impl<'a> Set<'a> {
    fn new(refs: &'a mut [Reference], depth: usize) -> Self {
        let empty = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        let (mut all, mut centers) = (empty, empty);
        for r in refs.iter() {
            let (min, max) = (Vec3A::from(r.bounds.min), Vec3A::from(r.bounds.max));
            all = (all.0.min(min), all.1.max(max));
            centers = (centers.0.min(min + max), centers.1.max(min + max));
        }
        let [bounds, centers] = [all, centers].map(|(min, max)| Aabb {
            min: min.to_array(),
            max: max.to_array(),
        });
        Self {
            refs,
            depth,
            bounds,
            centers,
        }
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
    fn split(&self, set: &mut Set<'_>) -> Result<Option<usize>, BuildError>;

    /// What [`Split::split`] weighs, for explaining.
    fn look(&self, set: &mut Set<'_>) -> Result<Look, BuildError>;
}

/// The parts of a set.
struct Cut {
    /// Length of the first.
    middle: usize,
    /// The frame halved it, not the builder's rule.
    is_halved: bool,
}

/// Runs the frame. `O(n log n)` calls of constant work per primitive.
pub(crate) fn top_down(
    input: &BuildInput<'_>,
    options: &BuildOptions,
    split: &impl Split,
) -> Result<Topology, BuildError> {
    let kept = |(bounds, _): &(&Aabb, u32)| bounds.is_in_domain();
    let mut refs = room(input.boxes.len())?;
    refs.extend(
        input
            .boxes
            .iter()
            .zip(0..)
            .filter(kept)
            .map(|(bounds, prim)| Reference {
                bounds: *bounds,
                prim,
            }),
    );
    let frame = Frame {
        split,
        leaf_limit: input.leaf_limit(options),
        watch: Watch::start(&options.progress, refs.len())?,
    };
    if refs.is_empty() {
        return Ok(Topology::default());
    }
    let nodes = frame.grow_apart(Set::new(&mut refs, 0), 0)?;
    let mut order = room(refs.len())?;
    order.extend(refs.iter().map(|r| r.prim));
    Ok(Topology {
        nodes,
        order,
        is_split: false,
    })
}

/// What the frame holds at most: the references, the nodes twice (they are put together from branches), the order.
pub(crate) fn memory(count: usize, _: &BuildOptions) -> usize {
    count * (size_of::<Reference>() + 4 * size_of::<TopologyNode>() + size_of::<u32>())
}

/// Sets above this size are worth a thread, and a word about progress.
pub(super) const LARGE: usize = 4096;

struct Frame<'a, S> {
    split: &'a S,
    leaf_limit: usize,
    watch: Watch<'a>,
}

impl<S: Split> Frame<'_, S> {
    /// Makes `nodes[at]` the root of the tree over `set`, whose first reference is in slot `slot`.
    fn grow(
        &self,
        nodes: &mut Vec<TopologyNode>,
        at: usize,
        mut set: Set<'_>,
        slot: u32,
    ) -> Result<(), BuildError> {
        let count = set.refs.len();
        let Some(Cut { middle, .. }) = self.place(&mut set)? else {
            nodes[at] = TopologyNode::leaf(set.bounds, slot, count as u32);
            return Ok(());
        };
        let children = nodes.len();
        nodes[at] = TopologyNode::inner(set.bounds, children as u32);
        nodes.extend([TopologyNode::PLACEHOLDER; 2]);
        let depth = set.depth + 1;
        let (left, right) = set.refs.split_at_mut(middle);
        let right_slot = slot + middle as u32;
        if count > LARGE {
            let (a, b) = join(
                || self.grow_apart(Set::new(left, depth), slot),
                || self.grow_apart(Set::new(right, depth), right_slot),
            );
            graft(nodes, children, &a?);
            graft(nodes, children + 1, &b?);
            return Ok(());
        }
        self.grow(nodes, children, Set::new(left, depth), slot)?;
        self.grow(nodes, children + 1, Set::new(right, depth), right_slot)
    }

    /// The split of a set, by the builder's rule while that keeps the tree shallow.
    fn place(&self, set: &mut Set<'_>) -> Result<Option<Cut>, BuildError> {
        let count = set.refs.len();
        if count == 1 {
            return Ok(None);
        }
        if set.depth < PATIENCE {
            match self.split.split(set)? {
                None if count <= self.leaf_limit => return Ok(None),
                Some(middle) if middle > 0 && middle < count => {
                    return Ok(Some(Cut {
                        middle,
                        is_halved: false,
                    }));
                }
                _ => {}
            }
        } else if count <= self.leaf_limit {
            return Ok(None);
        }
        let axis = longest(&set.centers);
        Ok(Some(Cut {
            middle: set.halve(axis),
            is_halved: true,
        }))
    }

    fn grow_apart(&self, set: Set<'_>, slot: u32) -> Result<Vec<TopologyNode>, BuildError> {
        let count = set.refs.len();
        let mut nodes = room(2 * count - 1)?;
        nodes.push(TopologyNode::PLACEHOLDER);
        self.grow(&mut nodes, 0, set, slot)?;
        if count <= LARGE {
            self.watch.advance(count)?;
        }
        Ok(nodes)
    }
}

/// Both, on two threads where that is compiled in.
pub(crate) fn join<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "rayon")]
    return rayon::join(a, b);
    #[cfg(not(feature = "rayon"))]
    return (a(), b());
}

/// Puts a tree that was grown apart in the place where growing in sequence would have put it.
pub(super) fn graft(nodes: &mut Vec<TopologyNode>, at: usize, branch: &[TopologyNode]) {
    let shift = nodes.len() as u32 - 1;
    nodes[at] = shifted(&branch[0], shift);
    nodes.extend(branch[1..].iter().map(|node| shifted(node, shift)));
}

fn shifted(node: &TopologyNode, shift: u32) -> TopologyNode {
    let first = if node.is_leaf() {
        node.first
    } else {
        node.first + shift
    };
    TopologyNode { first, ..*node }
}
