//! Instances: content that stands somewhere else, or at many places at once, and is stored once.
//!
//! An instance is a primitive with many hits: structures see its box and nothing else, and the visitors in
//! `structure/instanced.rs` ask its content with the turned ray (see `geom/transform.rs` for the exact recipe and for why
//! the box never loses a hit).

use super::{Geometry, Primitives, with_primitives};
use crate::geom::{Aabb, Candidate, Hit, Placement, PreparedRay, Slack, Transform};
use crate::observe::{InstanceVerdict, InstanceVisit, Observer, Watch, watch};
use std::sync::Arc;

/// What can be instanced: a scene, as seen from below.
pub(crate) trait Content: Send + Sync {
    /// The box around everything that can be hit.
    fn bounds(&self) -> Aabb;
    /// How far outside of it hits may lie.
    fn slack(&self) -> Slack;
    /// How many numbers the `inst` of its hits needs: one, or one for each instance inside.
    fn paths(&self) -> u32;
    /// The closest hit, as the content's own users see it.
    fn closest_hit(&self, ray: &PreparedRay, watch: Watch<'_>) -> Option<Hit>;
    /// True if anything is hit.
    fn occluded(&self, ray: &PreparedRay, watch: Watch<'_>) -> bool;
    /// Replaces `hits` by all hits, each once.
    fn all_hits(&self, ray: &PreparedRay, hits: &mut Vec<Hit>, watch: Watch<'_>);
}

/// A set of instances. Scenes make it ([`SceneBuilder::instance`](crate::SceneBuilder::instance)).
#[derive(Clone, Default)]
pub struct Instances {
    all: Vec<Placed>,
    bounds: Aabb,
    slack: Option<Slack>,
}

/// One instance.
#[derive(Clone)]
struct Placed {
    content: Arc<dyn Content>,
    /// Number in the scene.
    number: u32,
    /// Number of its first path.
    first: u32,
    mask: u32,
    /// Empty if it can never be hit.
    bounds: Aabb,
    placement: Option<Placement>,
}

/// Where an instance stands, what it shows, and to whom.
pub(crate) struct Place {
    pub(crate) content: Arc<dyn Content>,
    pub(crate) world_from_object: Transform,
    pub(crate) mask: u32,
}

impl Instances {
    /// Numbered in the order given. The numbers of all paths must fit `u32`, which the scene sees to.
    pub(crate) fn new(places: impl IntoIterator<Item = Place>) -> Self {
        let mut instances = Self::default();
        let mut first = 0_u32;
        for (place, number) in places.into_iter().zip(0..) {
            let paths = place.content.paths();
            instances.push(place, number, first);
            first = first.saturating_add(paths);
        }
        instances
    }

    fn push(&mut self, place: Place, number: u32, first: u32) {
        let Place {
            content,
            world_from_object,
            mask,
        } = place;
        let placement = Placement::new(&world_from_object);
        let placed_box = placement
            .and_then(|p| p.world_box(&world_from_object, &content.bounds(), content.slack()));
        let mut bounds = Aabb::EMPTY;
        if let Some((around, slack)) = placed_box {
            bounds = around;
            self.bounds = self.bounds.union(&bounds);
            self.slack = Some(self.slack.map_or(slack, |all| all.max(slack)));
        }
        self.all.push(Placed {
            content,
            number,
            first,
            mask,
            bounds,
            placement,
        });
    }

    /// How far outside of their boxes hits may lie.
    pub(crate) fn slack(&self) -> Slack {
        self.slack.unwrap_or(Slack::OF_PRIMITIVES)
    }

    /// The ray for a structure around these instances.
    pub(crate) fn loosened(&self, ray: &PreparedRay) -> PreparedRay {
        ray.loosened(self.slack(), &self.bounds)
    }

    /// The closest hit on one instance, no farther than `t_max`.
    pub(crate) fn closest_hit<O: Observer>(
        &self,
        index: usize,
        ray: &PreparedRay,
        t_max: f32,
        observer: &mut O,
    ) -> Option<Hit> {
        let placed = &self.all[index];
        let inside = placed.enter(ray, t_max, observer)?;
        let hit = placed.content.closest_hit(&inside, watch(observer));
        placed.leave(observer);
        hit.map(|hit| placed.named(hit))
    }

    /// True if anything of one instance is hit.
    pub(crate) fn occluded<O: Observer>(
        &self,
        index: usize,
        ray: &PreparedRay,
        observer: &mut O,
    ) -> bool {
        let placed = &self.all[index];
        let Some(inside) = placed.enter(ray, ray.t_max, observer) else {
            return false;
        };
        let occluded = placed.content.occluded(&inside, watch(observer));
        placed.leave(observer);
        occluded
    }

    /// Appends all hits on one instance. `scratch` is memory that is used again.
    pub(crate) fn all_hits<O: Observer>(
        &self,
        index: usize,
        ray: &PreparedRay,
        (hits, scratch): (&mut Vec<Hit>, &mut Vec<Hit>),
        observer: &mut O,
    ) {
        let placed = &self.all[index];
        let Some(inside) = placed.enter(ray, ray.t_max, observer) else {
            return;
        };
        placed.content.all_hits(&inside, scratch, watch(observer));
        placed.leave(observer);
        hits.extend(scratch.iter().map(|hit| placed.named(*hit)));
    }
}

impl Placed {
    /// The ray inside, if it comes in at all.
    #[inline]
    fn enter(
        &self,
        ray: &PreparedRay,
        t_max: f32,
        observer: &mut impl Observer,
    ) -> Option<PreparedRay> {
        let is_seen = self.mask & ray.mask != 0;
        let inside = self
            .placement
            .filter(|_| is_seen)
            .and_then(|placement| placement.ray_in_object(ray, t_max));
        observer.instance(InstanceVisit {
            instance: self.number,
            verdict: match (is_seen, &inside) {
                (false, _) => InstanceVerdict::Masked,
                (true, None) => InstanceVerdict::Miss,
                (true, Some(_)) => InstanceVerdict::Enter,
            },
            flops: if is_seen { Placement::FLOPS } else { 0 },
            bytes: Instances::BYTES,
        });
        inside
    }

    fn leave(&self, observer: &mut impl Observer) {
        observer.instance(InstanceVisit {
            instance: self.number,
            verdict: InstanceVerdict::Leave,
            flops: 0,
            bytes: 0,
        });
    }

    /// The hit with the number of the path through this instance.
    #[inline]
    fn named(&self, hit: Hit) -> Hit {
        let inside = if hit.inst == Hit::NO_INSTANCE {
            0
        } else {
            hit.inst
        };
        Hit {
            inst: self.first + inside,
            ..hit
        }
    }
}

impl Primitives for Instances {
    const FLOPS_MISS: u32 = Placement::FLOPS;
    const FLOPS_HIT: u32 = Placement::FLOPS;
    const BYTES: u32 = size_of::<Placed>() as u32;

    fn len(&self) -> usize {
        self.all.len()
    }

    fn bounds(&self, index: usize) -> Aabb {
        self.all[index].bounds
    }

    /// The closest point of the content, without its ids.
    fn intersect(&self, index: usize, ray: &PreparedRay) -> Option<Candidate> {
        let nobody = &mut crate::observe::NoObserver;
        let Hit { t, u, v, .. } = self.closest_hit(index, ray, ray.t_max, nobody)?;
        Some(Candidate { t, u, v })
    }

    fn gather(&self, order: &[u32]) -> Self {
        Self {
            all: order
                .iter()
                .map(|&i| self.all[i as usize].clone())
                .collect(),
            ..*self
        }
    }

    fn instances(&self) -> Option<&Instances> {
        Some(self)
    }

    /// Without the content.
    fn bytes(&self) -> usize {
        size_of_val(self.all.as_slice())
    }
}

impl std::fmt::Debug for Instances {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Instances")
            .field("count", &self.all.len())
            .field("bounds", &self.bounds)
            .finish_non_exhaustive()
    }
}

impl Geometry {
    /// How far outside of the box around all primitives hits may lie.
    pub(crate) fn slack(&self) -> Slack {
        with_primitives!(self, p => p.instances().map_or(Slack::OF_PRIMITIVES, Instances::slack))
    }
}
