//! What several commands ask for: from what was typed to checked values. Parsing does no work; the methods do.

use std::{
    io::Read,
    path::Path,
    str::FromStr,
    time::{Duration, Instant},
};

use boxwood::{
    AxisRule, BUILDERS, BuildOptions, Builder, PRESETS, Preset, STRUCTURES, Scene, Structure,
    VOLUMES, Volume, geom::MAX_COORDINATE,
};
use boxwood_render::{MAX_SIDE, Surfaces, View, auto_camera};
use boxwood_scene::{Camera, FlatMesh, Folded, Limits, LoadError, MAX_TRIANGLES, Model};
use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::{
    memory,
    output::{Output, Trouble, coordinate, counted, grouped},
    warnings,
};

/// Sets the size of the pool that everything runs in.
pub(crate) fn use_threads(threads: u16) -> anyhow::Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
    pool.build_global().map_err(|_| {
        Trouble::usage(
            format!("the system does not grant {threads} threads"),
            "ask for fewer with --threads",
        )
    })?;
    Ok(())
}

/// Which scene.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct SceneArgs {
    /// Scene: a file (`boxwood list` has the formats), builtin:NAME as in builtin:soup?n=1000, or - for standard input.
    #[arg(value_name = "FILE", value_parser = file_name)]
    pub(crate) file: String,
}

/// A scene ready to be built and shown: multiplied out, or [`Folded`].
#[derive(Debug)]
pub(crate) struct Loaded<M = FlatMesh> {
    /// As the user named it.
    pub(crate) name: String,
    /// As loaded.
    pub(crate) model: Model,
    /// Its triangles.
    pub(crate) mesh: M,
    /// Reading, and multiplying out or folding.
    pub(crate) time: Duration,
}

/// Triangles with looks.
pub(crate) trait Triangles {
    /// All that is stored.
    fn meshes(&self) -> Vec<&FlatMesh>;
    /// The looks, with the materials of the model.
    fn surfaces<'a>(&'a self, model: &'a Model) -> Surfaces<'a>;
}

impl Triangles for FlatMesh {
    fn meshes(&self) -> Vec<&FlatMesh> {
        vec![self]
    }

    fn surfaces<'a>(&'a self, model: &'a Model) -> Surfaces<'a> {
        Surfaces::new(self, model)
    }
}

impl Triangles for Folded {
    fn meshes(&self) -> Vec<&FlatMesh> {
        self.parts.iter().chain([&self.once]).collect()
    }

    fn surfaces<'a>(&'a self, model: &'a Model) -> Surfaces<'a> {
        Surfaces::of_folded(self, model)
    }
}

impl SceneArgs {
    /// Loads the scene and passes its warnings on.
    pub(crate) fn load(&self, out: &Output) -> anyhow::Result<Loaded> {
        let loaded = self.load_quietly()?;
        loaded.warn(out);
        Ok(loaded)
    }

    /// Loads the scene, meshes that repeat kept once, and passes its warnings on.
    pub(crate) fn load_folded(&self, out: &Output) -> anyhow::Result<Loaded<Folded>> {
        let loaded = self.load_folded_quietly()?;
        loaded.warn(out);
        Ok(loaded)
    }

    /// Loads the scene, meshes that repeat kept once; its warnings stay in the model.
    pub(crate) fn load_folded_quietly(&self) -> anyhow::Result<Loaded<Folded>> {
        let start = Instant::now();
        let model = self.model()?;
        let kept = match model.repeats() {
            true => model.unique_triangle_count(),
            false => model.triangle_count(),
        };
        memory::check(&self.file, kept)?;
        let mesh = model.fold().map_err(|error| self.blamed(error))?;
        Ok(Loaded {
            name: self.file.clone(),
            model,
            mesh,
            time: start.elapsed(),
        })
    }

    /// An error there is about the scene; it is the user's file that it is in.
    fn blamed(&self, error: LoadError) -> LoadError {
        LoadError {
            file: self.file.clone(),
            ..error
        }
    }

    /// Loads the scene; its warnings stay in the model.
    pub(crate) fn load_quietly(&self) -> anyhow::Result<Loaded> {
        let start = Instant::now();
        let model = self.model()?;
        memory::check(&self.file, model.triangle_count())?;
        let mesh = model.flatten().map_err(|error| self.blamed(error))?;
        Ok(Loaded {
            name: self.file.clone(),
            model,
            mesh,
            time: start.elapsed(),
        })
    }

    /// Loads the scene as it is stored.
    pub(crate) fn model(&self) -> anyhow::Result<Model> {
        let model = match &*self.file {
            "-" => boxwood_scene::load_bytes("<stdin>", None, &read_stdin()?, Limits::default()),
            name => {
                if let Some(triangles) = asked_for(name) {
                    memory::check(name, triangles)?;
                }
                boxwood_scene::open(name)
            }
        };
        Ok(model?)
    }
}

