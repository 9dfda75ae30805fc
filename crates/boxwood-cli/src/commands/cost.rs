//! `boxwood cost`: ray tracing is expensive. How expensive, and what does a structure save?

use boxwood::{
    Counts, Ray, Scene, Triangle, VOLUMES,
    lecture::{baldwin_weber, cramer, moller_trumbore, price::Price},
};
use boxwood_render::View;
use serde::Serialize;

use crate::{
    args::{self, CameraArgs, Loaded, SceneArgs},
    contest::{Built, contenders},
    measure::Peak,
    output::{Exit, Output, Table, grouped, mebibytes, short},
};

/// What a frame costs: the lecture's arithmetic, and with a scene, what each structure really executes.
///
/// Without FILE: pixels x triangles x operations per test, and how long that takes at 100 and 200 GFLOPS and at the peak
/// of this machine. With FILE: the same for its triangles, beside the tests, operations and bytes that each structure
/// spends on the same frame, one ray per pixel.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  boxwood cost
  boxwood cost --triangles 114
  boxwood cost builtin:bush --size 320x180")]
pub(crate) struct Args {
    /// Scene to trace; without it there is only arithmetic.
    #[arg(value_name = "FILE", value_parser = args::file_name)]
    file: Option<String>,
    /// Triangles of the arithmetic. [default: 40000, or those of FILE]
    #[arg(long, value_name = "N", conflicts_with = "file", allow_negative_numbers = true, value_parser = args::whole::<u64>)]
    triangles: Option<u64>,
    /// Count for every structure, builder and volume.
    #[arg(long)]
    all: bool,
    #[command(flatten)]
    camera: CameraArgs,
}

/// The slides' second number.
const FORTY_THOUSAND: u64 = 40_000;
/// The slides' machines, in 10^9 operations a second.
const SLIDE_SPEEDS: [f64; 2] = [100.0, 200.0];

/// The JSON object.
#[derive(Serialize)]
struct Answer {
    width: u64,
    height: u64,
    pixels: u64,
    triangles: u64,
    flops_per_test: u64,
    brute_force_flops: u64,
    peak: PeakAnswer,
    frames: Vec<Frame>,
    tests: Vec<TestPrice>,
    #[serde(skip_serializing_if = "Option::is_none")]
    scene: Option<SceneAnswer>,
}

#[derive(Serialize)]
struct PeakAnswer {
    gflops_one_thread: f64,
    gflops: f64,
    threads: usize,
    how: &'static str,
}

/// One frame by brute force.
#[derive(Serialize)]
struct Frame {
    machine: &'static str,
    gflops: f64,
    seconds_per_frame: f64,
    frames_per_second: f64,
}

/// Operations of one test, exit by exit.
#[derive(Serialize)]
struct TestPrice {
    name: String,
    flops: Vec<u32>,
    about: &'static str,
}

#[derive(Serialize)]
struct SceneAnswer {
    file: String,
    hits: u64,
    structures: Vec<Row>,
}

/// One structure's frame.
#[derive(Serialize)]
struct Row {
    name: String,
    /// False for brute force, which is multiplied out, not run.
    counted: bool,
    build_ms: Option<f64>,
    bytes_held: Option<usize>,
    rays: u64,
    nodes: u64,
    box_tests: u64,
    primitive_tests: u64,
    flops: u64,
    bytes: u64,
    /// Operations of brute force by the same exact test, over these.
    times_less: f64,
}

/// Calculates, and counts if there is a scene.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let scene = args
        .file
        .clone()
        .map(|file| SceneArgs { file }.load(out))
        .transpose()?;
    let triangles = match &scene {
        Some(loaded) => loaded.mesh.indices.len() as u64,
        None => args.triangles.unwrap_or(FORTY_THOUSAND),
    };
    let [width, height] = args.camera.size.map(u64::from);
    let price = Price {
        width,
        height,
        ..Price::of_720p(triangles)
    };
    let peak = Peak::measure();
    let answer = Answer {
        width,
        height,
        pixels: price.pixels(),
        triangles,
        flops_per_test: price.flops_per_test,
        brute_force_flops: price.flops(),
        frames: frames(&price, &peak),
        peak: PeakAnswer {
            gflops_one_thread: peak.one_thread,
            gflops: peak.all_threads,
            threads: peak.threads,
            how: Peak::HOW,
        },
        tests: tests(),
        scene: scene.map(|loaded| count(args, &loaded, out)).transpose()?,
    };
    if out.is_json() {
        out.json(&answer)?;
    } else {
        out.text(text(&answer))?;
    }
    Ok(Exit::Ok)
}

