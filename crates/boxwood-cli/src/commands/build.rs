//! `boxwood build`: how a structure comes to be, step by step.

use boxwood_render::RenderError;
use boxwood_trace::BuildTrace;
use serde::Serialize;

use crate::{
    args::{SceneArgs, StructureArgs, whole},
    output::{Exit, Output, short},
    save,
};

/// Build a structure and tell how: each set of primitives, the planes that were weighed, the chosen one and why.
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
  boxwood build builtin:cornell --builder morton --trace build.json --steps 0")]
pub(crate) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Print the steps; with a name, write them to that file as JSON.
    #[arg(long, value_name = "FILE.json", num_args = 0..=1, default_missing_value = "")]
    trace: Option<String>,
    /// Most steps to tell, those nearest to the root; 0 is all, which is much for large scenes.
    #[arg(long, value_name = "N", default_value_t = 200, allow_negative_numbers = true, value_parser = whole::<usize>)]
    steps: usize,
    #[command(flatten)]
    structure: StructureArgs,
}

/// The JSON object.
#[derive(Serialize)]
struct Answer {
    file: String,
    triangles: usize,
    build_ms: f64,
    #[serde(flatten)]
    trace: BuildTrace,
}

/// Builds, tells and prints.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let file = args.trace.as_deref().filter(|name| !name.is_empty());
    save::check(file, out, &["json"])?;
    let loaded = args.scene.load(out)?;
    let (scene, time) = args.structure.build(&loaded.mesh)?;
    let limit = match (args.steps, out.is_json() || args.trace.is_some()) {
        (0, true) => usize::MAX,
        (limit, true) => limit,
        // The totals alone.
        (_, false) => 0,
    };
    let answer = Answer {
        file: loaded.name.clone(),
        triangles: scene.len(),
        build_ms: time.as_secs_f64() * 1e3,
        trace: boxwood_trace::build(&scene, limit)?,
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
    } else {
        out.text(text(&answer, args.trace.is_some() && file.is_none()))?;
    }
    Ok(Exit::Ok)
}

fn text(answer: &Answer, with_steps: bool) -> String {
    let Answer {
        file,
        build_ms,
        trace,
        ..
    } = answer;
    let told = match with_steps {
        true => trace.text(),
        false => format!("{}\n{}", trace.summary(), trace.outcome()),
    };
    let rest = match with_steps && trace.steps.len() < trace.steps_total {
        true => " (--steps 0 tells all steps)",
        false => "",
    };
    format!("{file}: {told}\nbuilt in {} ms{rest}", short(*build_ms))
}
