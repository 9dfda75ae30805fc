//! The triangle that is nearest to a point: nearer boxes first, and none that begins beyond the nearest triangle known.
//!
//! Boxes and triangles are measured in single precision, eight at a time, with bounds of what rounding may have done (`feet`); the
//! few triangles that may be the nearest wait, and are measured in double precision when the traversal is over. So the answer is that
//! of asking every triangle.

use super::Wide;
use super::feet::Feet;
use super::foot::foot;
use super::form::Form;
use super::lanes::nearest;
use super::layout::{Ref, WIDTH, bounds};
use super::ray::splat3;
use crate::geom::{Aabb, Nearest, Triangle};
use crate::simd::{NodeRows, PlaneRow, RowStack, Stack, Third};
use crate::structure::nearest::{NearestPlace, is_in_domain};
use fearless_simd::{f32x8, i32x8, mask32x8, prelude::*, u32x8};

/// Points and scenes beyond this have squares that single precision has not.
const MOST: f32 = 1e18;
/// Triangles that may wait.
const ROOM: usize = 16;

/// The nearest triangle of each point.
#[inline(always)]
pub(super) fn nearest_of_each<S: Simd, M: Form>(
    simd: S,
    wide: &Wide<M>,
    points: &[[f32; 3]],
    answers: &mut [Option<Nearest>],
) {
    let mut search = Search::NEW;
    for (point, answer) in points.iter().zip(answers) {
        *answer = match wide.root {
            Some(root) if is_in_domain(point) => {
                search.run(simd, wide, root, point);
                search.known.answer()
            }
            _ => None,
        };
    }
}

/// A triangle that may be the nearest.
#[derive(Clone, Copy)]
struct Waiting {
    /// It is no nearer than this.
    lower: f32,
    leaf: Ref,
    lane: usize,
}

/// What is known of one point, and of the one before.
struct Search {
    known: NearestPlace,
    /// No triangle farther than this matters.
    reach: f32,
    waiting: [Waiting; ROOM],
    count: usize,
    /// Where the last answer was: points come in rows and clouds.
    guess: Option<Ref>,
}

impl Search {
    const NEW: Self = Self {
        known: NearestPlace::NONE,
        reach: f32::MAX,
        waiting: [Waiting {
            lower: 0.0,
            leaf: Ref(0),
            lane: 0,
        }; ROOM],
        count: 0,
        guess: None,
    };

