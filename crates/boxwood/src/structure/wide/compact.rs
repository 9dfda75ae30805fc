//! The form for memory, lossless: quantised boxes, and corners that the triangles of a leaf share.
//!
//! A node is 128 bytes: where its box begins and the steps of a grid over it along each axis, the number of its children; two rows with
//! six bytes a child, the planes of its box in steps (Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed
//! Wide BVHs", HPG 2017); references. Steps are powers of two, so a plane is rounded once when it is unpacked, on every instruction
//! set alike; planes are put where that leaves the child inside.
//!
//! A leaf is its triangles' numbers, three bytes for each that name corners, and each corner once, bit for bit.

use super::form::Form;
use super::layout::{MAX_LEAF, Ref, WIDTH};
use crate::build::TopologyNode;
use crate::geom::{Aabb, Triangle};
use crate::simd::{Arena, GRANULE, LeafRows, NodeRows, Row};
use fearless_simd::{f32x8, i32x8, prelude::*};

/// Packed, and unpacked when read.
pub(crate) struct Compact;

/// Where the parts of a node lie, in words: origin and steps of the grid, number of children, planes, references.
const ORIGIN: usize = 0;
const STEP: usize = 3;
const COUNT: usize = 6;
const XY: usize = 8;
const Z: usize = 16;
const REFS: usize = 24;
const WORDS: usize = 32;

/// Steps of the grid of a node. The last may lie beyond the box of the whole tree, by less than a hundredth of its size: the
/// paddings of the box test have that to spare.
const STEPS: u32 = 255;
/// Smaller steps than this are not needed, and nothing may become denormal.
const LEAST_STEP: f32 = 1.0 / (1_u128 << 120) as f32;

/// The grid of a node along one axis.
#[derive(Clone, Copy)]
struct Axis {
    origin: f32,
    step: f32,
}

impl Axis {
    /// The finest that reaches from `min` to `max`.
    fn around(min: f32, max: f32) -> Self {
        let mut axis = Self {
            origin: min,
            step: LEAST_STEP,
        };
        // A first guess from below, by exponents; then what rounding asks for.
        let per_step = (max - min) / STEPS as f32;
        if per_step > LEAST_STEP {
            axis.step = f32::from_bits(per_step.to_bits() & 0x7f80_0000);
        }
        while axis.plane(STEPS) < max {
            axis.step *= 2.0;
        }
        axis
    }

    /// As kernels unpack it: the product is exact.
    fn plane(self, steps: u32) -> f32 {
        steps as f32 * self.step + self.origin
    }

    /// The last plane not beyond `x`.
    fn below(self, x: f32) -> u32 {
        let mut steps = (((x - self.origin) / self.step) as u32).min(STEPS);
        while self.plane(steps) > x {
            steps -= 1;
        }
        steps
    }

    /// The first plane not before `x`.
    fn above(self, x: f32) -> u32 {
        let mut steps = (((x - self.origin) / self.step) as u32).min(STEPS);
        while self.plane(steps) < x {
            steps += 1;
        }
        steps
    }
}

/// The corners of a leaf, each once, and which of them each triangle has.
struct Shared {
    corners: Vec<[f32; 3]>,
    names: [[u8; 3]; MAX_LEAF],
}

impl Shared {
    fn of(order: &[u32], triangles: &[Triangle]) -> Self {
        let mut shared = Self {
            corners: Vec::with_capacity(3 * MAX_LEAF),
            names: [[0; 3]; MAX_LEAF],
        };
        for (names, &prim) in shared.names.iter_mut().zip(order) {
            *names = triangles[prim as usize].0.map(|corner| {
                let bits = corner.map(f32::to_bits);
                let is_it = |other: &[f32; 3]| other.map(f32::to_bits) == bits;
                let known = shared.corners.iter().position(is_it);
                known.unwrap_or_else(|| {
                    shared.corners.push(corner);
                    shared.corners.len() - 1
                }) as u8
            });
        }
        shared
    }
}

