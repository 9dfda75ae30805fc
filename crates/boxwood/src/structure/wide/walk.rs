//! A walk through the nodes that anything can watch: for counting and explaining, for collecting all hits, for primitives
//! that are not packed triangles, and for rays so extreme that the fast test's products would overflow.

use super::Wide;
use super::form::Form;
use super::lanes::planes;
use super::layout::{Ref, WIDTH, bounds};
use super::ray::{SlabConstants, SlabLanes};
use crate::geom::{Aabb, PreparedRay, SlabRay};
use crate::query::{NodeInfo, Observer, VolumeTest, VolumeVerdict};
use crate::simd::{GRANULE, NodeRows, Stack};
use fearless_simd::dispatch;
use std::ops::ControlFlow;

/// What is done with leaves.
pub(super) trait Leaves {
    /// Nothing beyond this matters any more.
    fn t_max(&self) -> f32;
    /// The ray enters the box of a leaf. `Break` ends the walk.
    fn leaf(&mut self, leaf: Ref) -> ControlFlow<()>;
    /// Who watches.
    fn observer(&mut self) -> &mut impl Observer;
}

/// Where the ray is in each child's box.
struct Intervals {
    near: [f32; WIDTH],
    far: [f32; WIDTH],
}

/// A test of all children.
///
/// Chosen for each node and not for each walk: else every walk, for every kind of primitive and every watcher, would be
/// compiled for every instruction set.
enum Boxes {
    /// The test of the fast kernels, for rays with this `t_min`.
    Fused(SlabConstants, f32),
    /// One box after the other, in the form that never overflows to NaN.
    Careful(SlabRay),
}

impl Boxes {
    fn test<M: Form>(&self, wide: &Wide<M>, node: NodeRows<'_>) -> Intervals {
        match self {
            Self::Fused(slabs, t_min) => dispatch!(wide.level.0, simd => {
                let (near, far) = planes(simd, node, &SlabLanes::new(simd, slabs, *t_min));
                Intervals { near: near.into(), far: far.into() }
            }),
            Self::Careful(ray) => Intervals::one_by_one(ray, node),
        }
    }
}

impl Intervals {
    fn one_by_one(ray: &SlabRay, node: NodeRows<'_>) -> Self {
        let mut intervals = Self {
            near: [f32::INFINITY; WIDTH],
            far: [f32::NEG_INFINITY; WIDTH],
        };
        for lane in (0..WIDTH).filter(|lane| !bounds(node, *lane).is_empty()) {
            let interval = ray.interval(&bounds(node, lane));
            (intervals.near[lane], intervals.far[lane]) = (interval.near, interval.far);
        }
        intervals
    }
}

impl<M: Form> Wide<M> {
    /// A node as rows.
    fn rows<'a>(&'a self, at: Ref, room: &'a mut M::NodeRoom) -> NodeRows<'a> {
        dispatch!(self.level.0, simd => self.store.node(simd, at.granule(), room))
    }
}

/// Hands the leaves that the ray may hit to `leaves`, the nearest child of each node first.
#[inline]
pub(super) fn walk<M: Form>(wide: &Wide<M>, ray: &PreparedRay, leaves: &mut impl Leaves) {
    let Some(root) = wide.root else { return };
    let boxes = match SlabConstants::new(ray, wide.size) {
        Some(slabs) => Boxes::Fused(slabs, ray.t_min),
        None => Boxes::Careful(SlabRay::new(ray, &wide.bounds)),
    };
    let mut room = M::NODE_ROOM;
    let mut memory = Stack::memory::<{ super::STACK }>();
    let mut stack = Stack::<(Ref, u32, f32)>::new(&mut memory);
    stack.push((root, 0, ray.t_min));
    while let Some((at, number, near)) = stack.pop() {
        if near > leaves.t_max() {
            drop_node(number, near, leaves.observer());
            continue;
        }
        leaves.observer().turn(number);
        if at.is_leaf() {
            if leaves.leaf(at).is_break() {
                return;
            }
        } else {
            let node = wide.rows(at, &mut room);
            let intervals = boxes.test(wide, node);
            let entered = |lane: &usize| enters::<M>(at, *lane, node, &intervals, ray, leaves);
            let hits = (0..WIDTH)
                .filter(entered)
                .fold(0u32, |hits, lane| hits | 1 << lane);
            push_children(at, node, hits, &intervals, &mut stack);
        }
    }
}

