//! Bundles: 64 neighbouring rays that go nearly the same way, through the tree together.
//!
//! A node is tested once for all of them, by interval arithmetic; a child that this lets through is tested against packets
//! of eight rays when its turn comes, from the first packet that entered its parent on, and dropped if none enters (Fuetterling,
//! Lojewski, Pfreundt, Hamann, Ebert, "Accelerated Single Ray Tracing for Wide Vector Units", HPG 2017; Reshetov, Soupikov,
//! Hurley, "Multi-Level Ray Tracing Algorithm", 2005). In a leaf each triangle is tested against the packets that enter it.

use super::batch::{Answers, fetch, slow};
use super::finish::{Corners, evaluate_rows};
use super::form::Form;
use super::lanes::{Floats, Planes};
use super::layout::{MAX_LEAF, Ref};
use super::meet::{List, PACKETS, visit_leaf};
use super::packet::{Beam, Column, Columns, NONE, load};
use super::pending::Best;
use super::worth::Worth;
use super::{STACK, Wide};
use crate::geom::Ray;
use crate::simd::Stack;
use core::ops::Range;
use fearless_simd::{f32x8, prelude::*, u32x8};

pub(super) use super::packet::RAYS;

/// Memory of a bundle. Lives longer than one, so that it need not be cleared.
pub(super) struct Bundle {
    pub(super) columns: Columns,
    /// Packets that entered a leaf, and triangles that they met.
    pub(super) entered: List<PACKETS>,
    pub(super) met: List<{ MAX_LEAF * PACKETS }>,
    /// Which rays are blocked.
    pub(super) blocked: u64,
    pub(super) worth: Worth,
}

impl Bundle {
    pub(super) const EMPTY: Self = Self {
        columns: Columns::EMPTY,
        entered: List::EMPTY,
        met: List::EMPTY,
        blocked: 0,
        worth: Worth::UNKNOWN,
    };

    /// What begins beyond matters to no ray.
    #[inline(always)]
    fn bound<S: Simd>(&self, simd: S) -> f32 {
        let mut most: f32x8<S> = load(simd, &self.columns.bound, 0);
        for p in 1..RAYS / 8 {
            most = most.max(load::<S, f32x8<S>>(simd, &self.columns.bound, p));
        }
        most.reduce_max()
    }
}

/// A child that waits: where it is entered at the earliest (so that this orders them), the node it belongs to, its lane there, and the
/// first ray that may have entered the node, in eights.
#[derive(Clone, Copy)]
struct Waiting(u64);

impl Waiting {
    #[inline(always)]
    fn new(enter: u32, node: Ref, lane: u32, first: usize) -> Self {
        // Nodes begin at multiples of four granules, of which there are 2^28.
        Self(
            u64::from(enter) << 32
                | u64::from(node.granule()) << 4
                | u64::from(lane) << 3
                | (first / 8) as u64,
        )
    }
    #[inline(always)]
    fn enter(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }
    #[inline(always)]
    fn node(self) -> u32 {
        (self.0 as u32 >> 6) * 4
    }
    #[inline(always)]
    fn lane(self) -> usize {
        (self.0 >> 3) as usize & 7
    }
    #[inline(always)]
    fn first(self) -> usize {
        8 * (self.0 as usize & 7)
    }
}

