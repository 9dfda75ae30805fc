//! What a builder is given, and what it owes while it works: progress, an end when told so, errors instead of aborts.

use super::{BuildOptions, LeafCost};
use crate::error::BuildError;
use crate::geom::Aabb;
use crate::prims::{Parts, Primitives};
use crate::simd;
use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Boxes, and what else a builder may ask of the primitives.
#[derive(Clone, Copy)]
pub struct BuildInput<'a> {
    /// `boxes[i]` is the box of primitive `i`; empty ones and those out of the domain are left out.
    pub boxes: &'a [Aabb],
    pub(super) parts: Option<&'a dyn Parts>,
    leaves: Option<LeafRule>,
}

impl<'a> BuildInput<'a> {
    /// Boxes alone: no primitive will be split.
    pub fn of_boxes(boxes: &'a [Aabb]) -> Self {
        Self {
            boxes,
            parts: None,
            leaves: None,
        }
    }

    /// Primitives with their boxes, as [`Accel::build`](crate::structure::Accel::build) gets them: they may be split.
    pub fn new(prims: &'a impl Primitives, boxes: &'a [Aabb]) -> Self {
        Self {
            parts: prims.parts(),
            ..Self::of_boxes(boxes)
        }
    }

    /// The structure has a rule of its own for leaves; else they are as [`BuildOptions`] says.
    #[must_use]
    pub fn with_leaves(self, rule: LeafRule) -> Self {
        Self {
            leaves: Some(rule),
            ..self
        }
    }

    /// Most primitives in a leaf: as the options have it, but no more than the structure takes.
    pub(crate) fn leaf_limit(&self, options: &BuildOptions) -> usize {
        let limit = self.leaves.map_or(u32::MAX, |rule| rule.max.max(1));
        options.leaf_limit().min(limit as usize)
    }

    pub(crate) fn leaf_rule(&self, options: &BuildOptions) -> LeafRule {
        self.leaves.unwrap_or(LeafRule {
            node_cost: 1.0,
            cost: LeafCost {
                base: 0.0,
                per_primitive: options.primitive_cost,
            },
            max: options.leaf_limit() as u32,
            enough: 1,
        })
    }
}

impl fmt::Debug for BuildInput<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("BuildInput")
            .field("boxes", &self.boxes.len())
            .field("parts", &self.parts.is_some())
            .finish()
    }
}

/// When a set of primitives is split further, rather than made a leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeafRule {
    /// What one more binary node costs.
    pub node_cost: f32,
    /// What a visit of a leaf costs.
    pub cost: LeafCost,
    /// Most primitives in a leaf.
    pub max: u32,
    /// Sets up to this size become leaves without a look, at least 1.
    pub enough: u32,
}

impl LeafRule {
    /// For a tree that is to be collapsed to eight wide over leaves of up to eight triangles that are tested at once. A
    /// binary node is a seventh of a wide one.
    pub const ROWS_OF_8: Self = Self {
        node_cost: 1.0 / 7.0,
        cost: LeafCost::ROWS_OF_8,
        max: 8,
        enough: 3,
    };

    /// The base cost of a leaf, in primitives.
    pub(crate) fn extra(&self) -> f32 {
        let extra = self.cost.base / self.cost.per_primitive;
        if extra.is_finite() { extra } else { 0.0 }
    }

    /// True if a set of `count` had better be split, the sum over both sides of relative area times count and extra being
    /// `sides`.
    #[inline(always)]
    pub(crate) fn splits(&self, count: usize, sides: f32) -> bool {
        self.node_cost + self.cost.per_primitive * sides < self.cost.of(count as u32)
    }
}

type Hook = dyn Fn(f32) -> ControlFlow<()> + Send + Sync;

/// Who is told how far a build is, and may end it. Nobody by default.
///
/// ```
/// use boxwood::{BuildError, BuildOptions, Progress, Scene};
/// use std::ops::ControlFlow;
/// let never = Progress::new(|_done| ControlFlow::Break(()));
/// let options = BuildOptions { progress: never, ..BuildOptions::default() };
/// let scene = Scene::builder().mesh(&[[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]], &[[0, 1, 2]]);
/// assert_eq!(scene.options(options).build().unwrap_err(), BuildError::Cancelled);
/// ```
#[derive(Clone, Default)]
pub struct Progress(Option<Arc<Hook>>);

impl Progress {
    /// `hook` is called now and then, from any thread of the build, with the share that is done, 0 to 1: at least once at the
    /// beginning and about once per some thousand primitives. `Break` ends the build with
    /// [`BuildError::Cancelled`].
    pub fn new(hook: impl Fn(f32) -> ControlFlow<()> + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(hook)))
    }
}

impl fmt::Debug for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() {
            "Progress(hook)"
        } else {
            "Progress"
        })
    }
}

impl PartialEq for Progress {
    /// The same hook, or none.
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        }
    }
}

/// One build as its hook sees it.
pub(crate) struct Watch<'a> {
    hook: Option<&'a Hook>,
    total: usize,
    done: AtomicUsize,
    is_cancelled: AtomicBool,
}

impl<'a> Watch<'a> {
    /// A build of `total` steps begins.
    pub(crate) fn start(progress: &'a Progress, total: usize) -> Result<Self, BuildError> {
        let watch = Self {
            hook: progress.0.as_deref(),
            total,
            done: AtomicUsize::new(0),
            is_cancelled: AtomicBool::new(false),
        };
        watch.advance(0)?;
        Ok(watch)
    }

    /// `steps` more are done. To be called for some thousand at a time.
    pub(crate) fn advance(&self, steps: usize) -> Result<(), BuildError> {
        let Some(hook) = self.hook else { return Ok(()) };
        let done = self.done.fetch_add(steps, Ordering::Relaxed) + steps;
        let share = (done as f32 / self.total.max(1) as f32).min(1.0);
        if self.is_cancelled.load(Ordering::Relaxed) || hook(share).is_break() {
            self.is_cancelled.store(true, Ordering::Relaxed);
            return Err(BuildError::Cancelled);
        }
        Ok(())
    }
}

/// An empty vector with room for `count` elements, or an error if the system has no memory for them.
pub(crate) fn room<T>(count: usize) -> Result<Vec<T>, BuildError> {
    simd::room(count).map_err(|_| BuildError::OutOfMemory {
        bytes: count.saturating_mul(size_of::<T>()),
    })
}

/// `count` copies of `element`, or an error if the system has no memory for them.
pub(crate) fn filled<T: Clone>(element: T, count: usize) -> Result<Vec<T>, BuildError> {
    let mut all = room(count)?;
    all.resize(count, element);
    Ok(all)
}
