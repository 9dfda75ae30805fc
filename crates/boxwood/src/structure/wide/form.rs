//! How nodes and leaves are written: the forms, and the memory of a tree in one of them.

use super::layout::{Ref, WIDTH};
use crate::build::TopologyNode;
use crate::geom::Triangle;
use crate::simd::{Arena, LeafRows, NodeRows};
use fearless_simd::prelude::*;
use std::marker::PhantomData;

/// A way to write nodes and leaves. Kernels read rows, whatever the form.
pub(crate) trait Form: Send + Sync + 'static {
    /// Granules of a node; a multiple of a cache line.
    const NODE_GRANULES: u32;
    /// True if small trees have kernels of their own, which fetch nothing ahead: a little speed for much code.
    const HAS_SMALL_KERNELS: bool;
    /// True if files keep trees of this form.
    #[cfg(feature = "file")]
    const IS_SAVED: bool;
    /// Where a node is unpacked.
    type NodeRoom;
    const NODE_ROOM: Self::NodeRoom;
    /// Where a leaf is unpacked.
    type LeafRoom;
    const LEAF_ROOM: Self::LeafRoom;

    /// Granules of a leaf.
    fn leaf_granules(order: &[u32], triangles: &[Triangle]) -> u32;
    fn write_node(arena: &mut Arena, place: u32, children: &[TopologyNode], refs: [Ref; WIDTH]);
    fn write_leaf(arena: &mut Arena, leaf: Ref, order: &[u32], triangles: &[Triangle]);

    fn node<'a, S: Simd>(
        simd: S,
        arena: &'a Arena,
        granule: u32,
        room: &'a mut Self::NodeRoom,
    ) -> NodeRows<'a>;
    fn leaf<'a>(arena: &'a Arena, leaf: Ref, room: &'a mut Self::LeafRoom) -> LeafRows<'a>;
    /// Corners and number of one triangle.
    fn triangle(arena: &Arena, leaf: Ref, lane: usize) -> ([[f32; 3]; 3], u32);
}

/// The memory of a tree.
pub(super) struct Store<M> {
    arena: Arena,
    form: PhantomData<M>,
}

impl<M: Form> Store<M> {
    pub(super) fn new(arena: Arena) -> Self {
        Self {
            arena,
            form: PhantomData,
        }
    }

    /// Its memory.
    #[cfg(feature = "file")]
    pub(super) fn bytes(&self) -> &[u8] {
        self.arena.bytes()
    }

    /// Its length in bytes.
    pub(super) fn len(&self) -> usize {
        self.arena.len()
    }

    /// Where a node or leaf begins, or would begin.
    #[inline(always)]
    pub(super) fn address(&self, at: Ref) -> *const u8 {
        self.arena.address(at.granule())
    }

    /// A node as rows, in `room` if need be.
    #[inline(always)]
    pub(super) fn node<'a, S: Simd>(
        &'a self,
        simd: S,
        granule: u32,
        room: &'a mut M::NodeRoom,
    ) -> NodeRows<'a> {
        M::node(simd, &self.arena, granule, room)
    }

    /// A leaf as rows, in `room` if need be.
    #[inline(always)]
    pub(super) fn leaf<'a>(&'a self, leaf: Ref, room: &'a mut M::LeafRoom) -> LeafRows<'a> {
        M::leaf(&self.arena, leaf, room)
    }

    /// Corners and number of one triangle.
    #[inline(always)]
    pub(super) fn triangle(&self, leaf: Ref, lane: usize) -> ([[f32; 3]; 3], u32) {
        M::triangle(&self.arena, leaf, lane)
    }
}
