//! `boxwood render`: a picture of a scene.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use boxwood_render::{
    Crop, Film, PointLight, RenderOptions, SHADINGS, ScaleOptions, Shading, View, Watch, render,
    write_exr, write_png,
};
use boxwood_scene::Folded;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde::Serialize;

use crate::{
    args::{self, CameraArgs, Loaded, SceneArgs, StructureArgs, Triangles, camera_flags},
    output::{Exit, Output, Trouble, counted, grouped, short},
    progress::{Progress, interrupted},
    save,
    terminal::{self, Show},
};

/// Make a picture of a scene.
///
/// Ctrl-C (or SIGTERM) saves the tiles that are done, and ends with exit code 4. The same arguments give the same picture, bit for
/// bit, for any number of threads and in every structure.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  boxwood render builtin:bush --show
  boxwood render bunny.obj -o bunny.png --shading ao --size 800x800
  boxwood render builtin:cornell --shading path --spp 64 -o cornell.exr
  boxwood render builtin:stadium --shading heat-prims --structure grid -o heat.png
  boxwood render - -o - < bunny.ply > bunny.png")]
pub(crate) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Where to write: .png, .exr (with all layers), or - for PNG on standard output. [default: the scene's name, .png]
    #[arg(short, long, value_name = "FILE")]
    output: Option<String>,
    /// Draw the picture into the terminal too.
    #[arg(long)]
    show: bool,
    #[command(flatten)]
    look: LookArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    structure: StructureArgs,
}

/// What the picture shows.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Picture")]
struct LookArgs {
    /// What the colours mean; `boxwood list` says more.
    #[arg(long, value_name = "NAME", default_value = "whitted", value_parser = shadings())]
    shading: &'static Shading,
    /// Samples per pixel. [default: as many as the shading needs]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=i64::from(boxwood_render::MAX_SAMPLES)))]
    spp: Option<u32>,
    /// Another seed gives another noise.
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = args::whole::<u64>)]
    seed: u64,
    /// Only this part, in pixels: left, top, width, height.
    #[arg(long, value_name = "X,Y,W,H", allow_hyphen_values = true, value_parser = crop)]
    crop: Option<Crop>,
    /// Most bounces of light.
    #[arg(long, value_name = "N", default_value_t = 8, allow_negative_numbers = true, value_parser = args::whole::<u32>)]
    max_depth: u32,
    /// A lamp: its place, and its power, where 1 (the default) lights the scene's middle like the sun. May be given often.
    #[arg(long = "light", value_name = "X,Y,Z[,POWER]", allow_hyphen_values = true, value_parser = lamp)]
    lights: Vec<Lamp>,
    /// Strength of sun and sky, 0 is night. [default: 1; in rooms with lights of their own 0]
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = not_negative)]
    sky: Option<f32>,
    /// Brightness in stops, 0 is neutral. [default: neutral by daylight, measured in rooms]
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true, value_parser = plain)]
    exposure: Option<f32>,
    /// No floor under the object.
    #[arg(long)]
    no_floor: bool,
    /// Number at the bright end of heat pictures; the same one makes pictures comparable. [default: from the picture]
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = not_negative)]
    top: Option<f32>,
    /// Colour heat pictures by the logarithm.
    #[arg(long)]
    log: bool,
}

/// As typed: place and power.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Lamp {
    position: [f32; 3],
    power: f32,
}

fn shadings() -> impl TypedValueParser<Value = &'static Shading> {
    PossibleValuesParser::new(SHADINGS.iter().map(|s| s.name)).try_map(|name| Shading::named(&name))
}

fn crop(text: &str) -> Result<Crop, String> {
    let numbers: Option<Vec<u32>> = text
        .split(',')
        .map(|part| part.trim().parse().ok())
        .collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Crop {
            x,
            y,
            width,
            height,
        }),
        _ => Err("left, top, width and height in pixels, as in 320,180,640,360".to_owned()),
    }
}

fn lamp(text: &str) -> Result<Lamp, String> {
    let with_power = |[x, y, z, power]: [f32; 4]| Lamp {
        position: [x, y, z],
        power,
    };
    let without = |[x, y, z]: [f32; 3]| Lamp {
        position: [x, y, z],
        power: 1.0,
    };
    args::numbers(text)
        .map(with_power)
        .or_else(|_| args::numbers(text).map(without))
        .ok()
        .filter(|l| l.power >= 0.0)
        .ok_or_else(|| "a place and a power, as in 2,5,3 or 2,5,3,0.5".to_owned())
}

fn plain(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|x: &f32| x.is_finite())
        .ok_or_else(|| "a plain number".to_owned())
}

