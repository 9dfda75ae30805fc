//! Scenes inside scenes.

use super::{Scene, SceneBuilder};
use crate::error::BuildError;
use crate::geom::{Aabb, Affine, Hit, PreparedRay, Ray, Slack, Transform};
use crate::observe::Watch;
use crate::prims::{Content, Instances, Place};
use std::sync::Arc;

/// A scene that stands somewhere in another one: stored once, however often it is shown.
#[derive(Clone, Debug)]
pub struct Instance {
    /// What it shows; may itself be of instances.
    pub scene: Arc<Scene>,
    /// Where it stands. A matrix that cannot be undone is no error: the instance is never hit, and counted in
    /// [`Scene::skipped`].
    pub world_from_object: Transform,
    /// It is there for rays whose mask shares a bit with this ([`Scene::closest_hit_masked`]).
    pub mask: u32,
}

impl Instance {
    /// Seen by every ray.
    pub fn new(scene: &Arc<Scene>, world_from_object: Transform) -> Self {
        Self {
            scene: Arc::clone(scene),
            world_from_object,
            mask: u32::MAX,
        }
    }

    /// Seen by rays that share a bit.
    #[must_use]
    pub fn with_mask(self, mask: u32) -> Self {
        Self { mask, ..self }
    }
}

/// Where a hit of a scene of instances comes from.
#[derive(Clone, Debug)]
pub struct Placed<'a> {
    /// The scene that holds the primitive: `geom` and `prim` count in it.
    pub scene: &'a Scene,
    /// The numbers of the instances on the way to it, the outermost first; empty in a scene without instances.
    pub path: Vec<u32>,
    /// The way back.
    pub world_from_object: Affine,
}

/// How many scenes may stand inside each other, the innermost not counted.
pub(super) const MAX_NESTING: u32 = 8;

impl SceneBuilder {
    /// Puts a scene into this one. Instances are numbered in the order added; a scene is of instances or of
    /// primitives, so a mesh that is shown once beside them becomes a scene of its own, with [`Transform::IDENTITY`].
    #[must_use]
    pub fn instance(self, scene: &Arc<Scene>, world_from_object: Transform) -> Self {
        self.instances([Instance::new(scene, world_from_object)])
    }

    /// Puts several scenes into this one.
    #[must_use]
    pub fn instances(mut self, instances: impl IntoIterator<Item = Instance>) -> Self {
        self.instances.extend(instances);
        self
    }
}

impl Scene {
    /// The instances, in the order added; empty for a scene of primitives.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// How deep scenes stand inside each other: 0 for one of primitives.
    pub fn nesting(&self) -> u32 {
        self.nesting
    }

    /// How many ways lead from this scene to scenes of primitives: the numbers that [`Hit::inst`] may take. 1 for a scene of
    /// primitives.
    pub fn path_count(&self) -> u32 {
        self.paths
    }

