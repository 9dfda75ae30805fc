//! The form for speed: everything as the rows that kernels read.
//!
//! A node is 256 bytes: two planes for each axis, then references. A leaf is 40 bytes a triangle: nine rows of coordinates (x, y,
//! z of each vertex in turn), one of numbers.

use super::form::Form;
use super::layout::{Ref, WIDTH};
use crate::build::TopologyNode;
use crate::geom::Triangle;
use crate::simd::{Arena, GRANULE, LeafRows, NodeRows, Row, Third};
use fearless_simd::prelude::*;

/// Rows as they are.
pub(crate) struct Full;

/// The row of references.
const REFS: usize = 6;

/// The row of a leaf that has the triangles' numbers, behind those of coordinates.
pub(super) const NUMBERS: usize = 9;

/// Numbers of a leaf of `count` triangles.
pub(super) const fn leaf_floats(count: usize) -> usize {
    (NUMBERS + 1) * count
}

/// What they take.
pub(super) const fn leaf_granules(count: usize) -> u32 {
    (leaf_floats(count) * 4).div_ceil(GRANULE) as u32
}

impl Form for Full {
    const NODE_GRANULES: u32 = (8 * size_of::<Row>() / GRANULE) as u32;
    const HAS_SMALL_KERNELS: bool = true;
    #[cfg(feature = "file")]
    const IS_SAVED: bool = true;
    type NodeRoom = ();
    const NODE_ROOM: () = ();
    type LeafRoom = ();
    const LEAF_ROOM: () = ();

    fn leaf_granules(order: &[u32], _: &[Triangle]) -> u32 {
        leaf_granules(order.len())
    }

    /// Empty lanes have inverted boxes, which no ray enters.
    fn write_node(arena: &mut Arena, place: u32, children: &[TopologyNode], refs: [Ref; WIDTH]) {
        let floats = arena.floats_mut(place, Self::NODE_GRANULES as usize * GRANULE / 4);
        for lane in 0..WIDTH {
            for axis in 0..3 {
                let empty = (f32::INFINITY, f32::NEG_INFINITY);
                let (min, max) = children
                    .get(lane)
                    .map_or(empty, |c| (c.bounds.min[axis], c.bounds.max[axis]));
                floats[2 * axis * WIDTH + lane] = min;
                floats[(2 * axis + 1) * WIDTH + lane] = max;
            }
            floats[REFS * WIDTH + lane] = f32::from_bits(refs[lane].0);
        }
    }

    fn write_leaf(arena: &mut Arena, leaf: Ref, order: &[u32], triangles: &[Triangle]) {
        let n = order.len();
        let floats = arena.floats_mut(leaf.granule(), leaf_floats(n));
        for (lane, &prim) in order.iter().enumerate() {
            let corners = triangles[prim as usize].0;
            for (row, coordinate) in corners.as_flattened().iter().enumerate() {
                floats[row * n + lane] = *coordinate;
            }
            floats[NUMBERS * n + lane] = f32::from_bits(prim);
        }
    }

    #[inline(always)]
    fn node<'a, S: Simd>(_: S, arena: &'a Arena, granule: u32, _: &'a mut ()) -> NodeRows<'a> {
        arena.node(granule)
    }

    #[inline(always)]
    fn leaf<'a>(arena: &'a Arena, leaf: Ref, _: &'a mut ()) -> LeafRows<'a> {
        arena.leaf(leaf.granule(), leaf.count())
    }

    #[inline(always)]
    fn triangle(arena: &Arena, leaf: Ref, lane: usize) -> ([[f32; 3]; 3], u32) {
        let n = leaf.count();
        let (rows, lane) = (arena.leaf(leaf.granule(), n), lane & 7);
        let [x, y, z] = [Third::A, Third::B, Third::C].map(|axis| rows.axis(axis));
        let vertex = |v: Third| [x.corner(v)[lane], y.corner(v)[lane], z.corner(v)[lane]];
        let number = arena.floats(leaf.granule(), leaf_floats(n))[NUMBERS * n + lane.min(n - 1)];
        let corners = [vertex(Third::A), vertex(Third::B), vertex(Third::C)];
        (corners, number.to_bits())
    }
}
