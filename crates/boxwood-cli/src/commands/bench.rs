//! `boxwood bench`: how fast is all of it on this scene and this machine, and is it as fast as it was?

mod course;
mod table;

use std::{io::Write, path::Path};

use boxwood_measure::{
    Machine, MeasureError, Probe, Report, Row,
    baseline::{self, Comparison},
    html::{self, Page},
};
use boxwood_render::RenderError;
use serde::Serialize;

use self::course::Course;
use crate::{
    args::{self, SceneArgs},
    contest::{Contender, contenders},
    output::{Exit, Output, Trouble},
    save,
};

/// Measure every structure and builder: five kinds of rays, single and in batches, on one thread and on all.
///
/// The rays are those that pictures are made of: primary rays, shadow rays, ambient occlusion, a diffuse bounce, random
/// lines. All contenders take turns on the same rays; medians count, and so does how far the rounds lie apart. A second
/// table says which part of an estimated limit each rate is: what the nodes and leaves that the rays visit must cost on this
/// machine. Who is slow gets a sample of the rays, marked `est.`; `~` marks what varied by more than 20 %.
///
/// With --baseline the figures are compared with those of an earlier run, and what got worse by more than noise is named
/// (after a second look). Exit code 1 then, or if two structures do not give the same bits. Ctrl-C keeps what is measured.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  boxwood bench builtin:terrain?n=2000 --size 16 --rounds 1 --only grid --html bench.html
  boxwood bench --save before.json builtin:bush --only 'bvh2 binned aabb'
  boxwood bench builtin:bush --only 'bvh2 binned aabb' --baseline before.json --json")]
pub(crate) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Only contenders whose name has these words, as in 'grid,bvh2 sweep'.
    #[arg(long, value_name = "WORDS,...", value_delimiter = ',')]
    only: Vec<String>,
    /// Every structure with every builder and volume.
    #[arg(long)]
    all: bool,
    /// A set has so many rays, squared.
    #[arg(long, value_name = "N", default_value_t = 256, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(8..=4096))]
    size: u32,
    /// Turns of each contender. More: less noise.
    #[arg(long, value_name = "N", default_value_t = 9, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// View point of the primary rays. [default: the scene's first camera, else from outside]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = args::triple, requires = "vi")]
    vp: Option<[f32; 3]>,
    /// Point that they look at.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = args::triple, requires = "vp")]
    vi: Option<[f32; 3]>,
    /// Compare with what an earlier run saved.
    #[arg(long, value_name = "FILE")]
    baseline: Option<String>,
    /// Changes up to this are never counted, in percent.
    #[arg(long, value_name = "PERCENT", default_value_t = 5.0, allow_negative_numbers = true, value_parser = percent)]
    tolerance: f64,
    /// Save the figures as JSON, for a --baseline to come.
    #[arg(long, value_name = "FILE")]
    save: Option<String>,
    /// Save a page with plots, in one file.
    #[arg(long, value_name = "FILE")]
    html: Option<String>,
}

fn percent(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x| (0.0..=10_000.0).contains(x));
    number.ok_or_else(|| "a number from 0 to 10000".to_owned())
}

/// The JSON object.
#[derive(Serialize)]
struct Answer<'a> {
    #[serde(flatten)]
    report: &'a Report,
    same_answer: bool,
    comparison: Option<&'a Comparison>,
    regressions: usize,
}

/// Measures, prints, saves, compares.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    save::check(args.save.as_deref(), out, &["json"])?;
    save::check(args.html.as_deref(), out, &["html", "htm"])?;
    let before = args.baseline.as_deref().map(read_baseline).transpose()?;
    let loaded = args.scene.load(out)?;
    let course = Course::new(args, &loaded)?;
    let chosen = chosen(args)?;
    out.note("looking at the machine ...");
    let machine = Machine::seen();
    let probe = Probe::measure(&machine);
    let mut report = course.measure(&chosen, machine, probe)?;
    let compare = |report: &Report| {
        let compare = |(file, before): &(&str, Report)| {
            baseline::compare(report, before, file, args.tolerance / 100.0)
        };
        before.as_ref().map(compare).transpose()
    };
    let mut comparison = compare(&report)?;
    let suspects = suspects(comparison.as_ref(), &chosen);
    if !suspects.is_empty() && report.complete {
        out.note("a second look at what got worse ...");
        let again = course.measure(&suspects, report.machine.clone(), probe)?;
        keep_better(&mut report, again);
        comparison = compare(&report)?;
    }
    finish(args, out, &report, comparison.as_ref())
}

