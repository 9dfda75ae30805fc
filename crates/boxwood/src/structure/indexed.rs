//! A structure together with its primitives: something that can be asked.

#[cfg(feature = "distances")]
use super::nearest::{is_in_domain, nearest_of_all};
use super::visit::{AllHits, Asked, ClosestHit, Occluded};
use super::{Accel, instanced};
use crate::build::BuildOptions;
use crate::error::BuildError;
#[cfg(feature = "distances")]
use crate::geom::Nearest;
use crate::geom::{Hit, PreparedRay, Ray};
use crate::prims::{Geometry, Primitives, boxes, with_primitives};
use crate::query::{Counts, NoObserver, NodeInfo, Observer, Query, Walk, Watch};
use std::any::Any;

/// An [`Accel`] with the primitives in its order.
pub struct Indexed<A, P> {
    accel: A,
    prims: P,
}

impl<A: Accel, P: Primitives> Indexed<A, P> {
    /// Builds the structure and gathers the primitives in its order.
    pub fn new(prims: &P, options: &BuildOptions) -> Result<Self, BuildError> {
        let accel = A::build(prims, &boxes(prims), options)?;
        let prims = prims.gather(accel.order());
        Ok(Self { accel, prims })
    }

    /// The same, ready for a table.
    pub(crate) fn boxed(prims: &P, options: &BuildOptions) -> Result<Box<dyn Query>, BuildError> {
        Ok(Box::new(Self::new(prims, options)?))
    }

    /// The structure.
    pub fn accel(&self) -> &A {
        &self.accel
    }

    /// The primitives, in the structure's order.
    pub fn prims(&self) -> &P {
        &self.prims
    }

    #[inline]
    fn ask<'a, O>(&'a self, ray: &'a PreparedRay, observer: &'a mut O) -> Asked<'a, P, O> {
        Asked {
            prims: &self.prims,
            ids: self.accel.order(),
            ray,
            observer,
        }
    }
}

/// The questions with a watcher. Whoever implements these is a [`Query`].
pub trait Trace: Send + Sync {
    /// See [`Query::closest_hit`].
    fn closest<O: Observer>(&self, ray: &PreparedRay, observer: &mut O) -> Option<Hit>;
    /// See [`Query::occluded`].
    fn is_occluded<O: Observer>(&self, ray: &PreparedRay, observer: &mut O) -> bool;
    /// Adds to `hits`, sorted; see [`Query::all_hits`].
    fn collect<O: Observer>(&self, ray: &PreparedRay, hits: &mut Vec<Hit>, observer: &mut O);
    /// See [`Query::nearest_each`].
    #[cfg(feature = "distances")]
    fn nearest(&self, point: &[f32; 3]) -> Option<Nearest>;
    /// See [`Query::refitted`].
    fn refit(&self, _geometry: &Geometry) -> Option<Box<dyn Query>> {
        None
    }
    /// See [`Query::for_each_node`].
    fn nodes(&self, visit: &mut dyn FnMut(NodeInfo));
    /// See [`Query::bytes`].
    fn memory(&self) -> usize;
}

impl<A: Accel, P: Primitives> Trace for Indexed<A, P> {
    #[inline]
    fn closest<O: Observer>(&self, ray: &PreparedRay, observer: &mut O) -> Option<Hit> {
        if let Some(instances) = self.prims.instances() {
            return instanced::closest(&self.accel, instances, ray, observer);
        }
        let mut visitor = ClosestHit::new(self.ask(ray, observer));
        self.accel.traverse(ray, &mut visitor);
        visitor.answer()
    }

    #[inline]
    fn is_occluded<O: Observer>(&self, ray: &PreparedRay, observer: &mut O) -> bool {
        if let Some(instances) = self.prims.instances() {
            return instanced::is_occluded(&self.accel, instances, ray, observer);
        }
        let mut visitor = Occluded {
            asked: self.ask(ray, observer),
            found: false,
        };
        self.accel.traverse(ray, &mut visitor);
        visitor.found
    }

    fn collect<O: Observer>(&self, ray: &PreparedRay, hits: &mut Vec<Hit>, observer: &mut O) {
        if let Some(instances) = self.prims.instances() {
            return instanced::collect(&self.accel, instances, ray, hits, observer);
        }
        let mut visitor = AllHits {
            asked: self.ask(ray, observer),
            hits,
        };
        self.accel.traverse(ray, &mut visitor);
        visitor.finish();
    }