    /// Looks at every triangle that may be the nearest.
    #[inline(always)]
    fn run<S: Simd, M: Form>(&mut self, simd: S, wide: &Wide<M>, root: Ref, point: &[f32; 3]) {
        self.known = NearestPlace::NONE;
        self.reach = f32::MAX;
        if wide.size > MOST || point.iter().any(|x| x.abs() > MOST) {
            return self.run_large(simd, wide, root, point);
        }
        let lanes = splat3(simd, *point);
        let guess = self.guess;
        if let Some(leaf) = guess {
            self.measure(simd, wide, leaf, point, &lanes);
        }
        let mut room = M::NODE_ROOM;
        let mut stack = RowStack::<{ super::STACK }>::new();
        let mut at = root;
        'all: loop {
            if at.is_leaf() {
                if Some(at) != guess {
                    self.measure(simd, wide, at, point, &lanes);
                }
            } else {
                let node = wide.store.node(simd, at.granule(), &mut room);
                let squares = squares_of_boxes(simd, node, &lanes);
                // Empty lanes are infinitely far.
                let near = squares.simd_le(f32x8::splat(simd, square(self.reach)));
                let mask = near.to_bitmask() as u32;
                if mask != 0 {
                    let (lane, others) = nearest(simd, near, squares.bitcast::<i32x8<S>>());
                    let refs = u32x8::simd_from(simd, *node.refs());
                    stack.push(
                        refs.compress(others).into(),
                        squares.compress(others).into(),
                        mask.count_ones() as usize - 1,
                    );
                    at = Ref(node.child(lane));
                    continue;
                }
            }
            let reach = square(self.reach);
            loop {
                let Some((below, near)) = stack.pop() else {
                    break 'all;
                };
                if near <= reach {
                    at = Ref(below);
                    break;
                }
            }
        }
        self.settle(simd, wide, point);
    }

    /// Takes in the triangles of a leaf.
    #[inline(always)]
    fn measure<S: Simd, M: Form>(
        &mut self,
        simd: S,
        wide: &Wide<M>,
        leaf: Ref,
        point: &[f32; 3],
        lanes: &[f32x8<S>; 3],
    ) {
        let mut room = M::LEAF_ROOM;
        let rows = wide.store.leaf(leaf, &mut room);
        let feet = Feet::new(simd, rows, lanes);
        let near = feet.within(simd, self.reach) & ((2 << (leaf.count() - 1)) - 1);
        if near != 0 {
            self.keep(simd, wide, leaf, point, &feet, near);
        }
    }

    /// Lets triangles wait, and does without what is beyond them.
    #[inline(always)]
    fn keep<S: Simd, M: Form>(
        &mut self,
        simd: S,
        wide: &Wide<M>,
        leaf: Ref,
        point: &[f32; 3],
        feet: &Feet<S>,
        mut near: u32,
    ) {
        let reach = f32x8::splat(simd, self.reach);
        let upper = feet.upper(simd);
        let shorter = upper.simd_lt(reach) & mask32x8::from_bitmask(simd, u64::from(near));
        self.reach = shorter.select(upper, reach).reduce_min();
        let lower: [f32; WIDTH] = feet.lower(simd).into();
        while near != 0 {
            let lane = near.trailing_zeros() as usize & 7;
            near &= near - 1;
            if !(lower[lane] > self.reach) {
                if self.count == ROOM {
                    self.settle(simd, wide, point);
                }
                self.waiting[self.count] = Waiting {
                    lower: lower[lane],
                    leaf,
                    lane,
                };
                self.count += 1;
            }
        }
    }

    /// Measures what waits in double precision.
    #[inline(never)]
    fn settle<S: Simd, M: Form>(&mut self, simd: S, wide: &Wide<M>, point: &[f32; 3]) {
        simd.vectorize(
            #[inline(always)]
            || {
                for k in 0..self.count {
                    let Waiting { lower, leaf, lane } = self.waiting[k];
                    if lower <= self.reach {
                        self.look(simd, wide, leaf, lane, point);
                    }
                }
                self.count = 0;
            },
        );
    }

    #[inline(always)]
    fn look<S: Simd, M: Form>(
        &mut self,
        simd: S,
        wide: &Wide<M>,
        leaf: Ref,
        lane: usize,
        point: &[f32; 3],
    ) {
        let (corners, prim) = wide.store.triangle(leaf, lane);
        let triangle = Triangle(corners);
        if self
            .known
            .take(&triangle, prim, foot(simd, &triangle, point))
        {
            self.guess = Some(leaf);
            self.reach = self.reach.min(self.known.reach());
        }
    }

    /// The same where squares are too large: all triangles in double precision.
    #[cold]
    fn run_large<S: Simd, M: Form>(
        &mut self,
        simd: S,
        wide: &Wide<M>,
        root: Ref,
        point: &[f32; 3],
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut room = M::NODE_ROOM;
                let mut memory = Stack::memory::<{ super::STACK }>();
                let mut stack = Stack::<u64>::new(&mut memory);
                stack.push(u64::from(root.0));
                while let Some(next) = stack.pop() {
                    let (at, near) = (Ref(next as u32), f32::from_bits((next >> 32) as u32));
                    if near > self.reach {
                        continue;
                    }
                    if at.is_leaf() {
                        for lane in 0..at.count() {
                            self.look(simd, wide, at, lane, point);
                        }
                        continue;
                    }
                    let node = wide.store.node(simd, at.granule(), &mut room);
                    let base = stack.len();
                    for lane in 0..WIDTH {
                        let near = distance_to(&bounds(node, lane), point);
                        if near <= self.reach {
                            let child = u64::from(node.refs()[lane]);
                            stack.insert_descending(base, u64::from(near.to_bits()) << 32 | child);
                        }
                    }
                }
            },
        );
    }
}

/// What squares of distances up to `reach` may be: single precision errs by less than this, relatively and absolutely.
#[inline(always)]
fn square(reach: f32) -> f32 {
    const SLACK: f32 = 1.0 + 1.0 / (1 << 20) as f32;
    (reach * reach * SLACK + 1e-37).min(f32::MAX)
}

/// Distances to eight boxes, squared.
#[inline(always)]
fn squares_of_boxes<S: Simd>(simd: S, node: NodeRows<'_>, [x, y, z]: &[f32x8<S>; 3]) -> f32x8<S> {
    let x = outside(simd, node, Third::A, *x);
    let y = outside(simd, node, Third::B, *y);
    let z = outside(simd, node, Third::C, *z);
    z.mul_add(z, y.mul_add(y, x * x))
}

/// How far a coordinate is outside of eight boxes along one axis.
#[inline(always)]
fn outside<S: Simd>(simd: S, node: NodeRows<'_>, axis: Third, x: f32x8<S>) -> f32x8<S> {
    let low = f32x8::simd_from(simd, *node.plane(PlaneRow::new(axis, false)));
    let high = f32x8::simd_from(simd, *node.plane(PlaneRow::new(axis, true)));
    (low - x).max(x - high).max(f32x8::splat(simd, 0.0))
}

/// Distance to a box, in double precision and then less what rounding may add; infinite if the box is empty.
fn distance_to(bounds: &Aabb, point: &[f32; 3]) -> f32 {
    if bounds.is_empty() {
        return f32::INFINITY;
    }
    let outside = |k: usize| {
        let x = f64::from(point[k]);
        let (min, max) = (f64::from(bounds.min[k]), f64::from(bounds.max[k]));
        (min - x).max(x - max).max(0.0)
    };
    let square: f64 = (0..3).map(|k| outside(k) * outside(k)).sum();
    (square.sqrt() as f32).next_down().max(0.0)
}
