//! The front door: from mesh to hit.

mod census;
mod change;
mod instance;
#[cfg(feature = "lists")]
mod lists;
#[cfg(feature = "distances")]
mod nearest;
mod normals;
#[cfg(feature = "file")]
mod notes;

pub use census::Census;
pub use instance::{Instance, Placed};
#[cfg(feature = "lists")]
pub use lists::HitLists;
#[cfg(feature = "file")]
pub use notes::ContentHash;
#[cfg(feature = "file")]
pub(crate) use notes::Notes;

use crate::build::{BuildOptions, BuildWalk};
use crate::error::BuildError;
use crate::geom::{Aabb, Hit, Ray, Sphere, Triangle};
use crate::prims::{Custom, Geometry, Shapes, Spheres, Triangles};
use crate::query::{Counts, Query, Walk};
use crate::stats::Stats;
use crate::tables::Structure;
use instance::{geometry_of, nesting_of, paths_of};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Primitives in a structure, ready to be asked. Cheap to share: every query takes `&self`.
///
/// A scene never changes. What moves or repeats is made of scenes: [`SceneBuilder::instance`] puts one into
/// another, and [`Scene::with_transforms`] and [`Scene::with_mesh`] make a new scene from an old one at the price of the change,
/// while the old one goes on answering.
pub struct Scene {
    query: Box<dyn Query>,
    geometry: Geometry,
    /// First primitive of each mesh, ascending from 0.
    starts: Vec<u32>,
    instances: Vec<Instance>,
    /// First path of each instance, ascending from 0.
    path_starts: Vec<u32>,
    paths: u32,
    nesting: u32,
    structure: &'static str,
    options: BuildOptions,
    /// The SAH cost when the structure was built, once it is asked for.
    built_cost: OnceLock<f64>,
    is_refitted: bool,
    skipped: usize,
    bounds: Aabb,
    #[cfg(feature = "file")]
    notes: Notes,
}

/// Largest number of primitives: a tree has up to twice as many nodes, which 32 bits number.
const MAX_PRIMITIVES: usize = (1 << 31) - 1;

/// Rays that one task of a batch answers.
#[cfg(feature = "rayon")]
const CHUNK: usize = 1024;

impl Scene {
    /// An indexed triangle mesh in the default structure.
    ///
    /// # Errors
    /// If an index is not below `positions.len()`, or there are 2^31 triangles. Triangles without area and
    /// non-finite ones are no error: they keep their numbers and are never hit (see [`Scene::skipped`] for the latter).
    pub fn new(positions: &[[f32; 3]], indices: &[[u32; 3]]) -> Result<Self, BuildError> {
        Self::builder().mesh(positions, indices).build()
    }

    /// For several meshes, other primitives, another structure or other options.
    pub fn builder() -> SceneBuilder {
        SceneBuilder::default()
    }

