//! The bounding volume hierarchy as a flat binary tree, over any bounding volume.

pub mod by_hand;

use super::dress::{TIGHT, around, dress};
use super::{Accel, Visit};
use crate::build::{BuildInput, BuildOptions, MAX_DEPTH, Topology};
use crate::error::BuildError;
use crate::geom::{Aabb, Interval, PreparedRay};
use crate::prims::Primitives;
use crate::query::{NodeInfo, Observer, VolumeTest, VolumeVerdict};
use crate::simd::{Stack, address, prefetch};
use crate::volume::BoundingVolume;
use std::hint::select_unpredictable;
use std::ops::Range;

/// A binary tree of volumes. A node holds the volumes of both its children, which are tested together.
///
/// Nodes are numbered as in the [`Topology`]: the root is 0, the children of pair `p` are `2 p + 1` and `2 p + 2`.
#[derive(Clone, Debug)]
pub struct Bvh2<V: BoundingVolume> {
    pairs: Vec<Pair<V>>,
    root: Option<(V, Child)>,
    order: Vec<u32>,
    bounds: Aabb,
}

/// Two siblings: with boxes 64 bytes, a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Pair<V: BoundingVolume> {
    volumes: V::Pair,
    /// Leaf: first slot. Inner node: the pair of its children.
    first: [u32; 2],
    /// Primitives of a leaf; 0: inner node.
    count: [u8; 2],
    /// Bit `o` is set if a ray of octant `o` comes to the second sibling before the first.
    second_first: u8,
}

/// What a volume holds, as in [`Pair`].
#[derive(Clone, Copy, Debug)]
struct Child {
    first: u32,
    count: u8,
}

impl Child {
    /// All slots under the node, given those under each pair.
    fn slots(self, below: &[Range<usize>]) -> Range<usize> {
        let first = self.first as usize;
        match self.count {
            0 => below[first].clone(),
            count => first..first + usize::from(count),
        }
    }
}

/// A node whose turn comes later, its number, and where the ray enters it.
#[derive(Clone, Copy)]
struct Later {
    child: Child,
    node: u32,
    near: f32,
}

impl<V: BoundingVolume> Pair<V> {
    fn new(volumes: [&V; 2], children: [Child; 2]) -> Self {
        let [a, b] = volumes.map(|volume| volume.bounds().center());
        let comes_first = |octant: &u32| {
            let along = |k: usize| {
                if octant >> k & 1 == 0 {
                    b[k] - a[k]
                } else {
                    a[k] - b[k]
                }
            };
            along(0) + along(1) + along(2) < 0.0
        };
        Self {
            volumes: V::pair(volumes[0], volumes[1]),
            first: children.map(|child| child.first),
            count: children.map(|child| child.count),
            second_first: (0..8)
                .filter(comes_first)
                .fold(0, |set, octant| set | 1 << octant),
        }
    }

    #[inline(always)]
    fn child(&self, which: usize) -> Child {
        Child {
            first: self.first[which],
            count: self.count[which],
        }
    }
}

/// Bit `k` is set if the ray runs against axis `k`.
#[inline(always)]
fn octant(ray: &PreparedRay) -> u32 {
    let against = |k: usize| u32::from(ray.recip[k] < 0.0) << k;
    against(0) | against(1) | against(2)
}

impl<V: BoundingVolume> Accel for Bvh2<V> {
    fn build<P: Primitives>(
        prims: &P,
        boxes: &[Aabb],
        options: &BuildOptions,
    ) -> Result<Self, BuildError> {
        let topology = options
            .builder
            .build(&BuildInput::new(prims, boxes), options)?;
        let volumes = dress::<V, P>(&topology, prims);
        let child = |node: usize| child(&topology, node);
        let pairs = (1..topology.nodes.len())
            .step_by(2)
            .map(|i| Pair::new([&volumes[i], &volumes[i + 1]], [child(i), child(i + 1)]))
            .collect();
        let root = volumes.first().map(|volume| (*volume, child(0)));
        Ok(Self {
            pairs,
            root,
            order: topology.order,
            bounds: Aabb::of_boxes(boxes),
        })
    }

    fn order(&self) -> &[u32] {
        &self.order
    }