    /// What the number in [`Hit::inst`] stands for.
    ///
    /// Ways to scenes of primitives are numbered in the order of their instances, depth first. So if no instance holds instances,
    /// `inst` is simply the number of the instance; and in any case the order of numbers is that of the paths. `None` if there
    /// is no such way. For hits of a scene of primitives ([`Hit::NO_INSTANCE`]) it is the scene itself.
    pub fn placed(&self, inst: u32) -> Option<Placed<'_>> {
        let mut placed = Placed {
            scene: self,
            path: Vec::new(),
            world_from_object: Affine::of(&Transform::IDENTITY),
        };
        let mut rest = inst;
        while !placed.scene.instances.is_empty() {
            let (number, instance) = placed.scene.instance_of(&mut rest)?;
            placed.path.push(number);
            placed.world_from_object = placed
                .world_from_object
                .after(&Affine::of(&instance.world_from_object));
            placed.scene = &instance.scene;
        }
        (rest == 0 || inst == Hit::NO_INSTANCE && placed.path.is_empty()).then_some(placed)
    }

    /// The instance that path `rest` leads through; `rest` becomes the path inside.
    fn instance_of(&self, rest: &mut u32) -> Option<(u32, &Instance)> {
        let number = self.path_starts.partition_point(|&start| start <= *rest) - 1;
        let instance = self.instances.get(number)?;
        *rest -= self.path_starts[number];
        (*rest < instance.scene.paths).then_some((number as u32, instance))
    }

    /// [`Scene::closest_hit`] among the instances whose mask shares a bit with `mask`, on every level.
    ///
    /// Masks belong to instances: a scene of primitives has none and is always there.
    pub fn closest_hit_masked(&self, ray: &Ray, mask: u32) -> Option<Hit> {
        let ray = masked(ray, mask)?;
        Content::closest_hit(self, &ray, None)
    }

    /// [`Scene::occluded`] by the instances whose mask shares a bit with `mask`.
    pub fn occluded_masked(&self, ray: &Ray, mask: u32) -> bool {
        masked(ray, mask).is_some_and(|ray| Content::occluded(self, &ray, None))
    }

    /// [`Scene::all_hits`] among the instances whose mask shares a bit with `mask`.
    pub fn all_hits_masked(&self, ray: &Ray, mask: u32) -> Vec<Hit> {
        let mut hits = Vec::new();
        if let Some(ray) = masked(ray, mask) {
            Content::all_hits(self, &ray, &mut hits, None);
        }
        hits
    }

    /// The same instances at other places: `world_from_object[i]` is where instance `i` goes.
    ///
    /// This scene stays as it is, and whoever asks it gets its answers: a change is a new scene, which shares with the old
    /// one all that is inside the instances. Only the structure over them is built anew, in time that grows with
    /// their number alone.
    ///
    /// # Errors
    /// If there are not as many transforms as instances.
    pub fn with_transforms(&self, world_from_object: &[Transform]) -> Result<Self, BuildError> {
        let (expected, found) = (self.instances.len(), world_from_object.len());
        if expected != found {
            let what = "transforms";
            return Err(BuildError::WrongCount {
                what,
                expected,
                found,
            });
        }
        let moved = self.instances.iter().zip(world_from_object);
        Self::builder()
            .instances(moved.map(|(instance, &world_from_object)| Instance {
                world_from_object,
                ..instance.clone()
            }))
            .structure(self.structure)
            .options(self.options.clone())
            .build()
    }
}

fn masked(ray: &Ray, mask: u32) -> Option<PreparedRay> {
    Some(PreparedRay {
        mask,
        ..PreparedRay::new(ray)?
    })
}

/// The instances as primitives.
pub(super) fn geometry_of(instances: &[Instance]) -> Instances {
    Instances::new(instances.iter().map(|instance| Place {
        content: Arc::clone(&instance.scene) as Arc<dyn Content>,
        world_from_object: instance.world_from_object,
        mask: instance.mask,
    }))
}

/// How deep they make the scene around them; an error beyond [`MAX_NESTING`].
pub(super) fn nesting_of(instances: &[Instance]) -> Result<u32, BuildError> {
    let inside = instances.iter().map(|instance| instance.scene.nesting);
    let nesting = inside.max().map_or(0, |deepest| deepest + 1);
    match nesting {
        depth if depth > MAX_NESTING => Err(BuildError::NestedTooDeep {
            depth,
            limit: MAX_NESTING,
        }),
        depth => Ok(depth),
    }
}

/// The number of the first path through each instance, and of all; an error if `u32` does not do.
pub(super) fn paths_of(instances: &[Instance]) -> Result<(Vec<u32>, u32), BuildError> {
    let mut starts = Vec::with_capacity(instances.len());
    let mut count = 0_u64;
    for instance in instances {
        starts.push(u32::try_from(count).unwrap_or(u32::MAX));
        count += u64::from(instance.scene.paths);
    }
    let limit = Hit::NO_INSTANCE;
    match u32::try_from(count) {
        Ok(paths) if paths < limit => Ok((starts, if instances.is_empty() { 1 } else { paths })),
        _ => Err(BuildError::TooManyPaths { count, limit }),
    }
}

impl Content for Scene {
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn slack(&self) -> Slack {
        self.geometry.slack()
    }

    fn paths(&self) -> u32 {
        self.paths
    }

    fn closest_hit(&self, ray: &PreparedRay, watch: Watch<'_>) -> Option<Hit> {
        let hit = self.query.closest_hit_prepared(ray, watch);
        hit.map(|hit| self.locate(hit))
    }

    fn occluded(&self, ray: &PreparedRay, watch: Watch<'_>) -> bool {
        self.query.occluded_prepared(ray, watch)
    }

    fn all_hits(&self, ray: &PreparedRay, hits: &mut Vec<Hit>, watch: Watch<'_>) {
        self.query.all_hits_prepared(ray, hits, watch);
        for hit in hits {
            *hit = self.locate(*hit);
        }
    }
}