/// What `builtin:NAME?n=...` asks for, if it can be had.
fn asked_for(name: &str) -> Option<u64> {
    let (_, query) = name.strip_prefix("builtin:")?.split_once('?')?;
    let number = query.split('&').find_map(|part| part.strip_prefix("n="))?;
    let number = number.replace('_', "").parse().ok();
    number.filter(|n| *n <= MAX_TRIANGLES)
}

impl<M: Triangles> Loaded<M> {
    /// Passes the warnings of the loader on.
    fn warn(&self, out: &Output) {
        for warning in warnings::shortened(&self.model.warnings) {
            out.warn(warning);
        }
        let meshes = self.mesh.meshes();
        let unhittable: usize = meshes.iter().map(|mesh| unhittable(mesh)).sum();
        if unhittable > 0 {
            let all = meshes.iter().map(|mesh| mesh.indices.len()).sum();
            out.warn(format!(
                "{} of {} lie beyond 2^100 or are not finite, and can never be hit",
                grouped(unhittable as u64),
                counted(all, "triangle")
            ));
        }
    }

    /// The looks of the triangles.
    pub(crate) fn surfaces(&self) -> Surfaces<'_> {
        self.mesh.surfaces(&self.model)
    }
}

/// Triangles that no ray can hit, because exact arithmetic does not reach so far.
fn unhittable(mesh: &FlatMesh) -> usize {
    let reaches = |i: &u32| {
        let corner = mesh.positions[*i as usize];
        corner.iter().all(|x| x.abs() <= MAX_COORDINATE)
    };
    let triangles = mesh.indices.iter();
    triangles
        .filter(|corners| !corners.iter().all(reaches))
        .count()
}

/// All of standard input, within the limit of files.
pub(crate) fn read_stdin() -> anyhow::Result<Vec<u8>> {
    let limit = Limits::default().max_file_bytes;
    let mut bytes = Vec::new();
    std::io::stdin()
        .lock()
        .take(limit + 1)
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(Trouble::input(
            format!("<stdin>: more than {limit} bytes"),
            "name the file instead",
        )
        .into());
    }
    Ok(bytes)
}

/// All of a file that is not a scene, within the limit of files.
pub(crate) fn read_file(path: &Path) -> anyhow::Result<Vec<u8>> {
    let name = path.display();
    let failed = |error: std::io::Error| {
        Trouble::input(format!("{name}: {error}"), "name a file that can be read")
    };
    let (metadata, limit) = (
        std::fs::metadata(path).map_err(failed)?,
        Limits::default().max_file_bytes,
    );
    if metadata.is_dir() {
        let cause = format!("{name}: is a folder");
        return Err(Trouble::input(cause, "name a file in it").into());
    }
    if !metadata.is_file() {
        return Err(
            Trouble::input(format!("{name}: is not a regular file"), "pipe it into `-`").into(),
        );
    }
    if metadata.len() > limit {
        return Err(Trouble::input(
            format!("{name}: more than {limit} bytes"),
            "name a smaller file",
        )
        .into());
    }
    Ok(std::fs::read(path).map_err(failed)?)
}

/// How to build.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Structure")]
pub(crate) struct StructureArgs {
    /// Acceleration structure.
    #[arg(long, value_name = "NAME", default_value = Structure::DEFAULT, value_parser = structures())]
    pub(crate) structure: Structure,
    /// How much a build may cost for how good a tree.
    #[arg(long, value_name = "NAME", default_value = "default", value_parser = presets())]
    pub(crate) preset: Preset,
    /// What builds a tree. [default: as the preset has it]
    #[arg(long, value_name = "NAME", value_parser = builders())]
    pub(crate) builder: Option<Builder>,
    /// Bounding volume of tree nodes. [default: aabb]
    #[arg(long, value_name = "NAME", value_parser = volumes())]
    pub(crate) volume: Option<Volume>,
    /// Axis along which `median` and `midpoint` split. [default: longest]
    #[arg(long, value_name = "RULE", value_parser = axes())]
    pub(crate) axis: Option<AxisRule>,
    /// Most primitives in a leaf, 1 to 255. [default: 4]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=255))]
    pub(crate) max_leaf: Option<u32>,
    /// Bins per axis of the `binned` builder, 2 to 32. [default: 16]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(2..=32))]
    pub(crate) bins: Option<u32>,
    /// Grid cells per primitive, 0.01 to 64. [default: 4]
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = density)]
    pub(crate) density: Option<f32>,
}

