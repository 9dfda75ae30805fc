//! `boxwood check`: do all structures give the same answer, bit for bit?

use std::time::Instant;

use boxwood::{
    Transform, Triangle,
    check::{self, AIMS, Aim, Failure, Layout, Options, Report, VariantReport},
};
use boxwood_scene::{FlatMesh, Folded};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde::Serialize;

use crate::{
    args::{self, SceneArgs},
    output::{Exit, Output, Table, counted, grouped, short},
    progress::Progress,
};

/// Check that every structure gives the same answer, bit for bit.
///
/// Shoots rays that look for trouble (at edges and vertices, along axes, from planes of boxes, from far away, some that are
/// no rays) through every structure, by every builder and over every volume, one at a time and in slices, by one thread and
/// by many, for the closest hit, for any and for all. Every answer must be that of `list`, brute force, in every bit. On
/// a closed mesh, each line must besides meet the surface an even number of times.
///
/// Of a scene whose meshes repeat, structures hold the meshes once and stand around each other: every structure around the
/// default one and inside it, and each around each.
///
/// Where brute force or a structure is too dear for all the rays it gets the first of them, and the table says how many.
/// Exit code 1 if anything differs.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  boxwood check builtin:sphere --rays 3000 --aim vertices
  boxwood check builtin:cornell --rays 20000 --seed 7 --json")]
pub(crate) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// How many rays.
    #[arg(long, value_name = "N", default_value_t = 100_000, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..))]
    rays: u32,
    /// Other seeds, other rays.
    #[arg(long, value_name = "S", default_value_t = 0, allow_negative_numbers = true, value_parser = args::whole::<u64>)]
    seed: u64,
    /// Where the rays are aimed.
    #[arg(long, value_name = "WHERE", default_value = "mixed", value_parser = aims())]
    aim: Aim,
    /// Operations, in 10^9, that one structure may spend (it gets fewer rays where that does not do).
    #[arg(long, value_name = "GFLOP", default_value_t = 20, allow_negative_numbers = true, value_parser = args::whole::<u64>)]
    budget: u64,
    /// The same for brute force.
    #[arg(long, value_name = "GFLOP", default_value_t = 60, allow_negative_numbers = true, value_parser = args::whole::<u64>)]
    oracle_budget: u64,
}

const GIGA: u64 = 1_000_000_000;

fn aims() -> impl TypedValueParser<Value = Aim> {
    PossibleValuesParser::new(AIMS.iter().map(|(name, _)| *name)).map(|name| {
        AIMS.iter()
            .find(|(known, _)| *known == name)
            .map_or(Aim::Mixed, |(_, aim)| *aim)
    })
}

/// The JSON object.
#[derive(Serialize)]
struct Answer<'a> {
    file: &'a str,
    triangles: u64,
    rays: u64,
    seed: u64,
    aim: &'static str,
    /// Structures compared, `list` included.
    structures: usize,
    differences: u64,
    misses: u64,
    parity_errors: u64,
    /// Rays that hit something.
    hits: u64,
    /// The first so many rays were compared with brute force.
    oracle_rays: u64,
    closed: bool,
    /// Lines tested for parity; 0 for an open mesh.
    parity_rays: u64,
    /// Of all closest hits, hexadecimal.
    digest: String,
    rays_by_structure: Vec<Row<'a>>,
    failures: Vec<String>,
    threads: usize,
    seconds: f64,
}

#[derive(Serialize)]
struct Row<'a> {
    name: &'a str,
    rays: u64,
    differences: u64,
    misses: u64,
}

/// Checks, reports, and ends with 1 if anything differs.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let loaded = args.scene.load_folded(out)?;
    let options = Options {
        rays: args.rays.into(),
        seed: args.seed,
        aim: args.aim,
        budget: args.budget.saturating_mul(GIGA),
        oracle_budget: args.oracle_budget.saturating_mul(GIGA),
    };
    let start = Instant::now();
    let bar = Progress::new(
        u64::from(args.rays).saturating_mul(check::variants().len() as u64 + 1),
        "answers",
    );
    let mut tell = |progress: &check::Progress<'_>| {
        bar.set(progress.done);
        bar.limit(progress.total);
        bar.say(format!(
            "{}, {} differences",
            progress.structure, progress.differences
        ));
    };
    let report = match loaded.mesh.is_folded() {
        true => check::run_instances(&layout(&loaded.mesh), &options, &mut tell)?,
        false => check::run(&triangles(&loaded.mesh.once), &options, &mut tell)?,
    };
    drop(bar);
    let answer = answer(
        args,
        loaded.mesh.triangle_count(),
        &report,
        start.elapsed().as_secs_f64(),
    );
    if out.is_json() {
        out.json(&answer)?;
    } else {
        out.text(text(&answer))?;
    }
    Ok(Exit::from_difference(!report.is_clean()))
}

