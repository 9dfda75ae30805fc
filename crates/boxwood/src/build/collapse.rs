//! From a binary tree to one whose nodes have up to eight children.
//!
//! Which binary nodes survive, and which subtrees become one leaf, is the choice of least cost under the surface area
//! heuristic: Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017,
//! section 3.1. It is found by dynamic programming, bottom-up, in linear time.

use super::input::{filled, room};
use super::measure::Measure;
use super::top_down::MAX_DEPTH;
use super::topology::{Topology, TopologyNode};
use crate::error::BuildError;
use crate::geom::Aabb;
use std::ops::Range;

/// Most children of a wide node.
pub(crate) const MAX_WIDTH: usize = 8;

/// A tree of wide nodes. Depth first: of a node's inner children the one of the largest area stands right behind it. At
/// most as deep as the binary tree, which is at most 96.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WideTopology {
    /// The box around everything.
    pub bounds: Aabb,
    /// The children of all nodes in a row; `first` of an inner child is the number of its node.
    pub children: Vec<TopologyNode>,
    /// Node `i` has the children `starts[i]..starts[i + 1]`. Empty if the tree is.
    pub starts: Vec<u32>,
    /// Slot to primitive, in the order in which leaves stand in `children`.
    pub order: Vec<u32>,
}

impl WideTopology {
    /// How many nodes.
    pub fn node_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// The children of a node, largest area first. The root, node 0, has one child if everything is in one leaf, every
    /// other node has at least two.
    pub fn node(&self, index: usize) -> &[TopologyNode] {
        &self.children[self.starts[index] as usize..self.starts[index + 1] as usize]
    }
}

/// How binary nodes are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CollapseRule {
    /// The least cost.
    #[default]
    Optimal,
    /// The child of the largest area is opened again and again, leaves stay as they are: what most libraries do, for
    /// comparison.
    Greedy,
}

/// What a traversal pays, in visits of a wide node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollapseOptions {
    /// Most children of a node, 2 to 8.
    pub width: usize,
    /// Most primitives in a leaf; leaves of the binary tree that are larger stay.
    pub max_leaf: u32,
    /// What a visit of a leaf costs, where visiting a node costs 1.
    pub leaf_cost: LeafCost,
    /// How binary nodes are chosen.
    pub rule: CollapseRule,
}

impl Default for CollapseOptions {
    fn default() -> Self {
        Self {
            width: MAX_WIDTH,
            max_leaf: 8,
            leaf_cost: LeafCost::ROWS_OF_8,
            rule: CollapseRule::Optimal,
        }
    }
}

/// What a visit of a leaf costs: `base + per_primitive * n`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeafCost {
    /// For any leaf.
    pub base: f32,
    /// For each primitive in it.
    pub per_primitive: f32,
}

impl LeafCost {
    /// Eight triangles are tested at once.
    pub const ROWS_OF_8: Self = Self {
        base: 0.7,
        per_primitive: 0.06,
    };

    /// Of a leaf of `count` primitives.
    #[inline]
    pub fn of(&self, count: u32) -> f32 {
        self.base + self.per_primitive * count as f32
    }
}

impl Topology {
    /// Makes the tree wide. Linear in nodes; holds 40 bytes per binary node meanwhile.
    ///
    /// # Errors
    /// [`BuildError::OutOfMemory`].
    pub fn collapse(&self, options: &CollapseOptions) -> Result<WideTopology, BuildError> {
        let Some(root) = self.nodes.first() else {
            return Ok(WideTopology::default());
        };
        let plan = Plan::new(self, options)?;
        let mut wide = WideTopology {
            bounds: root.bounds,
            children: room(self.nodes.len())?,
            starts: room(self.nodes.len() + 1)?,
            order: room(self.order.len())?,
        };
        plan.emit(&mut wide)?;
        Ok(wide)
    }
}

/// The least costs of everything below a binary node, relative to the area of the root.
#[derive(Clone, Copy, Debug)]
struct Costs {
    /// `as_children[i]`: if it may take up to `i + 1` places among the children of a wide node. Falls with `i`.
    as_children: [f32; MAX_WIDTH],
    /// If it is one leaf; infinite if it must not be.
    as_leaf: f32,
}

