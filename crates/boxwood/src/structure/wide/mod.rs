//! The wide hierarchy: nodes of eight children, leaves of up to eight triangles, each tested at once.
//!
//! * One block of memory on huge pages ([`crate::simd::Arena`]) holds everything; references are 32 bits (`layout`). Nodes and
//!   leaves are kept in one of two forms (`form`): as the rows that kernels read (`full`), or packed (`compact`).
//! * A binary tree is built, collapsed to eight wide by dynamic programming, and laid out depth first (`emit`).
//! * Single rays go by `single`, slices by `batch` (many rays in flight), whatever must be watched by `walk`.
//! * A kernel decides in two steps: a test over all lanes, in single precision, that errs only towards *maybe* and gives
//!   bounds of `t` (`lanes`); then the exact test, for the one or two triangles that remain when the traversal is over
//!   (`pending`; then `finish` for eight rays at once, `finish_one` for one).
//!
//! Every instruction set runs the same source (`fearless_simd`) and gives the same bits.

mod batch;
mod bundle;
#[cfg(feature = "compact")]
mod compact;
mod emit;
mod every;
#[cfg(feature = "distances")]
mod feet;
mod finish;
mod finish_one;
#[cfg(feature = "distances")]
mod foot;
mod form;
mod full;
mod lanes;
mod layout;
#[cfg(feature = "lists")]
mod lists;
mod meet;
#[cfg(feature = "distances")]
mod nearest;
mod packet;
mod pending;
mod prepare;
mod ray;
#[cfg(test)]
mod same_numbers;
#[cfg(feature = "file")]
mod saved;
mod single;
mod slots;
mod triangles;
mod walk;
mod worth;

#[cfg(feature = "compact")]
pub(crate) use compact::Compact;
pub(crate) use full::Full;
#[cfg(feature = "file")]
pub(crate) use saved::{Flaw, opened};
pub(crate) use slots::WideSlots;
pub(crate) use triangles::WideTriangles;

use crate::build::{BuildInput, BuildOptions, CollapseOptions, LeafRule, MAX_DEPTH, WideTopology};
use crate::error::BuildError;
use crate::geom::{Aabb, Triangle};
use crate::prims::Primitives;
use crate::simd::InstructionSet;
use form::{Form, Store};
use layout::{MAX_GRANULES, Ref, WIDTH};

/// Most references that can wait in a traversal: of each level all children but one, and room for a last push of eight.
const STACK: usize = (WIDTH - 1) * MAX_DEPTH + WIDTH + 1;

/// The tree.
struct Wide<M> {
    store: Store<M>,
    /// `None` if nothing can be hit.
    root: Option<Ref>,
    bounds: Aabb,
    /// Largest coordinate of `bounds`, by size.
    size: f32,
    level: InstructionSet,
    /// True if a triangle that was split is in more than one leaf.
    #[cfg(feature = "lists")]
    has_copies: bool,
    /// Most references that wait in a traversal of this tree.
    stack_need: usize,
}

/// What leaves hold.
enum Payload<'a> {
    /// Triangles, packed.
    Triangles(&'a [Triangle]),
    /// The first slot.
    Slots,
}

impl<M: Form> Wide<M> {
    fn new(
        tree: &WideTopology,
        payload: &Payload<'_>,
        options: &BuildOptions,
    ) -> Result<Self, BuildError> {
        Self::within(MAX_GRANULES, tree, payload, options)
    }

    /// In less than `limit` granules, or not at all.
    fn within(
        limit: u32,
        tree: &WideTopology,
        payload: &Payload<'_>,
        options: &BuildOptions,
    ) -> Result<Self, BuildError> {
        let emitted = emit::emit::<M>(tree, payload, limit)?;
        Ok(Self {
            root: emitted.root,
            bounds: tree.bounds,
            size: ray::size(&tree.bounds),
            level: options.instructions,
            #[cfg(feature = "lists")]
            has_copies: has_copies(&tree.order),
            stack_need: emitted.stack_need,
            store: emitted.store,
        })
    }
}

/// True if a number comes twice.
#[cfg(feature = "lists")]
fn has_copies(order: &[u32]) -> bool {
    let most = order.iter().max().map_or(0, |most| *most as usize + 1);
    let mut seen = vec![0_u64; most.div_ceil(64)];
    order.iter().any(|prim| {
        let (word, bit) = (&mut seen[*prim as usize / 64], 1 << (prim % 64));
        let is_second = *word & bit != 0;
        *word |= bit;
        is_second
    })
}

/// The wide tree that a builder and the collapse make of boxes.
fn collapsed<P: Primitives>(
    prims: &P,
    boxes: &[Aabb],
    options: &BuildOptions,
) -> Result<WideTopology, BuildError> {
    let input = BuildInput::new(prims, boxes).with_leaves(LeafRule::ROWS_OF_8);
    let tree = options.builder.build(&input, options)?;
    tree.collapse(&CollapseOptions::default())
}
