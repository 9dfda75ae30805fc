//! The three questions where the primitives are instances: the same visitors as for shapes, but an instance has many hits
//! with names of their own, and what is closest so far is handed inside, so that no more is looked at there than must be.

use super::{Accel, Visit};
use crate::geom::{Hit, PreparedRay};
use crate::prims::Instances;
use crate::query::Observer;
use std::ops::ControlFlow;

/// [`ClosestHit`](super::ClosestHit) among instances.
struct Closest<'a, O> {
    instances: &'a Instances,
    ray: &'a PreparedRay,
    observer: &'a mut O,
    t_max: f32,
    best: Option<Hit>,
}

/// [`Occluded`](super::Occluded) among instances.
struct Occluded<'a, O> {
    instances: &'a Instances,
    ray: &'a PreparedRay,
    observer: &'a mut O,
    found: bool,
}

/// [`AllHits`](super::AllHits) among instances.
struct AllHits<'a, O> {
    instances: &'a Instances,
    ray: &'a PreparedRay,
    observer: &'a mut O,
    hits: &'a mut Vec<Hit>,
    scratch: Vec<Hit>,
}

/// The hit with the smallest `(t, instance, geometry, primitive)`; `accel` is over the instances, in its order.
pub(super) fn closest<O: Observer>(
    accel: &impl Accel,
    instances: &Instances,
    ray: &PreparedRay,
    observer: &mut O,
) -> Option<Hit> {
    let ray = &instances.loosened(ray);
    let mut visitor = Closest {
        instances,
        ray,
        observer,
        t_max: ray.t_max,
        best: None,
    };
    accel.traverse(ray, &mut visitor);
    visitor.best
}

/// True if anything is hit.
pub(super) fn is_occluded<O: Observer>(
    accel: &impl Accel,
    instances: &Instances,
    ray: &PreparedRay,
    observer: &mut O,
) -> bool {
    let ray = &instances.loosened(ray);
    let mut visitor = Occluded {
        instances,
        ray,
        observer,
        found: false,
    };
    accel.traverse(ray, &mut visitor);
    visitor.found
}

/// Adds all hits to `hits`, which is empty, sorted and each once.
pub(super) fn collect<O: Observer>(
    accel: &impl Accel,
    instances: &Instances,
    ray: &PreparedRay,
    hits: &mut Vec<Hit>,
    observer: &mut O,
) {
    let ray = &instances.loosened(ray);
    let mut visitor = AllHits {
        instances,
        ray,
        observer,
        hits,
        scratch: Vec::new(),
    };
    accel.traverse(ray, &mut visitor);
    sort_once(hits);
}

/// In the order of [`Hit::order`], each once: an instance may have been asked twice.
pub(super) fn sort_once(hits: &mut Vec<Hit>) {
    hits.sort_unstable_by(Hit::order);
    hits.dedup_by_key(|hit| (hit.inst, hit.geom, hit.prim));
}

impl<O: Observer> Visit for Closest<'_, O> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn address(&self, _: u32) -> *const u8 {
        std::ptr::null()
    }

    fn leaf(&mut self, slots: impl Iterator<Item = u32>) -> ControlFlow<()> {
        for slot in slots {
            let found =
                self.instances
                    .closest_hit(slot as usize, self.ray, self.t_max, self.observer);
            if let Some(hit) = found
                && self.best.is_none_or(|best| hit.order(&best).is_lt())
            {
                self.t_max = hit.t;
                self.best = Some(hit);
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn observer(&mut self) -> &mut impl Observer {
        &mut *self.observer
    }
}

impl<O: Observer> Visit for Occluded<'_, O> {
    const IN_ORDER: bool = false;

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.ray.t_max
    }

    #[inline(always)]
    fn address(&self, _: u32) -> *const u8 {
        std::ptr::null()
    }

    fn leaf(&mut self, slots: impl Iterator<Item = u32>) -> ControlFlow<()> {
        for slot in slots {
            if self
                .instances
                .occluded(slot as usize, self.ray, self.observer)
            {
                self.found = true;
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn observer(&mut self) -> &mut impl Observer {
        &mut *self.observer
    }
}

impl<O: Observer> Visit for AllHits<'_, O> {
    const IN_ORDER: bool = false;

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.ray.t_max
    }

    #[inline(always)]
    fn address(&self, _: u32) -> *const u8 {
        std::ptr::null()
    }

    fn leaf(&mut self, slots: impl Iterator<Item = u32>) -> ControlFlow<()> {
        for slot in slots {
            let into = (&mut *self.hits, &mut self.scratch);
            self.instances
                .all_hits(slot as usize, self.ray, into, self.observer);
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn observer(&mut self) -> &mut impl Observer {
        &mut *self.observer
    }
}