/// True if the rays seem to go nearly the same way: a look at eight of them.
#[inline(always)]
fn alike(rays: &[Ray; RAYS]) -> bool {
    let dot = |a: &[f32; 3], b: &[f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let of = &rays[RAYS / 2 + 4].dir;
    let own = dot(of, of) * 0.8;
    (0..RAYS).step_by(9).all(|k| {
        let dir = &rays[k].dir;
        let along = dot(of, dir);
        along > 0.0 && along * along > own * dot(dir, dir)
    })
}

/// Traces the rays from `first` on together if they are coherent. False: they are not, and nothing was done.
#[inline(always)]
pub(super) fn trace<S: Simd, M: Form, A: Answers>(
    simd: S,
    wide: &Wide<M>,
    bundle: &mut Bundle,
    rays: &[Ray; RAYS],
    first: usize,
    answers: &mut A,
) -> bool {
    if bundle.worth.pass > 0 {
        bundle.worth.pass -= 1;
        return false;
    }
    if !alike(rays) {
        return false;
    }
    trace_alike(simd, wide, bundle, rays, first, answers);
    bundle.worth.judge(A::ANY);
    true
}

#[inline(never)]
fn trace_alike<S: Simd, M: Form, A: Answers>(
    simd: S,
    wide: &Wide<M>,
    bundle: &mut Bundle,
    rays: &[Ray; RAYS],
    first: usize,
    answers: &mut A,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let mut tame = 0u64;
            let columns = &mut bundle.columns;
            columns.along = [0; 3];
            for (p, eight) in rays.as_chunks().0.iter().enumerate() {
                let prepared = columns.prepare(simd, p, eight, wide.size);
                tame |= u64::from(prepared.valid & !prepared.extreme) << (8 * p);
            }
            bundle.blocked = 0;
            let negative = [
                negative(simd, &columns.recip[0]),
                negative(simd, &columns.recip[1]),
                negative(simd, &columns.recip[2]),
            ];
            let mut left = tame;
            while left != 0 {
                let ray = left.trailing_zeros();
                let same = |k: usize| !(negative[k] ^ 0u64.wrapping_sub(negative[k] >> ray & 1));
                let group = left & same(0) & same(1) & same(2);
                left &= !group;
                match Beam::around(simd, &mut bundle.columns, group, wide.size) {
                    Some(beam) => walk::<S, M, S::f32s, A>(simd, wide, bundle, rays, &beam),
                    None => tame &= !group,
                }
            }
            for p in 0..RAYS / 8 {
                finish::<S, M, A>(
                    simd,
                    wide,
                    bundle,
                    p,
                    rays,
                    (tame >> (8 * p)) as u32 & 0xff,
                    first,
                    answers,
                );
            }
            let mut wild = !tame;
            while wild != 0 {
                let k = wild.trailing_zeros() as usize;
                wild &= wild - 1;
                answers.give(first + k, slow::<M, A>(wide, &rays[k]));
            }
        },
    );
}

/// Which are negative.
#[inline(always)]
fn negative<S: Simd>(simd: S, column: &Column) -> u64 {
    let zero = f32x8::splat(simd, 0.0);
    let mut mask = 0;
    for p in 0..RAYS / 8 {
        mask |= load::<S, f32x8<S>>(simd, column, p)
            .simd_lt(zero)
            .to_bitmask()
            << (8 * p);
    }
    mask
}

/// The way of a group of one octant through the tree.
#[inline(always)]
fn walk<S: Simd, M: Form, F: Floats<S>, A: Answers>(
    simd: S,
    wide: &Wide<M>,
    bundle: &mut Bundle,
    rays: &[Ray; RAYS],
    beam: &Beam<S>,
) {
    let mut room = M::NODE_ROOM;
    let mut memory = Stack::memory::<STACK>();
    let mut stack = Stack::<u64>::new(&mut memory);
    let Some(mut node) = wide.root else { return };
    let mut first = 0;
    let mut bound = bundle.bound(simd);
    loop {
        let rows = wide.store.node(simd, node.granule(), &mut room);
        let (hit, enter) = beam.boxes(simd, rows, f32x8::splat(simd, bound));
        let enter: [i32; 8] = enter.into();
        let mut left = hit.to_bitmask() as u32;
        let base = stack.len();
        while left != 0 {
            let lane = 31 - left.leading_zeros();
            left ^= 1 << lane;
            // Whatever the size of the tree: nothing else is in flight meanwhile.
            fetch::<M, true>(wide, rows.child(lane as usize));
            let waiting = Waiting::new(enter[lane as usize & 7] as u32, node, lane, first);
            if A::ANY {
                // The largest is the likeliest to be in the way.
                stack.push(waiting.0);
            } else {
                stack.insert_descending(base, waiting.0);
            }
        }
        loop {
            let Some(waiting) = stack.pop() else { return };
            let waiting = Waiting(waiting);
            if waiting.enter() > bound {
                continue;
            }
            let parent = wide.store.node(simd, waiting.node(), &mut room);
            let at = Ref(parent.child(waiting.lane()));
            let planes = Planes::<F>::of(simd, parent, waiting.lane(), beam.rows);
            let packets = waiting.first() / F::LEN..RAYS / F::LEN;
            if at.is_leaf() {
                if visit_leaf::<S, M, F, A>(simd, wide, bundle, rays, at, &planes, packets, beam) {
                    bound = bundle.bound(simd);
                    if A::ANY && bound < 0.0 {
                        return;
                    }
                }
            } else if let Some(entered) = first_to_enter(simd, &bundle.columns, &planes, packets) {
                (node, first) = (at, entered * F::LEN);
                break;
            }
        }
    }
}