fn triangles(mesh: &FlatMesh) -> Vec<Triangle> {
    let corners = |indices: &[u32; 3]| Triangle(indices.map(|i| mesh.positions[i as usize]));
    mesh.indices.iter().map(corners).collect()
}

/// Parts with their instances; what is shown once stands where it is.
fn layout(mesh: &Folded) -> Layout {
    let parts = mesh.parts.iter().chain([&mesh.once]);
    let placed = mesh.instances.iter().map(|instance| {
        let columns = instance.world_from_mesh.to_cols_array_2d();
        (instance.mesh, Transform::from_columns(columns))
    });
    let once = (mesh.parts.len() as u32, Transform::IDENTITY);
    Layout {
        meshes: parts.map(triangles).collect(),
        instances: placed.chain([once]).collect(),
    }
}

fn answer<'a>(args: &'a Args, triangles: u64, report: &'a Report, seconds: f64) -> Answer<'a> {
    let row = |v: &'a VariantReport| Row {
        name: &v.name,
        rays: v.rays,
        differences: v.differences,
        misses: v.misses,
    };
    let list = Row {
        name: "list",
        rays: report.oracle_rays,
        differences: 0,
        misses: 0,
    };
    let rows: Vec<Row<'_>> = [list]
        .into_iter()
        .chain(report.variants.iter().map(row))
        .collect();
    Answer {
        file: &args.scene.file,
        triangles,
        rays: report.rays,
        seed: args.seed,
        aim: AIMS
            .iter()
            .find(|(_, aim)| *aim == args.aim)
            .map_or("mixed", |(name, _)| name),
        structures: rows.len(),
        differences: report.differences,
        misses: report.misses,
        parity_errors: report.parity_errors,
        hits: report.hits,
        oracle_rays: report.oracle_rays,
        closed: report.is_closed,
        parity_rays: report.parity_rays,
        digest: format!("{:016x}", report.digest),
        rays_by_structure: rows,
        failures: report.failures.iter().map(Failure::to_string).collect(),
        threads: rayon::current_num_threads(),
        seconds,
    }
}

fn text(answer: &Answer<'_>) -> String {
    let mut table = Table::new(["structure", "rays", "differences", "misses"]);
    for row in &answer.rays_by_structure {
        table.row([
            row.name.to_owned(),
            grouped(row.rays),
            grouped(row.differences),
            grouped(row.misses),
        ]);
    }
    let parity = match answer.closed {
        true => format!(
            "{} parity errors: the mesh is closed, and {} whole lines were tested for an even number of hits",
            grouped(answer.parity_errors),
            grouped(answer.parity_rays)
        ),
        false => "0 parity errors: the mesh is open, so parity says nothing".to_owned(),
    };
    let mut lines = vec![
        format!(
            "{}: {}, {} rays ({}, seed {}), {} of them hit",
            answer.file,
            counted(answer.triangles as usize, "triangle"),
            grouped(answer.rays),
            answer.aim,
            answer.seed,
            grouped(answer.hits)
        ),
        String::new(),
        table.to_string(),
        String::new(),
        reference(answer),
        format!(
            "{} differences, {} of them lost hits",
            grouped(answer.differences),
            grouped(answer.misses)
        ),
        parity,
        format!(
            "digest of the answers {}, {} s on {} threads",
            answer.digest,
            short(answer.seconds),
            answer.threads
        ),
    ];
    lines.extend(answer.failures.iter().map(|failure| format!("\n{failure}")));
    lines.join("\n")
}

/// With what the answers were compared.
fn reference(answer: &Answer<'_>) -> String {
    let stand_in = answer.rays_by_structure.get(1).map_or("", |row| row.name);
    match answer.rays - answer.oracle_rays {
        0 => "every ray was compared with brute force".to_owned(),
        rest => format!(
            "the first {} rays were compared with brute force, the other {} with {stand_in}",
            grouped(answer.oracle_rays),
            grouped(rest)
        ),
    }
}
