//! The lecture's implementation: a `BoundedObject` is a new kind of object that stores references to objects, which may
//! be bounded objects themselves. Its `ray_intersect` asks each child and returns the closest hit.

use super::indexed::Trace;
#[cfg(feature = "distances")]
use super::nearest::nearest_of_all;
use super::visit::{hit, sort_once};
use crate::build::{BuildInput, BuildOptions, Topology};
use crate::error::BuildError;
#[cfg(feature = "distances")]
use crate::geom::Nearest;
use crate::geom::{Aabb, Hit, Interval, PreparedRay, Ray, Sphere, Triangle};
use crate::prims::{Primitives, Spheres, Tested, Triangles, boxes};
use crate::query::{
    NoObserver, NodeInfo, Observer, PrimitiveTest, PrimitiveVerdict, Query, VolumeTest,
    VolumeVerdict,
};
use crate::volume::BoundingVolume;
use std::sync::Arc;

/// Anything that a ray can hit.
///
/// ```
/// use boxwood::{Aabb, BoundedObject, Object, Ray, Sphere, Triangle};
/// let ball = Sphere { center: [0.0, 0.0, 9.0], radius: 1.0 };
/// let leaf = Triangle([[-1.0, -1.0, 5.0], [1.0, -1.0, 5.0], [0.0, 1.0, 5.0]]);
/// let pair = BoundedObject::<Sphere>::new(vec![Box::new((0, ball)), Box::new((1, leaf))]);
/// let world = BoundedObject::<Aabb>::new(vec![Box::new(pair)]);
/// assert_eq!(world.closest_hit(&Ray::new([0.0; 3], [0.0, 0.0, 1.0])).unwrap().prim, 1);
/// ```
pub trait Object: Send + Sync {
    /// The box around the object.
    fn bounds(&self) -> Aabb;

    /// The closest hit in the ray's range.
    /// (In [`PreparedRay::limit`] stands what has been found elsewhere; farther hits may be left out.)
    fn ray_intersect(&self, ray: &PreparedRay, observer: &mut dyn Observer) -> Option<Hit>;

    /// True if there is any hit in the ray's range.
    fn occludes(&self, ray: &PreparedRay, observer: &mut dyn Observer) -> bool {
        self.ray_intersect(ray, observer).is_some()
    }

    /// Appends all hits in the ray's range, in any order. An object that is one primitive has one.
    fn collect_hits(&self, ray: &PreparedRay, observer: &mut dyn Observer, hits: &mut Vec<Hit>) {
        hits.extend(self.ray_intersect(ray, observer));
    }

    /// Appends points whose convex hull contains the object.
    fn hull(&self, points: &mut Vec<[f32; 3]>) {
        let bounds = self.bounds();
        if !bounds.is_empty() {
            points.extend(bounds.corners());
        }
    }

    /// Tells of the node that this object is, and of those inside. `next` is the number of the next node.
    fn describe(&self, _depth: u32, _next: &mut u32, _visit: &mut dyn FnMut(NodeInfo)) {}

    /// True for a primitive, false for an object that holds others.
    fn is_primitive(&self) -> bool {
        true
    }
}

/// Objects inside a bounding volume.
pub struct BoundedObject<V> {
    volume: V,
    bounds: Aabb,
    children: Vec<Box<dyn Object>>,
    node: u32,
}

impl<V: BoundingVolume> BoundedObject<V> {
    /// Fits the volume around the children. No children: an object that is never hit.
    pub fn new(children: Vec<Box<dyn Object>>) -> Self {
        let mut points = Vec::new();
        for child in &children {
            child.hull(&mut points);
        }
        Self::with_volume(V::of_points(&points), children)
    }

    fn with_volume(volume: V, children: Vec<Box<dyn Object>>) -> Self {
        let bounds = children
            .iter()
            .fold(Aabb::EMPTY, |all, child| all.union(&child.bounds()));
        Self {
            volume,
            bounds,
            children,
            node: 0,
        }
    }

    /// The volume around the children.
    pub fn volume(&self) -> &V {
        &self.volume
    }

    /// The children.
    pub fn children(&self) -> &[Box<dyn Object>] {
        &self.children
    }

    /// [`Object::ray_intersect`] for a ray as users have it.
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.ray_intersect(&PreparedRay::new(ray)?, &mut NoObserver)
    }

    /// *If the ray intersects the bounding volume ...*
    fn is_entered(&self, ray: &PreparedRay, observer: &mut dyn Observer) -> bool {
        // The volume is padded for what it holds, which the box of the children and its own box both bound.
        let ray_for_volume = V::prepare(ray, &self.bounds);
        let Interval { near, far } = self.volume.interval(&ray_for_volume);
        let met = Interval { near, far }.meets(ray.t_min, ray.t_max);
        let entered = met && near <= ray.limit;
        observer.volume(VolumeTest {
            node: self.node,
            near,
            far,
            verdict: match (met, entered) {
                (_, true) => VolumeVerdict::Enter,
                (true, false) => VolumeVerdict::Farther,
                (false, _) => VolumeVerdict::Miss,
            },
            flops: V::FLOPS,
            bytes: size_of::<Self>() as u32,
        });
        if entered {
            observer.turn(self.node);
        }
        entered
    }
}