#[inline(always)]
#[expect(
    clippy::manual_find,
    reason = "a closure would not be compiled for the instruction set"
)]
fn first_to_enter<S: Simd, F: Floats<S>>(
    simd: S,
    columns: &Columns,
    planes: &Planes<F>,
    packets: Range<usize>,
) -> Option<usize> {
    for p in packets {
        if columns.enter(simd, p, planes) != 0 {
            return Some(p);
        }
    }
    None
}

/// Answers for rays `8 * p..`, those in `group`.
#[inline(always)]
#[expect(
    clippy::too_many_arguments,
    reason = "one step of `trace`, apart to be read"
)]
fn finish<S: Simd, M: Form, A: Answers>(
    simd: S,
    wide: &Wide<M>,
    bundle: &Bundle,
    p: usize,
    rays: &[Ray; RAYS],
    group: u32,
    first: usize,
    answers: &mut A,
) {
    let columns = &bundle.columns;
    let mut best = [Best {
        prim: 0,
        ..Best::none(0.0)
    }; 8];
    let (hit, good) = if A::ANY {
        let blocked = (bundle.blocked >> (8 * p)) as u32 & 0xff;
        (blocked, blocked)
    } else {
        let (leaf, lane) = (bits(simd, &columns.leaf, p), bits(simd, &columns.lane, p));
        let hit = leaf.simd_ne(u32x8::splat(simd, NONE)).to_bitmask() as u32 & group;
        (
            hit,
            if hit == 0 {
                0
            } else {
                evaluate(simd, wide, columns, p, hit, leaf, lane, &mut best)
            },
        )
    };
    for k in 0..8 {
        if group >> k & 1 == 0 {
            continue;
        }
        if hit >> k & 1 == 0 {
            answers.give(first + 8 * p + k, Best::none(0.0));
        } else if good >> k & 1 != 0 {
            answers.give(first + 8 * p + k, best[k]);
        } else {
            answers.give(first + 8 * p + k, slow::<M, A>(wide, &rays[8 * p + k]));
        }
    }
}

#[inline(always)]
fn bits<S: Simd>(simd: S, column: &Column, p: usize) -> u32x8<S> {
    load::<S, f32x8<S>>(simd, column, p).bitcast::<u32x8<S>>()
}

