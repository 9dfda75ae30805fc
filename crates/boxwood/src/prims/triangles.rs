//! Triangles with their vertices beside each other: 36 bytes each.

use super::Primitives;
use super::parts::{Parts, clip_triangle};
use crate::geom::{Aabb, Candidate, MAX_COORDINATE, PreparedRay, Triangle};
use crate::simd::Kept;

/// A list of triangles. A copy of it is the same memory.
#[derive(Clone, Debug)]
pub struct Triangles(Kept<Triangle>);

impl Triangles {
    /// Those of a list.
    pub fn new(triangles: Vec<Triangle>) -> Self {
        Self(triangles.into())
    }

    /// Those that someone keeps.
    #[cfg(feature = "file")]
    pub(crate) fn kept(triangles: Kept<Triangle>) -> Self {
        Self(triangles)
    }

    /// All of them.
    #[inline(always)]
    pub fn as_slice(&self) -> &[Triangle] {
        &self.0
    }
}

impl Default for Triangles {
    fn default() -> Self {
        Self::new(Vec::new())
    }
}

impl FromIterator<Triangle> for Triangles {
    fn from_iter<I: IntoIterator<Item = Triangle>>(triangles: I) -> Self {
        Self::new(triangles.into_iter().collect())
    }
}

impl Primitives for Triangles {
    const FLOPS_MISS: u32 = Triangle::FLOPS_MISS;
    const FLOPS_HIT: u32 = Triangle::FLOPS_HIT;
    const BYTES: u32 = size_of::<Triangle>() as u32;

    #[inline]
    fn len(&self) -> usize {
        self.0.len()
    }

    #[inline]
    fn bounds(&self, index: usize) -> Aabb {
        self.0[index].bounds()
    }

    /// By coordinates: the box alone would not show a NaN.
    fn is_active(&self, index: usize) -> bool {
        self.0[index]
            .0
            .iter()
            .flatten()
            .all(|x| x.abs() <= MAX_COORDINATE)
    }

    #[inline(always)]
    fn intersect(&self, index: usize, ray: &PreparedRay) -> Option<Candidate> {
        self.0[index].intersect(ray)
    }

    #[cfg(feature = "distances")]
    fn triangle(&self, index: usize) -> Option<&Triangle> {
        Some(&self.0[index])
    }

    fn gather(&self, order: &[u32]) -> Self {
        order.iter().map(|&i| self.0[i as usize]).collect()
    }

    fn hull(&self, index: usize, points: &mut Vec<[f32; 3]>) {
        points.extend(self.0[index].0);
    }

    #[inline(always)]
    fn address(&self, index: usize) -> *const u8 {
        crate::simd::address(&self.0, index)
    }

    fn parts(&self) -> Option<&dyn Parts> {
        Some(self)
    }

    fn bytes(&self) -> usize {
        size_of_val(self.as_slice())
    }
}

impl Parts for Triangles {
    fn clip(&self, index: u32, cell: &Aabb) -> Aabb {
        clip_triangle(&self.0[index as usize], cell)
    }

    fn least_area(&self, index: u32) -> f32 {
        let [x, y, z] = self.0[index as usize].normal();
        0.5 * (x.abs() + y.abs() + z.abs())
    }
}
