//! Primitives: what can be hit. Structures never see shapes; shapes never see structures.

mod custom;
mod spheres;
mod triangles;

pub use custom::{Custom, Shapes};
pub use spheres::Spheres;
pub use triangles::Triangles;

use crate::geom::{Aabb, Candidate, MAX_COORDINATE, PreparedRay};

/// A numbered set of primitives of one kind.
pub trait Primitives: Send + Sync + Sized + 'static {
    /// Operations of a test that misses.
    const FLOPS_MISS: u32;
    /// Operations of a test that hits.
    const FLOPS_HIT: u32;
    /// Memory read by one test.
    const BYTES: u32;

    /// How many.
    fn len(&self) -> usize;

    /// True if there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The box of one primitive.
    fn bounds(&self, index: usize) -> Aabb;

    /// False for a primitive that can never be hit: no extent, not finite, or beyond
    /// [`MAX_COORDINATE`]. It keeps its number, and structures leave it out.
    fn is_active(&self, index: usize) -> bool {
        let bounds = self.bounds(index);
        !bounds.is_empty()
            && bounds
                .min
                .iter()
                .chain(&bounds.max)
                .all(|x| x.abs() <= MAX_COORDINATE)
    }

    /// The test. At most one hit, the first in the ray's range if the shape has several; the caller checks the range and
    /// binds `t` to the primitive's box.
    fn intersect(&self, index: usize, ray: &PreparedRay) -> Option<Candidate>;

    /// The same primitives in another order, side by side for a structure that reads them so.
    fn gather(&self, order: &[u32]) -> Self;

    /// Appends points whose convex hull contains the primitive, for fitting volumes.
    fn hull(&self, index: usize, points: &mut Vec<[f32; 3]>) {
        points.extend(self.bounds(index).corners());
    }

    /// A hint that this primitive may be tested soon.
    #[inline(always)]
    fn prefetch(&self, _index: usize) {}

    /// Memory held.
    fn bytes(&self) -> usize;
}

/// The test as the definition of a hit has it: the range is closed, `t` is bound to the primitive's own padded box.
#[inline(always)]
pub(crate) fn accepted<P: Primitives>(
    prims: &P,
    index: usize,
    ray: &PreparedRay,
) -> Option<Candidate> {
    let candidate = prims.intersect(index, ray)?;
    bind(prims.bounds(index), candidate, ray)
}

/// Binds a candidate to its primitive's box and the ray's range.
#[inline]
pub(crate) fn bind(bounds: Aabb, candidate: Candidate, ray: &PreparedRay) -> Option<Candidate> {
    let t = bounds.bind(ray, candidate.t)?;
    ray.contains(t).then_some(Candidate { t, ..candidate })
}

/// Every kind of primitive that a [`Scene`](crate::Scene) can hold.
pub enum Geometry {
    /// The common case.
    Triangles(Triangles),
    /// Balls.
    Spheres(Spheres),
    /// The user's own, through a virtual call per test.
    Custom(Custom),
}

/// Calls a generic function on whichever kind of primitives a [`Geometry`] holds.
macro_rules! with_primitives {
    ($geometry:expr, $prims:ident => $body:expr) => {
        match $geometry {
            $crate::prims::Geometry::Triangles($prims) => $body,
            $crate::prims::Geometry::Spheres($prims) => $body,
            $crate::prims::Geometry::Custom($prims) => $body,
        }
    };
}
pub(crate) use with_primitives;

impl Geometry {
    /// How many primitives.
    pub fn len(&self) -> usize {
        with_primitives!(self, p => p.len())
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The box of each primitive.
    pub fn boxes(&self) -> Vec<Aabb> {
        with_primitives!(self, p => boxes(p))
    }
}

/// The box of each primitive, [`Aabb::EMPTY`] for one that can never be hit.
pub(crate) fn boxes<P: Primitives>(prims: &P) -> Vec<Aabb> {
    (0..prims.len())
        .map(|i| {
            if prims.is_active(i) {
                prims.bounds(i)
            } else {
                Aabb::EMPTY
            }
        })
        .collect()
}
