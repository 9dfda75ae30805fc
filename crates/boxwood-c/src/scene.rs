//! What stands behind a handle: what is attached, and what was committed.

use crate::error::{BwError, Failure};
use crate::threads::on_threads;
use crate::types::{BW_INVALID_ID, BwQuality, BwStats};
use arc_swap::{ArcSwapOption, Guard};
use boxwood::{BuildError, BuildOptions, Instance, Scene, SceneBuilder, Transform, Triangle};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A scene: triangles, or instances of scenes.
///
/// It is asked as it was when it was last committed; what is attached or changed since then counts from the next commit on.
pub struct BwScene {
    plan: Mutex<Plan>,
    /// Questions take it without a lock, and keep what they took alive while a commit puts another in its place.
    committed: ArcSwapOption<Scene>,
    threads: AtomicU32,
}

/// What the next commit builds.
struct Plan {
    quality: BwQuality,
    is_compact: bool,
    meshes: Vec<Mesh>,
    instances: Vec<Instance>,
}

/// Triangles as they were attached.
pub(crate) struct Given {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) indices: Vec<[u32; 3]>,
}

/// Where the triangles of a geometry are.
enum Mesh {
    /// Attached or changed since the last commit.
    Given(Given),
    /// In the committed scene, which then is their only place.
    Committed,
}

impl BwScene {
    pub(crate) fn new() -> Self {
        Self {
            plan: Mutex::new(Plan {
                quality: BwQuality::Default,
                is_compact: false,
                meshes: Vec::new(),
                instances: Vec::new(),
            }),
            committed: ArcSwapOption::empty(),
            threads: AtomicU32::new(0),
        }
    }

    /// A scene that was committed already: it may be asked at once, and what is attached later counts from the next commit on.
    pub(crate) fn of(scene: Scene) -> Self {
        let new = Self::new();
        let meshes = (0..).map_while(|geom| scene.mesh_len(geom));
        new.plan().meshes = meshes.map(|_| Mesh::Committed).collect();
        new.committed.store(Some(Arc::new(scene)));
        new
    }

    /// The scene to ask.
    #[inline]
    pub(crate) fn committed(&self) -> Result<Committed, Failure> {
        let committed = self.committed.load();
        match *committed {
            Some(_) => Ok(Committed(committed)),
            None => Err(not_committed()),
        }
    }

    pub(crate) fn threads(&self) -> u32 {
        self.threads.load(Ordering::Relaxed)
    }

    pub(crate) fn set_threads(&self, threads: u32) {
        self.threads.store(threads, Ordering::Relaxed);
    }

    pub(crate) fn set_quality(&self, quality: BwQuality) {
        self.plan().quality = quality;
    }

    pub(crate) fn set_compact(&self, is_compact: bool) {
        self.plan().is_compact = is_compact;
    }

    /// Adds triangles; their number.
    pub(crate) fn attach(&self, given: Given) -> Result<u32, Failure> {
        let mut plan = self.plan();
        if !plan.instances.is_empty() {
            return Err(BuildError::MixedPrimitives.into());
        }
        let geom = next_id(plan.meshes.len())?;
        given.check(geom)?;
        plan.meshes.push(Mesh::Given(given));
        Ok(geom)
    }

    /// Puts other triangles in the place of those of a geometry.
    pub(crate) fn change(&self, geom: u32, given: Given) -> Result<(), Failure> {
        let mut plan = self.plan();
        let meshes = plan.meshes.len();
        let Some(mesh) = plan.meshes.get_mut(geom as usize) else {
            return Err(BuildError::NoSuchMesh { geom, meshes }.into());
        };
        given.check(geom)?;
        *mesh = Mesh::Given(given);
        Ok(())
    }

    /// Adds an instance of what `content` is now; its number.
    pub(crate) fn place(
        &self,
        content: &Self,
        matrix: Transform,
        mask: u32,
    ) -> Result<u32, Failure> {
        let content = content.committed.load_full().ok_or_else(not_committed)?;
        let mut plan = self.plan();
        if !plan.meshes.is_empty() {
            return Err(BuildError::MixedPrimitives.into());
        }
        let inst = next_id(plan.instances.len())?;
        plan.instances
            .push(Instance::new(&content, finite(matrix)?).with_mask(mask));
        Ok(inst)
    }

    /// Moves an instance.
    pub(crate) fn transform(&self, inst: u32, matrix: Transform) -> Result<(), Failure> {
        let mut plan = self.plan();
        let count = plan.instances.len();
        let Some(instance) = plan.instances.get_mut(inst as usize) else {
            let message = format!("instance {inst} is to move, the scene has {count}");
            return Err(Failure::new(BwError::NoSuchId, message));
        };
        instance.world_from_object = finite(matrix)?;
        Ok(())
    }