fn frames(price: &Price, peak: &Peak) -> Vec<Frame> {
    let speeds = [
        ("a machine of the slides", SLIDE_SPEEDS[0]),
        ("a machine of the slides", SLIDE_SPEEDS[1]),
        ("this machine", peak.all_threads),
    ];
    let frame = |(machine, gflops)| {
        let seconds_per_frame = price.seconds_at(gflops);
        Frame {
            machine,
            gflops,
            seconds_per_frame,
            frames_per_second: 1.0 / seconds_per_frame,
        }
    };
    speeds.into_iter().map(frame).collect()
}

fn tests() -> Vec<TestPrice> {
    let price = |name: &str, flops: &[u32], about| TestPrice {
        name: name.to_owned(),
        flops: flops.to_vec(),
        about,
    };
    let exits = "executed, at each of its exits";
    let mut tests = vec![
        price(
            "Cramer's rule, the slides' count",
            &[cramer::SLIDE_FLOPS],
            "up to the exit on beta",
        ),
        price("Cramer's rule", &cramer::FLOPS, exits),
        price("Moeller-Trumbore", &moller_trumbore::FLOPS, exits),
        price("precomputed (Baldwin-Weber)", &baldwin_weber::FLOPS, exits),
        price(
            "exact test, which all structures use",
            &[Triangle::FLOPS_MISS, Triangle::FLOPS_HIT],
            "a miss, a hit",
        ),
    ];
    tests.extend(VOLUMES.iter().map(|v| {
        price(
            &format!("bounding volume: {}", v.name),
            &[v.flops],
            "always",
        )
    }));
    tests
}

fn count(args: &Args, loaded: &Loaded, out: &Output) -> anyhow::Result<SceneAnswer> {
    let mut rows = Vec::new();
    let mut hits = 0;
    let mut view: Option<View> = None;
    for contender in contenders(args.all).into_iter().filter(|c| !c.is_list()) {
        out.note(format_args!("{} ...", contender.name()));
        let Built { name, scene, time } = contender.build(&loaded.mesh)?;
        let view = match &view {
            Some(view) => view,
            None => view.insert(args.camera.view(&scene, loaded)?),
        };
        let counts;
        (counts, hits) = trace(&scene, view);
        if rows.is_empty() {
            rows.push(brute_force(&scene, counts.rays, hits));
        }
        rows.push(Row {
            name,
            counted: true,
            build_ms: Some(time.as_secs_f64() * 1e3),
            bytes_held: Some(scene.stats().bytes),
            rays: counts.rays,
            nodes: counts.nodes,
            box_tests: counts.boxes,
            primitive_tests: counts.prims,
            flops: counts.flops,
            bytes: counts.bytes,
            times_less: rows[0].flops as f64 / counts.flops.max(1) as f64,
        });
    }
    Ok(SceneAnswer {
        file: loaded.name.clone(),
        hits,
        structures: rows,
    })
}

/// Traces the frame, one ray per pixel, some rows at a time so that it fits any memory.
fn trace(scene: &Scene, view: &View) -> (Counts, u64) {
    const ROWS: usize = 64;
    let (mut counts, mut hit_count) = (Counts::default(), 0);
    let rows: Vec<u32> = (0..view.height()).collect();
    for rows in rows.chunks(ROWS) {
        let row = |y: &u32| {
            let y = *y;
            (0..view.width()).map(move |x| view.pixel_ray(x, y))
        };
        let rays: Vec<Ray> = rows.iter().flat_map(row).collect();
        let mut hits = vec![None; rays.len()];
        counts += scene.closest_hits_counted(&rays, &mut hits);
        hit_count += hits.iter().flatten().count() as u64;
    }
    (counts, hit_count)
}