    #[cfg(feature = "distances")]
    fn nearest(&self, point: &[f32; 3]) -> Option<Nearest> {
        let ids = self.accel.order().iter().copied().enumerate();
        nearest_of_all(&self.prims, ids, point)
    }

    fn refit(&self, geometry: &Geometry) -> Option<Box<dyn Query>> {
        let prims = with_primitives!(geometry, p => (p as &dyn Any).downcast_ref::<P>())?;
        let boxes = boxes(prims);
        // Those that can be hit, and no others, must have slots.
        let mut has_slot = vec![false; boxes.len()];
        for &prim in self.accel.order() {
            *has_slot.get_mut(prim as usize)? = true;
        }
        if has_slot
            .iter()
            .zip(&boxes)
            .any(|(has, b)| *has == b.is_empty())
        {
            return None;
        }
        let accel = self.accel.refitted(prims, &boxes)?;
        let prims = prims.gather(accel.order());
        Some(Box::new(Self { accel, prims }))
    }

    fn nodes(&self, visit: &mut dyn FnMut(NodeInfo)) {
        self.accel.for_each_node(visit);
    }

    fn memory(&self) -> usize {
        self.accel.bytes() + self.prims.bytes()
    }
}

impl<T: Trace> Query for T {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.closest(&PreparedRay::new(ray)?, &mut NoObserver)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        PreparedRay::new(ray).is_some_and(|ray| self.is_occluded(&ray, &mut NoObserver))
    }

    fn all_hits(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        hits.clear();
        if let Some(ray) = PreparedRay::new(ray) {
            self.collect(&ray, hits, &mut NoObserver);
        }
    }

    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = PreparedRay::new(ray).and_then(|ray| self.closest(&ray, &mut NoObserver));
        }
    }

    fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]) {
        for (ray, answer) in rays.iter().zip(occluded) {
            *answer =
                PreparedRay::new(ray).is_some_and(|ray| self.is_occluded(&ray, &mut NoObserver));
        }
    }

    #[cfg(feature = "distances")]
    fn nearest_each(&self, points: &[[f32; 3]], nearest: &mut [Option<Nearest>]) {
        for (point, answer) in points.iter().zip(nearest) {
            *answer = is_in_domain(point).then(|| self.nearest(point)).flatten();
        }
    }

    fn closest_hit_counted(&self, ray: &Ray, counts: &mut Counts) -> Option<Hit> {
        counts.ray();
        self.closest(&PreparedRay::new(ray)?, counts)
    }

    fn occluded_counted(&self, ray: &Ray, counts: &mut Counts) -> bool {
        counts.ray();
        PreparedRay::new(ray).is_some_and(|ray| self.is_occluded(&ray, counts))
    }

    fn all_hits_counted(&self, ray: &Ray, hits: &mut Vec<Hit>, counts: &mut Counts) {
        counts.ray();
        hits.clear();
        if let Some(ray) = PreparedRay::new(ray) {
            self.collect(&ray, hits, counts);
        }
    }

    fn explain(&self, ray: &Ray) -> Walk {
        let mut walk = Walk::default();
        walk.ray();
        walk.hit = PreparedRay::new(ray).and_then(|ray| self.closest(&ray, &mut walk));
        walk
    }

    fn closest_hit_prepared(&self, ray: &PreparedRay, watch: Watch<'_>) -> Option<Hit> {
        match watch {
            None => self.closest(ray, &mut NoObserver),
            Some(mut observer) => self.closest(ray, &mut observer),
        }
    }

    fn occluded_prepared(&self, ray: &PreparedRay, watch: Watch<'_>) -> bool {
        match watch {
            None => self.is_occluded(ray, &mut NoObserver),
            Some(mut observer) => self.is_occluded(ray, &mut observer),
        }
    }

    fn all_hits_prepared(&self, ray: &PreparedRay, hits: &mut Vec<Hit>, watch: Watch<'_>) {
        hits.clear();
        match watch {
            None => self.collect(ray, hits, &mut NoObserver),
            Some(mut observer) => self.collect(ray, hits, &mut observer),
        }
    }

    fn refitted(&self, geometry: &Geometry) -> Option<Box<dyn Query>> {
        self.refit(geometry)
    }

    fn for_each_node(&self, visit: &mut dyn FnMut(NodeInfo)) {
        self.nodes(visit);
    }

    fn bytes(&self) -> usize {
        self.memory()
    }
}