fn structures() -> impl TypedValueParser<Value = Structure> {
    PossibleValuesParser::new(STRUCTURES.iter().map(|s| s.name))
        .try_map(|name| Structure::named(&name))
}

fn presets() -> impl TypedValueParser<Value = Preset> {
    PossibleValuesParser::new(PRESETS.iter().map(|p| p.name)).try_map(|name| {
        let named = |preset: &&Preset| preset.name == name;
        PRESETS.iter().find(named).copied().ok_or("no such preset")
    })
}

fn builders() -> impl TypedValueParser<Value = Builder> {
    PossibleValuesParser::new(BUILDERS.iter().map(|b| b.name))
        .try_map(|name| Builder::named(&name).ok_or("no such builder"))
}

fn volumes() -> impl TypedValueParser<Value = Volume> {
    PossibleValuesParser::new(VOLUMES.iter().map(|v| v.name)).try_map(|name| Volume::named(&name))
}

fn axes() -> impl TypedValueParser<Value = AxisRule> {
    PossibleValuesParser::new(["longest", "round-robin"]).map(|name| match &*name {
        "longest" => AxisRule::Longest,
        _ => AxisRule::RoundRobin,
    })
}

impl StructureArgs {
    /// The options, defaults filled in.
    pub(crate) fn options(&self) -> BuildOptions {
        let usual = (self.preset.options)();
        BuildOptions {
            builder: self.builder.unwrap_or(usual.builder),
            volume: self.volume.map_or(usual.volume, |volume| volume.name),
            axis: self.axis.unwrap_or(usual.axis),
            max_leaf: self.max_leaf.unwrap_or(usual.max_leaf),
            bins: self.bins.unwrap_or(usual.bins),
            grid_density: self.density.unwrap_or(usual.grid_density),
            ..usual
        }
    }

    /// `bvh2 (binned, aabb)`.
    pub(crate) fn label(&self) -> String {
        let choices = self.structure.choices(&self.options());
        match choices.is_empty() {
            true => self.structure.name.to_owned(),
            false => format!("{} ({})", self.structure.name, choices.join(", ")),
        }
    }

    /// Builds over meshes and their instances, and says how long that took.
    pub(crate) fn build_folded(&self, mesh: &Folded) -> anyhow::Result<(Scene, Duration)> {
        let start = Instant::now();
        let scene = mesh.build(self.structure.name, &self.options())?;
        Ok((scene, start.elapsed()))
    }

    /// Builds over `mesh`, and says how long that took.
    pub(crate) fn build(&self, mesh: &FlatMesh) -> anyhow::Result<(Scene, Duration)> {
        build(mesh, self.structure.name, self.options())
    }
}

/// Builds over `mesh`, and says how long that took.
pub(crate) fn build(
    mesh: &FlatMesh,
    structure: &str,
    options: BuildOptions,
) -> anyhow::Result<(Scene, Duration)> {
    let start = Instant::now();
    let builder = Scene::builder()
        .mesh(&mesh.positions, &mesh.indices)
        .structure(structure)
        .options(options);
    Ok((builder.build()?, start.elapsed()))
}

/// From where, in the words of Embree's viewer.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Camera")]
pub(crate) struct CameraArgs {
    /// View point. [default: the scene's first camera, else one that is found]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = triple)]
    pub(crate) vp: Option<[f32; 3]>,
    /// Point that the camera looks at.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = triple)]
    pub(crate) vi: Option<[f32; 3]>,
    /// Up.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = triple)]
    pub(crate) vu: Option<[f32; 3]>,
    /// Vertical field of view in degrees.
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    pub(crate) fov: Option<f32>,
    /// A camera of the scene by its number, from 0, or `auto`. [default: 0 if there is one]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) camera: Option<CameraChoice>,
    /// Size of the picture in pixels.
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, default_value = "1280x720", value_parser = size)]
    pub(crate) size: [u32; 2],
}

/// Which camera to start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CameraChoice {
    /// Found by looking at the scene.
    Auto,
    /// One of the scene's.
    Number(usize),
}

impl FromStr for CameraChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            _ => text
                .parse()
                .map(Self::Number)
                .map_err(|_| "a number or `auto`".to_owned()),
        }
    }
}