/// Words before the corners of a leaf of `count` triangles: numbers; names of corners and, in the last byte, how many corners there are.
const fn head_words(count: usize) -> usize {
    count + (3 * count + 1).div_ceil(4)
}

const fn leaf_words(count: usize, corners: usize) -> usize {
    head_words(count) + 3 * corners
}

impl Form for Compact {
    const NODE_GRANULES: u32 = (WORDS * 4 / GRANULE) as u32;
    const HAS_SMALL_KERNELS: bool = false;
    #[cfg(feature = "file")]
    const IS_SAVED: bool = false;
    type NodeRoom = [Row; 8];
    const NODE_ROOM: [Row; 8] = [[0.0; 8]; 8];
    type LeafRoom = [Row; 9];
    const LEAF_ROOM: [Row; 9] = [[0.0; 8]; 9];

    fn leaf_granules(order: &[u32], triangles: &[Triangle]) -> u32 {
        let corners = Shared::of(order, triangles).corners.len();
        (leaf_words(order.len(), corners) * 4).div_ceil(GRANULE) as u32
    }

    fn write_node(arena: &mut Arena, place: u32, children: &[TopologyNode], refs: [Ref; WIDTH]) {
        let around = Aabb::of_boxes(children.iter().map(|child| &child.bounds));
        let words = arena.floats_mut(place, WORDS);
        let mut planes = [[0_u32; WIDTH]; 2];
        for k in 0..3 {
            let axis = Axis::around(around.min[k], around.max[k]);
            (words[ORIGIN + k], words[STEP + k]) = (axis.origin, axis.step);
            for (lane, child) in children.iter().enumerate() {
                let (low, high) = (
                    axis.below(child.bounds.min[k]),
                    axis.above(child.bounds.max[k]),
                );
                planes[k / 2][lane] |= (low | high << 8) << (16 * (k % 2));
            }
        }
        words[COUNT] = f32::from_bits(children.len() as u32);
        for lane in 0..WIDTH {
            words[XY + lane] = f32::from_bits(planes[0][lane]);
            words[Z + lane] = f32::from_bits(planes[1][lane]);
            words[REFS + lane] = f32::from_bits(refs[lane].0);
        }
    }

    fn write_leaf(arena: &mut Arena, leaf: Ref, order: &[u32], triangles: &[Triangle]) {
        let n = order.len();
        let Shared { corners, names } = Shared::of(order, triangles);
        let words = arena.floats_mut(leaf.granule(), leaf_words(n, corners.len()));
        let (head, rest) = words.split_at_mut(head_words(n));
        for (word, prim) in head.iter_mut().zip(order) {
            *word = f32::from_bits(*prim);
        }
        let mut bytes = [0_u8; 4 * (head_words(MAX_LEAF) - MAX_LEAF)];
        bytes[..3 * n].copy_from_slice(names[..n].as_flattened());
        bytes[4 * (head.len() - n) - 1] = corners.len() as u8;
        for (word, four) in head[n..].iter_mut().zip(bytes.as_chunks().0) {
            *word = f32::from_bits(u32::from_le_bytes(*four));
        }
        rest.copy_from_slice(corners.as_flattened());
    }

