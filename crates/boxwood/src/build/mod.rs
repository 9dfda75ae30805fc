//! Building the hierarchy: boxes in, tree out. A builder never sees a shape.
//!
//! Every builder works top-down: it splits a set of boxes in two until a set is small enough to be a leaf. They differ
//! in *where* they split, and that is all that their files hold (see `top_down.rs`). A new one is one file and one line
//! in [`BUILDERS`].

mod binned;
mod median;
mod midpoint;
mod sweep;
mod top_down;

use crate::geom::Aabb;
pub(crate) use top_down::MAX_DEPTH;

/// What can be asked of a build; `Default` is a good choice.
///
/// ```
/// use boxwood::{AxisRule, BuildOptions, Builder};
/// let as_on_the_slides = BuildOptions { axis: AxisRule::RoundRobin, ..BuildOptions::with(Builder::MEDIAN) };
/// # let _ = as_on_the_slides;
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BuildOptions {
    /// Where sets are split. Default: [`Builder::BINNED`].
    pub builder: Builder,
    /// The name of the bounding volume of tree nodes, from [`VOLUMES`](crate::VOLUMES). Default: `aabb`.
    pub volume: &'static str,
    /// Along which axis `median` and `midpoint` split. Default: the longest.
    pub axis: AxisRule,
    /// Most primitives in a leaf, 1 to 255. More: smaller tree, slower rays. Default: 4.
    pub max_leaf: u32,
    /// Bins per axis of the `binned` builder, 2 to 64. More: better splits, slower build. Default: 32.
    pub bins: u32,
    /// What a primitive test costs, where visiting a node costs 1; the surface area heuristic weighs by it. Default: 0.6.
    pub primitive_cost: f32,
    /// Cells per primitive of the uniform grid, 0.01 to 64. Default: 4.
    pub grid_density: f32,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            builder: Builder::BINNED,
            volume: "aabb",
            axis: AxisRule::Longest,
            max_leaf: 4,
            bins: 32,
            primitive_cost: 0.6,
            grid_density: 4.0,
        }
    }
}

impl BuildOptions {
    /// The defaults with another builder.
    pub fn with(builder: Builder) -> Self {
        Self {
            builder,
            ..Self::default()
        }
    }

    /// `grid_density` in its range.
    pub(crate) fn cells_per_primitive(&self) -> f64 {
        let density = self.grid_density;
        f64::from(if density.is_nan() {
            4.0
        } else {
            density.clamp(0.01, 64.0)
        })
    }

    /// `max_leaf` in its range.
    pub(crate) fn leaf_limit(&self) -> usize {
        self.max_leaf.clamp(1, 255) as usize
    }
}

/// The lecture's "partition along an axis": which one?
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AxisRule {
    /// The one along which the centres are spread farthest.
    #[default]
    Longest,
    /// x, y, z in turn, by depth.
    RoundRobin,
}

/// A way to build a tree.
#[derive(Clone, Copy)]
pub struct Builder {
    /// `median`, `midpoint`, `binned`, `sweep`.
    pub name: &'static str,
    /// One line for `boxwood list`.
    pub about: &'static str,
    build: fn(&[Aabb], &BuildOptions) -> Topology,
}

/// Every builder. Add a line here.
pub const BUILDERS: &[Builder] = &[
    Builder::MEDIAN,
    Builder::MIDPOINT,
    Builder::BINNED,
    Builder::SWEEP,
];

impl Builder {
    /// Half of the primitives on each side.
    pub const MEDIAN: Self = Self {
        name: "median",
        about: "half of the primitives on each side of an axis",
        build: median::build,
    };
    /// Half of the space on each side.
    pub const MIDPOINT: Self = Self {
        name: "midpoint",
        about: "half of the space on each side of an axis",
        build: midpoint::build,
    };
    /// Surface area heuristic over bins.
    pub const BINNED: Self = Self {
        name: "binned",
        about: "surface area heuristic, centres sorted into bins",
        build: binned::build,
    };
    /// Surface area heuristic over all splits.
    pub const SWEEP: Self = Self {
        name: "sweep",
        about: "surface area heuristic, every split along every axis",
        build: sweep::build,
    };

    /// Looks a builder up by name.
    pub fn named(name: &str) -> Option<Self> {
        BUILDERS.iter().copied().find(|b| b.name == name)
    }

    /// Builds a tree over `boxes[i]` of primitive `i`. Empty and non-finite boxes are left out; no box gives a tree
    /// without nodes. The same input and options give the same tree for any number of threads. Never panics.
    pub fn build(&self, boxes: &[Aabb], options: &BuildOptions) -> Topology {
        (self.build)(boxes, options)
    }
}

impl std::fmt::Debug for Builder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Builder")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

impl PartialEq for Builder {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// The shape of a binary tree, without volumes: structures dress it with those.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    /// The root first; children stand side by side after their parent. At most `2 n - 1` nodes, at most 96 deep.
    pub nodes: Vec<TopologyNode>,
    /// Slot to primitive: leaves are ranges of slots.
    pub order: Vec<u32>,
}

