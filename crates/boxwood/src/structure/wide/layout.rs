//! References, and what they refer to.

use crate::geom::Aabb;
use crate::simd::NodeRows;

/// A node or a leaf: bit 31 tells a leaf, bits 30..28 its triangles less one, bits 27..0 the granule where it begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct Ref(pub(super) u32);

/// Children of a node.
pub(crate) const WIDTH: usize = 8;
/// Triangles of a leaf.
pub(super) const MAX_LEAF: usize = 8;
/// First granule that cannot be named.
pub(super) const MAX_GRANULES: u32 = 1 << 28;

const LEAF: u32 = 1 << 31;

impl Ref {
    pub(super) fn node(granule: u32) -> Self {
        assert!(granule < MAX_GRANULES, "checked by `emit`");
        Self(granule)
    }

    pub(super) fn leaf(granule: u32, count: usize) -> Self {
        assert!(granule < MAX_GRANULES, "checked by `emit`");
        assert!(
            (1..=MAX_LEAF).contains(&count),
            "a builder broke its rule for leaves"
        );
        Self(LEAF | (count as u32 - 1) << 28 | granule)
    }

    #[inline(always)]
    pub(super) fn is_leaf(self) -> bool {
        self.0 & LEAF != 0
    }

    #[inline(always)]
    pub(super) fn granule(self) -> u32 {
        self.0 & (MAX_GRANULES - 1)
    }

    /// Of a leaf.
    #[inline(always)]
    pub(super) fn count(self) -> usize {
        (self.0 >> 28 & 7) as usize + 1
    }
}

/// The box of a child, empty if there is none.
pub(super) fn bounds(node: NodeRows<'_>, lane: usize) -> Aabb {
    let [min, max] = node.bounds(lane);
    Aabb { min, max }
}