impl<V: BoundingVolume> Object for BoundedObject<V> {
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// *Intersect with each child; if any, return closest.* The closest hit so far limits the ray, so that volumes
    /// behind it are not looked into.
    fn ray_intersect(&self, ray: &PreparedRay, observer: &mut dyn Observer) -> Option<Hit> {
        if !self.is_entered(ray, observer) {
            return None;
        }
        let mut ray = *ray;
        let mut closest: Option<Hit> = None;
        for child in &self.children {
            let Some(found) = child.ray_intersect(&ray, observer) else {
                continue;
            };
            if closest.is_none_or(|best| found.order(&best).is_lt()) {
                ray.limit = found.t;
                closest = Some(found);
            }
        }
        closest
    }

    fn occludes(&self, ray: &PreparedRay, observer: &mut dyn Observer) -> bool {
        self.is_entered(ray, observer)
            && self
                .children
                .iter()
                .any(|child| child.occludes(ray, observer))
    }

    fn collect_hits(&self, ray: &PreparedRay, observer: &mut dyn Observer, hits: &mut Vec<Hit>) {
        if self.is_entered(ray, observer) {
            for child in &self.children {
                child.collect_hits(ray, observer, hits);
            }
        }
    }

    fn hull(&self, points: &mut Vec<[f32; 3]>) {
        for child in &self.children {
            child.hull(points);
        }
    }

    fn describe(&self, depth: u32, next: &mut u32, visit: &mut dyn FnMut(NodeInfo)) {
        let node = *next;
        *next += 1;
        let prims = self
            .children
            .iter()
            .filter(|child| child.is_primitive())
            .count() as u32;
        let is_leaf = prims == self.children.len() as u32;
        visit(NodeInfo {
            node,
            depth,
            bounds: self.volume.bounds(),
            prims: is_leaf.then_some(prims),
        });
        for child in &self.children {
            child.describe(depth + 1, next, visit);
        }
    }

    fn is_primitive(&self) -> bool {
        false
    }
}

/// One primitive of a set as an object, with its number there.
pub struct PrimitiveObject<P> {
    prims: Arc<P>,
    index: u32,
    is_active: bool,
}

impl<P: Primitives> PrimitiveObject<P> {
    /// Primitive `index` of the set.
    pub fn new(prims: Arc<P>, index: u32) -> Self {
        let is_active = prims.is_active(index as usize);
        Self {
            prims,
            index,
            is_active,
        }
    }
}

impl<P: Primitives> Object for PrimitiveObject<P> {
    fn bounds(&self) -> Aabb {
        self.prims.bounds(self.index as usize)
    }

    fn ray_intersect(&self, ray: &PreparedRay, observer: &mut dyn Observer) -> Option<Hit> {
        if !self.is_active {
            return None;
        }
        if let Some(instances) = self.prims.instances() {
            return instances.closest_hit(self.index as usize, ray, ray.limit, &mut { observer });
        }
        let tested = Tested::of(&*self.prims, self.index as usize, ray);
        report(self.index, &tested, ray, observer)
    }

    fn occludes(&self, ray: &PreparedRay, observer: &mut dyn Observer) -> bool {
        match self.prims.instances() {
            Some(instances) if self.is_active => {
                instances.occluded(self.index as usize, ray, &mut { observer })
            }
            _ => self.ray_intersect(ray, observer).is_some(),
        }
    }

    fn collect_hits(&self, ray: &PreparedRay, observer: &mut dyn Observer, hits: &mut Vec<Hit>) {
        match self.prims.instances() {
            Some(instances) if self.is_active => {
                let into = (hits, &mut Vec::new());
                instances.all_hits(self.index as usize, ray, into, &mut { observer });
            }
            _ => hits.extend(self.ray_intersect(ray, observer)),
        }
    }

    fn hull(&self, points: &mut Vec<[f32; 3]>) {
        self.prims.hull(self.index as usize, points);
    }
}

/// A triangle with the number that its hits bear.
impl Object for (u32, Triangle) {
    fn bounds(&self) -> Aabb {
        self.1.bounds()
    }

    fn ray_intersect(&self, ray: &PreparedRay, observer: &mut dyn Observer) -> Option<Hit> {
        let bounds = self.1.bounds();
        let found = self.1.intersect(ray).filter(|_| bounds.is_in_domain());
        let tested = Tested::new::<Triangles>(found, || bounds, ray);
        report(self.0, &tested, ray, observer)
    }

    fn hull(&self, points: &mut Vec<[f32; 3]>) {
        points.extend(self.1.0);
    }
}

/// A sphere with the number that its hits bear.
impl Object for (u32, Sphere) {
    fn bounds(&self) -> Aabb {
        Aabb::of_sphere(&self.1)
    }

