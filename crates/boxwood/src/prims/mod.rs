//! Primitives: what can be hit. Structures never see shapes; shapes never see structures.

mod custom;
mod instances;
mod parts;
mod spheres;
mod triangles;

pub use custom::{Custom, Shapes};
pub use instances::Instances;
pub(crate) use instances::{Content, Place};
pub use parts::Parts;
pub use spheres::Spheres;
pub use triangles::Triangles;

#[cfg(feature = "distances")]
use crate::geom::Triangle;
use crate::geom::{Aabb, Candidate, PreparedRay};

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

    /// False for a primitive that can never be hit: an empty box, not finite, or beyond
    /// [`MAX_COORDINATE`](crate::geom::MAX_COORDINATE). It keeps its number, and structures leave it out.
    fn is_active(&self, index: usize) -> bool {
        self.bounds(index).is_in_domain()
    }

    /// The test. At most one hit, the first in the ray's range if the shape has several; the caller checks the range and
    /// binds `t` to the primitive's box.
    fn intersect(&self, index: usize, ray: &PreparedRay) -> Option<Candidate>;

    /// The primitive as a triangle, if it is one.
    #[cfg(feature = "distances")]
    fn triangle(&self, _index: usize) -> Option<&Triangle> {
        None
    }

    /// The same primitives in another order, side by side for a structure that reads them so.
    fn gather(&self, order: &[u32]) -> Self;

    /// Appends points whose convex hull contains the primitive, for fitting volumes.
    fn hull(&self, index: usize, points: &mut Vec<[f32; 3]>) {
        points.extend(self.bounds(index).corners());
    }

    /// Where the primitive lies in memory, to be fetched ahead; null if nowhere in particular. Never read through.
    #[inline(always)]
    fn address(&self, _index: usize) -> *const u8 {
        std::ptr::null()
    }

    /// These primitives, if they are instances, which have more than one hit each and are asked otherwise.
    #[inline(always)]
    fn instances(&self) -> Option<&Instances> {
        None
    }

    /// How to take the primitives apart, for builders that split them; `None` if they must stay whole.
    fn parts(&self) -> Option<&dyn Parts> {
        None
    }

    /// Memory held.
    fn bytes(&self) -> usize;
}

/// A test as the definition of a hit has it: the range is closed, `t` is bound to the primitive's own padded box.
pub(crate) struct Tested {
    pub(crate) candidate: Option<Candidate>,
    pub(crate) flops: u32,
    pub(crate) bytes: u32,
}

impl Tested {
    #[inline(always)]
    pub(crate) fn of<P: Primitives>(prims: &P, index: usize, ray: &PreparedRay) -> Self {
        Self::new::<P>(prims.intersect(index, ray), || prims.bounds(index), ray)
    }

    /// From what a test of the kind `P` found, and the box of what it tested.
    #[inline(always)]
    pub(crate) fn new<P: Primitives>(
        found: Option<Candidate>,
        bounds: impl FnOnce() -> Aabb,
        ray: &PreparedRay,
    ) -> Self {
        let flops = if found.is_some() {
            P::FLOPS_HIT
        } else {
            P::FLOPS_MISS
        };
        let candidate = found.and_then(|c| {
            let t = bounds().bind(ray, c.t)?;
            ray.contains(t).then_some(Candidate { t, ..c })
        });
        Self {
            candidate,
            flops,
            bytes: P::BYTES,
        }
    }
}

/// Every kind of primitive that a [`Scene`](crate::Scene) can hold.
pub enum Geometry {
    /// The common case.
    Triangles(Triangles),
    /// Balls.
    Spheres(Spheres),
    /// The user's own, through a virtual call per test.
    Custom(Custom),
    /// Whole scenes at other places.
    Instances(Instances),
}

/// Calls a generic function on whichever kind of primitives a [`Geometry`] holds.
macro_rules! with_primitives {
    ($geometry:expr, $prims:ident => $body:expr) => {
        match $geometry {
            $crate::prims::Geometry::Triangles($prims) => $body,
            $crate::prims::Geometry::Spheres($prims) => $body,
            $crate::prims::Geometry::Custom($prims) => $body,
            $crate::prims::Geometry::Instances($prims) => $body,
        }
    };
}
pub(crate) use with_primitives;

/// The same for builds, which are compiled for each kind: without the feature `shapes` for triangles alone. Triangles may have
/// a way of their own.
macro_rules! build_over {
    ($geometry:expr, $prims:ident => $body:expr) => {
        build_over!($geometry, triangles $prims => $body, $prims => $body)
    };
    ($geometry:expr, triangles $triangles:ident => $own:expr, $prims:ident => $body:expr) => {
        match $geometry {
            $crate::prims::Geometry::Triangles($triangles) => $own,
            #[cfg(feature = "shapes")]
            $crate::prims::Geometry::Spheres($prims) => $body,
            #[cfg(feature = "shapes")]
            $crate::prims::Geometry::Custom($prims) => $body,
            #[cfg(feature = "shapes")]
            $crate::prims::Geometry::Instances($prims) => $body,
            #[cfg(not(feature = "shapes"))]
            _ => Err($crate::BuildError::NotCompiled { feature: "shapes" }),
        }
    };
}
pub(crate) use build_over;

impl Geometry {
    /// How many primitives.
    pub fn len(&self) -> usize {
        with_primitives!(self, p => p.len())
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The box around all primitives that can be hit, and how many cannot.
    pub(crate) fn extent(&self) -> (Aabb, usize) {
        with_primitives!(self, p => extent(p))
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

fn extent<P: Primitives>(prims: &P) -> (Aabb, usize) {
    let add = |(all, skipped): (Aabb, usize), i| {
        if prims.is_active(i) {
            (all.union(&prims.bounds(i)), skipped)
        } else {
            (all, skipped + 1)
        }
    };
    (0..prims.len()).fold((Aabb::EMPTY, 0), add)
}