    /// The closest hit: the one with the smallest `(t, instance, geometry, primitive)`.
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.query.closest_hit(ray).map(|hit| self.locate(hit))
    }

    /// True if anything is hit in the ray's range.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.query.occluded(ray)
    }

    /// All hits in the ray's range, nearest first, each primitive at most once.
    pub fn all_hits(&self, ray: &Ray) -> Vec<Hit> {
        let mut hits = Vec::new();
        self.all_hits_into(ray, &mut hits);
        hits
    }

    /// [`Scene::all_hits`] into a vector that is used again.
    pub fn all_hits_into(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        self.query.all_hits(ray, hits);
        for hit in hits {
            *hit = self.locate(*hit);
        }
    }

    /// [`Scene::closest_hit`] for each ray, on the threads of the caller's rayon pool.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.closest_hits_as(rays, hits, |rays, hits| self.query.closest_hits(rays, hits));
    }

    /// The same as `ask` does it.
    fn closest_hits_as(
        &self,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        ask: impl Fn(&[Ray], &mut [Option<Hit>]) + Sync,
    ) {
        assert_eq!(rays.len(), hits.len(), "one answer per ray");
        for_chunks(rays, hits, |rays, hits| {
            ask(rays, hits);
            if self.starts.len() > 1 {
                hits.iter_mut()
                    .flatten()
                    .for_each(|hit| *hit = self.locate(*hit));
            }
        });
    }

    /// [`Scene::occluded`] for each ray, on the threads of the caller's rayon pool.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]) {
        assert_eq!(rays.len(), occluded.len(), "one answer per ray");
        for_chunks(rays, occluded, |rays, occluded| {
            self.query.occluded_each(rays, occluded);
        });
    }

    /// [`Scene::closest_hit`], adding its work to `counts`.
    pub fn closest_hit_counted(&self, ray: &Ray, counts: &mut Counts) -> Option<Hit> {
        self.query
            .closest_hit_counted(ray, counts)
            .map(|hit| self.locate(hit))
    }

    /// [`Scene::occluded`], adding its work to `counts`.
    pub fn occluded_counted(&self, ray: &Ray, counts: &mut Counts) -> bool {
        self.query.occluded_counted(ray, counts)
    }

    /// [`Scene::all_hits`], adding its work to `counts`.
    pub fn all_hits_counted(&self, ray: &Ray, counts: &mut Counts) -> Vec<Hit> {
        let mut hits = Vec::new();
        self.query.all_hits_counted(ray, &mut hits, counts);
        hits.iter_mut().for_each(|hit| *hit = self.locate(*hit));
        hits
    }

    /// [`Scene::closest_hits`] with the work of all rays together.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_hits_counted(&self, rays: &[Ray], hits: &mut [Option<Hit>]) -> Counts {
        assert_eq!(rays.len(), hits.len(), "one answer per ray");
        let total = std::sync::Mutex::new(Counts::default());
        for_chunks(rays, hits, |rays, hits| {
            let mut counts = Counts::default();
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = self.closest_hit_counted(ray, &mut counts);
            }
            // Sums of integers do not depend on the order.
            *total
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner) += counts;
        });
        total
            .into_inner()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// How [`Scene::closest_hit`] comes to its answer: every box, cell and primitive looked at, and why.
    pub fn explain(&self, ray: &Ray) -> Walk {
        let mut walk = self.query.explain(ray);
        walk.hit = walk.hit.map(|hit| self.locate(hit));
        walk
    }

    /// How the structure came to be, or would from the primitives as they are now if it was refitted: every split, merge and
    /// move with what was weighed, at most `limit` of them. It builds again, so it is for small scenes and lessons.
    ///
    /// # Errors
    /// If the system has no memory for it, or [`BuildOptions::progress`] says to end.
    pub fn explain_build(&self, limit: usize) -> Result<BuildWalk, BuildError> {
        Structure::named(self.structure)?.explain_build(&self.geometry, &self.options, limit)
    }

    /// The triangle of a hit; `None` if the scene is not of triangles or the mesh has no such number.
    #[inline]
    pub fn triangle(&self, geom: u32, prim: u32) -> Option<Triangle> {
        let number = self.range(geom)?.nth(prim as usize)?;
        self.triangle_in_scene(number as u32)
    }

    /// How many triangles a mesh has; `None` if there is no such mesh.
    pub fn mesh_len(&self, geom: u32) -> Option<usize> {
        self.range(geom).map(|range| range.len())
    }

    /// The numbers in the scene of the primitives of a mesh.
    #[inline]
    fn range(&self, geom: u32) -> Option<Range<usize>> {
        let start = *self.starts.get(geom as usize)? as usize;
        let next = self.starts.get(geom as usize + 1);
        Some(start..next.map_or(self.len(), |&next| next as usize))
    }

    /// The triangle with a number that counts through all meshes, as the steps of [`Scene::explain`] have it.
    #[inline]
    pub fn triangle_in_scene(&self, number: u32) -> Option<Triangle> {
        let Geometry::Triangles(triangles) = &self.geometry else {
            return None;
        };
        triangles.as_slice().get(number as usize).copied()
    }

    /// Not unit; its length is twice the triangle's area. `None` as for [`Scene::triangle`]. On an instance it is turned into
    /// the world with the surface, on the side where it was: mirrored, it still points outward.
    #[inline]
    pub fn normal(&self, hit: &Hit) -> Option<[f32; 3]> {
        if self.instances.is_empty() {
            return Some(self.triangle(hit.geom, hit.prim)?.normal());
        }
        let placed = self.placed(hit.inst)?;
        let normal = placed.scene.triangle(hit.geom, hit.prim)?.normal();
        let turned = placed.world_from_object.normal(normal.map(f64::from));
        Some(turned.map(|x| x as f32))
    }

    /// The box around all primitives that can be hit; empty if there are none.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Number of primitives, those that can never be hit included; of a scene of instances, their number.
    pub fn len(&self) -> usize {
        self.geometry.len()
    }

    /// True if there are no primitives.
    pub fn is_empty(&self) -> bool {
        self.geometry.is_empty()
    }

    /// How many primitives can never be hit: coordinates that are not finite or beyond 2^100, a negative radius, an empty
    /// box, an instance whose matrix cannot be undone (or nearly so: beyond a condition of some 10^8). (A triangle without area is never hit either, but is not told apart.)
    pub fn skipped(&self) -> usize {
        self.skipped
    }

    /// Name of the structure.
    pub fn structure(&self) -> &'static str {
        self.structure
    }

    /// Depth, cost, leaf sizes, memory.
    pub fn stats(&self) -> Stats {
        Stats::of(&*self.query)
    }

    /// What is shown and what is stored, with all that is inside instances.
    pub fn census(&self) -> Census {
        Census::of(self)
    }

    /// How it was built.
    pub fn options(&self) -> &BuildOptions {
        &self.options
    }

    /// The structure itself. Its hits count primitives through all meshes, with `geom` 0.
    pub fn query(&self) -> &dyn Query {
        &*self.query
    }

    /// The structure alone, without the scene's own copy of the primitives.
    pub fn into_query(self) -> Box<dyn Query> {
        self.query
    }

    /// The primitives, all meshes in a row.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Builds over primitives that are not instances, unless there is a structure already.
    pub(crate) fn of(
        geometry: Geometry,
        starts: Vec<u32>,
        structure: &'static str,
        options: &BuildOptions,
        query: Option<Box<dyn Query>>,
    ) -> Result<Self, BuildError> {
        let (count, limit) = (geometry.len(), MAX_PRIMITIVES);
        if count > limit {
            return Err(BuildError::TooManyPrimitives { count, limit });
        }
        let (bounds, skipped) = geometry.extent();
        let build = || Structure::named(structure)?.build(&geometry, options);
        Ok(Self {
            query: query.map_or_else(build, Ok)?,
            geometry,
            starts,
            instances: Vec::new(),
            path_starts: Vec::new(),
            paths: 1,
            nesting: 0,
            structure,
            options: options.clone(),
            built_cost: OnceLock::new(),
            is_refitted: false,
            skipped,
            bounds,
            #[cfg(feature = "file")]
            notes: Notes::default(),
        })
    }

    /// First primitive of each mesh.
    #[cfg(feature = "file")]
    pub(crate) fn starts(&self) -> &[u32] {
        &self.starts
    }

    /// From a number in the scene to mesh and number in the mesh.
    #[inline]
    fn locate(&self, hit: Hit) -> Hit {
        if self.starts.len() <= 1 {
            return hit;
        }
        let [geom, prim] = self.mesh_of(hit.prim);
        Hit { geom, prim, ..hit }
    }

    /// Mesh and number in it of the primitive with a number in the scene.
    #[inline]
    fn mesh_of(&self, prim: u32) -> [u32; 2] {
        match self.starts.partition_point(|&start| start <= prim) {
            0 => [0, prim],
            next => [next as u32 - 1, prim - self.starts[next - 1]],
        }
    }
}

