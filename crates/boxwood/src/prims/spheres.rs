//! Spheres as primitives.

use super::Primitives;
use crate::geom::{Aabb, Candidate, PreparedRay, Sphere};

/// A list of spheres. A ray that starts inside one hits it where it leaves.
#[derive(Clone, Debug, Default)]
pub struct Spheres(pub Vec<Sphere>);

impl Primitives for Spheres {
    const FLOPS_MISS: u32 = Sphere::ROOTS_FLOPS - 4;
    /// The roots, then the own box: its bounds 6, reach 12, padding 2, slabs 24, their cut 4, `t` 2.
    const FLOPS_HIT: u32 = Sphere::ROOTS_FLOPS + 50;
    const BYTES: u32 = size_of::<Sphere>() as u32;

    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, index: usize) -> Aabb {
        Aabb::of_sphere(&self.0[index])
    }

    fn intersect(&self, index: usize, ray: &PreparedRay) -> Option<Candidate> {
        self.0[index].intersect(ray)
    }

    fn gather(&self, order: &[u32]) -> Self {
        Self(order.iter().map(|&i| self.0[i as usize]).collect())
    }

    fn bytes(&self) -> usize {
        size_of_val(self.0.as_slice())
    }
}
