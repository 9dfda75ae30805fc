//! The surface area heuristic, tried only at the borders of bins.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", IEEE RT 2007. Boxes of sides come from the bins;
//! while a set is split, both sides are sorted into their bins (Hendrich, Meister, Bittner, "Parallel BVH Construction using
//! Progressive Hierarchical Refinement", 2017, has a like pass). A box is one vector with its lower corner negated, so that a
//! union is one `max`.

mod bins;
mod explain;
mod partition;

pub(super) use explain::explain;

use super::fragment::{Fragment, Lanes, Scale, box_around, range_of_centers};
use super::input::{LeafRule, Watch, filled, room};
use super::presplit::{drop_copies, split_fragments};
use super::reinsert::optimize;
use super::top_down::{LARGE, PATIENCE, graft, join};
use super::{BuildInput, BuildOptions, Topology, TopologyNode};
use crate::error::BuildError;
use bins::{Binned, Border, Packed, Table};
use fearless_simd::{Simd, dispatch};
use partition::{partition, partition_and_bin};

pub(super) fn build(
    input: &BuildInput<'_>,
    options: &BuildOptions,
) -> Result<Topology, BuildError> {
    let fragments = split_fragments(input, options.split_budget)?;
    let is_split = fragments.len() > input.boxes.len();
    let watch = Watch::start(&options.progress, fragments.len())?;
    let mut tree = of_fragments(fragments, input, options, &watch)?;
    if is_split {
        drop_copies(&mut tree);
    }
    optimize(tree, options, &watch)
}

/// A tree over fragments of primitives.
fn of_fragments(
    mut fragments: Vec<Fragment>,
    input: &BuildInput<'_>,
    options: &BuildOptions,
    watch: &Watch<'_>,
) -> Result<Topology, BuildError> {
    let count = fragments.len();
    if count == 0 {
        return Ok(Topology::default());
    }
    let mut spare = filled(Lanes::EMPTY, count)?;
    let mut order = filled(0, count)?;
    let rule = input.leaf_rule(options);
    let bins = (options.bins as usize).clamp(2, 32);
    let set = Set {
        from: &mut fragments,
        to: &mut spare,
        order: &mut order,
        bounds: Lanes::EMPTY,
        slot: 0,
        depth: 0,
    };
    let piece = dispatch!(options.instructions.0, simd => match bins {
        ..=8 => Frame::<_, 8> { simd, rule, bins, watch }.grow_all(set),
        9..=16 => Frame::<_, 16> { simd, rule, bins, watch }.grow_all(set),
        _ => Frame::<_, 32> { simd, rule, bins, watch }.grow_all(set),
    })?;
    let mut nodes = room(piece.node_count())?;
    nodes.push(TopologyNode::PLACEHOLDER);
    piece.put(0, &mut nodes);
    Ok(Topology {
        nodes,
        order,
        is_split: false,
    })
}

/// What a build over so many boxes holds at most: fragments twice, those of parts included; the order; nodes twice, then
/// with their parents.
pub(super) fn memory(count: usize, options: &BuildOptions) -> usize {
    let budget = f64::from(options.split_budget.clamp(0.0, 4.0));
    let parts = count + (count as f64 * budget) as usize;
    let tree = 4 * size_of::<TopologyNode>() + 2 * size_of::<Fragment>() + 5 * size_of::<u32>();
    count * size_of::<Fragment>() + parts * (2 * size_of::<Fragment>() + tree)
}

/// Sets up to this size get bins that fit their centres exactly; for larger ones a pass for that would cost more than it
/// gives.
const SMALL: usize = 64;
/// Bins of small sets.
const FEW: usize = 8;

/// A set that is to become a tree.
struct Set<'a> {
    from: &'a mut [Fragment],
    /// Room for as many.
    to: &'a mut [Fragment],
    /// The slots that it will fill, the first of which is `slot`.
    order: &'a mut [u32],
    slot: u32,
    bounds: Lanes,
    depth: usize,
}

impl<'a> Set<'a> {
    fn len(&self) -> usize {
        self.from.len()
    }