    #[inline]
    fn traverse<T: Visit>(&self, ray: &PreparedRay, visit: &mut T) {
        let Some((volume, root)) = &self.root else {
            return;
        };
        let volume_ray = V::prepare(ray, &self.bounds);
        if !enters::<V, T>(0, volume.interval(&volume_ray), ray, visit) {
            return;
        }
        let octant = octant(ray);
        let mut memory = Stack::memory::<{ MAX_DEPTH + 1 }>();
        let mut stack = Stack::new(&mut memory);
        let (mut child, mut number) = (*root, 0);
        loop {
            visit.observer().turn(number);
            if child.count > 0 {
                let slots = child.first..child.first + u32::from(child.count);
                if visit.leaf(slots).is_break() {
                    return;
                }
            } else {
                let pair = &self.pairs[child.first as usize];
                let node = 2 * child.first + 1;
                self.fetch_ahead(pair.child(0), visit);
                self.fetch_ahead(pair.child(1), visit);
                let [a, b] = V::pair_intervals(&pair.volumes, &volume_ray);
                let hits = (
                    enters::<V, T>(node, a, ray, visit),
                    enters::<V, T>(node + 1, b, ray, visit),
                );
                let later = |which: usize| Later {
                    child: pair.child(which),
                    node: node + which as u32,
                    near: [a.near, b.near][which],
                };
                // Branches, not selections: the processor goes on along the guessed way while the test ends. Selecting
                // makes each step wait for the one before (15 % slower, see bench/LOG.md).
                let next = match hits {
                    (true, both) if !T::IN_ORDER => {
                        stack.push_if(both, later(1));
                        Some(0)
                    }
                    (true, true) if pair.second_first >> octant & 1 == 1 => {
                        stack.push(later(0));
                        Some(1)
                    }
                    (true, true) => {
                        stack.push(later(1));
                        Some(0)
                    }
                    (true, false) => Some(0),
                    (false, true) => Some(1),
                    (false, false) => None,
                };
                if let Some(next) = next {
                    (child, number) = (pair.child(next), node + next as u32);
                    continue;
                }
            }
            // The next one whose turn is not over.
            (child, number) = loop {
                let Some(Later { child, node, near }) = stack.pop() else {
                    return;
                };
                if near <= visit.t_max() {
                    break (child, node);
                }
                let (far, verdict) = (f32::INFINITY, VolumeVerdict::Dropped);
                visit.observer().volume(VolumeTest {
                    node,
                    near,
                    far,
                    verdict,
                    flops: 0,
                    bytes: 0,
                });
            };
        }
    }

    fn refitted<P: Primitives>(&self, prims: &P, boxes: &[Aabb]) -> Option<Self> {
        let mut new = Self {
            bounds: Aabb::of_boxes(boxes),
            ..self.clone()
        };
        // Children stand after their parents: backwards, they are done before.
        let mut below = vec![0..0; new.pairs.len()];
        for i in (0..new.pairs.len()).rev() {
            let children = [0, 1].map(|which| new.pairs[i].child(which));
            let [a, b] = children.map(|child| new.volume(child, child.slots(&below), prims, boxes));
            new.pairs[i] = Pair::new([&a, &b], children);
            below[i] = children[0].slots(&below).start..children[1].slots(&below).end;
        }
        new.root = self.root.map(|(_, root)| {
            let volume = new.volume(root, root.slots(&below), prims, boxes);
            (volume, root)
        });
        Some(new)
    }

    fn for_each_node(&self, visit: &mut dyn FnMut(NodeInfo)) {
        let Some((volume, root)) = &self.root else {
            return;
        };
        let mut stack = vec![(0, 0, volume.bounds(), *root)];
        while let Some((node, depth, bounds, child)) = stack.pop() {
            let prims = (child.count > 0).then_some(u32::from(child.count));
            visit(NodeInfo {
                node,
                depth,
                bounds,
                prims,
            });
            if prims.is_none() {
                let pair = &self.pairs[child.first as usize];
                let [a, b] = V::of_pair(&pair.volumes).map(|v| v.bounds());
                let number = 2 * child.first + 1;
                stack.push((number + 1, depth + 1, b, pair.child(1)));
                stack.push((number, depth + 1, a, pair.child(0)));
            }
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(self.pairs.as_slice()) + size_of_val(self.order.as_slice())
    }
}

impl<V: BoundingVolume> Bvh2<V> {
    /// The volume of a node whose children have theirs, as [`dress`] has it.
    fn volume<P: Primitives>(
        &self,
        child: Child,
        slots: Range<usize>,
        prims: &P,
        boxes: &[Aabb],
    ) -> V {
        let is_leaf = child.count > 0;
        if V::UNION_IS_TIGHT && is_leaf {
            let each = self.order[slots].iter().map(|&i| boxes[i as usize]);
            V::of_aabb(&each.fold(Aabb::EMPTY, |all, b| all.union(&b)))
        } else if is_leaf || (!V::UNION_IS_TIGHT && slots.len() <= TIGHT) {
            around(prims, &self.order[slots])
        } else {
            V::of_volumes(&V::of_pair(&self.pairs[child.first as usize].volumes))
        }
    }

    /// Asks for the memory of a node before it is known to be entered. A selection, not a branch: whether it is a leaf
    /// cannot be guessed.
    #[inline(always)]
    fn fetch_ahead(&self, child: Child, visit: &impl Visit) {
        prefetch(select_unpredictable(
            child.count == 0,
            address(&self.pairs, child.first as usize),
            visit.address(child.first),
        ));
    }
}

/// A node of the topology as a child. Siblings stand at an odd place and the even one after it.
fn child(topology: &Topology, node: usize) -> Child {
    let node = topology.nodes[node];
    let first = if node.is_leaf() {
        node.first
    } else {
        (node.first - 1) / 2
    };
    Child {
        first,
        // At most `max_leaf`, which is below 256.
        count: node.count as u8,
    }
}

/// True if the ray meets the volume while that still matters.
#[inline(always)]
fn enters<V: BoundingVolume, T: Visit>(
    node: u32,
    interval: Interval,
    ray: &PreparedRay,
    visit: &mut T,
) -> bool {
    let Interval { near, far } = interval;
    let hit = interval.meets(ray.t_min, visit.t_max());
    let test = VolumeTest {
        node,
        near,
        far,
        verdict: if hit {
            VolumeVerdict::Enter
        } else if near <= far && near > visit.t_max() && near <= ray.t_max {
            VolumeVerdict::Farther
        } else {
            VolumeVerdict::Miss
        },
        flops: V::FLOPS,
        bytes: (size_of::<Pair<V>>() / 2) as u32,
    };
    visit.observer().volume(test);
    hit
}
