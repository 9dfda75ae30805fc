//! The wide tree over triangles, which are packed into its leaves: what most scenes are.

#[cfg(feature = "compact")]
use super::Compact;
use super::batch::{self, Answers};
use super::form::Form;
use super::layout::{MAX_GRANULES, Ref};
#[cfg(feature = "lists")]
use super::lists::{Lists, Names, Numbers};
#[cfg(feature = "distances")]
use super::nearest::nearest_of_each;
use super::pending::Best;
use super::single;
use super::walk::{Leaves, for_each, walk};
use super::{Full, Payload, Wide};
use crate::build::{BuildOptions, WideTopology};
use crate::error::BuildError;
#[cfg(feature = "file")]
use crate::geom::Aabb;
#[cfg(feature = "distances")]
use crate::geom::Nearest;
use crate::geom::{Candidate, Hit, PreparedRay, Ray, Triangle};
use crate::prims::{Tested, Triangles, boxes};
use crate::query::{
    Counts, NoObserver, NodeInfo, Observer, PrimitiveTest, PrimitiveVerdict, Query, Walk, Watch,
};
use crate::simd::fetch_ends;
use crate::structure::visit::hit;
use fearless_simd::dispatch;
use std::ops::ControlFlow;

/// A wide tree with the triangles in its leaves.
pub(crate) struct WideTriangles<M>(pub(super) Wide<M>);

impl<M: Form> WideTriangles<M> {
    /// Builds it.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`] beyond 4 GB, [`BuildError::OutOfMemory`], and those of the builder.
    #[cfg(any(feature = "compact", test))]
    pub(crate) fn boxed(
        prims: &Triangles,
        options: &BuildOptions,
    ) -> Result<Box<dyn Query>, BuildError> {
        let tree = super::collapsed(prims, &boxes(prims), options)?;
        Self::within(MAX_GRANULES, &tree, prims, options)
    }

    fn within(
        limit: u32,
        tree: &WideTopology,
        prims: &Triangles,
        options: &BuildOptions,
    ) -> Result<Box<dyn Query>, BuildError> {
        let payload = Payload::Triangles(prims.as_slice());
        Ok(Box::new(Self(Wide::within(
            limit, tree, &payload, options,
        )?)))
    }
}

impl WideTriangles<Full> {
    /// The same, in the compact form if it would be too large in this one and the compact one is there.
    ///
    /// # Errors
    /// As for [`WideTriangles::boxed`].
    pub(crate) fn boxed_or_compact(
        prims: &Triangles,
        options: &BuildOptions,
    ) -> Result<Box<dyn Query>, BuildError> {
        Self::boxed_within(MAX_GRANULES, prims, options)
    }

    fn boxed_within(
        limit: u32,
        prims: &Triangles,
        options: &BuildOptions,
    ) -> Result<Box<dyn Query>, BuildError> {
        let tree = super::collapsed(prims, &boxes(prims), options)?;
        match Self::within(limit, &tree, prims, options) {
            #[cfg(feature = "compact")]
            Err(BuildError::TooLarge { .. }) => {
                WideTriangles::<Compact>::within(limit, &tree, prims, options)
            }
            built => built,
        }
    }
}

/// What the exact test's candidates mean for an answer.
trait Judge {
    fn t_max(&self) -> f32;
    fn judge(&mut self, candidate: Candidate, prim: u32) -> (PrimitiveVerdict, ControlFlow<()>);
}

/// The smallest `(t, primitive)`.
struct Closest(Best);

impl Closest {
    fn new(ray: &PreparedRay) -> Self {
        Self(Best::none(ray.t_max))
    }
}

impl Judge for Closest {
    fn t_max(&self) -> f32 {
        self.0.candidate.t
    }

    fn judge(&mut self, candidate: Candidate, prim: u32) -> (PrimitiveVerdict, ControlFlow<()>) {
        let verdict = if self.0.improve(candidate, prim) {
            PrimitiveVerdict::Closest
        } else {
            PrimitiveVerdict::Farther
        };
        (verdict, ControlFlow::Continue(()))
    }
}

/// Any hit.
struct Occluded {
    t_max: f32,
    found: bool,
}

impl Judge for Occluded {
    fn t_max(&self) -> f32 {
        self.t_max
    }

    fn judge(&mut self, _: Candidate, _: u32) -> (PrimitiveVerdict, ControlFlow<()>) {
        self.found = true;
        (PrimitiveVerdict::Closest, ControlFlow::Break(()))
    }
}

/// Every hit.
struct All<'a> {
    t_max: f32,
    hits: &'a mut Vec<Hit>,
}

impl Judge for All<'_> {
    fn t_max(&self) -> f32 {
        self.t_max
    }

    fn judge(&mut self, candidate: Candidate, prim: u32) -> (PrimitiveVerdict, ControlFlow<()>) {
        self.hits.push(hit(candidate, prim));
        (PrimitiveVerdict::Closest, ControlFlow::Continue(()))
    }
}

/// The exact test for each triangle of a leaf.
struct Exact<'a, M, O, J> {
    wide: &'a Wide<M>,
    ray: &'a PreparedRay,
    observer: &'a mut O,
    judge: J,
}