    /// Both parts, where `from` holds them one after the other.
    fn parts(self, middle: usize, boxes: [Lanes; 2]) -> [Set<'a>; 2] {
        let (from_left, from_right) = self.from.split_at_mut(middle);
        let (to_left, to_right) = self.to.split_at_mut(middle);
        let (order_left, order_right) = self.order.split_at_mut(middle);
        let depth = self.depth + 1;
        [
            Set {
                from: from_left,
                to: to_left,
                order: order_left,
                slot: self.slot,
                bounds: boxes[0],
                depth,
            },
            Set {
                from: from_right,
                to: to_right,
                order: order_right,
                slot: self.slot + middle as u32,
                bounds: boxes[1],
                depth,
            },
        ]
    }

    /// The same where `to` holds them.
    fn moved_parts(mut self, border: &Border) -> [Set<'a>; 2] {
        std::mem::swap(&mut self.from, &mut self.to);
        self.parts(border.left_count, border.boxes)
    }

    fn into_leaf(self) -> TopologyNode {
        for (slot, fragment) in self.order.iter_mut().zip(&*self.from) {
            *slot = fragment.number();
        }
        TopologyNode::leaf(self.bounds.bounds(), self.slot, self.order.len() as u32)
    }
}

/// A tree that was grown in parts.
enum Piece {
    Whole(Vec<TopologyNode>),
    Split(TopologyNode, Box<[Piece; 2]>),
}

impl Piece {
    fn node_count(&self) -> usize {
        match self {
            Self::Whole(nodes) => nodes.len(),
            Self::Split(_, sides) => 1 + sides[0].node_count() + sides[1].node_count(),
        }
    }

    /// Puts the tree to the end of `nodes`, its root to the place `at`.
    fn put(&self, at: usize, nodes: &mut Vec<TopologyNode>) {
        match self {
            Self::Whole(part) => graft(nodes, at, part),
            Self::Split(node, sides) => {
                let children = nodes.len();
                nodes[at] = TopologyNode {
                    first: children as u32,
                    ..*node
                };
                nodes.extend([TopologyNode::PLACEHOLDER; 2]);
                sides[0].put(children, nodes);
                sides[1].put(children + 1, nodes);
            }
        }
    }
}

struct Frame<'a, S, const N: usize> {
    simd: S,
    rule: LeafRule,
    bins: usize,
    watch: &'a Watch<'a>,
}

/// The bins of both sides of a set, and of what is below: used again and again.
struct Level<const N: usize> {
    sides: [Binned<N>; 2],
    below: Option<Box<Level<N>>>,
}

impl<const N: usize> Level<N> {
    fn new() -> Box<Self> {
        Box::new(Self {
            sides: [Binned::new(), Binned::new()],
            below: None,
        })
    }
}