impl std::fmt::Debug for Scene {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scene")
            .field("structure", &self.structure)
            .field("primitives", &self.len())
            .field("bounds", &self.bounds)
            .finish_non_exhaustive()
    }
}

/// Runs `f` on chunks of both slices, in parallel where that is compiled in and worth it.
fn for_chunks<Q: Sync, T: Send>(rays: &[Q], answers: &mut [T], f: impl Fn(&[Q], &mut [T]) + Sync) {
    #[cfg(feature = "rayon")]
    if rays.len() > CHUNK {
        use rayon::prelude::*;
        rays.par_chunks(CHUNK)
            .zip(answers.par_chunks_mut(CHUNK))
            .for_each(|(r, a)| f(r, a));
        return;
    }
    f(rays, answers);
}

/// The same on pieces of up to `most`, where large ones pay: a few for each thread.
#[cfg(feature = "distances")]
fn for_pieces<Q: Sync, T: Send>(
    most: usize,
    asked: &[Q],
    answers: &mut [T],
    f: impl Fn(&[Q], &mut [T]) + Sync,
) {
    #[cfg(feature = "rayon")]
    if asked.len() > CHUNK {
        use rayon::prelude::*;
        let threads = rayon::current_num_threads();
        let piece = if threads > 1 {
            asked.len() / (4 * threads)
        } else {
            most
        };
        let piece = piece.clamp(CHUNK, most);
        asked
            .par_chunks(piece)
            .zip(answers.par_chunks_mut(piece))
            .for_each(|(asked, answers)| f(asked, answers));
        return;
    }
    for (asked, answers) in asked.chunks(most).zip(answers.chunks_mut(most)) {
        f(asked, answers);
    }
}

