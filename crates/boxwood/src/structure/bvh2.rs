//! The bounding volume hierarchy as a flat binary tree, over any bounding volume.

use super::dress::dress;
use super::{Accel, Visit};
use crate::build::{BuildOptions, MAX_DEPTH, Topology};
use crate::error::BuildError;
use crate::geom::{Aabb, Interval, PreparedRay};
use crate::prims::Primitives;
use crate::query::{NodeInfo, VolumeTest, VolumeVerdict};
use crate::volume::BoundingVolume;

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
    children: [Child; 2],
}

/// What a volume holds.
#[derive(Clone, Copy, Debug, Default)]
struct Child {
    /// Leaf: first slot. Inner node: the pair of its children.
    first: u32,
    /// Primitives of a leaf; 0: inner node.
    count: u32,
}

/// A node whose turn comes later, and where the ray enters it.
#[derive(Clone, Copy, Default)]
struct Later {
    node: u32,
    near: f32,
}

impl<V: BoundingVolume> Accel for Bvh2<V> {
    fn build<P: Primitives>(
        prims: &P,
        boxes: &[Aabb],
        options: &BuildOptions,
    ) -> Result<Self, BuildError> {
        let topology = options.builder.build(boxes, options);
        let volumes = dress::<V, P>(&topology, prims, boxes);
        let child = |node: usize| child(&topology, node);
        let pairs = (1..topology.nodes.len())
            .step_by(2)
            .map(|i| Pair {
                volumes: V::pair(&volumes[i], &volumes[i + 1]),
                children: [child(i), child(i + 1)],
            })
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
        let mut stack = [Later::default(); MAX_DEPTH];
        let mut top = 0;
        let mut child = *root;
        loop {
            if child.count > 0 {
                if visit
                    .leaf(child.first..child.first + child.count)
                    .is_break()
                {
                    return;
                }
            } else {
                let pair = &self.pairs[child.first as usize];
                let node = 2 * child.first + 1;
                for child in pair.children {
                    if child.count == 0 {
                        crate::simd::prefetch(&self.pairs, child.first as usize);
                    } else {
                        visit.soon(child.first);
                    }
                }
                let [a, b] = V::pair_intervals(&pair.volumes, &volume_ray);
                let hits = (
                    enters::<V, T>(node, a, ray, visit),
                    enters::<V, T>(node + 1, b, ray, visit),
                );
                // Branches, not selections: the processor goes on along the guessed way while the test ends. Selecting
                // makes each step wait for the one before (15 % slower, see bench/LOG.md).
                let next = match hits {
                    (true, true) => {
                        let second_first = T::IN_ORDER && b.near < a.near;
                        let (later, near) = if second_first {
                            (node, a.near)
                        } else {
                            (node + 1, b.near)
                        };
                        stack[top] = Later { node: later, near };
                        top += 1;
                        Some(usize::from(second_first))
                    }
                    (true, false) => Some(0),
                    (false, true) => Some(1),
                    (false, false) => None,
                };
                if let Some(next) = next {
                    child = pair.children[next];
                    continue;
                }
            }
            // The next one whose turn is not over.
            child = loop {
                if top == 0 {
                    return;
                }
                top -= 1;
                let Later { node, near } = stack[top];
                if near <= visit.t_max() {
                    let place = node as usize - 1;
                    break self.pairs[place / 2].children[place % 2];
                }
                let (far, verdict) = (f32::INFINITY, VolumeVerdict::Dropped);
                visit.volume(VolumeTest {
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

    fn for_each_node(&self, visit: &mut dyn FnMut(NodeInfo)) {
        let Some((volume, root)) = &self.root else {
            return;
        };
        let mut stack = vec![(0, 0, volume.bounds(), *root)];
        while let Some((node, depth, bounds, child)) = stack.pop() {
            let prims = (child.count > 0).then_some(child.count);
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
                stack.push((number + 1, depth + 1, b, pair.children[1]));
                stack.push((number, depth + 1, a, pair.children[0]));
            }
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(self.pairs.as_slice()) + size_of_val(self.order.as_slice())
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
        count: node.count,
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
    visit.volume(VolumeTest {
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
    });
    hit
}
