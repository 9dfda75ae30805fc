//! The three questions where the primitives are instances: the same visitors as for shapes, but an instance has many hits
//! with names of their own, and what is closest so far is handed inside, so that no more is looked at there than must be.

use super::visit::sort_once;
use super::{Accel, Visit};
use crate::geom::{Hit, PreparedRay};
use crate::prims::Instances;
use crate::query::Observer;
use std::ops::ControlFlow;

/// The hit with the smallest `(t, instance, geometry, primitive)`; `accel` is over the instances, in its order.
pub(super) fn closest<O: Observer>(
    accel: &impl Accel,
    instances: &Instances,
    ray: &PreparedRay,
    observer: &mut O,
) -> Option<Hit> {
    let question = Closest {
        t_max: ray.t_max,
        best: None,
    };
    ask(accel, instances, ray, observer, question).best
}

/// True if anything is hit.
pub(super) fn is_occluded<O: Observer>(
    accel: &impl Accel,
    instances: &Instances,
    ray: &PreparedRay,
    observer: &mut O,
) -> bool {
    let question = Occluded { found: false };
    ask(accel, instances, ray, observer, question).found
}

/// Adds all hits to `hits`, which is empty, sorted and each once.
pub(super) fn collect<O: Observer>(
    accel: &impl Accel,
    instances: &Instances,
    ray: &PreparedRay,
    hits: &mut Vec<Hit>,
    observer: &mut O,
) {
    let question = AllHits {
        hits,
        scratch: Vec::new(),
    };
    sort_once(ask(accel, instances, ray, observer, question).hits);
}

fn ask<O: Observer, Q: Question>(
    accel: &impl Accel,
    instances: &Instances,
    ray: &PreparedRay,
    observer: &mut O,
    question: Q,
) -> Q {
    let ray = &instances.loosened(ray);
    let mut visitor = Visitor {
        instances,
        ray,
        observer,
        question,
    };
    accel.traverse(ray, &mut visitor);
    visitor.question
}

/// What is asked of each instance, and what has come of it.
trait Question {
    /// See [`Visit::IN_ORDER`].
    const IN_ORDER: bool = false;

    /// Nothing beyond this matters any more.
    fn t_max(&self, ray: &PreparedRay) -> f32 {
        ray.t_max
    }

    /// Asks one instance. `Break` ends the traversal.
    fn put<O: Observer>(
        &mut self,
        instances: &Instances,
        slot: usize,
        ray: &PreparedRay,
        observer: &mut O,
    ) -> ControlFlow<()>;
}

/// [`ClosestHit`](super::ClosestHit) among instances.
struct Closest {
    t_max: f32,
    best: Option<Hit>,
}

impl Question for Closest {
    const IN_ORDER: bool = true;

    #[inline(always)]
    fn t_max(&self, _: &PreparedRay) -> f32 {
        self.t_max
    }

    #[inline]
    fn put<O: Observer>(
        &mut self,
        instances: &Instances,
        slot: usize,
        ray: &PreparedRay,
        observer: &mut O,
    ) -> ControlFlow<()> {
        let found = instances.closest_hit(slot, ray, self.t_max, observer);
        if let Some(hit) = found
            && self.best.is_none_or(|best| hit.order(&best).is_lt())
        {
            self.t_max = hit.t;
            self.best = Some(hit);
        }
        ControlFlow::Continue(())
    }
}

/// [`Occluded`](super::Occluded) among instances.
struct Occluded {
    found: bool,
}

impl Question for Occluded {
    #[inline]
    fn put<O: Observer>(
        &mut self,
        instances: &Instances,
        slot: usize,
        ray: &PreparedRay,
        observer: &mut O,
    ) -> ControlFlow<()> {
        self.found = instances.occluded(slot, ray, observer);
        if self.found {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

/// [`AllHits`](super::AllHits) among instances.
struct AllHits<'a> {
    hits: &'a mut Vec<Hit>,
    scratch: Vec<Hit>,
}

impl Question for AllHits<'_> {
    #[inline]
    fn put<O: Observer>(
        &mut self,
        instances: &Instances,
        slot: usize,
        ray: &PreparedRay,
        observer: &mut O,
    ) -> ControlFlow<()> {
        let into = (&mut *self.hits, &mut self.scratch);
        instances.all_hits(slot, ray, into, observer);
        ControlFlow::Continue(())
    }
}

/// Puts a question to instances.
struct Visitor<'a, O, Q> {
    instances: &'a Instances,
    ray: &'a PreparedRay,
    observer: &'a mut O,
    question: Q,
}

impl<O: Observer, Q: Question> Visit for Visitor<'_, O, Q> {
    const IN_ORDER: bool = Q::IN_ORDER;

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.question.t_max(self.ray)
    }

    #[inline(always)]
    fn address(&self, _: u32) -> *const u8 {
        std::ptr::null()
    }

    fn leaf(&mut self, mut slots: impl Iterator<Item = u32>) -> ControlFlow<()> {
        slots.try_for_each(|slot| {
            self.question
                .put(self.instances, slot as usize, self.ray, self.observer)
        })
    }

    #[inline(always)]
    fn observer(&mut self) -> &mut impl Observer {
        &mut *self.observer
    }
}