/// A node of a [`Topology`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TopologyNode {
    /// Leaf: its first slot. Inner node: its first child; the second stands beside it.
    pub first: u32,
    /// Primitives of a leaf, 0 for an inner node.
    pub count: u32,
}

impl TopologyNode {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    fn scenes() -> Vec<(&'static str, Vec<Aabb>)> {
        let mut random = Random::new(1);
        let mut cloud = |n: usize| -> Vec<Aabb> {
            (0..n)
                .map(|_| {
                    let p = [
                        random.signed() * 3.0,
                        random.signed(),
                        random.signed() * 0.5,
                    ];
                    Aabb::of_points(&[p, p.map(|x| x + random.unit() * 0.1)])
                })
                .collect()
        };
        let one = Aabb {
            min: [1.0, 2.0, 3.0],
            max: [2.0, 3.0, 4.5],
        };
        let at = |x: f32| Aabb {
            min: [x, 0.0, 0.0],
            max: [x * 1.5, x, x],
        };
        vec![
            ("nothing", vec![]),
            ("one", vec![one]),
            ("two equal", vec![one; 2]),
            ("a cloud", cloud(5000)),
            ("many equal", vec![one; 20_000]),
            (
                "exponential",
                (0..126).map(|i| at(2.0_f32.powi(i - 63))).collect(),
            ),
            ("on a line", (0..3000).map(|i| at(i as f32)).collect()),
            ("huge", (0..100).map(|i| at(i as f32 * 1e28)).collect()),
            (
                "some empty",
                cloud(100)
                    .into_iter()
                    .flat_map(|b| [b, Aabb::EMPTY])
                    .collect(),
            ),
            (
                "nested",
                (1..2000)
                    .map(|i| Aabb {
                        min: [-(i as f32); 3],
                        max: [i as f32; 3],
                    })
                    .collect(),
            ),
        ]
    }

    /// Depth of a tree in which every slot is in one leaf and every child stands after its parent.
    fn checked_depth(topology: &Topology) -> usize {
        let mut depth = vec![usize::MAX; topology.nodes.len()];
        let mut seen = vec![false; topology.order.len()];
        if let Some(root) = depth.first_mut() {
            *root = 0;
        }
        for (i, node) in topology.nodes.iter().enumerate() {
            assert_ne!(depth[i], usize::MAX, "node {i} has no parent");
            if node.is_leaf() {
                for slot in node.slots() {
                    assert!(
                        !std::mem::replace(&mut seen[slot as usize], true),
                        "slot {slot} twice"
                    );
                }
            } else {
                for child in [node.first, node.first + 1] {
                    assert!(child as usize > i && depth[child as usize] == usize::MAX);
                    depth[child as usize] = depth[i] + 1;
                }
            }
        }
        assert!(seen.into_iter().all(|s| s), "every slot is in a leaf");
        depth.into_iter().max().unwrap_or(0)
    }

    #[test]
    fn every_builder_gives_a_whole_tree_of_bounded_depth() {
        for builder in BUILDERS {
            for axis in [AxisRule::Longest, AxisRule::RoundRobin] {
                for (name, boxes) in scenes() {
                    for max_leaf in [1, 4, 300] {
                        let options = BuildOptions {
                            axis,
                            max_leaf,
                            ..BuildOptions::with(*builder)
                        };
                        let topology = builder.build(&boxes, &options);
                        let kept = boxes.iter().filter(|b| !b.is_empty()).count();
                        assert_eq!(topology.order.len(), kept, "{} of {name}", builder.name);
                        let mut prims = topology.order.clone();
                        prims.sort_unstable();
                        prims.dedup();
                        assert_eq!(prims.len(), kept, "each primitive once");
                        assert!(topology.nodes.len() <= (2 * kept).saturating_sub(1));
                        assert!(
                            topology
                                .nodes
                                .iter()
                                .all(|n| n.count as usize <= options.leaf_limit())
                        );
                        let depth = checked_depth(&topology);
                        assert!(depth < MAX_DEPTH, "{} of {name}: {depth}", builder.name);
                    }
                }
            }
        }
    }

    #[cfg(feature = "rayon")]
    #[test]
    fn the_tree_does_not_depend_on_the_number_of_threads() {
        let mut random = Random::new(6);
        let boxes: Vec<Aabb> = (0..60_000)
            .map(|_| {
                let p: [f32; 3] = std::array::from_fn(|_| random.unit());
                Aabb::of_points(&[p, p.map(|x| x + 0.01)])
            })
            .collect();
        for builder in BUILDERS {
            let on = |threads| {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .unwrap();
                pool.install(|| builder.build(&boxes, &BuildOptions::with(*builder)))
            };
            let one = on(1);
            assert!(one == on(2) && one == on(7), "{}", builder.name);
        }
    }
}