impl CameraArgs {
    /// The view: what was typed, over the scene's camera, over one that is found.
    pub(crate) fn view(
        &self,
        scene: &Scene,
        loaded: &Loaded<impl Triangles>,
    ) -> anyhow::Result<View> {
        let [width, height] = self.size;
        let auto = || self.auto(scene, loaded);
        let cameras = &loaded.model.cameras;
        let base = match self.camera {
            Some(CameraChoice::Auto) => auto()?,
            Some(CameraChoice::Number(number)) => *cameras.get(number).ok_or_else(|| {
                let help = format!(
                    "it has {}, counted from 0; --camera auto finds one",
                    counted(cameras.len(), "camera")
                );
                Trouble::usage(
                    format!("{}: there is no camera {number}", loaded.name),
                    help,
                )
            })?,
            None => match cameras.first() {
                Some(camera) => *camera,
                None => auto()?,
            },
        };
        let camera = Camera {
            eye: self.vp.unwrap_or(base.eye),
            target: self.vi.unwrap_or(base.target),
            up: self.vu.unwrap_or(base.up),
            fov: self.fov.unwrap_or(base.fov),
        };
        Ok(View::new(camera, width, height)?)
    }

    /// A camera that is found, which must do unless all that matters was typed.
    fn auto(&self, scene: &Scene, loaded: &Loaded<impl Triangles>) -> anyhow::Result<Camera> {
        let [width, height] = self.size;
        let camera = auto_camera(scene, loaded.surfaces(), width, height);
        if View::new(camera, width, height).is_err() && (self.vp.is_none() || self.vi.is_none()) {
            let cause = format!("{}: no camera can be found for this scene", loaded.name);
            return Err(Trouble::input(cause, "give --vp and --vi").into());
        }
        Ok(camera)
    }
}

/// A camera as it is typed.
pub(crate) fn camera_flags(camera: &Camera) -> String {
    let list = |point: [f32; 3]| point.map(coordinate).join(",");
    format!(
        "--vp {} --vi {} --vu {} --fov {}",
        list(camera.eye),
        list(camera.target),
        list(camera.up),
        camera.fov
    )
}

/// Not empty.
pub(crate) fn file_name(text: &str) -> Result<String, String> {
    match text {
        "" => Err("the name is empty".to_owned()),
        name => Ok(name.to_owned()),
    }
}

/// A whole number that is not negative.
pub(crate) fn whole<T: FromStr>(text: &str) -> Result<T, String> {
    text.parse()
        .map_err(|_| "a whole number, 0 or more".to_owned())
}

/// `N` numbers with commas between them.
pub(crate) fn numbers<const N: usize>(text: &str) -> Result<[f32; N], String> {
    let parsed: Result<Vec<f32>, _> = text
        .split(',')
        .map(|part| part.trim().parse::<f32>())
        .collect();
    let parsed = parsed
        .ok()
        .filter(|numbers| numbers.iter().all(|x| x.is_finite()));
    parsed
        .and_then(|list| list.try_into().ok())
        .ok_or_else(|| format!("{N} plain numbers with commas, as in 1,2.5,-3"))
}

/// `1,2.5,-3`.
pub(crate) fn triple(text: &str) -> Result<[f32; 3], String> {
    numbers(text)
}

/// `1280x720`.
pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| {
        text.parse()
            .ok()
            .filter(|side| (1..=MAX_SIDE).contains(side))
    };
    let sides = text
        .split_once(['x', 'X'])
        .and_then(|(width, height)| Some([side(width)?, side(height)?]));
    sides.ok_or_else(|| format!("width x height in pixels, 1 to {MAX_SIDE} each, as in 1280x720"))
}

fn density(text: &str) -> Result<f32, String> {
    let number = text.parse().ok().filter(|x| (0.01..=64.0).contains(x));
    number.ok_or_else(|| "a number from 0.01 to 64".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_sides_within_the_limits() {
        assert_eq!(size("1280x720"), Ok([1280, 720]));
        for wrong in ["", "1280", "0x3", "3x0", "65536x1", "-1x2", "1x2x3", "axb"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn triples_are_three_plain_numbers() {
        assert_eq!(triple("1, 2.5,-3e2"), Ok([1.0, 2.5, -300.0]));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,nan", "1,inf,2", "a,b,c"] {
            assert!(triple(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_camera_is_typed_as_it_is_printed() {
        #[derive(clap::Parser)]
        struct Line {
            #[command(flatten)]
            camera: CameraArgs,
        }
        let camera = Camera {
            eye: [-1.0, 2.5, 1e-7],
            target: [0.1, -0.2, 3.0],
            up: [0.0, 0.0, 1.0],
            fov: 35.5,
        };
        let flags = camera_flags(&camera);
        let words = ["boxwood"].into_iter().chain(flags.split(' '));
        let line = <Line as clap::Parser>::try_parse_from(words)
            .unwrap()
            .camera;
        assert_eq!((line.vp, line.vi), (Some(camera.eye), Some(camera.target)));
        assert_eq!((line.vu, line.fov), (Some(camera.up), Some(camera.fov)));
    }
}
