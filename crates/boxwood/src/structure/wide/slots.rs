//! The wide tree over anything that is not a triangle: leaves are ranges of slots, primitives stand beside the tree.

use super::form::Form;
use super::layout::Ref;
use super::walk::{Leaves, for_each, walk};
use super::{Payload, Wide};
use crate::build::BuildOptions;
use crate::error::BuildError;
use crate::geom::{Aabb, PreparedRay};
use crate::prims::Primitives;
use crate::query::{NodeInfo, Observer};
use crate::structure::{Accel, Visit};
use std::ops::ControlFlow;

/// A wide tree whose leaves are ranges of slots.
pub(crate) struct WideSlots<M> {
    wide: Wide<M>,
    order: Vec<u32>,
}

/// A visitor of slots as a visitor of leaves.
struct Adapter<'a, V>(&'a mut V);

impl<V: Visit> Leaves for Adapter<'_, V> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.0.t_max()
    }

    #[inline(always)]
    fn leaf(&mut self, leaf: Ref) -> ControlFlow<()> {
        let first = leaf.granule();
        self.0.leaf(first..first + leaf.count() as u32)
    }

    #[inline(always)]
    fn observer(&mut self) -> &mut impl Observer {
        self.0.observer()
    }
}

impl<M: Form> Accel for WideSlots<M> {
    fn build<P: Primitives>(
        prims: &P,
        boxes: &[Aabb],
        options: &BuildOptions,
    ) -> Result<Self, BuildError> {
        let tree = super::collapsed(prims, boxes, options)?;
        let wide = Wide::new(&tree, &Payload::Slots, options)?;
        Ok(Self {
            wide,
            order: tree.order,
        })
    }

    fn order(&self) -> &[u32] {
        &self.order
    }

    #[inline]
    fn traverse<V: Visit>(&self, ray: &PreparedRay, visit: &mut V) {
        walk(&self.wide, ray, &mut Adapter(visit));
    }

    fn for_each_node(&self, visit: &mut dyn FnMut(NodeInfo)) {
        for_each(&self.wide, visit);
    }

    fn bytes(&self) -> usize {
        self.wide.store.len() + size_of_val(self.order.as_slice())
    }
}