/// What rays `8 * p..` hit, those in `hit`. Neighbours often hit the same triangle.
#[inline(always)]
#[expect(
    clippy::too_many_arguments,
    reason = "one step of `finish`, apart to be read"
)]
fn evaluate<S: Simd, M: Form>(
    simd: S,
    wide: &Wide<M>,
    columns: &Columns,
    p: usize,
    hit: u32,
    leaf: u32x8<S>,
    lane: u32x8<S>,
    best: &mut [Best; 8],
) -> u32 {
    let rows = columns.finish_rows(simd, p);
    let (leaves, lanes): ([u32; 8], [u32; 8]) = (leaf.into(), lane.into());
    let any = hit.trailing_zeros() as usize & 7;
    let same = leaf.simd_eq(u32x8::splat(simd, leaves[any]))
        & lane.simd_eq(u32x8::splat(simd, lanes[any]));
    if hit & !(same.to_bitmask() as u32) == 0 {
        return evaluate_rows(
            simd,
            &rows,
            &Corners::same(simd, &wide.store, Ref(leaves[any]), lanes[any]),
            best,
        );
    }
    let mut done = [(Ref(leaves[any]), lanes[any]); 8];
    for k in 0..8 {
        if hit >> k & 1 != 0 {
            done[k] = (Ref(leaves[k]), lanes[k]);
        }
    }
    evaluate_rows(
        simd,
        &rows,
        &Corners::gather(simd, &wide.store, &done),
        best,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::BuildOptions;
    use crate::geom::Triangle;
    use crate::prims::Triangles;
    use crate::query::Query;

    fn scene() -> Box<dyn Query> {
        let mut seed = 5u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        let triangle = |_| {
            let at = [4.0 * random(), 4.0 * random(), 4.0 * random()];
            Triangle([at, at.map(|x| x + random()), at.map(|x| x + random())])
        };
        let triangles = Triangles::new((0..500).map(triangle).collect());
        crate::structure::WideTriangles::<crate::structure::Full>::boxed(
            &triangles,
            &BuildOptions::default(),
        )
        .unwrap()
    }

    /// A tile around a direction.
    fn tile(origin: [f32; 3], dir: [f32; 3], step: f32) -> Vec<Ray> {
        let ray = |k: usize| {
            let (x, y) = ((k % 8) as f32 - 3.5, (k / 8) as f32 - 3.5);
            Ray::new(
                origin,
                [dir[0] + x * step, dir[1] + y * step, dir[2] - x * step],
            )
        };
        (0..RAYS).map(ray).collect()
    }

    fn assert_same(query: &dyn Query, rays: &[Ray]) {
        let (mut hits, mut occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
        query.closest_hits(rays, &mut hits);
        query.occluded_each(rays, &mut occluded);
        assert!(hits.iter().flatten().count() > 8, "too few hits to tell");
        for (k, ray) in rays.iter().enumerate() {
            assert_eq!(hits[k], query.closest_hit(ray), "{ray:?}");
            assert_eq!(occluded[k], query.occluded(ray), "{ray:?}");
        }
    }

    #[test]
    fn a_tile_answers_like_its_rays_one_by_one() {
        let query = scene();
        for dir in [
            [0.2, 0.3, -1.0],
            [-1.0, 0.4, 0.5],
            [0.1, 1.0, 0.99],
            [0.6, -0.6, 0.6],
        ] {
            let mut rays = tile(dir.map(|d| -5.0 * d), dir, 0.01);
            assert_same(&*query, &rays);
            for (k, ray) in rays.iter_mut().enumerate() {
                ray.origin[k % 3] += 0.002 * k as f32;
                ray.t_max = 4.0 + 0.02 * k as f32;
            }
            assert_same(&*query, &rays);
        }
    }

    #[test]
    fn a_tile_may_go_into_several_octants_and_hold_what_is_no_ray() {
        let query = scene();
        let mut rays = tile([0.01, 0.02, 5.0], [0.0, 0.0, -1.0], 0.02);
        assert_same(&*query, &rays);
        rays[11].dir[1] = f32::NAN;
        rays[30].t_max = f32::NAN;
        rays[33].t_max = -1.0;
        rays[40].dir = [0.0, -0.0, -1.0];
        assert_same(&*query, &rays);
    }

    #[test]
    fn rays_apart_are_no_bundle() {
        let mut rays = tile([0.0; 3], [0.0, 0.0, 1.0], 0.01);
        assert!(alike(rays.first_chunk().unwrap()));
        rays[9].dir = [0.0, 1.0, 0.0];
        assert!(!alike(rays.first_chunk().unwrap()));
    }
}