fn not_negative(text: &str) -> Result<f32, String> {
    plain(text)
        .ok()
        .filter(|&x| x >= 0.0)
        .ok_or_else(|| "a number, 0 or more".to_owned())
}

/// What was made, in the words of the JSON object.
#[derive(Serialize)]
struct Report<'a> {
    file: &'a str,
    output: &'a str,
    triangles: u64,
    shading: &'static str,
    structure: String,
    camera: String,
    width: u32,
    height: u32,
    samples: u32,
    seed: u64,
    complete: bool,
    load_ms: f64,
    build_ms: f64,
    render_ms: f64,
    rays: u64,
    mrays_per_second: f64,
    box_tests_per_camera_ray: f64,
    primitive_tests_per_camera_ray: f64,
}

/// Loads, builds, renders, writes.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let output = args
        .output
        .clone()
        .unwrap_or_else(|| default_output(&args.scene.file));
    save::check(Some(&output), out, &["png", "exr"])?;
    if args.show && (out.is_json() || output == "-") {
        return Err(Trouble::usage(
            "--show wants standard output for itself",
            "leave out --show, --json or -o -",
        )
        .into());
    }
    let loaded = args.scene.load_folded(out)?;
    if loaded.mesh.triangle_count() == 0 {
        let cause = format!("{}: the scene has no triangles", loaded.name);
        return Err(Trouble::input(cause, "give one that has some").into());
    }
    let (scene, build_time) = args.structure.build_folded(&loaded.mesh)?;
    let view = args.camera.view(&scene, &loaded)?;
    let options = RenderOptions {
        // Layers of the EXR, numbers of the JSON object; a PNG has no use for them.
        counts: out.is_json() || save::extension(&output) == "exr",
        ..args.look.options(&scene)
    };
    let start = Instant::now();
    let film = render_watched(&scene, &loaded, &view, &options)?;
    let time = start.elapsed();
    if film.finished_share() == 0.0 {
        out.warn(format!(
            "interrupted before the first tile was done; {output} is not written"
        ));
        return Ok(Exit::Interrupted);
    }
    write(&output, &film, &view, &args.look)?;
    if args.show {
        show(&film, out)?;
    }
    let report = args.report(&loaded, &output, (&film, &view), build_time, time);
    match (out.is_json(), &*output) {
        (true, _) => out.json(&report)?,
        (false, "-") => out.note(report.text()),
        (false, _) => out.text(report.text())?,
    }
    if film.is_complete() {
        return Ok(Exit::Ok);
    }
    out.warn(format!(
        "interrupted: {output} holds the {:.0} % that were done",
        film.finished_share() * 100.0
    ));
    Ok(Exit::Interrupted)
}

/// With progress on stderr; Ctrl-C stops it.
pub(crate) fn render_watched(
    scene: &boxwood::Scene,
    loaded: &Loaded<impl Triangles>,
    view: &View,
    options: &RenderOptions,
) -> anyhow::Result<Film> {
    let pixels = options.crop.map_or([view.width(), view.height()], |crop| {
        [crop.width, crop.height]
    });
    let progress = Progress::new(u64::from(pixels[0]) * u64::from(pixels[1]), "pixels");
    let start = Instant::now();
    let report = |done: boxwood_render::Progress| {
        progress.set(done.pixels);
        progress.say(format!(
            "{} Mrays/s",
            short(done.rays as f64 / start.elapsed().as_secs_f64() / 1e6)
        ));
    };
    let watch = Watch {
        cancel: Some(interrupted()),
        report: Some(&report),
    };
    Ok(render(scene, loaded.surfaces(), view, options, watch)?)
}

impl LookArgs {
    fn options(&self, scene: &boxwood::Scene) -> RenderOptions {
        RenderOptions {
            samples: self.spp,
            seed: self.seed,
            crop: self.crop,
            max_depth: self.max_depth,
            lights: self.lights.iter().map(|lamp| lamp.light(scene)).collect(),
            sky: self.sky,
            floor: !self.no_floor,
            exposure: self.exposure,
            scale: ScaleOptions {
                top: self.top,
                log: self.log,
            },
            ..RenderOptions::new(self.shading)
        }
    }
}

impl Lamp {
    /// Power 1 gives the sun's irradiance at the middle of the scene.
    fn light(&self, scene: &boxwood::Scene) -> PointLight {
        const SUN: f32 = 3.0;
        let bounds = scene.bounds();
        let way: f32 = self
            .position
            .iter()
            .zip(bounds.center())
            .map(|(a, b)| (a - b) * (a - b))
            .sum();
        let radius = (bounds.diagonal() * 0.01) as f32;
        PointLight {
            position: self.position,
            intensity: [self.power * SUN * way; 3],
            radius,
        }
    }
}