    #[inline(always)]
    fn node<'a, S: Simd>(
        simd: S,
        arena: &'a Arena,
        granule: u32,
        room: &'a mut [Row; 8],
    ) -> NodeRows<'a> {
        let words = arena.floats(granule, WORDS);
        let packed =
            |from: usize| f32x8::from_slice(simd, &words[from..from + WIDTH]).bitcast::<i32x8<S>>();
        let (xy, z) = (packed(XY), packed(Z));
        let planes = Planes { simd, words };
        room[0] = planes.unpack(xy, 0).into();
        room[1] = planes.unpack(xy, 1).into();
        room[2] = planes.unpack(xy, 2).into();
        room[3] = planes.unpack(xy, 3).into();
        room[4] = planes.unpack(z, 4).into();
        room[5] = planes.unpack(z, 5).into();
        room[6].copy_from_slice(&words[REFS..]);
        NodeRows::of(room)
    }

    #[inline(always)]
    fn leaf<'a>(arena: &'a Arena, leaf: Ref, room: &'a mut [Row; 9]) -> LeafRows<'a> {
        let packed = Packed::of(arena, leaf);
        for lane in 0..leaf.count() {
            for (v, corner) in packed.triangle(lane).iter().enumerate() {
                for k in 0..3 {
                    room[3 * v + k][lane] = corner[k];
                }
            }
        }
        LeafRows::of(room)
    }

    #[inline(always)]
    fn triangle(arena: &Arena, leaf: Ref, lane: usize) -> ([[f32; 3]; 3], u32) {
        let packed = Packed::of(arena, leaf);
        (packed.triangle(lane), packed.head[lane].to_bits())
    }
}

/// The planes of a node, to be unpacked.
struct Planes<'a, S> {
    simd: S,
    words: &'a [f32],
}

impl<S: Simd> Planes<'_, S> {
    /// Row `row` of x min, x max, y min, and so on. Lanes without a child get planes that no ray is between.
    #[inline(always)]
    fn unpack(&self, packed: i32x8<S>, row: usize) -> f32x8<S> {
        let (simd, words) = (self.simd, self.words);
        let steps = (packed >> (8 * (row as u32 % 4))) & i32x8::splat(simd, 0xff);
        let (axis, is_max) = (row / 2, row % 2 == 1);
        let plane = steps.to_float::<f32x8<S>>().mul_add(
            f32x8::splat(simd, words[STEP + axis]),
            f32x8::splat(simd, words[ORIGIN + axis]),
        );
        if axis > 0 {
            return plane;
        }
        let count = i32x8::splat(simd, words[COUNT].to_bits() as i32);
        let is_child = i32x8::simd_from(simd, [0, 1, 2, 3, 4, 5, 6, 7]).simd_lt(count);
        let nowhere = if is_max {
            f32::NEG_INFINITY
        } else {
            f32::INFINITY
        };
        is_child.select(plane, f32x8::splat(simd, nowhere))
    }
}

/// A leaf, to be unpacked.
struct Packed<'a> {
    head: &'a [f32],
    count: usize,
    corners: &'a [[f32; 3]],
}

impl<'a> Packed<'a> {
    #[inline(always)]
    fn of(arena: &'a Arena, leaf: Ref) -> Self {
        let count = leaf.count();
        let head = arena.floats(leaf.granule(), head_words(count));
        let corners = (head[head.len() - 1].to_bits() >> 24) as usize;
        let all = arena.floats(leaf.granule(), leaf_words(count, corners));
        Self {
            head,
            count,
            corners: all[head.len()..].as_chunks().0,
        }
    }

