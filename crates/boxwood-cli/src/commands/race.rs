//! `boxwood race`: every structure on the same rays.

mod frames;

use std::time::Duration;

use boxwood::{Counts, Hit, Ray, Scene};
use boxwood_render::View;
use rayon::prelude::*;
use serde::Serialize;

use crate::{
    args::{CameraArgs, Loaded, SceneArgs},
    contest::{Built, bounced_rays, camera_rays, contenders, random_rays, usual_contenders},
    measure::{Clock, Task, interleaved, nanoseconds, on_one_thread},
    output::{Exit, Output, Table, counted, grouped, mebibytes, short},
};

/// Race the structures: the same rays, the same answer, not the same time.
///
/// Some rays go through pixels of the picture: a third of --rays, or every pixel. As many are random lines through the
/// scene, and from each place that a pixel shows one starts in a random direction (as shadows and bounces do). Each
/// structure answers all of them for the closest hit; building time, memory, tests per ray and time per ray are measured:
/// one ray per call, and in batches of thousands. The structures take turns, and the times are medians: on one thread of
/// the processor's time, so that a busy machine does not show. The answers are those of the timed turns themselves. Brute
/// force gets as many rays as it can do in a moment: its row is an estimate, marked `est.`
///
/// With --frames they draw pictures instead: a batch of camera rays for each tile, a shadow ray from each pixel that hits,
/// flat shading, all threads. Each structure has its default options; brute force stays out.
///
/// Exit code 1 if two structures do not give the same bits.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  boxwood race builtin:stadium --rays 3000
  boxwood race builtin:bush --frames
  boxwood race builtin:cornell --rays 20000 --all --json")]
pub(crate) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// How many rays, at most; up to 30 million.
    #[arg(long, value_name = "N", default_value_t = 300_000, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(100..=30_000_000))]
    rays: u32,
    /// Race every structure, builder and volume.
    #[arg(long)]
    all: bool,
    /// Race by frames per second.
    #[arg(long)]
    frames: bool,
    #[command(flatten)]
    camera: CameraArgs,
}

/// Turns that each structure has on one thread, each with rays of its own.
const TURNS: usize = 16;
/// Rays of all those turns together.
const ONE_THREAD_RAYS: usize = 1 << 16;
/// Turns that each structure has on all threads, each with all the rays.
const LAPS: usize = 5;
/// Primitive tests that brute force may do in a turn.
const LIST_TESTS: usize = 20_000_000;

/// The JSON object.
#[derive(Serialize)]
struct Answer {
    file: String,
    triangles: usize,
    rays: usize,
    camera_rays: usize,
    bounced_rays: usize,
    random_rays: usize,
    hits: usize,
    threads: usize,
    same_answer: bool,
    structures: Vec<Row>,
}

/// One structure.
#[derive(Serialize)]
struct Row {
    name: String,
    /// True if only a sample of the rays was asked.
    estimated: bool,
    /// Rays that all numbers are from.
    rays: usize,
    build_ms: f64,
    bytes: usize,
    nodes_per_ray: f64,
    box_tests_per_ray: f64,
    primitive_tests_per_ray: f64,
    flops_per_ray: f64,
    bytes_per_ray: f64,
    /// On one thread, in batches.
    ns_per_ray: f64,
    /// On one thread, one ray per call.
    single_ns_per_ray: f64,
    /// On all threads, in batches; 10^6 rays a second.
    mrays_per_second: f64,
    /// Bit for bit, on its rays.
    same_answer: bool,
}

/// Races and prints the table.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let loaded = args.scene.load(out)?;
    let mut runners = Vec::new();
    let mut contenders = match (args.frames, args.all) {
        (true, false) => usual_contenders(),
        (_, all) => contenders(all),
    };
    contenders.retain(|contender| !(args.frames && contender.is_list()));
    for contender in contenders {
        out.note(format_args!("building {}", contender.name()));
        runners.push(Runner {
            is_list: contender.is_list(),
            built: contender.build(&loaded.mesh)?,
        });
    }
    let fastest = runners
        .iter()
        .find(|r| r.built.scene.structure() == boxwood::Structure::DEFAULT);
    let judge = &fastest.unwrap_or(&runners[0]).built.scene;
    let view = args.camera.view(judge, &loaded)?;
    if args.frames {
        return race_by_frames(&loaded, &runners, &view, out);
    }
    let course = Course::new(judge, &view, args.rays as usize);
    let answer = race(&loaded, &runners, &course, out)?;
    if out.is_json() {
        out.json(&answer)?;
    } else {
        out.text(text(&answer))?;
    }
    Ok(Exit::from_difference(!answer.same_answer))
}

fn race_by_frames(
    loaded: &Loaded,
    runners: &[Runner],
    view: &View,
    out: &Output,
) -> anyhow::Result<Exit> {
    out.note("drawing ...");
    let built: Vec<&Built> = runners.iter().map(|runner| &runner.built).collect();
    let answer = frames::race(loaded, &built, view);
    if out.is_json() {
        out.json(&answer)?;
    } else {
        out.text(frames::text(&answer))?;
    }
    Ok(Exit::from_difference(!answer.same_picture))
}

