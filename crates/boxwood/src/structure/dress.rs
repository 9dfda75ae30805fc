//! Volumes for a tree: the builder gives its shape, a bounding volume dresses it.

use crate::build::Topology;
use crate::geom::Aabb;
use crate::prims::Primitives;
use crate::volume::BoundingVolume;
use std::ops::Range;

/// Above this many primitives a volume is made of its children's volumes, which is looser than around all points but
/// keeps the work linear: a big node is entered by most rays anyway.
const TIGHT: usize = 2048;

/// The volume of every node of the tree.
pub(super) fn dress<V: BoundingVolume, P: Primitives>(
    topology: &Topology,
    prims: &P,
    boxes: &[Aabb],
) -> Vec<V> {
    let nodes = &topology.nodes;
    let slots = slots_below(topology);
    let mut volumes = vec![V::of_points(&[]); nodes.len()];
    for (i, node) in nodes.iter().enumerate().rev() {
        let below = slots[i].clone();
        let prims_below = &topology.order[below.start as usize..below.end as usize];
        volumes[i] = if node.is_leaf() && V::UNION_IS_TIGHT {
            let each = prims_below
                .iter()
                .map(|&prim| V::of_aabb(&boxes[prim as usize]));
            each.reduce(|a, b| a.union(&b)).unwrap_or(volumes[i])
        } else if node.is_leaf() || (!V::UNION_IS_TIGHT && prims_below.len() <= TIGHT) {
            around(prims, prims_below)
        } else {
            let first = node.first as usize;
            V::of_volumes(&volumes[first..first + 2])
        };
    }
    volumes
}

/// The slots under every node; they are consecutive.
pub(super) fn slots_below(topology: &Topology) -> Vec<Range<u32>> {
    let mut slots = vec![0..0; topology.nodes.len()];
    for (i, node) in topology.nodes.iter().enumerate().rev() {
        slots[i] = if node.is_leaf() {
            node.slots()
        } else {
            let first = node.first as usize;
            slots[first].start..slots[first + 1].end
        };
    }
    slots
}

/// The volume around primitives, tight where their points are known.
pub(super) fn around<V: BoundingVolume, P: Primitives>(prims: &P, indices: &[u32]) -> V {
    let mut points = Vec::with_capacity(3 * indices.len());
    for &index in indices {
        prims.hull(index as usize, &mut points);
    }
    V::of_points(&points)
}
