//! The questions, and what answering them costs.

mod walk;

pub use crate::observe::{
    CellVisit, Counts, InstanceVerdict, InstanceVisit, NoObserver, Observer, PrimitiveTest,
    PrimitiveVerdict, VolumeTest, VolumeVerdict, Watch,
};
pub use walk::{Step, Walk};

#[cfg(feature = "distances")]
use crate::geom::Nearest;
use crate::geom::{Aabb, Hit, PreparedRay, Ray, Triangle};
use crate::prims::Geometry;

/// What every structure answers, for single rays and for slices of rays.
///
/// All structures give the same bits. The plain forms count nothing and pay nothing; the counted forms are separate code
/// in the same binary. Slices are answered in order by the calling thread, with one virtual call;
/// [`Scene`](crate::Scene) spreads them over threads.
pub trait Query: Send + Sync {
    /// The hit with the smallest `(t, instance, geometry, primitive)`.
    fn closest_hit(&self, ray: &Ray) -> Option<Hit>;

    /// True if there is any hit in the ray's range. Stops at the first found.
    fn occluded(&self, ray: &Ray) -> bool;

    /// Replaces `hits` by all hits in the ray's range, each primitive at most once, in the order of [`Hit::order`].
    fn all_hits(&self, ray: &Ray, hits: &mut Vec<Hit>);

    /// [`Query::closest_hit`] for each ray. The slices are walked together; the longer one's rest is left alone.
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]);

    /// The same, each entry written, for whoever reads the triangles that are hit next: meanwhile the processor may be asked for them.
    fn closest_hits_fetching(
        &self,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        triangles: &[Triangle],
    ) {
        let _ = triangles;
        self.closest_hits(rays, hits);
    }

    /// [`Query::occluded`] for each ray.
    fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]);

    /// Appends the hits of [`Query::all_hits`] to `hits`, ray by ray, and sets how many each ray has. The
    /// slices are walked together.
    #[cfg(feature = "lists")]
    fn list_each(&self, rays: &[Ray], hits: &mut Vec<Hit>, counts: &mut [u32]) {
        let mut of_one = Vec::new();
        for (ray, count) in rays.iter().zip(counts) {
            self.all_hits(ray, &mut of_one);
            *count = of_one.len() as u32;
            hits.append(&mut of_one);
        }
    }

    /// How many hits [`Query::all_hits`] has for each ray.
    #[cfg(feature = "lists")]
    fn count_each(&self, rays: &[Ray], counts: &mut [u32]) {
        let mut hits = Vec::new();
        for (ray, count) in rays.iter().zip(counts) {
            self.all_hits(ray, &mut hits);
            *count = hits.len() as u32;
        }
    }

    /// The place of a triangle that is nearest to each point, the one with the smallest `(distance, geometry, primitive)`: the
    /// slices are walked together. `None` for a point that is not finite or outside the domain, and where there are no triangles:
    /// other primitives have no nearest places yet. Triangles without area count, as the edges or points that they are.
    ///
    /// Wide structures ask few triangles, the others all.
    #[cfg(feature = "distances")]
    fn nearest_each(&self, points: &[[f32; 3]], nearest: &mut [Option<Nearest>]);

    /// [`Query::closest_hit`], adding its work to `counts`.
    fn closest_hit_counted(&self, ray: &Ray, counts: &mut Counts) -> Option<Hit>;

    /// [`Query::occluded`], adding its work to `counts`.
    fn occluded_counted(&self, ray: &Ray, counts: &mut Counts) -> bool;

    /// [`Query::all_hits`], adding its work to `counts`.
    fn all_hits_counted(&self, ray: &Ray, hits: &mut Vec<Hit>, counts: &mut Counts);

    /// How [`Query::closest_hit`] comes to its answer, step by step.
    fn explain(&self, ray: &Ray) -> Walk;

    /// [`Query::closest_hit`] for a ray that is ready, watched by whoever is given: how scenes inside scenes are asked,
    /// and rays with a mask.
    fn closest_hit_prepared(&self, ray: &PreparedRay, watch: Watch<'_>) -> Option<Hit>;

    /// [`Query::occluded`] for a ray that is ready.
    fn occluded_prepared(&self, ray: &PreparedRay, watch: Watch<'_>) -> bool;

    /// [`Query::all_hits`] for a ray that is ready.
    fn all_hits_prepared(&self, ray: &PreparedRay, hits: &mut Vec<Hit>, watch: Watch<'_>);

    /// The same structure around primitives that have moved, cheaper than a new one but not as good; `None` where that
    /// cannot be, and a new one is to be built. The geometry is of the same kind and length as the one built over.
    fn refitted(&self, _geometry: &Geometry) -> Option<Box<dyn Query>> {
        None
    }

    /// Calls `visit` for every node (of a grid: for every cell that is not empty), parents first.
    fn for_each_node(&self, visit: &mut dyn FnMut(NodeInfo));

    /// Memory of the structure with its copy of the primitives, in bytes.
    fn bytes(&self) -> usize;

    /// The structure as a file keeps it, and the box around it; `None` if no file does.
    #[cfg(feature = "file")]
    fn saved(&self) -> Option<(&[u8], Aabb)> {
        None
    }
}

/// A node as statistics and drawings see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeInfo {
    /// Number, as in the steps of a [`Walk`].
    pub node: u32,
    /// 0 for the root.
    pub depth: u32,
    /// The box around the node's volume.
    pub bounds: Aabb,
    /// Primitives of a leaf; `None` for an inner node.
    pub prims: Option<u32>,
}
