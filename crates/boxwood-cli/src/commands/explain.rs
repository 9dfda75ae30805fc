//! `boxwood explain`: how one ray finds its answer, step by step.

use boxwood::{Counts, Hit, Ray, Scene, Walk};
use clap::ArgGroup;
use serde::Serialize;

use crate::{
    args::{CameraArgs, Loaded, SceneArgs, StructureArgs, numbers, whole},
    narrator::{Line, Narrator},
    output::{Exit, Output, Trouble, grouped},
};

/// Explain the walk of one ray: every box, cell and triangle that is tried, with its numbers, and why it is skipped.
///
/// Indented by depth; siblings are tested together, and `in N` names the box they stand in. A triangle shows its three edge
/// functions: all of one sign means that the line passes through it, and a zero is settled by a rule of ties, whose sign
/// then stands beside it. `t a .. b` is where the ray is inside; it misses where a is above b.
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
    structure: String,
    triangles: usize,
    ray: RayAnswer,
    steps: Vec<Line>,
    hit: Option<HitAnswer>,
    counts: CountsAnswer,
}

/// Numbers that are not finite are null.
#[derive(Serialize)]
struct RayAnswer {
    origin: [f32; 3],
    dir: [f32; 3],
    t_min: f32,
    t_max: f32,
}

#[derive(Serialize)]
struct HitAnswer {
    t: f32,
    u: f32,
    v: f32,
    prim: u32,
}

#[derive(Serialize)]
struct CountsAnswer {
    nodes: u64,
    box_tests: u64,
    primitive_tests: u64,
    flops: u64,
    bytes: u64,
}

/// Walks and prints.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let loaded = args.scene.load(out)?;
    let (scene, _) = args.structure.build(&loaded.mesh)?;
    let ray = ray(args, &scene, &loaded)?;
    let Walk { steps, hit, counts } = scene.explain(&ray);
    let Counts {
        nodes,
        boxes,
        prims,
        flops,
        bytes,
        ..
    } = counts;
    let answer = Answer {
        file: loaded.name.clone(),
        structure: args.structure.label(),
        triangles: scene.len(),
        ray: RayAnswer {
            origin: ray.origin,
            dir: ray.dir,
            t_min: ray.t_min,
            t_max: ray.t_max,
        },
        steps: Narrator::new(&scene, &ray).narrate(&steps),
        hit: hit.map(|Hit { t, u, v, prim, .. }| HitAnswer { t, u, v, prim }),
        counts: CountsAnswer {
            nodes,
            box_tests: boxes,
            primitive_tests: prims,
            flops,
            bytes,
        },
    };
    if out.is_json() {
        out.json(&answer)?;
    } else {
        out.text(text(&answer, args.lines, ray.is_valid()))?;
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

fn text(answer: &Answer, limit: usize, is_valid: bool) -> String {
    let RayAnswer {
        origin,
        dir,
        t_min,
        t_max,
    } = &answer.ray;
    let mut lines = vec![
        format!(
            "{}: {}, {} triangles",
            answer.file,
            answer.structure,
            grouped(answer.triangles as u64)
        ),
        format!(
            "ray from {} along {}, t in {t_min} .. {t_max}",
            point(*origin),
            point(*dir)
        ),
        String::new(),
    ];
    if !is_valid {
        lines.push(
            "this is no ray (no direction, or numbers out of range): it hits nothing\n".to_owned(),
        );
    }
    let shown = if limit == 0 {
        answer.steps.len()
    } else {
        limit
    };
    lines.extend(
        answer
            .steps
            .iter()
            .take(shown)
            .map(|line| format!("{}{}", "  ".repeat(line.depth as usize), line.step)),
    );
    if answer.steps.len() > shown {
        let rest = grouped((answer.steps.len() - shown) as u64);
        lines.push(format!("... and {rest} steps more (--lines 0 prints all)"));
    }
    lines.push(String::new());
    lines.push(match &answer.hit {
        Some(HitAnswer { t, u, v, prim }) => {
            format!("hit: triangle {prim} at t = {t}, u = {u}, v = {v}")
        }
        None => "no hit".to_owned(),
    });
    let CountsAnswer {
        nodes,
        box_tests,
        primitive_tests,
        flops,
        bytes,
    } = &answer.counts;
    lines.push(format!(
        "{} box tests, {} boxes or cells entered; {} triangle tests; {} flop, {} bytes read",
        grouped(*box_tests),
        grouped(*nodes),
        grouped(*primitive_tests),
        grouped(*flops),
        grouped(*bytes)
    ));
    lines.join("\n")
}

fn point(p: [f32; 3]) -> String {
    format!("({})", p.map(|x| x.to_string()).join(", "))
}
