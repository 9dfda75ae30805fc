//! `boxwood simplify`: "carefully reduce triangle count".

use std::{io::Write, time::Instant};

use boxwood_render::RenderError;
use boxwood_scene::{FlatMesh, simplify, write_obj, write_ply};
use serde::Serialize;

use crate::{
    args::{self, SceneArgs},
    output::{Exit, Output, counted, grouped, short},
    save,
};

/// Reduce the number of triangles, keeping the shape as well as may be.
///
/// Edges are collapsed where it moves the surface least (Garland and Heckbert 1997). Instances are multiplied out; normals
/// and texture coordinates are left out.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  boxwood simplify builtin:sphere --triangles 114 -o ball.obj
  boxwood simplify bunny.obj --triangles 5000 -o bunny-5k.ply")]
pub(crate) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// How many are wanted.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = args::whole::<usize>)]
    triangles: usize,
    /// Where to write: .ply or .obj; - writes PLY to standard output.
    #[arg(short, long, value_name = "PLY|OBJ")]
    output: String,
}

/// What was done, in the words of the JSON object.
#[derive(Serialize)]
struct Report<'a> {
    file: &'a str,
    triangles_before: usize,
    triangles: usize,
    wanted: usize,
    vertices: usize,
    seconds: f64,
    output: &'a str,
}

/// Simplifies and writes.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    save::check(Some(&args.output), out, &["ply", "obj"])?;
    let loaded = args.scene.load(out)?;
    let start = Instant::now();
    let mesh = simplify(&loaded.mesh, args.triangles);
    let seconds = start.elapsed().as_secs_f64();
    save::save(&args.output, |mut file| {
        write_mesh(&args.output, &mesh, &mut file)
    })?;
    let report = Report {
        file: &loaded.name,
        triangles_before: loaded.mesh.indices.len(),
        triangles: mesh.indices.len(),
        wanted: args.triangles,
        vertices: mesh.positions.len(),
        seconds,
        output: &args.output,
    };
    match (out.is_json(), &*args.output) {
        (true, _) => out.json(&report)?,
        (false, "-") => out.note(text(&report)),
        (false, _) => out.text(text(&report))?,
    }
    Ok(Exit::Ok)
}

fn write_mesh(name: &str, mesh: &FlatMesh, mut file: &mut dyn Write) -> Result<(), RenderError> {
    let (format, written) = match &*save::extension(name) {
        "obj" => ("OBJ", write_obj(mesh, &mut file)),
        _ => ("PLY", write_ply(mesh, &mut file)),
    };
    written.map_err(|error| RenderError::Encode {
        format,
        cause: error.to_string(),
    })
}

fn text(report: &Report<'_>) -> String {
    let count = |n: usize| grouped(n as u64);
    let missed = match report.triangles == report.wanted.min(report.triangles_before) {
        true => String::new(),
        false => format!(
            " (wanted {}; this is as near as the shape allows)",
            count(report.wanted)
        ),
    };
    let (before, after) = (
        count(report.triangles_before),
        counted(report.triangles, "triangle"),
    );
    format!(
        "{}: {before} to {after}{missed} in {} s",
        report.output,
        short(report.seconds)
    )
}