struct Runner {
    built: Built,
    is_list: bool,
}

/// The rays, well mixed, and the right answers.
struct Course {
    rays: Vec<Ray>,
    /// From the camera, bounced, random.
    kinds: [usize; 3],
    answers: Vec<Option<Hit>>,
}

impl Course {
    fn new(scene: &Scene, view: &View, count: usize) -> Self {
        let third = count / 3;
        let camera = camera_rays(view, third);
        let bounced = bounced_rays(scene, &camera);
        let random = random_rays(scene, camera.len());
        let kinds = [camera.len(), bounced.len(), random.len()];
        // In turn, so that the first rays are a fair sample of all.
        let longest = kinds.into_iter().max().unwrap_or(0);
        let of = |i: usize| {
            [camera.get(i), bounced.get(i), random.get(i)]
                .into_iter()
                .flatten()
                .copied()
        };
        let rays: Vec<Ray> = (0..longest).flat_map(of).collect();
        let mut answers = vec![None; rays.len()];
        scene.closest_hits(&rays, &mut answers);
        Self {
            rays,
            kinds,
            answers,
        }
    }
}

impl Runner {
    /// How many of the first rays it is asked about.
    fn rays(&self, course: &Course) -> usize {
        let all = course.rays.len();
        if self.is_list {
            (LIST_TESTS / self.built.scene.len().max(1))
                .clamp(8, all.max(8))
                .min(all)
        } else {
            all
        }
    }
}

fn race(
    loaded: &Loaded,
    runners: &[Runner],
    course: &Course,
    out: &Output,
) -> anyhow::Result<Answer> {
    out.note("racing ...");
    let slow = on_one_thread(|| one_thread(runners, course))?;
    let fast = all_threads(runners, course);
    let laps = slow.into_iter().zip(fast);
    let structures: Vec<Row> = runners
        .iter()
        .zip(laps)
        .map(|(runner, ([batch, single], fast))| row(runner, course, [batch, single, fast]))
        .collect();
    Ok(Answer {
        file: loaded.name.clone(),
        triangles: loaded.mesh.indices.len(),
        rays: course.rays.len(),
        camera_rays: course.kinds[0],
        bounced_rays: course.kinds[1],
        random_rays: course.kinds[2],
        hits: course.answers.iter().flatten().count(),
        threads: rayon::current_num_threads(),
        same_answer: structures.iter().all(|row| row.same_answer),
        structures,
    })
}

fn row(runner: &Runner, course: &Course, laps: [Lap; 3]) -> Row {
    let Built { name, scene, time } = &runner.built;
    let rays = runner.rays(course);
    let work = count(runner, course);
    let [batch, single, fast] = laps;
    let per_ray = |sum: u64| sum as f64 / rays.max(1) as f64;
    Row {
        name: name.clone(),
        estimated: rays < course.rays.len(),
        rays,
        build_ms: time.as_secs_f64() * 1e3,
        bytes: scene.stats().bytes,
        nodes_per_ray: per_ray(work.nodes),
        box_tests_per_ray: per_ray(work.boxes),
        primitive_tests_per_ray: per_ray(work.prims),
        flops_per_ray: per_ray(work.flops),
        bytes_per_ray: per_ray(work.bytes),
        ns_per_ray: nanoseconds(batch.time, batch.rays),
        single_ns_per_ray: nanoseconds(single.time, single.rays),
        mrays_per_second: 1e3 / nanoseconds(fast.time, fast.rays),
        same_answer: laps.iter().all(|lap| lap.same_answer),
    }
}

/// The work, by the watched walk: what it answers is not looked at, as it is not what was timed.
fn count(runner: &Runner, course: &Course) -> Counts {
    let rays = &course.rays[..runner.rays(course)];
    let mut hits = vec![None; rays.len()];
    runner.built.scene.closest_hits_counted(rays, &mut hits)
}

/// Whether two lists of answers are the same in every bit.
fn same(hits: &[Option<Hit>], answers: &[Option<Hit>]) -> bool {
    let bits = |hit: &Option<Hit>| {
        hit.map(|h| ([h.t, h.u, h.v].map(f32::to_bits), [h.prim, h.geom, h.inst]))
    };
    hits.iter().map(bits).eq(answers.iter().map(bits))
}

/// The time of a turn, its rays, and whether the answers of all turns were right.
#[derive(Clone, Copy)]
struct Lap {
    time: Duration,
    rays: usize,
    same_answer: bool,
}

