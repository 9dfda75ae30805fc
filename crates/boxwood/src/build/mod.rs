//! Building the hierarchy: boxes in, tree out. A builder never sees a shape.
//!
//! Most builders work top-down: they split a set of boxes in two until a set is small enough to be a leaf. Those of the
//! lecture differ in *where* they split, and that is all that their files hold (see `top_down.rs`). `morton` works bottom-up;
//! `binned` has a frame of its own, made for speed, and then moves nodes to better places; `refined` is `binned` with more of
//! that. A new one is one file and one line in [`BUILDERS`].
//!
//! The tree is binary ([`Topology`]); [`Topology::collapse`] makes it up to eight wide.

mod binned;
mod collapse;
mod fragment;
mod input;
mod measure;
mod median;
mod midpoint;
mod morton;
mod options;
mod presplit;
mod refined;
mod reinsert;
mod steps;
mod sweep;
mod top_down;
mod topology;

pub use collapse::{CollapseOptions, CollapseRule, LeafCost, WideTopology};
pub use input::{BuildInput, LeafRule, Progress};
pub use options::{AxisRule, BuildOptions, PRESETS, Preset};
pub use steps::{
    BuildStep, BuildWalk, Choice, CurvePlace, GridTry, MergeStep, NodeMove, Plane, SetStep, Why,
};
pub use topology::{Topology, TopologyNode};

use crate::error::BuildError;
pub(crate) use top_down::MAX_DEPTH;