    fn ray_intersect(&self, ray: &PreparedRay, observer: &mut dyn Observer) -> Option<Hit> {
        let bounds = Aabb::of_sphere(&self.1);
        let found = self.1.intersect(ray).filter(|_| bounds.is_in_domain());
        let tested = Tested::new::<Spheres>(found, || bounds, ray);
        report(self.0, &tested, ray, observer)
    }
}

/// Tells the observer of a primitive test and names the hit.
fn report(
    prim: u32,
    tested: &Tested,
    ray: &PreparedRay,
    observer: &mut dyn Observer,
) -> Option<Hit> {
    let candidate = tested.candidate;
    observer.primitive(PrimitiveTest {
        prim,
        candidate,
        verdict: match candidate {
            Some(c) if c.t <= ray.limit => PrimitiveVerdict::Closest,
            Some(_) => PrimitiveVerdict::Farther,
            None => PrimitiveVerdict::Miss,
        },
        flops: tested.flops,
        bytes: tested.bytes,
    });
    candidate.map(|c| hit(c, prim))
}

/// Bounded objects all the way from the scene down to single primitives, nested as a builder says.
pub struct BoundedTree<V, P> {
    root: Option<BoundedObject<V>>,
    prims: Arc<P>,
    nodes: usize,
}

impl<V: BoundingVolume, P: Primitives> BoundedTree<V, P> {
    pub(crate) fn boxed(prims: &P, options: &BuildOptions) -> Result<Box<dyn Query>, BuildError> {
        let boxes = boxes(prims);
        let topology = options
            .builder
            .build(&BuildInput::new(prims, &boxes), options)?;
        let all: Vec<u32> = (0..prims.len() as u32).collect();
        let prims = Arc::new(prims.gather(&all));
        let volumes = super::dress::dress(&topology, &*prims);
        let nodes = topology.nodes.len();
        let nest = Nest {
            topology,
            volumes,
            prims: Arc::clone(&prims),
        };
        let root = (nodes > 0).then(|| nest.object(0, &mut 0));
        Ok(Box::new(Self { root, prims, nodes }))
    }
}

struct Nest<V, P> {
    topology: Topology,
    volumes: Vec<V>,
    prims: Arc<P>,
}

impl<V: BoundingVolume, P: Primitives> Nest<V, P> {
    /// Nodes are numbered parents first, `next` being the next number. The tree is at most 96 deep, so this may recurse.
    fn object(&self, index: u32, next: &mut u32) -> BoundedObject<V> {
        let number = *next;
        *next += 1;
        let node = self.topology.nodes[index as usize];
        let children: Vec<Box<dyn Object>> = if node.is_leaf() {
            let slots = node.first as usize..(node.first + node.count) as usize;
            self.topology.order[slots]
                .iter()
                .map(|&prim| self.primitive(prim))
                .collect()
        } else {
            let child = |index| -> Box<dyn Object> { Box::new(self.object(index, next)) };
            [node.first, node.first + 1].map(child).into()
        };
        let volume = self.volumes[index as usize];
        BoundedObject {
            node: number,
            ..BoundedObject::with_volume(volume, children)
        }
    }

    fn primitive(&self, prim: u32) -> Box<dyn Object> {
        Box::new(PrimitiveObject::new(Arc::clone(&self.prims), prim))
    }
}

impl<V: BoundingVolume, P: Primitives> BoundedTree<V, P> {
    /// With the padding that the primitives need.
    fn loosened(&self, ray: &PreparedRay) -> PreparedRay {
        self.prims
            .instances()
            .map_or(*ray, |instances| instances.loosened(ray))
    }
}

impl<V: BoundingVolume, P: Primitives> Trace for BoundedTree<V, P> {
    fn closest<O: Observer>(&self, ray: &PreparedRay, observer: &mut O) -> Option<Hit> {
        self.root
            .as_ref()?
            .ray_intersect(&self.loosened(ray), observer)
    }

    fn is_occluded<O: Observer>(&self, ray: &PreparedRay, observer: &mut O) -> bool {
        self.root
            .as_ref()
            .is_some_and(|root| root.occludes(&self.loosened(ray), observer))
    }

    fn collect<O: Observer>(&self, ray: &PreparedRay, hits: &mut Vec<Hit>, observer: &mut O) {
        if let Some(root) = &self.root {
            root.collect_hits(&self.loosened(ray), observer, hits);
        }
        sort_once(hits);
    }

    #[cfg(feature = "distances")]
    fn nearest(&self, point: &[f32; 3]) -> Option<Nearest> {
        let active = (0..self.prims.len()).filter(|&i| self.prims.is_active(i));
        nearest_of_all(&*self.prims, active.map(|i| (i, i as u32)), point)
    }

    fn nodes(&self, visit: &mut dyn FnMut(NodeInfo)) {
        if let Some(root) = &self.root {
            root.describe(0, &mut 0, visit);
        }
    }

    fn memory(&self) -> usize {
        let per_prim = size_of::<PrimitiveObject<P>>() + size_of::<Box<dyn Object>>();
        let per_node = size_of::<BoundedObject<V>>() + size_of::<Box<dyn Object>>();
        self.nodes * per_node + self.prims.len() * per_prim + self.prims.bytes()
    }
}
