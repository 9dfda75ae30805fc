//! Bottom-up along a space-filling curve: a fast build of good trees.
//!
//! Primitives are sorted along a Morton curve, then neighbours on the curve whose common box is the smallest are merged,
//! again and again (Meister and Bittner, TVCG 2018). As in H-PLOC (Benthin et al. 2024) blocks of the curve are reduced to few
//! clusters before they join, so that the work stays in the cache and runs on many threads.

mod explain;
mod merge;
mod sort;

pub(super) use explain::explain;

use super::fragment::{Fragment, box_around};
use super::input::{LeafRule, Watch, room};
use super::top_down::{PATIENCE, join};
use super::{BuildInput, BuildOptions, Topology, TopologyNode};
use crate::error::BuildError;
use crate::geom::Aabb;
use fearless_simd::{Simd, dispatch};
use merge::{Clusters, MAX_FRAGMENTS, Merges, scale_of};

pub(super) fn build(
    input: &BuildInput<'_>,
    options: &BuildOptions,
) -> Result<Topology, BuildError> {
    let fragments = super::fragment::fragments(input)?;
    let watch = Watch::start(&options.progress, fragments.len())?;
    if fragments.is_empty() {
        return Ok(Topology::default());
    }
    let (count, limit) = (fragments.len(), MAX_FRAGMENTS);
    if count > limit {
        return Err(BuildError::TooManyPrimitives { count, limit });
    }
    let rule = input.leaf_rule(options);
    dispatch!(options.instructions.0, simd => cluster(simd, &fragments, &rule, &watch))
}

/// What a build over so many boxes holds at most: fragments, keys twice, merges, and at the end the tree.
pub(super) fn memory(count: usize, _: &BuildOptions) -> usize {
    count * (size_of::<Fragment>() + 16 + 8 + 4 + 2 * size_of::<TopologyNode>())
}

/// Clusters that are reduced at a time, and to how many.
const BLOCK: usize = 4096;
const REDUCED: usize = 256;

#[inline(always)]
fn cluster<S: Simd>(
    simd: S,
    fragments: &[Fragment],
    rule: &LeafRule,
    watch: &Watch<'_>,
) -> Result<Topology, BuildError> {
    let places = sort::places_along_curve(simd, fragments)?;
    let all = simd.vectorize(
        #[inline(always)]
        || box_around(simd, fragments),
    );
    let merges = Merges::new(fragments.len())?;
    let frame = Frame {
        simd,
        fragments,
        scale: scale_of(&all),
        rule,
        merges: &merges,
        watch,
    };
    let mut clusters = frame.reduced(&places, 0)?;
    clusters.reduce(simd, 1, rule, &merges);
    let layout = Layout {
        fragments,
        places: &places,
        merges: &merges,
    };
    layout.of(clusters.root())
}

struct Frame<'a, S> {
    simd: S,
    fragments: &'a [Fragment],
    scale: f32,
    rule: &'a LeafRule,
    merges: &'a Merges,
    watch: &'a Watch<'a>,
}

impl<S: Simd> Frame<'_, S> {
    /// At most [`BLOCK`] clusters over a part of the curve that begins at place `first`.
    fn reduced(&self, places: &[u64], first: u32) -> Result<Clusters, BuildError> {
        let mut clusters = if places.len() <= BLOCK {
            self.watch.advance(places.len())?;
            Clusters::new(self.fragments, places, self.scale, self.rule, first)?
        } else {
            // Blocks of equal size, so that borders do not depend on anything else.
            let middle = (places.len() / 2).next_multiple_of(BLOCK);
            let (left, right) = places.split_at(middle);
            let (left, right) = join(
                || self.reduced(left, first),
                || self.reduced(right, first + middle as u32),
            );
            Clusters::joined([left?, right?])?
        };
        if clusters.len() > BLOCK / 2 {
            clusters.reduce(self.simd, REDUCED, self.rule, self.merges);
        }
        Ok(clusters)
    }
}

/// From merges to nodes.
struct Layout<'a> {
    fragments: &'a [Fragment],
    places: &'a [u64],
    merges: &'a Merges,
}

impl Layout<'_> {
    fn of(&self, root: u32) -> Result<Topology, BuildError> {
        let mut tree = Topology {
            nodes: room(2 * self.fragments.len() - 1)?,
            order: room(self.fragments.len())?,
            is_split: false,
        };
        tree.nodes.push(TopologyNode::PLACEHOLDER);
        self.put(root, 0, 0, &mut tree);
        for i in (0..tree.nodes.len()).rev() {
            let node = tree.nodes[i];
            tree.nodes[i].bounds = if node.is_leaf() {
                let prims = &mut tree.order[node.first as usize..][..node.count as usize];
                let mut all = Aabb::EMPTY;
                for place in prims {
                    let fragment = &self.fragments[*place as usize];
                    all = all.union(&fragment.bounds());
                    *place = fragment.number();
                }
                all
            } else {
                let first = node.first as usize;
                tree.nodes[first]
                    .bounds
                    .union(&tree.nodes[first + 1].bounds)
            };
        }
        Ok(tree)
    }

    /// Makes `nodes[at]` the root of the tree below a node; `order` gets places of fragments. At most [`PATIENCE`] deep, and
    /// then halved.
    fn put(&self, node: u32, at: usize, depth: usize, tree: &mut Topology) {
        let slot = tree.order.len() as u32;
        match self.merges.children(node) {
            Some((children, false)) if depth < PATIENCE => {
                let first = tree.nodes.len();
                tree.nodes[at].first = first as u32;
                tree.nodes.extend([TopologyNode::PLACEHOLDER; 2]);
                self.put(children[0], first, depth + 1, tree);
                self.put(children[1], first + 1, depth + 1, tree);
            }
            Some((_, is_leaf)) => {
                self.collect(node, &mut tree.order);
                let count = tree.order.len() as u32 - slot;
                if is_leaf {
                    tree.nodes[at] = TopologyNode::leaf(Aabb::EMPTY, slot, count);
                } else {
                    halve(at, slot, count, &mut tree.nodes);
                }
            }
            None => {
                tree.order.push(self.places[node as usize] as u32);
                tree.nodes[at] = TopologyNode::leaf(Aabb::EMPTY, slot, 1);
            }
        }
    }

    /// Appends all fragments below a node.
    fn collect(&self, node: u32, order: &mut Vec<u32>) {
        let mut waiting = vec![node];
        while let Some(node) = waiting.pop() {
            match self.merges.children(node) {
                Some((children, _)) => waiting.extend(children),
                None => order.push(self.places[node as usize] as u32),
            }
        }
    }
}

/// A balanced tree over slots, one each.
fn halve(at: usize, slot: u32, count: u32, nodes: &mut Vec<TopologyNode>) {
    if count == 1 {
        nodes[at] = TopologyNode::leaf(Aabb::EMPTY, slot, 1);
        return;
    }
    let first = nodes.len();
    nodes[at].first = first as u32;
    nodes.extend([TopologyNode::PLACEHOLDER; 2]);
    halve(first, slot, count / 2, nodes);
    halve(first + 1, slot + count / 2, count - count / 2, nodes);
}
