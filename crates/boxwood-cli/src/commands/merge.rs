//! `boxwood merge`: the picture of which shards hold the tiles.

use std::path::PathBuf;

use boxwood_render::merge;
use serde::Serialize;

use super::render::write;
use crate::{
    output::{Exit, Output, counted, grouped},
    save,
};

/// Put the tiles of several processes together.
///
/// Checks that all parts are of one scene, one set of options and one version, and that each tile is there once; then writes what one process
/// would have written, bit for bit. What `--shard` and `--resume` leave when they are stopped is taken too.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  boxwood merge bush.png.1of2.part bush.png.2of2.part -o bush.png
  boxwood merge bush.png.*.part -o bush.exr")]
pub(crate) struct Args {
    /// Files that `boxwood render --shard` has made, in any order.
    #[arg(value_name = "PARTS", required = true)]
    parts: Vec<PathBuf>,
    /// Where to write: .png, .exr (with all layers), or - for PNG on standard output.
    #[arg(short, long, value_name = "FILE", required = true)]
    output: String,
}

#[derive(Serialize)]
struct Report<'a> {
    output: &'a str,
    file: &'a str,
    scene: &'a str,
    parts: usize,
    tiles: usize,
    shading: &'a str,
    width: u32,
    height: u32,
    rays: u64,
}

/// Checks, and writes.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    save::check(Some(&args.output), out, &["png", "exr"])?;
    let merged = merge(&args.parts)?;
    let (film, header) = (&merged.film, &merged.header);
    write(&args.output, film, &header.camera, &header.shading)?;
    let report = Report {
        output: &args.output,
        file: &header.file,
        scene: &header.scene,
        parts: args.parts.len(),
        tiles: film.finished.len(),
        shading: &header.shading,
        width: film.width(),
        height: film.height(),
        rays: film.rays,
    };
    match (out.is_json(), &*args.output) {
        (true, _) => out.json(&report)?,
        (false, "-") => out.note(report.text()),
        (false, _) => out.text(report.text())?,
    }
    Ok(Exit::Ok)
}

impl Report<'_> {
    fn text(&self) -> String {
        format!(
            "{}: {}x{}, {}; {} from {}, {} rays",
            self.output,
            self.width,
            self.height,
            self.shading,
            counted(self.tiles, "tile"),
            counted(self.parts, "part"),
            grouped(self.rays)
        )
    }
}