/// `bunny.png` for `models/bunny.obj`, in the current folder.
fn default_output(file: &str) -> String {
    let name = match file.strip_prefix("builtin:") {
        Some(spec) => spec.split('?').next().unwrap_or(spec).to_owned(),
        None if file == "-" => "stdin".to_owned(),
        None => Path::new(file)
            .file_stem()
            .map(|stem| stem.to_string_lossy().into_owned())
            .unwrap_or_default(),
    };
    format!("{}.png", if name.is_empty() { "boxwood" } else { &name })
}

/// Camera, shading and program go into PNG files as text.
fn write(output: &str, film: &Film, view: &View, look: &LookArgs) -> anyhow::Result<()> {
    if save::extension(output) == "exr" {
        return save::save(output, |file| write_exr(film, file));
    }
    let camera = camera_flags(&view.camera());
    let program = concat!("boxwood ", env!("CARGO_PKG_VERSION"));
    let texts = [
        ("Software", program),
        ("Camera", &camera),
        ("Shading", look.shading.name),
    ];
    save::save(output, |file| write_png(&film.to_image(), &texts, file))
}

fn show(film: &Film, out: &Output) -> anyhow::Result<()> {
    match Show::of_stdout() {
        Some(way) => {
            let image = film.to_image();
            let columns =
                terminal::columns_for(&image, terminal::lines().saturating_sub(5).max(10));
            out.text(way.draw(&image, columns)?)
        }
        None => {
            out.warn("--show: standard output is not a terminal that shows pictures");
            Ok(())
        }
    }
}

impl Args {
    fn report<'a>(
        &'a self,
        loaded: &'a Loaded<Folded>,
        output: &'a str,
        (film, view): (&Film, &View),
        build_time: Duration,
        time: Duration,
    ) -> Report<'a> {
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        let per_ray = |count: u64| count as f64 / film.counts.rays.max(1) as f64;
        Report {
            file: &loaded.name,
            output,
            triangles: loaded.mesh.triangle_count(),
            shading: self.look.shading.name,
            structure: self.structure.label(),
            camera: camera_flags(&view.camera()),
            width: film.width(),
            height: film.height(),
            samples: self.look.spp.unwrap_or(self.look.shading.samples),
            seed: self.look.seed,
            complete: film.is_complete(),
            load_ms: ms(loaded.time),
            build_ms: ms(build_time),
            render_ms: ms(time),
            rays: film.rays,
            mrays_per_second: film.rays as f64 / time.as_secs_f64().max(1e-9) / 1e6,
            box_tests_per_camera_ray: per_ray(film.counts.boxes),
            primitive_tests_per_camera_ray: per_ray(film.counts.prims),
        }
    }
}

impl Report<'_> {
    fn text(&self) -> String {
        let Self {
            output,
            width,
            height,
            shading,
            samples,
            structure,
            ..
        } = self;
        format!(
            "{output}: {width}x{height}, {shading}, {samples} per pixel; {} in {structure}\n\
             loaded in {} ms, built in {} ms, {} rays in {} ms ({} Mrays/s)\ncamera {}",
            counted(self.triangles as usize, "triangle"),
            short(self.load_ms),
            short(self.build_ms),
            grouped(self.rays),
            short(self.render_ms),
            short(self.mrays_per_second),
            self.camera,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_is_named_after_the_scene() {
        let cases = [
            ("models/bunny.obj", "bunny.png"),
            ("builtin:soup?n=10", "soup.png"),
            ("-", "stdin.png"),
            ("..", "boxwood.png"),
        ];
        for (file, output) in cases {
            assert_eq!(default_output(file), output);
        }
    }

    #[test]
    fn crops_and_lamps_are_read_or_refused() {
        assert_eq!(
            crop("1, 2,30,40"),
            Ok(Crop {
                x: 1,
                y: 2,
                width: 30,
                height: 40
            })
        );
        assert!(crop("1,2,0,4").is_err() && crop("1,2,3").is_err() && crop("-1,2,3,4").is_err());
        assert_eq!(
            lamp("1,2,-3.5"),
            Ok(Lamp {
                position: [1.0, 2.0, -3.5],
                power: 1.0
            })
        );
        assert_eq!(
            lamp("1,2,3,0.5"),
            Ok(Lamp {
                position: [1.0, 2.0, 3.0],
                power: 0.5
            })
        );
        assert!(lamp("1,2").is_err() && lamp("1,2,3,-1").is_err());
    }
}
