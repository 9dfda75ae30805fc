//! What can be asked of a build.

use super::{Builder, Progress};
use crate::simd::InstructionSet;

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
    /// Bins per axis of the `binned` builder, 2 to 32. More: better splits, slower build. Default: 16.
    pub bins: u32,
    /// What a primitive test costs, where visiting a node costs 1; the surface area heuristic weighs by it. Default: 0.6.
    pub primitive_cost: f32,
    /// Rounds in which `binned` and `refined` put nodes where they cost less, after the tree is built. More: slower
    /// build, fewer visits, with less and less to gain. Default: 4.
    pub rounds: u32,
    /// The share of the nodes, those of the largest area, that a round looks at, 0 to 1. Default: 0.02.
    pub round_share: f32,
    /// How many more parts than primitives `binned` and `refined` may make of slivers, relative to the number of
    /// primitives, 0 to 4. More: fewer tests, more memory. Default: 0.
    pub split_budget: f32,
    /// Cells per primitive of the uniform grid, 0.01 to 64. Default: 4.
    pub grid_density: f32,
    /// Who is told how far the build is, and may end it. Default: nobody.
    pub progress: Progress,
    /// For which instruction set the kernels of `wide` are to be. The answers are the same bits in all. Default: the best
    /// of this machine.
    pub instructions: InstructionSet,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            builder: Builder::BINNED,
            volume: "aabb",
            axis: AxisRule::Longest,
            max_leaf: 4,
            bins: 16,
            primitive_cost: 0.6,
            rounds: 4,
            round_share: 0.02,
            split_budget: 0.0,
            grid_density: 4.0,
            progress: Progress::default(),
            instructions: InstructionSet::best(),
        }
    }
}

/// How much a build may cost for how good a tree: options under a name.
#[derive(Clone, Copy)]
pub struct Preset {
    /// `fast`, `default`, `high`.
    pub name: &'static str,
    /// One line for `boxwood list`.
    pub about: &'static str,
    /// What the name stands for.
    pub options: fn() -> BuildOptions,
}

/// Every preset.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "fast",
        about: "builder morton: for scenes that are built again all the time",
        options: BuildOptions::fast,
    },
    Preset {
        name: "default",
        about: "builder binned: rays dear, builds cheap",
        options: BuildOptions::default,
    },
    Preset {
        name: "high",
        about: "builder refined: for scenes that meet many rays",
        options: BuildOptions::high,
    },
];

impl std::fmt::Debug for Preset {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Preset")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

impl BuildOptions {
    /// The fastest build of a tree that is still good: [`Builder::MORTON`].
    pub fn fast() -> Self {
        Self::with(Builder::MORTON)
    }

    /// The best tree, for some times the time of the default: [`Builder::REFINED`].
    pub fn high() -> Self {
        Self::with(Builder::REFINED)
    }

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
