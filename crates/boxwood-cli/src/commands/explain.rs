//! `boxwood explain`: how one ray finds its answer, step by step.

use boxwood::{Ray, Scene};
use boxwood_trace::WalkTrace;
use clap::ArgGroup;
use serde::Serialize;

use crate::{
    args::{CameraArgs, Loaded, SceneArgs, StructureArgs, numbers, whole},
    output::{Exit, Output, Trouble, grouped},
};

/// Explain the walk of one ray: every box, cell and triangle that is tried, with its numbers, and why it is skipped.
///
/// Indented by depth; siblings are tested together, and `in N` names the box they stand in. A triangle shows its three edge
/// functions: all of one sign means that the line passes through it, and a zero is settled by a rule of ties, whose sign
/// then stands beside it. `t a .. b` is where the ray is inside; it misses where a is above b. docs/trace.md describes the JSON,
/// which also has the stack around each step.
#[derive(Debug, clap::Args)]
#[command(group(ArgGroup::new("which").required(true)), after_help = "\
Examples:
  boxwood explain builtin:cornell --pixel 640,360
  boxwood explain builtin:bush --ray 0,1,9,0,0,-1 --structure grid
  boxwood explain builtin:cornell --pixel 640,360 --structure bounded --builder median --json")]
pub(crate) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// The ray through the centre of a pixel, from the upper left one, 0,0.
    #[arg(long, value_name = "X,Y", group = "which", allow_hyphen_values = true, value_parser = pixel)]
    pixel: Option<[u32; 2]>,
    /// The ray from an origin in a direction of any length.
    #[arg(long, value_name = "OX,OY,OZ,DX,DY,DZ", group = "which", allow_hyphen_values = true, value_parser = numbers::<6>)]
    ray: Option<[f32; 6]>,
    /// Most lines to print; 0 is all.
    #[arg(long, value_name = "N", default_value_t = 200, allow_negative_numbers = true, value_parser = whole::<usize>)]
    lines: usize,
    #[command(flatten)]
    structure: StructureArgs,
    #[command(flatten)]
    camera: CameraArgs,
}

fn pixel(text: &str) -> Result<[u32; 2], String> {
    let parsed = text
        .split_once(',')
        .and_then(|(x, y)| Some([x.trim().parse().ok()?, y.trim().parse().ok()?]));
    parsed.ok_or_else(|| "two whole numbers with a comma, as in 640,360".to_owned())
}

/// The JSON object.
#[derive(Serialize)]
struct Answer {
    file: String,
    triangles: usize,
    #[serde(flatten)]
    trace: WalkTrace,
}

/// Walks and prints.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let loaded = args.scene.load(out)?;
    let (scene, _) = args.structure.build(&loaded.mesh)?;
    let ray = ray(args, &scene, &loaded)?;
    let answer = Answer {
        file: loaded.name.clone(),
        triangles: scene.len(),
        trace: boxwood_trace::walk(&scene, &ray),
    };
    if out.is_json() {
        out.json(&answer)?;
    } else {
        out.text(text(&answer, args.lines))?;
    }
    Ok(Exit::Ok)
}

fn ray(args: &Args, scene: &Scene, loaded: &Loaded) -> anyhow::Result<Ray> {
    if let Some([ox, oy, oz, dx, dy, dz]) = args.ray {
        return Ok(Ray::new([ox, oy, oz], [dx, dy, dz]));
    }
    let view = args.camera.view(scene, loaded)?;
    let [x, y] = args.pixel.unwrap_or_default();
    let (width, height) = (view.width(), view.height());
    if x >= width || y >= height {
        let help = format!(
            "choose from 0,0 to {},{}, or another --size",
            width - 1,
            height - 1
        );
        return Err(Trouble::usage(
            format!("pixel {x},{y} is outside a picture of {width}x{height}"),
            help,
        )
        .into());
    }
    Ok(view.pixel_ray(x, y))
}

fn text(answer: &Answer, lines: usize) -> String {
    let Answer {
        file,
        triangles,
        trace,
    } = answer;
    let limit = if lines == 0 { usize::MAX } else { lines };
    let rest = match trace.steps.len() > limit {
        true => "\n(--lines 0 prints all steps)",
        false => "",
    };
    let prims = grouped(*triangles as u64);
    let walk = trace.text(limit);
    format!(
        "{file}: {}, {prims} triangles\n{walk}{rest}",
        trace.structure
    )
}
