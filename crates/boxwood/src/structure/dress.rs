//! Volumes for a tree: the builder gives its shape, a bounding volume dresses it.

use crate::build::Topology;
use crate::prims::Primitives;
use crate::volume::BoundingVolume;

/// Above this many primitives a volume is made of its children's volumes, which is looser than around all points but
/// keeps the work linear: a big node is entered by most rays anyway.
pub(super) const TIGHT: usize = 2048;

/// The volume of every node of the tree.
pub(super) fn dress<V: BoundingVolume, P: Primitives>(topology: &Topology, prims: &P) -> Vec<V> {
    let nodes = &topology.nodes;
    if V::UNION_IS_TIGHT {
        return nodes.iter().map(|node| V::of_aabb(&node.bounds)).collect();
    }
    let slots = topology.slots_below();
    let mut volumes = vec![V::of_points(&[]); nodes.len()];
    for (i, node) in nodes.iter().enumerate().rev() {
        let below = slots[i].start as usize..slots[i].end as usize;
        volumes[i] = if node.is_leaf() || below.len() <= TIGHT {
            around(prims, &topology.order[below])
        } else {
            let first = node.first as usize;
            V::of_volumes(&volumes[first..first + 2])
        };
    }
    volumes
}

/// The volume around primitives, tight where their points are known.
pub(super) fn around<V: BoundingVolume, P: Primitives>(prims: &P, indices: &[u32]) -> V {
    let mut points = Vec::with_capacity(3 * indices.len());
    for &index in indices {
        prims.hull(index as usize, &mut points);
    }
    V::of_points(&points)
}