    /// Builds what is attached, and has it asked from now on. After an error everything is as before.
    pub(crate) fn commit(&self) -> Result<(), Failure> {
        let mut plan = self.plan();
        let old = self.committed.load_full();
        let built = on_threads(self.threads(), || plan.builder(old.as_deref())?.build())??;
        for mesh in &mut plan.meshes {
            *mesh = Mesh::Committed;
        }
        self.committed.store(Some(Arc::new(built)));
        Ok(())
    }

    fn plan(&self) -> MutexGuard<'_, Plan> {
        // Plans change by single steps: one is whole even after a panic.
        self.plan.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Plan {
    fn builder(&self, old: Option<&Scene>) -> Result<SceneBuilder, BuildError> {
        let options = match self.quality {
            BwQuality::Fast => BuildOptions::fast(),
            BwQuality::Default => BuildOptions::default(),
            BwQuality::High => BuildOptions::high(),
        };
        let structure = if self.is_compact { "compact" } else { "wide" };
        let mut builder = Scene::builder().structure(structure).options(options);
        for (mesh, geom) in self.meshes.iter().zip(0..) {
            builder = match (mesh, old) {
                (Mesh::Given(given), _) => builder.mesh(&given.positions, &given.indices),
                (Mesh::Committed, Some(old)) => {
                    let given = Given::of_committed(old, geom)?;
                    builder.mesh(&given.positions, &given.indices)
                }
                // Only a commit says that they are there.
                (Mesh::Committed, None) => builder.mesh(&[], &[]),
            };
        }
        Ok(builder.instances(self.instances.iter().cloned()))
    }
}

impl Given {
    /// Whether every triangle names vertices that exist, while the caller is there to be told.
    fn check(&self, geom: u32) -> Result<(), BuildError> {
        let vertices = self.positions.len();
        for (triangle, corners) in self.indices.iter().enumerate() {
            for &index in corners {
                if index as usize >= vertices {
                    return Err(BuildError::IndexOutOfRange {
                        geom: geom as usize,
                        triangle,
                        index,
                        vertices,
                    });
                }
            }
        }
        Ok(())
    }

    /// The triangles of a committed scene, each with vertices of its own.
    fn of_committed(scene: &Scene, geom: u32) -> Result<Self, BuildError> {
        let corners = || (0..).map_while(|prim| scene.triangle(geom, prim));
        let count = corners().count();
        // Vertices have 32-bit numbers.
        let limit = (u32::MAX / 3) as usize;
        if count > limit {
            return Err(BuildError::TooManyPrimitives { count, limit });
        }
        let bytes = count * (size_of::<Triangle>() + size_of::<[u32; 3]>());
        let refused = |_| BuildError::OutOfMemory { bytes };
        let (mut positions, mut indices) = (Vec::new(), Vec::new());
        positions.try_reserve_exact(3 * count).map_err(refused)?;
        indices.try_reserve_exact(count).map_err(refused)?;
        positions.extend(corners().flat_map(|triangle| triangle.0));
        indices.extend((0..count as u32).map(|prim| [3 * prim, 3 * prim + 1, 3 * prim + 2]));
        Ok(Self { positions, indices })
    }
}

/// A committed scene, there as long as it is asked.
pub(crate) struct Committed(Guard<Option<Arc<Scene>>>);

impl std::ops::Deref for Committed {
    type Target = Scene;

    #[inline]
    fn deref(&self) -> &Scene {
        // `BwScene::committed` gives no other.
        self.0.as_ref().expect("a committed scene")
    }
}

impl Committed {
    /// Triangles and memory, inside instances too.
    pub(crate) fn stats(&self) -> BwStats {
        let census = self.census();
        BwStats {
            triangles: census.shown,
            stored: census.stored,
            skipped: self.skipped() as u64,
            bytes: census.bytes as u64 + census.stored * size_of::<Triangle>() as u64,
        }
    }
}

#[cold]
fn not_committed() -> Failure {
    let message = "the scene was never committed: call bw_scene_commit first";
    Failure::new(BwError::NotCommitted, message)
}

fn next_id(count: usize) -> Result<u32, Failure> {
    let id = u32::try_from(count).ok().filter(|&id| id != BW_INVALID_ID);
    id.ok_or_else(|| Failure::new(BwError::TooLarge, "no number is left for another geometry"))
}

fn finite(matrix: Transform) -> Result<Transform, Failure> {
    match matrix.0.as_flattened().iter().position(|x| !x.is_finite()) {
        None => Ok(matrix),
        Some(place) => {
            let number = matrix.0[place / 4][place % 4];
            let message = format!("matrix[{place}] is {number}");
            Err(Failure::new(BwError::NotFinite, message))
        }
    }
}