/// As a batch, and one ray per call. In each turn the structures are asked about the same rays, brute force about the first
/// of those; first all of them for batches, then all for single rays, so that neither finds its memory in the cache.
fn one_thread(runners: &[Runner], course: &Course) -> Vec<[Lap; 2]> {
    let turn_of = |runner: &Runner| (runner.rays(course).min(ONE_THREAD_RAYS) / TURNS).max(1);
    let stride = course.rays.len() / TURNS;
    let part = |round: usize, turn: usize| round * stride..round * stride + turn;
    // Of every turn, to be compared when the race is over.
    let no_hits = |runner: &Runner| vec![None; turn_of(runner) * TURNS];
    let mut answers: [Vec<Vec<Option<Hit>>>; 2] =
        [(); 2].map(|()| runners.iter().map(no_hits).collect());
    let [batch, single] = &mut answers;
    let mut tasks: Vec<Task<'_>> = Vec::new();
    for (runner, hits) in runners.iter().zip(batch) {
        let turn = turn_of(runner);
        tasks.push(Box::new(move |round| {
            let (rays, hits) = (
                &course.rays[part(round, turn)],
                &mut hits[round * turn..][..turn],
            );
            runner.built.scene.closest_hits(rays, hits);
        }));
    }
    for (runner, hits) in runners.iter().zip(single) {
        let turn = turn_of(runner);
        tasks.push(Box::new(move |round| {
            let (rays, hits) = (
                &course.rays[part(round, turn)],
                &mut hits[round * turn..][..turn],
            );
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = runner.built.scene.closest_hit(ray);
            }
        }));
    }
    let times = interleaved(Clock::Thread, TURNS, &mut tasks);
    drop(tasks);
    let lap = |way: usize, number: usize| {
        let turn = turn_of(&runners[number]);
        let turns = answers[way][number].chunks(turn).enumerate();
        Lap {
            time: times[way * runners.len() + number],
            rays: turn,
            same_answer: turns.fold(true, |all, (round, hits)| {
                all && same(hits, &course.answers[part(round, turn)])
            }),
        }
    };
    let laps = |number| [lap(0, number), lap(1, number)];
    (0..runners.len()).map(laps).collect()
}

/// In pieces small enough to keep every thread busy, also with the few rays of brute force. Between the laps the answers are
/// compared and wiped out.
fn all_threads(runners: &[Runner], course: &Course) -> Vec<Lap> {
    let mut answers: Vec<Vec<Option<Hit>>> = runners
        .iter()
        .map(|runner| vec![None; runner.rays(course)])
        .collect();
    let mut times = vec![Vec::new(); runners.len()];
    let mut right = vec![true; runners.len()];
    for _ in 0..LAPS {
        let mut tasks: Vec<Task<'_>> = Vec::new();
        for (runner, hits) in runners.iter().zip(&mut answers) {
            let rays = &course.rays[..hits.len()];
            let piece = (rays.len() / (8 * rayon::current_num_threads())).clamp(1, 1024);
            tasks.push(Box::new(move |_| {
                let pieces = rays.par_chunks(piece).zip(hits.par_chunks_mut(piece));
                pieces.for_each(|(rays, hits)| runner.built.scene.closest_hits(rays, hits));
            }));
        }
        let lap = interleaved(Clock::Wall, 1, &mut tasks);
        drop(tasks);
        for (number, hits) in answers.iter_mut().enumerate() {
            times[number].push(lap[number]);
            right[number] &= same(hits, &course.answers[..hits.len()]);
            hits.fill(None);
        }
    }
    let lap = |(number, times): (usize, &mut Vec<Duration>)| {
        times.sort_unstable();
        Lap {
            time: times[LAPS / 2],
            rays: answers[number].len(),
            same_answer: right[number],
        }
    };
    times.iter_mut().enumerate().map(lap).collect()
}

fn text(answer: &Answer) -> String {
    let mut table = Table::new([
        "structure",
        "build ms",
        "MiB",
        "box tests/ray",
        "triangle tests/ray",
        "flop/ray",
        "ns/ray: single",
        "batch",
        "Mrays/s",
        "same answer",
    ]);
    for row in &answer.structures {
        table.row([
            if row.estimated {
                format!("{} est.", row.name)
            } else {
                row.name.clone()
            },
            short(row.build_ms),
            mebibytes(row.bytes),
            short(row.box_tests_per_ray),
            short(row.primitive_tests_per_ray),
            short(row.flops_per_ray),
            short(row.single_ns_per_ray),
            short(row.ns_per_ray),
            short(row.mrays_per_second),
            if row.same_answer { "yes" } else { "NO" }.to_owned(),
        ]);
    }
    let mut lines = vec![
        format!(
            "{}: {}; {} rays ({} camera, {} bounced, {} random), {} hit; {} threads",
            answer.file,
            counted(answer.triangles, "triangle"),
            grouped(answer.rays as u64),
            grouped(answer.camera_rays as u64),
            grouped(answer.bounced_rays as u64),
            grouped(answer.random_rays as u64),
            grouped(answer.hits as u64),
            answer.threads
        ),
        String::new(),
        table.to_string(),
        "\nns/ray: processor time of one thread, one ray per call and in a batch; Mrays/s: batches on all threads, by the clock\n\
         on the wall"
            .to_owned(),
    ];
    for row in answer.structures.iter().filter(|row| row.estimated) {
        lines.push(format!(
            "est.: {} was asked about the first {} rays",
            row.name,
            grouped(row.rays as u64)
        ));
    }
    lines.join("\n")
}
