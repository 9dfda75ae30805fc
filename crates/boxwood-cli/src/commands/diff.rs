//! `boxwood diff`: how far two pictures are apart.

use std::path::Path;

use anyhow::Context;
use boxwood_render::{Picture, compare, read_picture, write_png};
use serde::Serialize;

use crate::{
    args,
    output::{Exit, Output, Trouble, grouped},
    save,
};

/// Compare two pictures (PNG or EXR): RMSE, largest difference, FLIP.
///
/// FLIP is the difference that a viewer notices who flips between the two, 0 to 1 (Andersson et al. 2020). The exit code
/// is 1 if the mean FLIP is above the threshold; without a threshold, if any pixel differs at all.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  boxwood diff before.png after.png
  boxwood diff before.png after.png --threshold 0.02 -o flip.png")]
pub(crate) struct Args {
    /// A picture, or - for standard input.
    #[arg(value_parser = args::file_name)]
    a: String,
    /// The other picture.
    #[arg(value_parser = args::file_name)]
    b: String,
    /// Mean FLIP error up to which the pictures count as equal, 0 to 1. [default: any difference counts]
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = share)]
    threshold: Option<f64>,
    /// Write the map of FLIP errors: black is equal. - for standard output.
    #[arg(short, long, value_name = "PNG")]
    output: Option<String>,
}

fn share(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x| (0.0..=1.0).contains(x));
    number.ok_or_else(|| "a number from 0 to 1".to_owned())
}

/// The comparison, in the words of the JSON object.
#[derive(Serialize)]
struct Difference<'a> {
    a: &'a str,
    b: &'a str,
    width: u32,
    height: u32,
    equal: bool,
    differing_pixels: u64,
    rmse: f64,
    max: f32,
    flip: f64,
    threshold: Option<f64>,
    passed: bool,
    output: Option<&'a str>,
}

/// Compares.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    if (&*args.a, &*args.b) == ("-", "-") {
        return Err(
            Trouble::usage("both pictures are standard input", "name at least one file").into(),
        );
    }
    save::check(args.output.as_deref(), out, &["png"])?;
    let found = compare(&picture(&args.a)?, &picture(&args.b)?)?;
    if let Some(output) = &args.output {
        save::save(output, |file| write_png(&found.flip_image(), &[], file))?;
    }
    let passed = match args.threshold {
        Some(threshold) => found.flip <= threshold,
        None => found.differing == 0,
    };
    let difference = Difference {
        a: &args.a,
        b: &args.b,
        width: found.width,
        height: found.height,
        equal: found.differing == 0,
        differing_pixels: found.differing,
        rmse: found.rmse,
        max: found.max,
        flip: found.flip,
        threshold: args.threshold,
        passed,
        output: args.output.as_deref(),
    };
    match (out.is_json(), args.output.as_deref()) {
        (true, _) => out.json(&difference)?,
        (false, Some("-")) => out.note(text(&difference)),
        (false, _) => out.text(text(&difference))?,
    }
    Ok(Exit::from_difference(!passed))
}

fn picture(name: &str) -> anyhow::Result<Picture> {
    let bytes = match name {
        "-" => args::read_stdin()?,
        path => args::read_file(Path::new(path))?,
    };
    read_picture(&bytes).with_context(|| name.to_owned())
}

fn text(found: &Difference<'_>) -> String {
    if found.equal {
        return format!(
            "equal: all {} pixels",
            grouped(u64::from(found.width) * u64::from(found.height))
        );
    }
    let verdict = match (found.threshold, found.passed) {
        (None, _) => String::new(),
        (Some(threshold), true) => format!("\nwithin the threshold of {threshold}"),
        (Some(threshold), false) => format!("\nabove the threshold of {threshold}"),
    };
    format!(
        "{} of {} pixels differ\nRMSE {:.6}\nmax  {:.6}\nFLIP {:.6} (mean){verdict}",
        grouped(found.differing_pixels),
        grouped(u64::from(found.width) * u64::from(found.height)),
        found.rmse,
        found.max,
        found.flip,
    )
}
