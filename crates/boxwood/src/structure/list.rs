//! Brute force: every primitive, every time. The definition of truth for all others.

use super::{Accel, Visit};
use crate::build::BuildOptions;
use crate::error::BuildError;
use crate::geom::{Aabb, PreparedRay};
use crate::prims::Primitives;
use crate::query::NodeInfo;

/// No structure.
#[derive(Clone, Debug)]
pub struct List {
    order: Vec<u32>,
    bounds: Aabb,
}

impl Accel for List {
    fn build<P: Primitives>(_: &P, boxes: &[Aabb], _: &BuildOptions) -> Result<Self, BuildError> {
        let order = boxes
            .iter()
            .zip(0..)
            .filter(|(b, _)| !b.is_empty())
            .map(|(_, prim)| prim)
            .collect();
        Ok(Self {
            order,
            bounds: Aabb::of_boxes(boxes),
        })
    }

    fn order(&self) -> &[u32] {
        &self.order
    }

    fn traverse<V: Visit>(&self, _: &PreparedRay, visit: &mut V) {
        // A break ends the traversal, and so does the end.
        let _ = visit.leaf(0..self.order.len() as u32);
    }

    fn for_each_node(&self, visit: &mut dyn FnMut(NodeInfo)) {
        if !self.order.is_empty() {
            visit(NodeInfo {
                node: 0,
                depth: 0,
                bounds: self.bounds,
                prims: Some(self.order.len() as u32),
            });
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(self.order.as_slice())
    }
}
