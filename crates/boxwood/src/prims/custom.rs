//! The user's own primitives, of any mixture.

use super::Primitives;
use crate::geom::{Aabb, Candidate, PreparedRay};
use std::sync::Arc;

/// What a user implements to have shapes of their own in every structure.
///
/// The promise to keep: whatever [`Shapes::intersect`] finds lies in [`Shapes::bounds`]. It need not lie there to the
/// last bit: `t` is bound to the box, padded by some 2^-20 of its distance, before it counts.
pub trait Shapes: Send + Sync + 'static {
    /// How many shapes.
    fn len(&self) -> usize;

    /// True if there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The box around one shape.
    fn bounds(&self, index: usize) -> Aabb;

    /// The first point of one shape in the ray's range (`t_min..=t_max` of the ray).
    fn intersect(&self, index: usize, ray: &PreparedRay) -> Option<Candidate>;
}

/// [`Shapes`] as primitives: one virtual call per test.
#[derive(Clone)]
pub struct Custom {
    shapes: Arc<dyn Shapes>,
    order: Vec<u32>,
}

impl Custom {
    /// All shapes of the set, which must not be more than `u32` can number.
    pub fn new(shapes: Arc<dyn Shapes>) -> Self {
        let order = (0..u32::try_from(shapes.len()).unwrap_or(u32::MAX)).collect();
        Self { shapes, order }
    }
}

impl Primitives for Custom {
    /// Unknown to us: a call.
    const FLOPS_MISS: u32 = 0;
    const FLOPS_HIT: u32 = 0;
    const BYTES: u32 = 4;

    fn len(&self) -> usize {
        self.order.len()
    }

    fn bounds(&self, index: usize) -> Aabb {
        self.shapes.bounds(self.order[index] as usize)
    }

    fn intersect(&self, index: usize, ray: &PreparedRay) -> Option<Candidate> {
        self.shapes.intersect(self.order[index] as usize, ray)
    }

    fn gather(&self, order: &[u32]) -> Self {
        Self {
            shapes: Arc::clone(&self.shapes),
            order: order.iter().map(|&i| self.order[i as usize]).collect(),
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(self.order.as_slice())
    }
}