/// A binary tree with the costs of its nodes.
struct Plan<'a> {
    tree: &'a Topology,
    options: CollapseOptions,
    measure: Measure,
    /// Empty for the greedy rule.
    costs: Vec<Costs>,
    slots: Vec<Range<u32>>,
}

impl<'a> Plan<'a> {
    fn new(tree: &'a Topology, options: &CollapseOptions) -> Result<Self, BuildError> {
        let mut plan = Self {
            tree,
            options: CollapseOptions {
                width: options.width.clamp(2, MAX_WIDTH),
                ..*options
            },
            measure: Measure::new(&tree.nodes[0].bounds),
            costs: Vec::new(),
            slots: filled(0..0, tree.nodes.len())?,
        };
        if options.rule == CollapseRule::Optimal {
            plan.costs = filled(
                Costs {
                    as_children: [0.0; MAX_WIDTH],
                    as_leaf: 0.0,
                },
                tree.nodes.len(),
            )?;
        }
        for index in (0..tree.nodes.len()).rev() {
            plan.settle(index);
        }
        Ok(plan)
    }

    /// Finds slots and costs of a node from those of its children, which come after it.
    #[inline]
    fn settle(&mut self, index: usize) {
        let node = &self.tree.nodes[index];
        let first = node.first as usize;
        self.slots[index] = if node.is_leaf() {
            node.slots()
        } else {
            self.slots[first].start..self.slots[first + 1].end
        };
        if self.costs.is_empty() {
            return;
        }
        let area = self.measure.area(&node.bounds);
        let count = self.slots[index].len() as u32;
        let leaf = area * self.options.leaf_cost.of(count);
        self.costs[index] = if node.is_leaf() {
            Costs {
                as_children: [leaf; MAX_WIDTH],
                as_leaf: leaf,
            }
        } else {
            let as_leaf = if count <= self.options.max_leaf {
                leaf
            } else {
                f32::INFINITY
            };
            let [left, right] = [first, first + 1].map(|child| &self.costs[child].as_children);
            let mut as_children = distributed(left, right);
            // One place: a leaf, or a node of its own with all places for the two sides.
            as_children[0] = smaller(as_leaf, as_children[self.options.width - 1] + area);
            for places in 1..MAX_WIDTH {
                as_children[places] = smaller(as_children[places], as_children[places - 1]);
            }
            Costs {
                as_children,
                as_leaf,
            }
        };
    }

    /// Writes the chosen nodes, depth first, and their leaves.
    fn emit(&self, wide: &mut WideTopology) -> Result<(), BuildError> {
        let mut waiting = room(MAX_WIDTH * MAX_DEPTH)?;
        self.write(&self.children_of_root(), wide, &mut waiting);
        while let Some(Waiting { index, place }) = waiting.pop() {
            wide.children[place as usize].first = wide.starts.len() as u32;
            let chosen = self.children_of(index);
            self.write(&chosen, wide, &mut waiting);
        }
        wide.starts.push(wide.children.len() as u32);
        Ok(())
    }
}

/// The children of a wide node, before they have their place.
struct Chosen {
    nodes: [u32; MAX_WIDTH],
    count: usize,
}

/// A binary node that is to become a wide one, and the place among all children that is to know its number.
struct Waiting {
    index: u32,
    place: u32,
}

impl Chosen {
    const NONE: Self = Self {
        nodes: [0; MAX_WIDTH],
        count: 0,
    };

    fn push(&mut self, node: u32) {
        self.nodes[self.count] = node;
        self.count += 1;
    }
}

