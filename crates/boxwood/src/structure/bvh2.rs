//! The bounding volume hierarchy as a flat binary tree, over any bounding volume.

use super::dress::dress;
use super::{Accel, Visit};
use crate::build::{BuildOptions, MAX_DEPTH};
use crate::error::BuildError;
use crate::geom::{Aabb, Interval, PreparedRay};
use crate::prims::Primitives;
use crate::query::{NodeInfo, VolumeTest, VolumeVerdict};
use crate::volume::BoundingVolume;

/// A binary tree of volumes. Children stand side by side: with boxes, a pair is one cache line.
#[derive(Clone, Debug)]
pub struct Bvh2<V> {
    nodes: Vec<Node<V>>,
    order: Vec<u32>,
    bounds: Aabb,
}

/// 32 bytes with a box.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
struct Node<V> {
    volume: V,
    /// Leaf: first slot. Inner node: first child.
    first: u32,
    /// Primitives of a leaf; 0: inner node.
    count: u32,
}

impl<V: BoundingVolume> Accel for Bvh2<V> {
    fn build<P: Primitives>(
        prims: &P,
        boxes: &[Aabb],
        options: &BuildOptions,
    ) -> Result<Self, BuildError> {
        let topology = options.builder.build(boxes, options);
        let volumes = dress(&topology, prims, boxes);
        let nodes = topology
            .nodes
            .iter()
            .zip(volumes)
            .map(|(node, volume)| Node {
                volume,
                first: node.first,
                count: node.count,
            })
            .collect();
        Ok(Self {
            nodes,
            order: topology.order,
            bounds: Aabb::of_boxes(boxes),
        })
    }

    fn order(&self) -> &[u32] {
        &self.order
    }

    #[inline]
    fn traverse<T: Visit>(&self, ray: &PreparedRay, visit: &mut T) {
        let Some(root) = self.nodes.first() else {
            return;
        };
        let volume_ray = V::prepare(ray, &self.bounds);
        if self.enter(0, &volume_ray, ray, visit).is_none() {
            return;
        }
        let mut stack = [(0u32, 0.0f32); MAX_DEPTH];
        let mut top = 0;
        let mut node = root;
        loop {
            if node.count > 0 {
                if visit.leaf(node.first..node.first + node.count).is_break() {
                    return;
                }
            } else {
                let left = self.enter(node.first, &volume_ray, ray, visit);
                let right = self.enter(node.first + 1, &volume_ray, ray, visit);
                let (nearer, farther) = match (left, right) {
                    (Some(l), Some(r)) if r.1 < l.1 => (Some(r), Some(l)),
                    (Some(l), r) => (Some(l), r),
                    (None, r) => (r, None),
                };
                if let Some(later) = farther {
                    stack[top] = later;
                    top += 1;
                }
                if let Some((next, _)) = nearer {
                    node = &self.nodes[next as usize];
                    continue;
                }
            }
            // The next node whose turn is not over.
            node = loop {
                if top == 0 {
                    return;
                }
                top -= 1;
                let (next, near) = stack[top];
                if near <= visit.t_max() {
                    break &self.nodes[next as usize];
                }
                let far = f32::INFINITY;
                let verdict = VolumeVerdict::Dropped;
                visit.volume(VolumeTest {
                    node: next,
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
        let mut stack = vec![(0u32, 0u32)];
        while let Some((i, depth)) = stack.pop() {
            let Some(node) = self.nodes.get(i as usize) else {
                continue;
            };
            let prims = (node.count > 0).then_some(node.count);
            visit(NodeInfo {
                node: i,
                depth,
                bounds: node.volume.bounds(),
                prims,
            });
            if prims.is_none() {
                stack.extend([(node.first + 1, depth + 1), (node.first, depth + 1)]);
            }
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.order.as_slice())
    }
}

impl<V: BoundingVolume> Bvh2<V> {
    /// Tests the volume of a node: where the ray enters it, if it does while that still matters.
    #[inline(always)]
    fn enter<T: Visit>(
        &self,
        index: u32,
        volume_ray: &V::Ray,
        ray: &PreparedRay,
        visit: &mut T,
    ) -> Option<(u32, f32)> {
        let node = &self.nodes[index as usize];
        let Interval { near, far } = node.volume.interval(volume_ray);
        let hit = Interval { near, far }.meets(ray.t_min, visit.t_max());
        visit.volume(VolumeTest {
            node: index,
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
            bytes: size_of::<Node<V>>() as u32,
        });
        hit.then_some((index, near))
    }
}