/// Multiplied out: every ray against every triangle, of which one in the end is hit. (Those hit behind it would add some
/// operations more.)
fn brute_force(scene: &Scene, rays: u64, hits: u64) -> Row {
    let tests = rays.saturating_mul((scene.len() - scene.skipped()) as u64);
    let more = u64::from(Triangle::FLOPS_HIT - Triangle::FLOPS_MISS);
    Row {
        name: "list".to_owned(),
        counted: false,
        build_ms: None,
        bytes_held: None,
        rays,
        nodes: 0,
        box_tests: 0,
        primitive_tests: tests,
        flops: tests
            .saturating_mul(Triangle::FLOPS_MISS.into())
            .saturating_add(hits * more),
        bytes: tests.saturating_mul(size_of::<Triangle>() as u64),
        times_less: 1.0,
    }
}

fn text(answer: &Answer) -> String {
    let mut lines = vec![
        "Ray tracing is expensive. How expensive?".to_owned(),
        String::new(),
        format!(
            "{} x {} = {} pixels, one ray each",
            answer.width,
            answer.height,
            grouped(answer.pixels)
        ),
    ];
    let mut counts = vec![answer.triangles];
    if answer.scene.is_none() && answer.triangles == FORTY_THOUSAND {
        counts.insert(0, 114);
    }
    for triangles in counts {
        let price = Price {
            width: answer.width,
            height: answer.height,
            ..Price::of_720p(triangles)
        };
        lines.push(format!(
            "x {} triangles x {} flop = {} flop per frame",
            grouped(triangles),
            price.flops_per_test,
            grouped(price.flops())
        ));
    }
    lines.push(format!(
        "\nThe frame of {} triangles by brute force:\n",
        grouped(answer.triangles)
    ));
    lines.push(frame_table(answer).to_string());
    lines.push(format!(
        "\n(this machine: {} threads; {})",
        answer.peak.threads, answer.peak.how
    ));
    lines.push("\nOperations of one test:\n".to_owned());
    lines.push(test_table(answer).to_string());
    if let Some(scene) = &answer.scene {
        lines.push(scene_text(scene));
    }
    lines.join("\n")
}

fn frame_table(answer: &Answer) -> Table {
    let mut table = Table::new(["at", "s/frame", "frames/s"]);
    for frame in &answer.frames {
        let at = format!("{} GFLOPS ({})", short(frame.gflops), frame.machine);
        table.row([
            at,
            short(frame.seconds_per_frame),
            short(frame.frames_per_second),
        ]);
    }
    table
}

fn test_table(answer: &Answer) -> Table {
    let mut table = Table::new(["test", "flop", "counted"]);
    for test in &answer.tests {
        let flops: Vec<String> = test.flops.iter().map(u32::to_string).collect();
        table.row([test.name.clone(), flops.join(" / "), test.about.to_owned()]);
    }
    table
}

fn scene_text(scene: &SceneAnswer) -> String {
    let titles = [
        "structure",
        "build ms",
        "MiB",
        "box tests",
        "triangle tests",
        "flop",
        "MB read",
        "flop/ray",
        "bytes/ray",
        "times less",
    ];
    let mut table = Table::new(titles);
    for row in &scene.structures {
        let per_ray = |sum: u64| short(sum as f64 / row.rays.max(1) as f64);
        table.row([
            if row.counted {
                row.name.clone()
            } else {
                format!("{} (multiplied out)", row.name)
            },
            row.build_ms.map_or_else(|| "-".to_owned(), short),
            row.bytes_held.map_or_else(|| "-".to_owned(), mebibytes),
            grouped(row.box_tests),
            grouped(row.primitive_tests),
            grouped(row.flops),
            short(row.bytes as f64 / 1e6),
            per_ray(row.flops),
            per_ray(row.bytes),
            short(row.times_less),
        ]);
    }
    let rays = scene.structures.first().map_or(0, |row| row.rays);
    format!(
        "\nThe same frame of {}, {} rays, {} hits, as executed by the exact test:\n\n{table}",
        scene.file,
        grouped(rays),
        grouped(scene.hits)
    )
}
