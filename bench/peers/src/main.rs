//! Boxwood side by side with Embree, obvhs, parry3d and bvh: the same triangles, the same rays, in turn, in one process.
//!
//! `cargo run --release --manifest-path bench/peers/Cargo.toml -- FILE` measures one scene, `--all LIST` writes
//! `bench/RESULTS.md`. Rays, timing and reports are those of the crate `boxwood-measure`.

mod entries;
mod frame;
mod growth;
mod input;
mod measure;
mod output;
mod results;
mod rivals;
mod standing;

use anyhow::{Context, Result, bail};
use boxwood_measure::{Machine, Probe};
use boxwood_scene::Camera;
use clap::Parser;
use input::Input;
use measure::{Bench, Settings, measure};
use results::Results;
use std::{
    io::{self, Write},
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Measure Boxwood beside Embree, obvhs, parry3d and bvh.
#[derive(Debug, Parser)]
#[command(
    name = "peers",
    after_help = "\
Embree comes from EMBREE_LIB (and TBB_LIB), else from the PyPI wheel embreex, which is fetched once.
The Rust rivals are compiled as Boxwood is; obvhs gains from RUSTFLAGS=\"-C target-cpu=native\", the others choose at run time."
)]
struct Args {
    /// A mesh file, or builtin:NAME.
    #[arg(
        value_name = "FILE",
        required_unless_present = "all",
        conflicts_with = "all"
    )]
    file: Option<String>,
    /// Every scene of a list (name, file, camera; tabs between), into RESULTS.md.
    #[arg(long, value_name = "LIST")]
    all: Option<PathBuf>,
    /// Where --all writes.
    #[arg(long, value_name = "FILE", conflicts_with = "file")]
    out: Option<PathBuf>,
    /// The largest scene of the growth plot of --all; 0: none.
    #[arg(long, value_name = "TRIANGLES", default_value_t = 10_000_000)]
    growth: u64,
    /// Eye, target and vertical field of view. [default: the whole scene from outside]
    #[arg(long, value_name = "X,Y,Z,X,Y,Z,DEGREES", allow_hyphen_values = true, value_parser = input::camera)]
    cam: Option<Camera>,
    /// Only these contenders.
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    only: Vec<String>,
    /// A set has so many rays, squared.
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(8..=4096))]
    size: u32,
    /// Turns of each contender.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Besides one thread, so many. [default: one; with --all, all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// One JSON object on stdout.
    #[arg(long)]
    json: bool,
    /// A page with plots.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

/// Measures what is asked for. What was typed is looked at first: measuring takes minutes.
fn run(args: &Args) -> Result<()> {
    if cfg!(debug_assertions) {
        bail!("this is a debug build, whose figures are worthless; run with --release");
    }
    entries::check(&args.only)?;
    [&args.out, &args.html]
        .into_iter()
        .flatten()
        .try_for_each(|path| has_folder(path))?;
    match (&args.all, &args.file) {
        (Some(list), _) => all(args, list, &input::list(list)?),
        (None, Some(file)) => one(args, file),
        (None, None) => bail!("name a scene or give --all"),
    }
}

fn has_folder(path: &Path) -> Result<()> {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    match folder.filter(|folder| !folder.is_dir()) {
        Some(folder) => bail!(
            "{}: cannot be written, there is no folder {}",
            path.display(),
            folder.display()
        ),
        None => Ok(()),
    }
}

/// How to measure on this machine, and its limits.
fn prepare(args: &Args) -> Result<(Settings, Bench)> {
    let machine = Machine::seen();
    let usual_threads = if args.all.is_some() {
        machine.threads
    } else {
        1
    };
    let settings = Settings {
        only: args.only.clone(),
        size: args.size as usize,
        rounds: args.rounds as usize,
        threads: args.threads.map_or(usual_threads, usize::from),
        command: command(),
    };
    let embree = entries::want_embree(&args.only)
        .then(rivals::library::open)
        .transpose()?;
    let bench = Bench {
        probe: Probe::measure(&machine),
        machine,
        embree,
        embree_version: embree.map(rivals::embree::version).transpose()?,
    };
    Ok((settings, bench))
}

/// As typed, without the program's own path.
fn command() -> String {
    let args: Vec<String> = std::env::args().skip(1).collect();
    format!(
        "cargo run --release --manifest-path bench/peers/Cargo.toml -- {}",
        args.join(" ")
    )
}

fn one(args: &Args, file: &str) -> Result<()> {
    let input = Input {
        name: file.to_owned(),
        file: file.to_owned(),
        camera: args.cam,
    };
    let mesh = input.load(Path::new(""))?;
    let (settings, bench) = prepare(args)?;
    let measured = measure(&input.name, &mesh, input.camera, &settings, &bench)?;
    if let Some(path) = &args.html {
        write(
            path,
            &output::page(std::slice::from_ref(&measured), Vec::new(), &bench)?,
        )?;
    }
    if args.json {
        return say(&serde_json::to_string_pretty(&output::json(
            &measured, &bench,
        )?)?);
    }
    say(&output::text(&measured, &bench))
}

/// On stdout. A reader who has left (`| head`) is no failure.
fn say(text: &str) -> Result<()> {
    match writeln!(io::stdout(), "{}", text.trim_end()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

/// All scenes of a list; one that cannot be measured is skipped, and RESULTS says why.
fn all(args: &Args, list: &Path, inputs: &[Input]) -> Result<()> {
    let (settings, bench) = &prepare(args)?;
    let folder = list.parent().unwrap_or(Path::new(""));
    let (mut measured, mut skipped) = (Vec::new(), Vec::new());
    for input in inputs {
        let scene = input.load(folder);
        match scene.and_then(|mesh| measure(&input.name, &mesh, input.camera, settings, bench)) {
            Ok(scene) => {
                eprint!("{}", output::text(&scene, bench));
                measured.push(scene);
            }
            Err(error) => {
                eprintln!("{}: skipped: {error:#}", input.name);
                skipped.push((input.name.clone(), format!("{error:#}")));
            }
        }
    }
    let growth = growth::curves(args.growth, settings, bench)?;
    let results = Results {
        scenes: &measured,
        skipped: &skipped,
        growth: &growth,
        frames: &frame::of_list(list, settings, bench)?,
        bench,
        settings,
    };
    let text = results.markdown();
    let usual = Path::new(env!("CARGO_MANIFEST_DIR")).join("../RESULTS.md");
    write(args.out.as_deref().unwrap_or(&usual), &text)?;
    if let Some(path) = &args.html {
        write(
            path,
            &output::page(&measured, vec![growth::section(&growth)?], bench)?,
        )?;
    }
    if args.json {
        let scenes: Result<Vec<_>> = measured
            .iter()
            .map(|scene| output::json(scene, bench))
            .collect();
        say(&serde_json::to_string_pretty(&scenes?)?)?;
    }
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<()> {
    std::fs::write(path, text).with_context(|| format!("{}: cannot be written", path.display()))
}