/// Appends the triangles of mesh number `geom`.
fn gather_mesh(
    geom: usize,
    positions: &[[f32; 3]],
    indices: &[[u32; 3]],
    triangles: &mut Vec<Triangle>,
) -> Result<(), BuildError> {
    let bytes = indices.len().saturating_mul(size_of::<Triangle>());
    triangles
        .try_reserve(indices.len())
        .map_err(|_| BuildError::OutOfMemory { bytes })?;
    for (triangle, corners) in indices.iter().enumerate() {
        match corners.map(|index| positions.get(index as usize).copied().ok_or(index)) {
            [Ok(a), Ok(b), Ok(c)] => triangles.push(Triangle([a, b, c])),
            [Err(index), ..] | [_, Err(index), _] | [.., Err(index)] => {
                let vertices = positions.len();
                return Err(BuildError::IndexOutOfRange {
                    geom,
                    triangle,
                    index,
                    vertices,
                });
            }
        }
    }
    Ok(())
}

/// Collects primitives and choices for a [`Scene`].
#[derive(Default)]
pub struct SceneBuilder {
    triangles: Vec<Triangle>,
    starts: Vec<u32>,
    instances: Vec<Instance>,
    others: Option<Geometry>,
    structure: Option<String>,
    options: BuildOptions,
    error: Option<BuildError>,
}

impl SceneBuilder {
    /// Adds an indexed triangle mesh; meshes are numbered in the order added ([`Hit::geom`]). Mistakes are reported by
    /// [`SceneBuilder::build`].
    #[must_use]
    pub fn mesh(mut self, positions: &[[f32; 3]], indices: &[[u32; 3]]) -> Self {
        let geom = self.starts.len();
        self.starts.push(self.triangles.len() as u32);
        if let Err(error) = gather_mesh(geom, positions, indices, &mut self.triangles) {
            self.refuse(error);
        }
        self
    }

    /// The scene is of spheres.
    #[must_use]
    pub fn spheres(mut self, spheres: Vec<Sphere>) -> Self {
        self.set_others(Geometry::Spheres(Spheres(spheres)));
        self
    }

    /// The scene is of the user's own shapes, of any mixture.
    #[must_use]
    pub fn shapes(mut self, shapes: Arc<dyn Shapes>) -> Self {
        let (count, limit) = (shapes.len(), MAX_PRIMITIVES);
        if count > limit {
            self.refuse(BuildError::TooManyPrimitives { count, limit });
        } else {
            self.set_others(Geometry::Custom(Custom::new(shapes)));
        }
        self
    }

    /// A name from [`STRUCTURES`](crate::STRUCTURES).
    #[must_use]
    pub fn structure(mut self, name: &str) -> Self {
        self.structure = Some(name.to_owned());
        self
    }

    /// How to build.
    #[must_use]
    pub fn options(mut self, options: BuildOptions) -> Self {
        self.options = options;
        self
    }

    /// Builds the structure, on the threads of the caller's rayon pool.
    ///
    /// # Errors
    /// The first mistake of the calls before, an unknown name, two kinds of primitives at once, or too many of them.
    pub fn build(self) -> Result<Scene, BuildError> {
        if let Some(error) = self.error {
            return Err(error);
        }
        let structure = Structure::named(self.structure.as_deref().unwrap_or(Structure::DEFAULT))?;
        let kinds = [
            !self.starts.is_empty(),
            !self.instances.is_empty(),
            self.others.is_some(),
        ];
        if kinds.into_iter().filter(|&is_there| is_there).count() > 1 {
            return Err(BuildError::MixedPrimitives);
        }
        let nesting = nesting_of(&self.instances)?;
        let (path_starts, paths) = paths_of(&self.instances)?;
        let (geometry, starts) = match self.others {
            Some(others) => (others, vec![0]),
            None if nesting > 0 => (Geometry::Instances(geometry_of(&self.instances)), vec![0]),
            None => (
                Geometry::Triangles(Triangles::new(self.triangles)),
                self.starts,
            ),
        };
        Ok(Scene {
            instances: self.instances,
            path_starts,
            paths,
            nesting,
            ..Scene::of(geometry, starts, structure.name, &self.options, None)?
        })
    }

    fn set_others(&mut self, others: Geometry) {
        if self.others.replace(others).is_some() {
            self.refuse(BuildError::MixedPrimitives);
        }
    }

    /// Keeps the first mistake.
    fn refuse(&mut self, error: BuildError) {
        self.error.get_or_insert(error);
    }
}
