//! Pictures of scenes.

use crate::arrays::{array3, column, rows};
use crate::looks::{Gathered, NativeLooks};
use crate::pool::interruptible;
use crate::rays::{Origin, Table};
use crate::scene::NativeScene;
use boxwood::Scene;
use boxwood_host::FloatModes;
use boxwood_render::{
    Crop, Film, PointLight, RenderError, RenderOptions, SHADINGS, ScaleOptions, Shading, Surfaces,
    View, Watch, auto_camera, render, save_atomically, write_exr, write_png,
};
use boxwood_scene::Camera;
use numpy::{PyArray1, PyArray3, PyReadonlyArray2};
use pyo3::exceptions::{PyMemoryError, PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;

/// Names of the shadings, and what they show.
pub(crate) fn shadings() -> Vec<(&'static str, &'static str)> {
    SHADINGS
        .iter()
        .map(|shading| (shading.name, shading.about))
        .collect()
}

/// A scene and how it looks, ready for pictures.
#[pyclass(frozen, name = "NativeStudio", module = "boxwood._native")]
pub(crate) struct NativeStudio {
    scene: Source,
    looks: Gathered,
}

/// The renderer numbers the triangles of one mesh; a scene of several is built again as one.
enum Source {
    Asked(Py<NativeScene>),
    Own(Box<Scene>),
}

/// Positions, triangles and looks of a mesh.
type Part<'py> = (
    Table<'py>,
    PyReadonlyArray2<'py, u32>,
    Option<Bound<'py, NativeLooks>>,
);

/// Where the camera stands, where it looks, what is up there, its vertical field of view in degrees; None: as found.
type Place = (
    Option<[f32; 3]>,
    Option<[f32; 3]>,
    Option<[f32; 3]>,
    Option<f32>,
);

/// The same, all known.
type Known = ([f32; 3], [f32; 3], [f32; 3], f32);

/// Place and power.
type Lamp = ([f32; 3], f32);

/// What to paint, as keywords of Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Wish {
    shading: String,
    samples: Option<u32>,
    seed: u64,
    crop: Option<[u32; 4]>,
    max_depth: u32,
    lights: Vec<Lamp>,
    sky: Option<f32>,
    floor: bool,
    exposure: Option<f32>,
    top: Option<f32>,
    log: bool,
}

#[pymethods]
impl NativeStudio {
    /// `scene` is built of the meshes of `parts`, all moved by `-origin`, as those of `parts` may be already.
    #[new]
    fn new(
        py: Python<'_>,
        scene: Py<NativeScene>,
        parts: Vec<Part<'_>>,
        origin: Origin,
        is_moved: bool,
        threads: usize,
    ) -> PyResult<Self> {
        let shift = if is_moved { [0.0; 3] } else { origin };
        let mut looks = Gathered::default();
        for (positions, indices, look) in &parts {
            let (positions, indices) = (
                positions.points("vertices", shift)?,
                rows(indices, "triangles")?,
            );
            looks.add(positions, &indices, look.as_ref().map(Bound::get))?;
        }
        let _modes = FloatModes::enter();
        for camera in &mut looks.model.cameras {
            camera.eye = moved(camera.eye, origin);
            camera.target = moved(camera.target, origin);
        }
        if parts.len() == 1 {
            let scene = Source::Asked(scene);
            return Ok(Self { scene, looks });
        }
        drop(parts);
        let options = scene.get().0.options().clone();
        let mesh = &looks.mesh;
        let built = interruptible(py, threads, |_| {
            let builder = Scene::builder().mesh(&mesh.positions, &mesh.indices);
            builder.options(options).build()
        })?;
        let own = built.map_err(|error| PyValueError::new_err(error.to_string()))?;
        let scene = Source::Own(Box::new(own));
        Ok(Self { scene, looks })
    }

    /// The camera of a picture.
    fn camera(
        &self,
        py: Python<'_>,
        size: [u32; 2],
        place: Place,
        threads: usize,
    ) -> PyResult<Known> {
        let camera = self.view(py, size, place, threads)?.camera();
        Ok((camera.eye, camera.target, camera.up, camera.fov))
    }

    /// A picture of so many pixels.
    fn render(
        &self,
        py: Python<'_>,
        size: [u32; 2],
        place: Place,
        wish: Wish,
        threads: usize,
    ) -> PyResult<NativePicture> {
        let view = self.view(py, size, place, threads)?;
        let options = {
            let _modes = FloatModes::enter();
            wish.options(self.scene()).map_err(raised)?
        };
        let film = interruptible(py, threads, |cancel| {
            let watch = Watch {
                cancel: Some(cancel),
                report: None,
            };
            render(self.scene(), self.surfaces(), &view, &options, watch)
        })?;
        Ok(NativePicture {
            film: film.map_err(raised)?,
            shading: options.shading,
            camera: view.camera(),
            threads,
        })
    }
}

impl NativeStudio {
    fn scene(&self) -> &Scene {
        match &self.scene {
            Source::Asked(scene) => &scene.get().0,
            Source::Own(scene) => scene,
        }
    }

