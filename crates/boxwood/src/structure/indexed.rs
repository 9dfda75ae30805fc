//! A structure together with its primitives: something that can be asked.

use super::Accel;
use super::visit::{AllHits, Asked, ClosestHit, Occluded};
use crate::build::BuildOptions;
use crate::error::BuildError;
use crate::geom::{Hit, PreparedRay, Ray};
use crate::prims::{Primitives, boxes};
use crate::query::{Counts, NoObserver, NodeInfo, Observer, Query, Walk};

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
    /// See [`Query::for_each_node`].
    fn nodes(&self, visit: &mut dyn FnMut(NodeInfo));
    /// See [`Query::bytes`].
    fn memory(&self) -> usize;
}

impl<A: Accel, P: Primitives> Trace for Indexed<A, P> {
    #[inline]
    fn closest<O: Observer>(&self, ray: &PreparedRay, observer: &mut O) -> Option<Hit> {
        let mut visitor = ClosestHit::new(self.ask(ray, observer));
        self.accel.traverse(ray, &mut visitor);
        visitor.answer()
    }

    #[inline]
    fn is_occluded<O: Observer>(&self, ray: &PreparedRay, observer: &mut O) -> bool {
        let mut visitor = Occluded {
            asked: self.ask(ray, observer),
            found: false,
        };
        self.accel.traverse(ray, &mut visitor);
        visitor.found
    }

    fn collect<O: Observer>(&self, ray: &PreparedRay, hits: &mut Vec<Hit>, observer: &mut O) {
        let mut visitor = AllHits {
            asked: self.ask(ray, observer),
            hits,
        };
        self.accel.traverse(ray, &mut visitor);
        visitor.finish();
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

    fn for_each_node(&self, visit: &mut dyn FnMut(NodeInfo)) {
        self.nodes(visit);
    }

    fn bytes(&self) -> usize {
        self.memory()
    }
}