impl Plan<'_> {
    fn node(&self, index: u32) -> &TopologyNode {
        &self.tree.nodes[index as usize]
    }

    fn area(&self, index: u32) -> f32 {
        self.measure.area(&self.node(index).bounds)
    }

    /// True if a binary node becomes a leaf as a child of a wide node.
    fn becomes_leaf(&self, index: u32) -> bool {
        let costs = self.costs.get(index as usize);
        let fits = self.slots[index as usize].len() as u32 <= self.options.max_leaf;
        self.node(index).is_leaf() || (fits && costs.is_some_and(|c| c.as_leaf <= c.as_children[0]))
    }

    fn children_of_root(&self) -> Chosen {
        if self.becomes_leaf(0) {
            let mut only = Chosen::NONE;
            only.push(0);
            return only;
        }
        self.children_of(0)
    }

    /// The children of an inner binary node that becomes a wide one, largest area first.
    fn children_of(&self, index: u32) -> Chosen {
        let mut chosen = Chosen::NONE;
        if self.costs.is_empty() {
            self.open_greedily(index, &mut chosen);
        } else {
            self.distribute(index, self.options.width, &mut chosen);
        }
        // By insertion, since there are at most eight; equal areas keep the order of the binary tree.
        let mut areas = [0.0; MAX_WIDTH];
        for i in 0..chosen.count {
            let (node, area) = (chosen.nodes[i], self.area(chosen.nodes[i]));
            let mut to = i;
            while to > 0 && areas[to - 1] < area {
                (areas[to], chosen.nodes[to]) = (areas[to - 1], chosen.nodes[to - 1]);
                to -= 1;
            }
            (areas[to], chosen.nodes[to]) = (area, node);
        }
        chosen
    }

    /// Adds the cheapest choice of at most `places` binary nodes that have the place of `index` among them.
    fn choose(&self, index: u32, places: usize, chosen: &mut Chosen) {
        let costs = &self.costs[index as usize].as_children;
        // More places than help are for nobody.
        let places = (1..places)
            .find(|p| costs[p - 1] <= costs[places - 1])
            .unwrap_or(places);
        if places == 1 {
            chosen.push(index);
        } else {
            self.distribute(index, places, chosen);
        }
    }

    /// Adds the cheapest choice from both children of an inner node.
    fn distribute(&self, index: u32, places: usize, chosen: &mut Chosen) {
        let first = self.node(index).first;
        let [left, right] = [first, first + 1].map(|child| &self.costs[child as usize].as_children);
        let cost = |for_left: &usize| left[for_left - 1] + right[places - for_left - 1];
        let best = (1..places).min_by(|a, b| cost(a).total_cmp(&cost(b)));
        let for_left = best.unwrap_or(1);
        self.choose(first, for_left, chosen);
        self.choose(first + 1, places - for_left, chosen);
    }

    /// Opens the child of the largest area until there are enough.
    fn open_greedily(&self, index: u32, chosen: &mut Chosen) {
        let first = self.node(index).first;
        chosen.push(first);
        chosen.push(first + 1);
        while chosen.count < self.options.width {
            let inner = (0..chosen.count).filter(|&i| !self.node(chosen.nodes[i]).is_leaf());
            let area = |i: &usize| self.area(chosen.nodes[*i]);
            let Some(largest) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else {
                return;
            };
            let first = self.node(chosen.nodes[largest]).first;
            chosen.nodes[largest] = first;
            chosen.push(first + 1);
        }
    }

    /// Writes a wide node with its leaves. Inner children wait for their number, the one of the largest area on top.
    fn write(&self, chosen: &Chosen, wide: &mut WideTopology, waiting: &mut Vec<Waiting>) {
        let start = wide.children.len() as u32;
        wide.starts.push(start);
        for &index in &chosen.nodes[..chosen.count] {
            let bounds = self.node(index).bounds;
            let child = if self.becomes_leaf(index) {
                let slots = self.slots[index as usize].clone();
                let first = wide.order.len() as u32;
                let prims = &self.tree.order[slots.start as usize..slots.end as usize];
                if self.tree.is_split {
                    extend_with_new(&mut wide.order, prims);
                } else {
                    wide.order.extend_from_slice(prims);
                }
                TopologyNode::leaf(bounds, first, wide.order.len() as u32 - first)
            } else {
                TopologyNode::inner(bounds, 0)
            };
            wide.children.push(child);
        }
        for i in (0..chosen.count).rev() {
            let (index, place) = (chosen.nodes[i], start + i as u32);
            if !wide.children[place as usize].is_leaf() {
                waiting.push(Waiting { index, place });
            }
        }
    }
}