    #[inline(always)]
    fn triangle(&self, lane: usize) -> [[f32; 3]; 3] {
        let corner = |v: usize| {
            let byte = 3 * lane + v;
            let word = self.head[self.count + byte / 4].to_bits();
            self.corners[(word >> (8 * (byte % 4)) & 0xff) as usize]
        };
        [corner(0), corner(1), corner(2)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::InstructionSet;
    use crate::structure::wide::layout;
    use fearless_simd::dispatch;

    fn numbers() -> impl FnMut() -> f32 {
        let mut seed = 7_u32;
        move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32 - 0.5
        }
    }

    /// The boxes of the children as every instruction set unpacks them, which must be the same.
    fn unpacked(arena: &Arena) -> [Aabb; WIDTH] {
        let sets = InstructionSet::available();
        let each = sets.iter().map(|set| {
            let mut room = Compact::NODE_ROOM;
            let rows = dispatch!(set.0, simd => Compact::node(simd, arena, 0, &mut room));
            std::array::from_fn(|lane| layout::bounds(rows, lane))
        });
        let each: Vec<[Aabb; WIDTH]> = each.collect();
        assert!(each.iter().all(|boxes| *boxes == each[0]));
        each[0]
    }

    #[test]
    fn boxes_contain_what_was_packed_and_are_not_much_larger() {
        let mut random = numbers();
        for scale in [1e-37_f32, 1e-6, 1.0, 3e7, 1e30] {
            for count in [1, 2, 5, 8] {
                let far = 1000.0 * scale.min(1e26) * random();
                let children: Vec<TopologyNode> = (0..count)
                    .map(|k| {
                        let min: [f32; 3] = std::array::from_fn(|_| far + scale * random());
                        let size: [f32; 3] =
                            std::array::from_fn(
                                |k| if k == 1 { 0.0 } else { scale * random().abs() },
                            );
                        let max = std::array::from_fn(|k| min[k] + size[k]);
                        TopologyNode::leaf(Aabb { min, max }, k, 1)
                    })
                    .collect();
                let around = Aabb::of_boxes(children.iter().map(|c| &c.bounds));
                let mut arena = Arena::new(4096).unwrap();
                Compact::write_node(&mut arena, 0, &children, [Ref(0); WIDTH]);
                let boxes = unpacked(&arena);
                for (child, unpacked) in children.iter().zip(&boxes) {
                    for k in 0..3 {
                        let (packed, size) = (child.bounds, around.max[k] - around.min[k]);
                        let slack = 0.02 * size + 1e-6 * around.max[k].abs() + LEAST_STEP;
                        assert!(
                            unpacked.min[k] <= packed.min[k] && packed.max[k] <= unpacked.max[k]
                        );
                        assert!(
                            packed.min[k] - unpacked.min[k] <= slack,
                            "{scale} {child:?} {unpacked:?}"
                        );
                        assert!(
                            unpacked.max[k] - packed.max[k] <= slack,
                            "{scale} {child:?} {unpacked:?}"
                        );
                    }
                }
                assert!(boxes[count as usize..].iter().all(Aabb::is_empty));
            }
        }
    }

    #[test]
    fn leaves_keep_every_bit_and_corners_once() {
        let mut random = numbers();
        let corners: Vec<[f32; 3]> = (0..5).map(|_| [random(), -0.0, random()]).collect();
        let strip = |k: usize| {
            Triangle([
                corners[k % 5],
                corners[(k + 1) % 5],
                [0.0, 0.0, corners[k % 5][2]],
            ])
        };
        let triangles: Vec<Triangle> = (0..8).map(strip).collect();
        for count in 1..=8 {
            let order: Vec<u32> = (0..count as u32).rev().collect();
            let mut arena = Arena::new(4096).unwrap();
            let leaf = Ref::leaf(1, count);
            Compact::write_leaf(&mut arena, leaf, &order, &triangles);
            let mut room = Compact::LEAF_ROOM;
            let rows = Compact::leaf(&arena, leaf, &mut room);
            for (lane, &prim) in order.iter().enumerate() {
                let expected = triangles[prim as usize].0;
                let (found, number) = Compact::triangle(&arena, leaf, lane);
                assert_eq!(number, prim);
                assert_eq!(
                    found.map(|v| v.map(f32::to_bits)),
                    expected.map(|v| v.map(f32::to_bits))
                );
                use crate::simd::Third::{A, B, C};
                let by_rows = [A, B, C]
                    .map(|v| [A, B, C].map(|axis| rows.axis(axis).corner(v)[lane].to_bits()));
                assert_eq!(by_rows, expected.map(|v| v.map(f32::to_bits)));
            }
            let shared = Shared::of(&order, &triangles);
            assert!(shared.corners.len() <= 10);
        }
    }
}
