//! How nodes and leaves lie in the arena.

use crate::geom::Aabb;
use crate::simd::{Arena, GRANULE, NodeRows, Row};

/// A node or a leaf: bit 31 tells a leaf, bits 30..28 its triangles less one, bits 27..0 the granule where it begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(super) struct Ref(pub(super) u32);

/// Children of a node.
pub(super) const WIDTH: usize = 8;
/// Triangles of a leaf.
pub(super) const MAX_LEAF: usize = 8;
/// Granules of a node.
pub(super) const NODE_GRANULES: u32 = (8 * size_of::<Row>() / GRANULE) as u32;
/// First granule that cannot be named.
pub(super) const MAX_GRANULES: u32 = 1 << 28;

const LEAF: u32 = 1 << 31;

impl Ref {
    pub(super) fn node(granule: u32) -> Self {
        debug_assert!(granule < MAX_GRANULES);
        Self(granule)
    }

    pub(super) fn leaf(granule: u32, count: usize) -> Self {
        debug_assert!(granule < MAX_GRANULES && (1..=MAX_LEAF).contains(&count));
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

/// The row of references.
pub(super) const REFS: usize = 6;

/// Numbers of a leaf of `count` triangles: nine rows of `count` coordinates (x, y, z of each vertex in turn), one of ids.
pub(super) const fn leaf_floats(count: usize) -> usize {
    10 * count
}

/// Granules of a leaf.
pub(super) const fn leaf_granules(count: usize) -> u32 {
    (leaf_floats(count) * 4).div_ceil(GRANULE) as u32
}

/// The box of a child, empty if there is none.
pub(super) fn bounds(node: NodeRows<'_>, lane: usize) -> Aabb {
    let [min, max] = node.bounds(lane);
    Aabb { min, max }
}

/// Reads one triangle of a leaf.
#[inline(always)]
pub(super) fn triangle(arena: &Arena, leaf: Ref, lane: usize) -> ([[f32; 3]; 3], u32) {
    let n = leaf.count();
    let floats = arena.floats(leaf.granule(), leaf_floats(n));
    let at = |row: usize| floats[row * n + lane];
    let vertex = |v: usize| [at(3 * v), at(3 * v + 1), at(3 * v + 2)];
    ([vertex(0), vertex(1), vertex(2)], at(9).to_bits())
}