impl<S: Simd, const N: usize> Frame<'_, S, N> {
    fn grow_all(&self, mut set: Set<'_>) -> Result<Piece, BuildError> {
        set.bounds = self.simd.vectorize(
            #[inline(always)]
            || box_around(self.simd, set.from),
        );
        let mut binned = Binned::new();
        self.bin(set.from, &mut binned);
        self.grow_piece(set, &binned)
    }

    /// Sorts a set into bins of its own.
    fn bin(&self, fragments: &[Fragment], binned: &mut Binned<N>) {
        self.simd.vectorize(
            #[inline(always)]
            || {
                let range = range_of_centers(self.simd, fragments);
                binned.scale = Scale::new(&range, self.bins);
                binned.table.clear();
                let scale = binned.scale.load(self.simd);
                binned.table.add_all(self.simd, fragments, &scale);
            },
        );
    }

    /// The tree over a set of any size, sides of large ones on threads of their own.
    fn grow_piece(&self, set: Set<'_>, binned: &Binned<N>) -> Result<Piece, BuildError> {
        let count = set.len();
        let mut level = Level::new();
        if count > LARGE {
            let node = TopologyNode::inner(set.bounds.bounds(), 0);
            let [left, right] = self.split(set, binned, &mut level.sides);
            let [for_left, for_right] = &level.sides;
            let (left, right) = join(
                || self.grow_piece(left, for_left),
                || self.grow_piece(right, for_right),
            );
            return Ok(Piece::Split(node, Box::new([left?, right?])));
        }
        let mut nodes = room(2 * count - 1)?;
        nodes.push(TopologyNode::PLACEHOLDER);
        self.grow(&mut nodes, 0, set, binned, &mut level);
        self.watch.advance(count)?;
        Ok(Piece::Whole(nodes))
    }

    /// Makes `nodes[at]` the root of the tree over a set.
    fn grow(
        &self,
        nodes: &mut Vec<TopologyNode>,
        at: usize,
        set: Set<'_>,
        binned: &Binned<N>,
        level: &mut Level<N>,
    ) {
        if set.len() <= SMALL {
            return self.grow_small(nodes, at, set);
        }
        let children = nodes.len();
        nodes[at] = TopologyNode::inner(set.bounds.bounds(), children as u32);
        nodes.extend([TopologyNode::PLACEHOLDER; 2]);
        let [left, right] = self.split(set, binned, &mut level.sides);
        let below = level.below.get_or_insert_with(Level::new);
        self.grow(nodes, children, left, &level.sides[0], below);
        self.grow(nodes, children + 1, right, &level.sides[1], below);
    }

    /// Splits a set that is too large for a leaf, and sorts sides that are not small into bins.
    fn split<'s>(
        &self,
        set: Set<'s>,
        binned: &Binned<N>,
        sides: &mut [Binned<N>; 2],
    ) -> [Set<'s>; 2] {
        let Binned { scale, table } = binned;
        let border = self.simd.vectorize(
            #[inline(always)]
            || table.best_border(self.simd, &set.bounds, set.len(), self.rule.extra()),
        );
        let Some(border) = border.filter(|_| set.depth < PATIENCE) else {
            let halves = self.halve(set);
            self.bin(halves[0].from, &mut sides[0]);
            self.bin(halves[1].from, &mut sides[1]);
            return halves;
        };
        let larger = border.left_count.max(set.len() - border.left_count);
        self.simd.vectorize(
            #[inline(always)]
            || {
                if larger <= SMALL {
                    partition(self.simd, set.from, set.to, scale, &border);
                    return;
                }
                for (side, binned) in sides.iter_mut().enumerate() {
                    let bounds = &border.boxes[side];
                    let range = scale.range_beside(border.axis, border.bin, side == 0, bounds);
                    binned.scale = Scale::new(&range, self.bins);
                    binned.table.clear();
                }
                partition_and_bin(self.simd, set.from, set.to, scale, &border, sides);
            },
        );
        set.moved_parts(&border)
    }

    /// Makes `nodes[at]` the root of the tree over a small set.
    fn grow_small(&self, nodes: &mut Vec<TopologyNode>, at: usize, set: Set<'_>) {
        self.simd.vectorize(
            #[inline(always)]
            || self.grow_small_vectorized(nodes, at, set),
        );
    }

    #[inline(always)]
    fn grow_small_vectorized(&self, nodes: &mut Vec<TopologyNode>, at: usize, set: Set<'_>) {
        let count = set.len();
        if count <= self.rule.enough as usize {
            nodes[at] = set.into_leaf();
            return;
        }
        let range = range_of_centers(self.simd, set.from);
        let scale = Scale::new(&range, FEW);
        let mut table = Table::<FEW, Packed>::new();
        table.add_all(self.simd, set.from, &scale.load(self.simd));
        let border = table
            .best_border(self.simd, &set.bounds, count, self.rule.extra())
            .filter(|_| set.depth < PATIENCE);
        let is_dear = border
            .as_ref()
            .is_some_and(|b| self.rule.splits(count, b.cost));
        if count <= self.rule.max as usize && !is_dear {
            nodes[at] = set.into_leaf();
            return;
        }
        let children = nodes.len();
        nodes[at] = TopologyNode::inner(set.bounds.bounds(), children as u32);
        nodes.extend([TopologyNode::PLACEHOLDER; 2]);
        let [left, right] = if let Some(border) = border {
            partition(self.simd, set.from, set.to, &scale, &border);
            set.moved_parts(&border)
        } else {
            self.halve(set)
        };
        self.grow_small(nodes, children, left);
        self.grow_small(nodes, children + 1, right);
    }

    /// Two parts of equal size along the longest axis of centres. Equal centres are told apart by number.
    #[cold]
    fn halve<'s>(&self, set: Set<'s>) -> [Set<'s>; 2] {
        let range = range_of_centers(self.simd, set.from).bounds();
        let axis = super::top_down::longest(&range);
        let middle = set.len() / 2;
        set.from.select_nth_unstable_by(middle, |a, b| {
            a.center2_along(axis)
                .total_cmp(&b.center2_along(axis))
                .then(a.number().cmp(&b.number()))
        });
        let (left, right) = set.from.split_at(middle);
        let boxes = [left, right].map(|part| box_around(self.simd, part));
        set.parts(middle, boxes)
    }
}