impl<M: Form, O: Observer, J: Judge> Leaves for Exact<'_, M, O, J> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.judge.t_max()
    }

    fn leaf(&mut self, leaf: Ref) -> ControlFlow<()> {
        for lane in 0..leaf.count() {
            let (corners, prim) = self.wide.store.triangle(leaf, lane);
            let shape = Triangle(corners);
            let Tested {
                candidate,
                flops,
                bytes,
            } = Tested::new::<Triangles>(shape.intersect(self.ray), || shape.bounds(), self.ray);
            let (verdict, flow) = match candidate {
                Some(found) => self.judge.judge(found, prim),
                None => (PrimitiveVerdict::Miss, ControlFlow::Continue(())),
            };
            self.observer.primitive(PrimitiveTest {
                prim,
                candidate,
                verdict,
                flops,
                bytes,
            });
            flow?;
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn observer(&mut self) -> &mut impl Observer {
        &mut *self.observer
    }
}

impl<M: Form> Wide<M> {
    fn walked<O: Observer, J: Judge>(&self, ray: &PreparedRay, observer: &mut O, judge: J) -> J {
        let mut exact = Exact {
            wide: self,
            ray,
            observer,
            judge,
        };
        walk(self, ray, &mut exact);
        exact.judge
    }

    /// The closest hit by the watched walk.
    pub(super) fn closest_walked<O: Observer>(&self, ray: &PreparedRay, observer: &mut O) -> Best {
        self.walked(ray, observer, Closest::new(ray)).0
    }

    /// Occlusion by the watched walk.
    pub(super) fn occluded_walked<O: Observer>(&self, ray: &PreparedRay, observer: &mut O) -> bool {
        let judge = Occluded {
            t_max: ray.t_max,
            found: false,
        };
        self.walked(ray, observer, judge).found
    }

    /// All hits by the watched walk.
    pub(super) fn all_walked<O: Observer>(
        &self,
        ray: &PreparedRay,
        hits: &mut Vec<Hit>,
        observer: &mut O,
    ) {
        self.walked(
            ray,
            observer,
            All {
                t_max: ray.t_max,
                hits,
            },
        );
        hits.sort_unstable_by(Hit::order);
        // A primitive that was split has equal hits, hence neighbours.
        hits.dedup_by_key(|hit| hit.prim);
    }
}

fn answer(best: Best) -> Option<Hit> {
    (best.prim != u32::MAX).then(|| hit(best.candidate, best.prim))
}

/// Answers of a batch of closest hits.
struct ClosestHits<'a> {
    hits: &'a mut [Option<Hit>],
    /// What is to be fetched of what is hit; none if nothing.
    triangles: &'a [Triangle],
}

impl Answers for ClosestHits<'_> {
    const ANY: bool = false;

    #[inline(always)]
    fn give(&mut self, ray: usize, best: Best) {
        self.hits[ray] = answer(best);
        if !self.triangles.is_empty() {
            // Some line is fetched for a miss, too: whether a ray hits cannot be guessed.
            let prim = best.prim as usize;
            let place = if prim < self.triangles.len() { prim } else { 0 };
            fetch_ends(&self.triangles[place]);
        }
    }
}

/// Answers of a batch of occlusions.
struct OccludedEach<'a>(&'a mut [bool]);

impl Answers for OccludedEach<'_> {
    const ANY: bool = true;

    #[inline(always)]
    fn give(&mut self, ray: usize, best: Best) {
        self.0[ray] = best.prim != u32::MAX;
    }
}

