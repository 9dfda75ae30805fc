//! Structures: which primitives need not be asked?
//!
//! A structure is a filter. It hands the primitives that a ray may hit to a visitor, roughly front to back, and never
//! sees what they are; the visitors ([`ClosestHit`] and its siblings) turn that into answers, once for all structures.
//! A new one is one file with `impl Accel` and one line in [`STRUCTURES`](crate::STRUCTURES); the conformance tests,
//! the benchmarks and the command line find it there.

mod bounded;
mod bvh2;
mod dress;
mod grid;
mod indexed;
mod instanced;
mod list;
#[cfg(feature = "distances")]
mod nearest;
mod visit;
mod wide;

pub use bounded::{BoundedObject, BoundedTree, Object, PrimitiveObject};
pub use bvh2::Bvh2;
#[doc(hidden)]
pub use bvh2::by_hand;
pub use grid::Grid;
pub use indexed::{Indexed, Trace};
pub use list::List;
pub use visit::{AllHits, ClosestHit, Occluded, Visit};
#[cfg(feature = "compact")]
pub(crate) use wide::Compact;
#[cfg(feature = "file")]
pub(crate) use wide::{Flaw, opened};
pub(crate) use wide::{Full, WideSlots, WideTriangles};

use crate::build::BuildOptions;
use crate::error::BuildError;
use crate::geom::{Aabb, PreparedRay};
use crate::prims::Primitives;
use crate::query::NodeInfo;

/// What the author of a structure writes.
pub trait Accel: Sized + Send + Sync + 'static {
    /// Builds over the primitives. `boxes[i]` is the box of primitive `i`, empty for one that can never be hit, which
    /// is to be left out. Most structures need nothing but the boxes.
    fn build<P: Primitives>(
        prims: &P,
        boxes: &[Aabb],
        options: &BuildOptions,
    ) -> Result<Self, BuildError>;

    /// The order in which the structure wants to find the primitives side by side: slot to primitive.
    fn order(&self) -> &[u32];

    /// Hands every slot that the ray may hit to the visitor, at least once.
    ///
    /// The filter must be looser than the definition: a primitive is hit only where the ray is in its padded box
    /// ([`Aabb::own_interval`]), and a volume tested by a `BoundingVolume` that contains the primitive never misses that.
    /// What begins farther than [`Visit::t_max`] may be skipped; what begins exactly there may not (ties go by number).
    fn traverse<V: Visit>(&self, ray: &PreparedRay, visit: &mut V);

    /// The same structure around primitives that have moved; `None` where it can't be had so. As many as were built over,
    /// and the same ones active.
    fn refitted<P: Primitives>(&self, _prims: &P, _boxes: &[Aabb]) -> Option<Self> {
        None
    }

    /// Calls `visit` for every node, parents first.
    fn for_each_node(&self, visit: &mut dyn FnMut(NodeInfo));

    /// Memory held, without the primitives.
    fn bytes(&self) -> usize;
}