/// The nearest goes on top.
#[inline(always)]
fn push_children(
    at: Ref,
    node: NodeRows<'_>,
    hits: u32,
    intervals: &Intervals,
    stack: &mut Stack<'_, (Ref, u32, f32)>,
) {
    let hit = |lane: &usize| hits >> lane & 1 == 1;
    let nearest = (0..WIDTH)
        .filter(hit)
        .min_by(|a, b| intervals.near[*a].total_cmp(&intervals.near[*b]));
    let Some(nearest) = nearest else { return };
    let child = |lane: usize| {
        (
            Ref(node.refs()[lane]),
            number(at, lane),
            intervals.near[lane],
        )
    };
    (0..WIDTH)
        .filter(hit)
        .filter(|lane| *lane != nearest)
        .for_each(|lane| stack.push(child(lane)));
    stack.push(child(nearest));
}

/// The number of a child, as watchers know it: nodes are at least eight granules apart.
pub(super) fn number(parent: Ref, lane: usize) -> u32 {
    parent.granule() + 1 + lane as u32
}

/// Operations of a box test: 6 fused products and sums, 6 minima and maxima.
const FLOPS: u32 = 18;
/// An eighth of a node.
const fn bytes<M: Form>() -> u32 {
    M::NODE_GRANULES * GRANULE as u32 / WIDTH as u32
}

/// True if the ray meets the box of a child while that still matters.
#[inline(always)]
fn enters<M: Form>(
    at: Ref,
    lane: usize,
    node: NodeRows<'_>,
    intervals: &Intervals,
    ray: &PreparedRay,
    leaves: &mut impl Leaves,
) -> bool {
    let (near, far, t_max) = (intervals.near[lane], intervals.far[lane], leaves.t_max());
    let hit = near <= far && near <= t_max && far >= ray.t_min;
    if leaves.observer().is_watching() && !bounds(node, lane).is_empty() {
        let verdict = if hit {
            VolumeVerdict::Enter
        } else if near <= far && near > t_max && near <= ray.t_max {
            VolumeVerdict::Farther
        } else {
            VolumeVerdict::Miss
        };
        leaves.observer().volume(VolumeTest {
            node: number(at, lane),
            near,
            far,
            verdict,
            flops: FLOPS,
            bytes: bytes::<M>(),
        });
    }
    hit
}

fn drop_node(node: u32, near: f32, observer: &mut impl Observer) {
    observer.volume(VolumeTest {
        node,
        near,
        far: f32::INFINITY,
        verdict: VolumeVerdict::Dropped,
        flops: 0,
        bytes: 0,
    });
}

/// Nodes and leaves with their boxes, parents first.
pub(super) fn for_each<M: Form>(wide: &Wide<M>, visit: &mut dyn FnMut(NodeInfo)) {
    let mut room = M::NODE_ROOM;
    let mut stack: Vec<(u32, u32, Aabb, Ref)> = wide
        .root
        .map(|root| (0, 0, wide.bounds, root))
        .into_iter()
        .collect();
    while let Some((node_number, depth, around, at)) = stack.pop() {
        visit(NodeInfo {
            node: node_number,
            depth,
            bounds: around,
            prims: at.is_leaf().then(|| at.count() as u32),
        });
        if !at.is_leaf() {
            let node = wide.rows(at, &mut room);
            for lane in (0..WIDTH)
                .rev()
                .filter(|lane| !bounds(node, *lane).is_empty())
            {
                stack.push((
                    number(at, lane),
                    depth + 1,
                    bounds(node, lane),
                    Ref(node.refs()[lane]),
                ));
            }
        }
    }
}
