//! `boxwood build`: how a structure comes to be, step by step, or saved.

mod saved;

use boxwood_render::RenderError;
use boxwood_trace::BuildTrace;
use serde::Serialize;

use crate::{
    args::{SceneArgs, StructureArgs, whole},
    output::{Exit, Output, counted, short},
    save,
};
use saved::Saved;

/// Build a structure and tell how: each set of primitives, the planes that were weighed, the chosen one and why. Or save it with -o,
/// to be opened without a build.
///
/// Costs count in visits of a node. `at 278 (18 | 18)` is a plane with 18 primitives on either side; triangles go by the
/// centres of their boxes. The builder `morton` merges neighbours along a curve instead, some builders move nodes in the
/// end, and a grid tries resolutions. The steps are those of the real build: the tree is the same bit for bit.
/// docs/trace.md describes the JSON.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  boxwood build builtin:bush
  boxwood build builtin:cornell --structure bvh2 --builder sweep --trace
  boxwood build builtin:cornell --builder morton --trace build.json --steps 0
  boxwood build builtin:bush --preset high -o bush.bwx")]
pub(crate) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Print the steps; with a name, write them to that file as JSON.
    #[arg(long, value_name = "FILE.json", num_args = 0..=1, default_missing_value = "")]
    trace: Option<String>,
    /// Most steps to tell, those nearest to the root; 0 is all, which is much for large scenes.
    #[arg(long, value_name = "N", default_value_t = 200, allow_negative_numbers = true, value_parser = whole::<usize>)]
    steps: usize,
    /// Save the scene as a .bwx file for Scene.open of Rust and Python: triangles in the structure `wide`, without materials. Every
    /// command takes it for a file; those that build do so again.
    #[arg(short, long, value_name = "BWX")]
    output: Option<String>,
    #[command(flatten)]
    structure: StructureArgs,
}

/// The JSON object.
#[derive(Serialize)]
struct Answer {
    file: String,
    triangles: usize,
    build_ms: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    saved: Option<Saved>,
    #[serde(flatten)]
    trace: Option<BuildTrace>,
}

/// Builds, tells and prints.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let file = args.trace.as_deref().filter(|name| !name.is_empty());
    save::check(file, out, &["json"])?;
    save::check(args.output.as_deref(), out, &["bwx"])?;
    let loaded = args.scene.load(out)?;
    let (scene, time) = args.structure.build(&loaded.mesh)?;
    let limit = match (args.steps, out.is_json() || args.trace.is_some()) {
        (0, true) => usize::MAX,
        (limit, true) => limit,
        // The totals alone.
        (_, false) => 0,
    };
    // It builds again, which who saves did not ask for.
    let is_told = args.output.is_none() || out.is_json() || args.trace.is_some();
    let trace = is_told.then(|| boxwood_trace::build(&scene, limit));
    let triangles = scene.len();
    let saved = args.output.as_deref();
    let answer = Answer {
        file: loaded.name.clone(),
        triangles,
        build_ms: time.as_secs_f64() * 1e3,
        saved: saved
            .map(|name| saved::save(scene, &loaded.mesh, name))
            .transpose()?,
        trace: trace.transpose()?,
    };
    if let Some(name) = file {
        let json = serde_json::to_vec(&answer)?;
        save::save(name, |to| {
            to.write_all(&json).map_err(|error| RenderError::Encode {
                format: "JSON",
                cause: error.to_string(),
            })
        })?;
    }
    if out.is_json() {
        out.json(&answer)?;
    } else if args.output.as_deref() == Some("-") {
        out.note(text(&answer, false));
    } else {
        out.text(text(&answer, args.trace.is_some() && file.is_none()))?;
    }
    Ok(Exit::Ok)
}

fn text(answer: &Answer, with_steps: bool) -> String {
    let (file, ms) = (&answer.file, short(answer.build_ms));
    let mut rest = "";
    let mut lines = Vec::new();
    match &answer.trace {
        None => lines.push(format!("{file}: {}", counted(answer.triangles, "triangle"))),
        Some(trace) if with_steps => {
            if trace.steps.len() < trace.steps_total {
                rest = " (--steps 0 tells all steps)";
            }
            lines.push(format!("{file}: {}", trace.text()));
        }
        Some(trace) => lines.push(format!("{file}: {}\n{}", trace.summary(), trace.outcome())),
    }
    lines.push(format!("built in {ms} ms{rest}"));
    lines.extend(answer.saved.as_ref().map(Saved::text));
    lines.join("\n")
}