impl<M: Form> Query for WideTriangles<M> {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        // No closure in here: it may be left out of the instruction set.
        answer(dispatch!(self.0.level.0, simd => single::closest(simd, &self.0, ray)))
    }

    fn occluded(&self, ray: &Ray) -> bool {
        dispatch!(self.0.level.0, simd => single::occluded(simd, &self.0, ray))
    }

    fn closest_hit_prepared(&self, ray: &PreparedRay, watch: Watch<'_>) -> Option<Hit> {
        match watch {
            None => self.closest_hit(&ray.ray()),
            Some(mut observer) => answer(self.0.closest_walked(ray, &mut observer)),
        }
    }

    fn occluded_prepared(&self, ray: &PreparedRay, watch: Watch<'_>) -> bool {
        match watch {
            None => self.occluded(&ray.ray()),
            Some(mut observer) => self.0.occluded_walked(ray, &mut observer),
        }
    }

    fn all_hits_prepared(&self, ray: &PreparedRay, hits: &mut Vec<Hit>, watch: Watch<'_>) {
        hits.clear();
        match watch {
            None => self.0.all_walked(ray, hits, &mut NoObserver),
            Some(mut observer) => self.0.all_walked(ray, hits, &mut observer),
        }
    }

    fn all_hits(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        hits.clear();
        if let Some(ray) = PreparedRay::new(ray) {
            self.0.all_walked(&ray, hits, &mut NoObserver);
        }
    }

    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.closest_hits_fetching(rays, hits, &[]);
    }

    fn closest_hits_fetching(
        &self,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        triangles: &[Triangle],
    ) {
        let count = rays.len().min(hits.len());
        let hits = &mut hits[..count];
        batch::trace(
            &self.0,
            &rays[..count],
            &mut ClosestHits { hits, triangles },
        );
    }

    fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]) {
        let count = rays.len().min(occluded.len());
        batch::trace(
            &self.0,
            &rays[..count],
            &mut OccludedEach(&mut occluded[..count]),
        );
    }

    #[cfg(feature = "lists")]
    fn list_each(&self, rays: &[Ray], hits: &mut Vec<Hit>, counts: &mut [u32]) {
        let count = rays.len().min(counts.len());
        let mut lists = Lists::NEW;
        batch::trace(&self.0, &rays[..count], &mut lists);
        lists.give(hits, &mut counts[..count]);
    }

    #[cfg(feature = "lists")]
    fn count_each(&self, rays: &[Ray], counts: &mut [u32]) {
        let count = rays.len().min(counts.len());
        let (rays, counts) = (&rays[..count], &mut counts[..count]);
        if self.0.has_copies {
            let mut names = Names::NEW;
            batch::trace(&self.0, rays, &mut names);
            names.give(counts);
        } else {
            counts.fill(0);
            batch::trace(&self.0, rays, &mut Numbers(counts));
        }
    }

    #[cfg(feature = "distances")]
    fn nearest_each(&self, points: &[[f32; 3]], nearest: &mut [Option<Nearest>]) {
        dispatch!(self.0.level.0, simd => nearest_of_each(simd, &self.0, points, nearest));
    }

    fn closest_hit_counted(&self, ray: &Ray, counts: &mut Counts) -> Option<Hit> {
        counts.ray();
        answer(self.0.closest_walked(&PreparedRay::new(ray)?, counts))
    }

    fn occluded_counted(&self, ray: &Ray, counts: &mut Counts) -> bool {
        counts.ray();
        PreparedRay::new(ray).is_some_and(|ray| self.0.occluded_walked(&ray, counts))
    }

    fn all_hits_counted(&self, ray: &Ray, hits: &mut Vec<Hit>, counts: &mut Counts) {
        counts.ray();
        hits.clear();
        if let Some(ray) = PreparedRay::new(ray) {
            self.0.all_walked(&ray, hits, counts);
        }
    }

    fn explain(&self, ray: &Ray) -> Walk {
        let mut walk = Walk::default();
        walk.ray();
        walk.hit =
            PreparedRay::new(ray).and_then(|ray| answer(self.0.closest_walked(&ray, &mut walk)));
        walk
    }

    fn for_each_node(&self, visit: &mut dyn FnMut(NodeInfo)) {
        for_each(&self.0, visit);
    }

    fn bytes(&self) -> usize {
        self.0.store.len()
    }

    #[cfg(feature = "file")]
    fn saved(&self) -> Option<(&[u8], Aabb)> {
        M::IS_SAVED.then(|| (self.0.store.bytes(), self.0.bounds))
    }
}

#[cfg(all(test, feature = "compact"))]
mod tests {
    use super::*;
    use crate::simd::GRANULE;

    /// Two triangles a square, `n` squares each way, not quite flat.
    fn sheet(n: usize) -> Triangles {
        let corner = |x: usize, y: usize| [x as f32, y as f32, ((x * 7 + y * 3) % 5) as f32 * 0.1];
        let square = |k: usize| {
            let (x, y) = (k % n, k / n);
            let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| corner(x + i, y + j));
            [Triangle([a, b, c]), Triangle([b, d, c])]
        };
        Triangles::new((0..n * n).flat_map(square).collect())
    }

    #[test]
    fn what_is_too_large_as_rows_is_made_compact_and_then_refused() {
        let (prims, options) = (sheet(16), BuildOptions::default());
        let full = WideTriangles::<Full>::boxed_or_compact(&prims, &options).unwrap();
        let compact = WideTriangles::<Compact>::boxed(&prims, &options).unwrap();
        let granules = |query: &dyn Query| (query.bytes() / GRANULE) as u32;
        let between = granules(&*compact).midpoint(granules(&*full));
        let fallen = WideTriangles::<Full>::boxed_within(between, &prims, &options).unwrap();
        assert_eq!(fallen.bytes(), compact.bytes());
        let small = granules(&*compact) / 2;
        let refused = WideTriangles::<Full>::boxed_within(small, &prims, &options);
        assert!(
            matches!(refused, Err(BuildError::TooLarge { limit, .. }) if limit == u64::from(small) * 16)
        );
        let mut hits = 0;
        for k in 0..1000_usize {
            let (x, y) = ((k % 37) as f32 * 0.44, (k % 41) as f32 * 0.4);
            let ray = Ray::new([x, y, 3.0], [0.01 * x, -0.01, -1.0]);
            assert_eq!(fallen.closest_hit(&ray), full.closest_hit(&ray));
            hits += usize::from(full.closest_hit(&ray).is_some());
        }
        assert!(hits > 500, "{hits}");
    }
}