/// Appends each primitive once.
fn extend_with_new(order: &mut Vec<u32>, prims: &[u32]) {
    let first = order.len();
    for prim in prims {
        if !order[first..].contains(prim) {
            order.push(*prim);
        }
    }
}

/// The least costs of the places 2 to 8 for both sides of a node together, each side having at least one.
#[inline]
fn distributed(left: &[f32; MAX_WIDTH], right: &[f32; MAX_WIDTH]) -> [f32; MAX_WIDTH] {
    // `padded[8 + i]` is `right[i]`, so that each step of the loop is one shift of all places.
    let mut padded = [f32::INFINITY; 2 * MAX_WIDTH];
    padded[MAX_WIDTH..].copy_from_slice(right);
    let mut best = [f32::INFINITY; MAX_WIDTH];
    for k in 1..MAX_WIDTH {
        let shifted = &padded[MAX_WIDTH - k..2 * MAX_WIDTH - k];
        for (best, right) in best.iter_mut().zip(shifted) {
            *best = smaller(left[k - 1] + right, *best);
        }
    }
    best
}

/// One instruction, unlike `f32::min`.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildInput, BuildOptions, Builder};
    use crate::testing::Random;

    fn cloud(n: usize) -> Vec<Aabb> {
        let mut random = Random::new(3);
        (0..n)
            .map(|_| {
                let p = [random.signed() * 3.0, random.signed(), random.unit()];
                Aabb::of_points(&[p, p.map(|x| x + random.unit() * 0.1)])
            })
            .collect()
    }

    fn binary(boxes: &[Aabb], max_leaf: u32) -> Topology {
        let options = BuildOptions {
            max_leaf,
            ..BuildOptions::with(Builder::BINNED)
        };
        Builder::BINNED
            .build(&BuildInput::of_boxes(boxes), &options)
            .unwrap()
    }

    fn both_rules() -> [CollapseOptions; 2] {
        [CollapseRule::Optimal, CollapseRule::Greedy].map(|rule| CollapseOptions {
            rule,
            ..CollapseOptions::default()
        })
    }

    /// Checks that each primitive is in one leaf, boxes nest, areas fall and the largest child follows; gives the depth.
    fn checked_depth(wide: &WideTopology, boxes: &[Aabb], options: &CollapseOptions) -> usize {
        let mut depth = vec![usize::MAX; wide.node_count()];
        depth[0] = 0;
        let mut seen = vec![0; boxes.len()];
        let mut slot = 0;
        for i in 0..wide.node_count() {
            let children = wide.node(i);
            assert!(children.len() <= options.width && (i == 0 || children.len() >= 2));
            let areas: Vec<f64> = children.iter().map(|c| c.bounds.half_area()).collect();
            assert!(areas.is_sorted_by(|a, b| *a >= *b * 0.999), "{areas:?}");
            let mut largest = true;
            for child in children {
                if child.is_leaf() {
                    assert_eq!(child.first, slot, "leaves stand in the order of children");
                    slot += child.count;
                    for at in child.slots() {
                        let prim = wide.order[at as usize] as usize;
                        seen[prim] += 1;
                        assert!(child.bounds.contains_box(&boxes[prim]));
                    }
                    continue;
                }
                let below = child.first as usize;
                assert!(below > i && (!largest || below == i + 1));
                largest = false;
                assert_eq!(depth[below], usize::MAX, "one parent");
                depth[below] = depth[i] + 1;
                let inside = wide.node(below).iter();
                assert!(inside.clone().all(|c| child.bounds.contains_box(&c.bounds)));
            }
        }
        assert!(seen.iter().all(|&s| s == 1));
        depth.into_iter().max().unwrap()
    }

    fn cost(wide: &WideTopology, options: &CollapseOptions) -> f64 {
        let measure = Measure::new(&wide.bounds);
        let below: f64 = wide
            .children
            .iter()
            .map(|c| {
                let visit = if c.is_leaf() {
                    options.leaf_cost.of(c.count)
                } else {
                    1.0
                };
                f64::from(measure.area(&c.bounds) * visit)
            })
            .sum();
        below + f64::from(measure.area(&wide.bounds))
    }

    #[test]
    fn a_collapsed_tree_is_whole_for_every_width_and_rule() {
        for n in [1, 2, 3, 9, 1000] {
            let boxes = cloud(n);
            for max_leaf in [1, 4, 8] {
                let tree = binary(&boxes, max_leaf);
                for options in both_rules() {
                    for width in 2..=8 {
                        let options = CollapseOptions { width, ..options };
                        let wide = tree.collapse(&options).unwrap();
                        let depth = checked_depth(&wide, &boxes, &options);
                        assert!(depth <= 96);
                        let largest = wide.children.iter().map(|c| c.count).max();
                        assert!(largest.unwrap() <= 8);
                    }
                }
            }
        }
        let none = Topology::default();
        let wide = none.collapse(&CollapseOptions::default()).unwrap();
        assert_eq!((wide.node_count(), wide.order.len()), (0, 0));
    }

    #[test]
    fn the_optimal_cut_costs_what_was_computed_and_less_than_the_greedy_one() {
        let boxes = cloud(3000);
        let tree = binary(&boxes, 2);
        let [optimal, greedy] = both_rules();
        let plan = Plan::new(&tree, &optimal).unwrap();
        let wide = tree.collapse(&optimal).unwrap();
        let (computed, found) = (
            f64::from(plan.costs[0].as_children[0]),
            cost(&wide, &optimal),
        );
        assert!((computed / found - 1.0).abs() < 1e-4, "{computed} {found}");
        let rival = cost(&tree.collapse(&greedy).unwrap(), &greedy);
        assert!(found < 0.95 * rival, "{found} {rival}");
    }

    #[test]
    fn no_other_cut_of_a_small_tree_is_cheaper() {
        // All cuts of a tree by brute force: each inner node below the root is opened or not.
        fn least(tree: &Topology, index: usize, options: &CollapseOptions) -> f32 {
            let measure = Measure::new(&tree.nodes[0].bounds);
            let slots = tree.slots_below();
            let node = &tree.nodes[index];
            let area = measure.area(&node.bounds);
            let leaf = area * options.leaf_cost.of(slots[index].len() as u32);
            if node.is_leaf() {
                return leaf;
            }
            let mut cuts = vec![vec![node.first as usize, node.first as usize + 1]];
            let mut best = f32::INFINITY;
            while let Some(cut) = cuts.pop() {
                let below: f32 = cut.iter().map(|&c| least(tree, c, options)).sum();
                best = best.min(area + below);
                for (i, &c) in cut.iter().enumerate() {
                    if cut.len() < options.width && !tree.nodes[c].is_leaf() {
                        let mut opened = cut.clone();
                        opened[i] = tree.nodes[c].first as usize;
                        opened.push(tree.nodes[c].first as usize + 1);
                        cuts.push(opened);
                    }
                }
            }
            if slots[index].len() <= options.max_leaf as usize {
                best = best.min(leaf);
            }
            best
        }
        let tree = binary(&cloud(11), 1);
        for width in [2, 3, 4] {
            let options = CollapseOptions {
                width,
                max_leaf: 3,
                ..CollapseOptions::default()
            };
            let plan = Plan::new(&tree, &options).unwrap();
            let (found, truth) = (plan.costs[0].as_children[0], least(&tree, 0, &options));
            assert!(
                (found / truth - 1.0).abs() < 1e-5,
                "{width}: {found} {truth}"
            );
        }
    }

    #[test]
    fn points_lines_and_huge_scenes_are_collapsed_too() {
        let at = |x: f32, y: f32| Aabb {
            min: [x, y, 0.0],
            max: [x, y, 0.0],
        };
        let scenes: [Vec<Aabb>; 3] = [
            vec![at(1.0, 2.0); 500],
            (0..500).map(|i| at(i as f32, 0.0)).collect(),
            (0..500).map(|i| at(i as f32 * 1e27, 3e29)).collect(),
        ];
        for boxes in scenes {
            for options in both_rules() {
                let wide = binary(&boxes, 4).collapse(&options).unwrap();
                checked_depth(&wide, &boxes, &options);
            }
        }
    }
}
