//! What is looked at: a scene with its looks, and the structures that it stands in.

use std::{
    fmt,
    ops::ControlFlow,
    sync::{
        Arc, OnceLock,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use boxwood::{Aabb, BuildError, BuildOptions, Progress, Scene, query::NodeInfo};
use boxwood_render::{Frames, RenderError, Surfaces, View, auto_camera};
use boxwood_scene::{Camera, FlatMesh, Model};

use crate::{Matter, ViewError};

/// Reads a scene by the name that a user types: the model, and its triangles multiplied out. The error is for the user.
pub type Open = dyn Fn(&str) -> Result<(Model, FlatMesh), String> + Send + Sync;

/// [`boxwood_scene::open`], and flattened.
pub fn open(name: &str) -> Result<(Model, FlatMesh), String> {
    let model = boxwood_scene::open(name).map_err(|error| error.to_string())?;
    let mesh = model
        .flatten()
        .map_err(|error| format!("{name}: {error}"))?;
    Ok((model, mesh))
}

/// The camera to begin with, as far as the user has a say: the rest is the scene's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Aim {
    /// Which of the scene's cameras; none: the first, or one that is found.
    pub number: Option<usize>,
    /// One that is found, also where the scene has its own.
    pub auto: bool,
    /// View point.
    pub eye: Option<[f32; 3]>,
    /// Point of interest.
    pub target: Option<[f32; 3]>,
    /// Up.
    pub up: Option<[f32; 3]>,
    /// Vertical field of view in degrees.
    pub fov: Option<f32>,
}

impl Aim {
    /// At `camera`, whatever the scene has.
    pub fn at(camera: &Camera) -> Self {
        Self {
            eye: Some(camera.eye),
            target: Some(camera.target),
            up: Some(camera.up),
            fov: Some(camera.fov),
            ..Self::default()
        }
    }

    /// In the scene called `name`, which has its `own` cameras.
    fn camera(
        &self,
        name: &str,
        own: &[Camera],
        found: impl FnOnce() -> Camera,
    ) -> Result<Camera, ViewError> {
        let base = match self.number {
            _ if self.auto => found(),
            Some(number) => *own.get(number).ok_or_else(|| {
                let cause = format!("{name}: there is no camera {number}");
                let remedy = format!("it has {}, counted from 0; or let one be found", own.len());
                ViewError::new(Matter::Camera, cause).with_remedy(remedy)
            })?,
            None => own.first().copied().unwrap_or_else(found),
        };
        Ok(Camera {
            eye: self.eye.unwrap_or(base.eye),
            target: self.target.unwrap_or(base.target),
            up: self.up.unwrap_or(base.up),
            fov: self.fov.unwrap_or(base.fov),
        })
    }

    /// A camera that shows nothing is the user's matter where it was aimed, else the scene's.
    fn blamed(&self, name: &str, error: &RenderError) -> ViewError {
        let usual = Self {
            auto: self.auto,
            ..Self::default()
        };
        let kind = match *self == usual {
            true => Matter::Scene,
            false => Matter::Camera,
        };
        match error {
            RenderError::Camera { what, remedy } => {
                ViewError::new(kind, format!("{name}: camera: {what}")).with_remedy(*remedy)
            }
            other => ViewError::new(kind, format!("{name}: {other}")),
        }
    }
}

/// A scene with its looks.
#[derive(Debug)]
pub(crate) struct Subject {
    /// As the user named it.
    pub(crate) name: String,
    model: Model,
    mesh: FlatMesh,
    /// The looks of all triangles, for quick frames.
    pub(crate) frames: Frames,
    /// The scene's own, or one that shows all of it.
    pub(crate) camera: Camera,
    /// Of the bounds, for speeds.
    pub(crate) diagonal: f32,
}

impl Subject {
    /// Looks at every triangle.
    pub(crate) fn new(
        name: &str,
        (model, mesh): (Model, FlatMesh),
        scene: &Scene,
        aim: &Aim,
        [width, height]: [u32; 2],
    ) -> Result<Self, ViewError> {
        let surfaces = Surfaces::new(&mesh, &model);
        let found = || auto_camera(scene, surfaces, width, height);
        let camera = aim.camera(name, &model.cameras, found)?;
        let view = View::new(camera, width, height).map_err(|error| aim.blamed(name, &error))?;
        let frames = Frames::new(surfaces, &view);
        Ok(Self {
            name: name.to_owned(),
            frames,
            camera,
            diagonal: diagonal(&scene.bounds()),
            model,
            mesh,
        })
    }

    pub(crate) fn surfaces(&self) -> Surfaces<'_> {
        Surfaces::new(&self.mesh, &self.model)
    }

    pub(crate) fn mesh(&self) -> &FlatMesh {
        &self.mesh
    }

    /// What was tolerated while it was read.
    pub(crate) fn warnings(&self) -> &[String] {
        &self.model.warnings
    }

    /// The last part of the name.
    pub(crate) fn short_name(&self) -> &str {
        let end = self.name.rsplit(['/', '\\']).next();
        end.unwrap_or(&self.name)
    }
}

/// 1 where there is none.
fn diagonal(bounds: &Aabb) -> f32 {
    let squares = (0..3).map(|k| (bounds.max[k] - bounds.min[k]).powi(2));
    let length = squares.sum::<f32>().sqrt();
    if length.is_normal() { length } else { 1.0 }
}

/// A structure around a subject.
pub(crate) struct Built {
    pub(crate) structure: &'static str,
    pub(crate) scene: Scene,
    pub(crate) time: Duration,
    nodes: OnceLock<Vec<NodeInfo>>,
}

impl Built {
    /// Builds; ends early once `cancel` is set. `report` hears the share that is done.
    pub(crate) fn new(
        mesh: &FlatMesh,
        structure: &'static str,
        options: &BuildOptions,
        cancel: &Arc<AtomicBool>,
        report: impl Fn(f32) + Send + Sync + 'static,
    ) -> Result<Self, BuildError> {
        let cancel = Arc::clone(cancel);
        let progress = Progress::new(move |share| {
            report(share);
            match cancel.load(Ordering::Relaxed) {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        });
        let options = BuildOptions {
            progress,
            ..options.clone()
        };
        let start = Instant::now();
        let builder = Scene::builder().mesh(&mesh.positions, &mesh.indices);
        let scene = builder.structure(structure).options(options).build()?;
        Ok(Self {
            structure,
            scene,
            time: start.elapsed(),
            nodes: OnceLock::new(),
        })
    }

    /// Every node, parents first. Gathered when first asked for.
    pub(crate) fn nodes(&self) -> &[NodeInfo] {
        self.nodes.get_or_init(|| {
            let mut nodes = Vec::new();
            self.scene
                .query()
                .for_each_node(&mut |node| nodes.push(node));
            nodes
        })
    }

    pub(crate) fn mebibytes(&self) -> f64 {
        self.scene.query().bytes() as f64 / f64::from(1 << 20)
    }
}

impl fmt::Debug for Built {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Built")
            .field("structure", &self.structure)
            .field("scene", &self.scene)
            .finish_non_exhaustive()
    }
}