/// Prints and saves; the exit code says whether all is well.
fn finish(
    args: &Args,
    out: &Output,
    report: &Report,
    comparison: Option<&Comparison>,
) -> anyhow::Result<Exit> {
    let same_answer = report.rows.iter().all(has_same_answer);
    let regressions = comparison.map_or(0, |comparison| comparison.regressions().len());
    if let Some(name) = &args.save {
        let text = serde_json::to_string_pretty(report)?;
        save::save(name, |file| write_text(file, &text))?;
    }
    if let Some(name) = &args.html {
        let text = page(report, comparison)?;
        save::save(name, |file| write_text(file, &text))?;
    }
    if out.is_json() {
        out.json(&Answer {
            report,
            same_answer,
            comparison,
            regressions,
        })?;
    } else {
        out.text(table::text(report, comparison))?;
    }
    Ok(match report.complete {
        false => Exit::Interrupted,
        true => Exit::from_difference(!same_answer || regressions > 0),
    })
}

fn read_baseline(name: &str) -> anyhow::Result<(&str, Report)> {
    let bytes = args::read_file(Path::new(name))?;
    Ok((
        name,
        baseline::read(name, &String::from_utf8_lossy(&bytes))?,
    ))
}

fn page(report: &Report, comparison: Option<&Comparison>) -> Result<String, MeasureError> {
    let mut sections: Vec<_> = comparison.map(html::comparison).into_iter().collect();
    sections.extend(html::sections(report)?);
    let mut lead = report.notices();
    lead.push(table::heading(report));
    lead.extend(report.verdict());
    lead.extend(report.busy());
    lead.push(format!("{}. {}", report.date, report.machine.line()));
    Ok(html::page(&Page {
        title: format!("boxwood bench {}", report.scene.name),
        lead,
        sections,
    }))
}

/// The contenders that were asked for.
fn chosen(args: &Args) -> anyhow::Result<Vec<Contender>> {
    let all = contenders(args.all || !args.only.is_empty());
    if args.only.is_empty() {
        return Ok(all);
    }
    let matches = |name: &str, words: &str| {
        let has = |word| name.split(' ').any(|part| part == word);
        let mut words = words.split_whitespace().peekable();
        words.peek().is_some() && words.all(has)
    };
    if let Some(nobody) = args
        .only
        .iter()
        .find(|words| !all.iter().any(|c| matches(&c.name(), words)))
    {
        let cause = format!("--only {nobody}: no contender has these words");
        return Err(Trouble::usage(
            cause,
            "`boxwood list` has the structures, builders and volumes",
        )
        .into());
    }
    let is_asked_for = |c: &Contender| args.only.iter().any(|words| matches(&c.name(), words));
    Ok(all.into_iter().filter(is_asked_for).collect())
}

/// Those that seem to have got worse.
fn suspects(comparison: Option<&Comparison>, all: &[Contender]) -> Vec<Contender> {
    let worse = comparison.map_or(Vec::new(), Comparison::regressions);
    let is_worse = |c: &&Contender| worse.iter().any(|change| change.contender == c.name());
    all.iter().filter(is_worse).cloned().collect()
}

/// A figure that was disturbed once is rarely disturbed twice.
fn keep_better(report: &mut Report, again: Report) {
    for new in again.rows {
        let Some(row) = report.rows.iter_mut().find(|row| row.name == new.name) else {
            continue;
        };
        row.build_ms = row.build_ms.min(new.build_ms);
        for cell in &mut row.cells {
            let other = new.cell(&cell.set, cell.mode, cell.threads);
            if let Some(other) = other.filter(|other| other.mrays > cell.mrays) {
                *cell = other.clone();
            }
        }
    }
}

/// Whether all of a row's answers were right in every bit.
fn has_same_answer(row: &Row) -> bool {
    row.agreement.is_none_or(|a| a.same_bits == a.rays)
}

fn write_text(file: &mut dyn Write, text: &str) -> Result<(), RenderError> {
    writeln!(file, "{}", text.trim_end()).map_err(|error| RenderError::Encode {
        format: "text",
        cause: error.to_string(),
    })
}
