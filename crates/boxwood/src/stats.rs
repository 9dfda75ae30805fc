//! The shape of a structure in numbers.

use crate::query::{NodeInfo, Query};
use std::collections::BTreeMap;

/// What [`Stats::of`] counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stats {
    /// Inner nodes and leaves; of a grid, cells that are not empty.
    pub nodes: usize,
    /// Nodes with primitives.
    pub leaves: usize,
    /// Depth of the deepest leaf; the root has 0.
    pub max_depth: u32,
    /// Primitives in leaves; more than there are if some stand in several.
    pub references: usize,
    /// Primitives in a leaf to how many leaves hold so many.
    pub leaf_sizes: BTreeMap<u32, usize>,
    /// Expected work of a random line that meets the root: the sum over nodes of their area relative to the root's,
    /// times 1 for an inner node or the number of primitives for a leaf (Goldsmith and Salmon, 1987). Infinite or NaN for
    /// scenes without area. It says nothing about grids.
    pub sah_cost: f64,
    /// Memory of the structure with its copy of the primitives.
    pub bytes: usize,
}

impl Stats {
    /// Looks at every node once.
    pub fn of(query: &dyn Query) -> Self {
        let mut stats = Self {
            bytes: query.bytes(),
            ..Self::default()
        };
        let mut root_area = None;
        query.for_each_node(&mut |node| {
            stats.add(&node, *root_area.get_or_insert(node.bounds.half_area()));
        });
        stats
    }

    fn add(&mut self, node: &NodeInfo, root_area: f64) {
        self.nodes += 1;
        self.sah_cost += node.bounds.half_area() / root_area * f64::from(node.prims.unwrap_or(1));
        let Some(prims) = node.prims else { return };
        self.leaves += 1;
        self.references += prims as usize;
        self.max_depth = self.max_depth.max(node.depth);
        *self.leaf_sizes.entry(prims).or_default() += 1;
    }
}
