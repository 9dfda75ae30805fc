//! `boxwood render`: pictures of a scene.

mod frames;
mod kept;
mod look;
mod plan;
mod report;
mod share;
mod studio;
mod template;
mod write;

pub(crate) use self::write::write;

use std::path::Path;

use boxwood_render::Film;

use self::{
    look::LookArgs,
    plan::{FarmArgs, Picture, Plan},
    report::SeriesReport,
    studio::{Made, Studio},
};
use crate::{
    args::{CameraArgs, SceneArgs, StructureArgs},
    output::{Exit, Output, Trouble, counted},
    terminal::{self, Show},
};

/// Make a picture of a scene, or many.
///
/// Ctrl-C (or SIGTERM) saves the tiles that are done, and ends with exit code 4; frames are written only when they are whole. The same
/// arguments give the same picture, bit for bit, for any number of threads, in every structure, and from any number of processes.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  boxwood render builtin:bush --show
  boxwood render bunny.obj -o bunny.png --shading ao --size 800x800
  boxwood render builtin:cornell --shading path --spp 64 -o cornell.exr
  boxwood render builtin:stadium --shading heat-prims --structure grid -o heat.png
  boxwood render - -o - < bunny.ply > bunny.png
  boxwood render builtin:bush --turntable 120 --frames 1-120x40 -o turn.{frame:04}.png
  boxwood render bunny.obj --path cam.json --shard 1/4 --skip-existing
  boxwood render builtin:cornell --shading path --resume -o cornell.png
  boxwood render builtin:bush -o bush.png --shard 1/2    then 2/2, and: boxwood merge bush.png.*.part -o bush.png")]
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
    farm: FarmArgs,
    #[command(flatten)]
    structure: StructureArgs,
}

/// Plans, loads, builds, renders, writes.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let output = args
        .output
        .clone()
        .unwrap_or_else(|| default_output(&args.scene.file, args.farm.has_frames()));
    let plan = args.farm.plan(&output, out)?;
    if args.show && (out.is_json() || output == "-") {
        return Err(Trouble::usage(
            "--show wants standard output for itself",
            "leave out --show, --json or -o -",
        )
        .into());
    }
    if args.farm.dry_run {
        plan.print(out)?;
        return Ok(Exit::Ok);
    }
    if !plan.skipped.is_empty() {
        out.note(format!(
            "{} there already",
            counted(plan.skipped.len(), "picture")
        ));
    }
    if plan.pictures.is_empty() {
        return nothing_to_do(&plan, out);
    }
    let studio = Studio::open(args, plan.path.clone(), out)?;
    studio.check_cameras(&plan.pictures)?;
    match (&*plan.pictures, plan.is_series) {
        ([picture], false) => single(&studio, picture, &plan, out),
        _ => series(&studio, &plan, out),
    }
}

/// A share of few frames may be empty, and all may be there.
fn nothing_to_do(plan: &Plan, out: &Output) -> anyhow::Result<Exit> {
    match out.is_json() {
        true => out.json(&SeriesReport {
            frames: Vec::new(),
            skipped: &plan.skipped,
            complete: true,
        })?,
        false => out.text("nothing to do")?,
    }
    Ok(Exit::Ok)
}

fn single(
    studio: &Studio<'_>,
    picture: &Picture,
    plan: &Plan,
    out: &Output,
) -> anyhow::Result<Exit> {
    let made = make(studio, picture, plan, out)?;
    if let (true, Some(film)) = (studio.args.show, &made.film) {
        show(film, out)?;
    }
    if let Some(report) = &made.report {
        match (out.is_json(), &*picture.output) {
            (true, _) => out.json(report)?,
            (false, "-") => out.note(report.text()),
            (false, _) => out.text(report.text())?,
        }
    }
    Ok(told(&made, out))
}

fn series(studio: &Studio<'_>, plan: &Plan, out: &Output) -> anyhow::Result<Exit> {
    let (mut reports, mut exit) = (Vec::new(), Exit::Ok);
    for picture in &plan.pictures {
        let made = make(studio, picture, plan, out)?;
        if let (true, Some(film)) = (studio.args.show, &made.film) {
            show(film, out)?;
        }
        exit = told(&made, out);
        if let Some(report) = made.report {
            if !out.is_json() {
                out.text(report.line())?;
            }
            reports.push(report);
        }
        if exit != Exit::Ok {
            break;
        }
    }
    if out.is_json() {
        out.json(&SeriesReport {
            frames: reports,
            skipped: &plan.skipped,
            complete: exit == Exit::Ok,
        })?;
    }
    Ok(exit)
}

fn make(studio: &Studio<'_>, picture: &Picture, plan: &Plan, out: &Output) -> anyhow::Result<Made> {
    match studio.args.farm.resume || plan.shard.is_some() {
        true => kept::make(studio, picture, plan.shard, out),
        false => studio.make(picture, plan.only_whole, out.is_json()),
    }
}

/// Warns if it was interrupted.
fn told(made: &Made, out: &Output) -> Exit {
    match &made.interrupted {
        None => Exit::Ok,
        Some(what) => {
            out.warn(what);
            Exit::Interrupted
        }
    }
}

/// `bunny.png` for `models/bunny.obj`, in the current folder.
fn default_output(file: &str, many: bool) -> String {
    let name = match file.strip_prefix("builtin:") {
        Some(spec) => spec.split('?').next().unwrap_or(spec).to_owned(),
        None if file == "-" => "stdin".to_owned(),
        None => Path::new(file)
            .file_stem()
            .map(|stem| stem.to_string_lossy().into_owned())
            .unwrap_or_default(),
    };
    let name = if name.is_empty() { "boxwood" } else { &name };
    format!("{name}{}.png", if many { ".{frame:04}" } else { "" })
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
            assert_eq!(default_output(file, false), output);
        }
        assert_eq!(default_output("a/b.ply", true), "b.{frame:04}.png");
    }
}