/// A way to build a tree.
#[derive(Clone, Copy)]
pub struct Builder {
    /// `median`, `midpoint`, `morton`, `binned`, `refined`, `sweep`.
    pub name: &'static str,
    /// One line for `boxwood list`.
    pub about: &'static str,
    build: fn(&BuildInput<'_>, &BuildOptions) -> Result<Topology, BuildError>,
    /// The same with its steps, as many as are wanted.
    explain: fn(&BuildInput<'_>, &BuildOptions, usize) -> Result<BuildWalk, BuildError>,
    /// Bytes held at most while building over so many boxes, the result included.
    memory: fn(usize, &BuildOptions) -> usize,
}

/// Every builder. Add a line here.
pub static BUILDERS: &[Builder] = &[
    Builder::MEDIAN,
    Builder::MIDPOINT,
    Builder::MORTON,
    Builder::BINNED,
    Builder::REFINED,
    Builder::SWEEP,
];

impl Builder {
    /// Half of the primitives on each side.
    pub const MEDIAN: Self = Self {
        name: "median",
        about: "half of the primitives on each side of an axis",
        build: median::build,
        explain: median::explain,
        memory: top_down::memory,
    };
    /// Half of the space on each side.
    pub const MIDPOINT: Self = Self {
        name: "midpoint",
        about: "half of the space on each side of an axis",
        build: midpoint::build,
        explain: midpoint::explain,
        memory: top_down::memory,
    };
    /// Bottom-up: neighbours along a Morton curve are merged.
    pub const MORTON: Self = Self {
        name: "morton",
        about: "neighbours along a Morton curve merged, smallest boxes first: fast",
        build: morton::build,
        explain: morton::explain,
        memory: morton::memory,
    };
    /// Surface area heuristic over bins.
    pub const BINNED: Self = Self {
        name: "binned",
        about: "surface area heuristic, centres sorted into bins",
        build: binned::build,
        explain: binned::explain,
        memory: binned::memory,
    };
    /// [`Builder::BINNED`], then nodes are put where they cost least.
    pub const REFINED: Self = Self {
        name: "refined",
        about: "binned, then nodes put where they cost least; slivers are split: slow, for many rays",
        build: refined::build,
        explain: refined::explain,
        memory: refined::memory,
    };
    /// Surface area heuristic over all splits.
    pub const SWEEP: Self = Self {
        name: "sweep",
        about: "surface area heuristic, every split along every axis",
        build: sweep::build,
        explain: sweep::explain,
        memory: top_down::memory,
    };

    /// Looks a builder up by name.
    pub fn named(name: &str) -> Option<Self> {
        BUILDERS.iter().copied().find(|b| b.name == name)
    }

    /// Builds a tree over the boxes. Those that are empty or out of the domain
    /// ([`Aabb::is_in_domain`](crate::Aabb::is_in_domain)) are left out; no box gives a tree without nodes. The same
    /// input and options give the same tree for any number of threads. Never panics.
    ///
    /// # Errors
    /// [`BuildError::OutOfMemory`] if the system refuses the memory (see [`Builder::memory`]), and
    /// [`BuildError::Cancelled`] if [`BuildOptions::progress`] says so.
    pub fn build(
        &self,
        input: &BuildInput<'_>,
        options: &BuildOptions,
    ) -> Result<Topology, BuildError> {
        (self.build)(input, options)
    }

    /// How [`Builder::build`] comes to its tree: every set, split, merge and move, with what was weighed. At most `limit`
    /// steps are told. For small scenes and lessons: it takes several times as long as the build and, with large limits,
    /// much more memory.
    ///
    /// # Errors
    /// As [`Builder::build`].
    pub fn explain(
        &self,
        input: &BuildInput<'_>,
        options: &BuildOptions,
        limit: usize,
    ) -> Result<BuildWalk, BuildError> {
        (self.explain)(input, options, limit)
    }

    /// How many bytes [`Builder::build`] holds at most over `count` boxes, the tree that it gives included.
    pub fn memory(&self, count: usize, options: &BuildOptions) -> usize {
        (self.memory)(count, options)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Aabb;
    use crate::simd::InstructionSet;
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
            ("huge", (0..100).map(|i| at(i as f32 * 8e27)).collect()),
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
                        let topology = builder
                            .build(&BuildInput::of_boxes(&boxes), &options)
                            .unwrap();
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

    #[test]
    fn every_builder_tells_how_far_it_is_and_ends_when_told() {
        use std::ops::ControlFlow;
        use std::sync::{Arc, Mutex};
        let mut random = Random::new(12);
        let boxes: Vec<Aabb> = (0..20_000)
            .map(|_| Aabb::of_points(&[std::array::from_fn(|_| random.unit())]))
            .collect();
        let input = BuildInput::of_boxes(&boxes);
        for builder in BUILDERS {
            let told = Arc::new(Mutex::new(Vec::new()));
            let build = |limit: usize| {
                let listener = Arc::clone(&told);
                let progress = Progress::new(move |done| {
                    let mut told = listener.lock().unwrap();
                    told.push(done);
                    match told.len() < limit {
                        true => ControlFlow::Continue(()),
                        false => ControlFlow::Break(()),
                    }
                });
                let options = BuildOptions {
                    progress,
                    ..BuildOptions::with(*builder)
                };
                builder.build(&input, &options)
            };
            let tree = build(usize::MAX).unwrap();
            assert_eq!(
                tree,
                builder
                    .build(&input, &BuildOptions::with(*builder))
                    .unwrap()
            );
            let calls = std::mem::take(&mut *told.lock().unwrap());
            let name = builder.name;
            assert!(calls.len() > 4 && calls[0] == 0.0, "{name}: {calls:?}");
            assert!(
                calls.iter().all(|done| (0.0..=1.0).contains(done)),
                "{name}"
            );
            for limit in [1, 2, calls.len()] {
                assert_eq!(
                    build(limit),
                    Err(BuildError::Cancelled),
                    "{name} at {limit}"
                );
                told.lock().unwrap().clear();
            }
        }
    }

    #[test]
    fn the_tree_does_not_depend_on_the_instruction_set() {
        let mut random = Random::new(14);
        let boxes: Vec<Aabb> = (0..6000)
            .map(|_| {
                let p: [f32; 3] = std::array::from_fn(|_| random.unit());
                Aabb::of_points(&[p, p.map(|x| x + 0.1 * random.unit())])
            })
            .collect();
        for builder in BUILDERS {
            let trees = InstructionSet::available().into_iter().map(|instructions| {
                let options = BuildOptions {
                    instructions,
                    ..BuildOptions::with(*builder)
                };
                let input = BuildInput::of_boxes(&boxes).with_leaves(LeafRule::ROWS_OF_8);
                builder.build(&input, &options).unwrap()
            });
            let trees: Vec<Topology> = trees.collect();
            assert!(trees.iter().all(|t| *t == trees[0]), "{}", builder.name);
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
                pool.install(|| {
                    builder
                        .build(&BuildInput::of_boxes(&boxes), &BuildOptions::with(*builder))
                        .unwrap()
                })
            };
            let one = on(1);
            assert!(one == on(2) && one == on(7), "{}", builder.name);
        }
    }
}