    fn surfaces(&self) -> Surfaces<'_> {
        Surfaces::new(&self.looks.mesh, &self.looks.model)
    }

    /// What is not said comes from the file's first camera, or else from one that is found.
    fn view(
        &self,
        py: Python<'_>,
        [width, height]: [u32; 2],
        (eye, target, up, fov): Place,
        threads: usize,
    ) -> PyResult<View> {
        let _modes = FloatModes::enter();
        let base = match self.looks.model.cameras.first() {
            Some(camera) => *camera,
            None => interruptible(py, threads, |_| {
                auto_camera(self.scene(), self.surfaces(), width, height)
            })?,
        };
        let camera = Camera {
            eye: eye.unwrap_or(base.eye),
            target: target.unwrap_or(base.target),
            up: up.unwrap_or(base.up),
            fov: fov.unwrap_or(base.fov),
        };
        View::new(camera, width, height).map_err(raised)
    }
}

impl Wish {
    fn options(&self, scene: &Scene) -> Result<RenderOptions, RenderError> {
        Ok(RenderOptions {
            samples: self.samples,
            seed: self.seed,
            crop: self.crop.map(|[x, y, width, height]| Crop {
                x,
                y,
                width,
                height,
            }),
            max_depth: self.max_depth,
            lights: self.lights.iter().map(|lamp| light(lamp, scene)).collect(),
            sky: self.sky,
            floor: self.floor,
            exposure: self.exposure,
            scale: ScaleOptions {
                top: self.top,
                log: self.log,
            },
            counts: false,
            ..RenderOptions::new(Shading::named(&self.shading)?)
        })
    }
}

/// As on the command line: power 1 gives the sun's irradiance at the middle of the scene.
fn light(&(position, power): &Lamp, scene: &Scene) -> PointLight {
    const SUN: f32 = 3.0;
    let bounds = scene.bounds();
    let away = position.iter().zip(bounds.center()).map(|(a, b)| a - b);
    let way: f32 = away.map(|x| x * x).sum();
    PointLight {
        position,
        intensity: [power * SUN * way; 3],
        radius: (bounds.diagonal() * 0.01) as f32,
    }
}

fn moved(place: [f32; 3], origin: Origin) -> [f32; 3] {
    std::array::from_fn(|axis| (f64::from(place[axis]) - origin[axis]) as f32)
}

/// What a PNG tells about itself.
pub(crate) fn texts(shading: &'static Shading) -> [(&'static str, &'static str); 2] {
    let program = concat!("boxwood ", env!("CARGO_PKG_VERSION"));
    [("Software", program), ("Shading", shading.name)]
}

pub(crate) fn raised(error: RenderError) -> PyErr {
    let text = error.to_string();
    match error {
        RenderError::Memory { .. } => PyMemoryError::new_err(text),
        RenderError::Save { .. } => PyOSError::new_err(text),
        _ => PyValueError::new_err(text),
    }
}

/// A finished picture with what is known about each pixel.
#[pyclass(frozen, name = "NativePicture", module = "boxwood._native")]
pub(crate) struct NativePicture {
    film: Film,
    shading: &'static Shading,
    camera: Camera,
    /// Pixels are made in the same pool as the film, not in one that a fork would break.
    threads: usize,
}

#[pymethods]
impl NativePicture {
    /// Eye, target, up, vertical field of view in degrees.
    fn camera(&self) -> Known {
        let Camera {
            eye,
            target,
            up,
            fov,
        } = self.camera;
        (eye, target, up, fov)
    }

    /// Left, top, width and height in the full picture, and the size of that.
    fn window(&self) -> ([u32; 4], [u32; 2]) {
        let Crop {
            x,
            y,
            width,
            height,
        } = self.film.window;
        ([x, y, width, height], self.film.full_size)
    }

    /// Eight bits of sRGB, without a legend.
    fn pixels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let image = interruptible(py, self.threads, |_| self.film.to_plain_image())?;
        array3(py, image.rgb, self.shape())
    }

    /// Linear light, before exposure and tone.
    fn linear<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        array3(py, self.film.color.clone(), self.shape())
    }

    /// Shading normals.
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        array3(py, self.film.normal.clone(), self.shape())
    }

    /// Distances from the eye.
    fn depth<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        column(py, self.film.depth.clone())
    }

    /// Triangles, counted through all meshes.
    fn prims<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        column(py, self.film.prim.clone())
    }

    /// A PNG file.
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = interruptible(py, self.threads, |_| {
            let mut bytes = Vec::new();
            self.write_png(&mut bytes).map(|()| bytes)
        })?;
        Ok(PyBytes::new(py, &bytes.map_err(raised)?))
    }

    /// Writes a PNG or an EXR file beside `path` and renames it.
    fn save(&self, py: Python<'_>, path: PathBuf, exr: bool) -> PyResult<()> {
        let save = || {
            save_atomically(&path, |file| {
                if exr {
                    write_exr(&self.film, file)
                } else {
                    self.write_png(file)
                }
            })
        };
        interruptible(py, self.threads, |_| save())?.map_err(raised)
    }
}

impl NativePicture {
    fn shape(&self) -> [usize; 2] {
        [self.film.height() as usize, self.film.width() as usize]
    }

    /// With the legend of a scale, and how it was made as text.
    fn write_png(&self, out: impl std::io::Write) -> Result<(), RenderError> {
        write_png(&self.film.to_image(), &texts(self.shading), out)
    }
}
