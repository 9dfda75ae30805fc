//! The race of `boxwood bench`: rays of one scene, contenders, a report.

use std::{ops::ControlFlow, sync::atomic::Ordering};

use anyhow::Context;
use boxwood::{Scene, Structure};
use boxwood_measure::{
    Asked, Built, Clock, Entry, Machine, MeasureError, Mode, Plan, Probe, RaySet, Report, Row,
    SceneInfo, Step,
    agree::{Agreement, agreement},
    build_all, race, ray_sets, rows_while, with_threads,
};
use boxwood_scene::{Camera, FlatMesh};

use super::Args;
use crate::{
    args::Loaded,
    contest::Contender,
    progress::{Progress, interrupted},
};

/// Above so many triangles there is one build instead of three.
const LARGE: usize = 500_000;
/// Rays of each set whose answers are compared.
const COMPARED: usize = 4096;

/// The rays, and how they are asked about.
pub(super) struct Course<'a> {
    loaded: &'a Loaded,
    judge: Asked,
    sets: Vec<RaySet>,
    plan: Plan,
}

impl<'a> Course<'a> {
    pub(super) fn new(args: &Args, loaded: &'a Loaded) -> anyhow::Result<Self> {
        let mesh = &loaded.mesh;
        let judge = Scene::new(&mesh.positions, &mesh.indices)?;
        let camera = camera(args, loaded);
        let size = args.size as usize;
        let sets = match ray_sets(&judge, camera, size) {
            // A camera of the file may look into nothing; what the user has typed is meant.
            Err(MeasureError::SeesNothing) if args.vp.is_none() => ray_sets(&judge, None, size),
            sets => sets,
        };
        Ok(Self {
            loaded,
            judge: Asked::new(Structure::DEFAULT, judge),
            sets: sets.with_context(|| loaded.name.clone())?,
            plan: Plan {
                rounds: args.rounds as usize,
                threads: rayon::current_num_threads(),
                ..Plan::default()
            },
        })
    }

    /// All of it for some contenders; less if the user interrupts.
    pub(super) fn measure(
        &self,
        chosen: &[Contender],
        machine: Machine,
        probe: Probe,
    ) -> anyhow::Result<Report> {
        let (mesh, stop) = (&self.loaded.mesh, interrupted());
        let go_on = || match stop.load(Ordering::SeqCst) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let entries: Vec<Entry<'_>> = chosen.iter().map(|c| entry(c, mesh)).collect();
        let build_rounds = if mesh.indices.len() > LARGE { 1 } else { 3 };
        // On one thread and on all.
        let ways = if self.plan.threads > 1 { 2 } else { 1 };
        let builds_in_all = entries.len() * build_rounds * ways;
        let turns = turns_of_a_heat(entries.len(), self.plan.rounds);
        let mut pace = Pace::new(builds_in_all, self.sets.len() * ways, turns);
        let (contenders, builds) =
            build_all(&entries, build_rounds, self.plan.threads, &mut |who| {
                pace.building(who);
                go_on()
            })?;
        let heats = race(&contenders, &self.sets, &self.plan, &mut |step| {
            pace.racing(step);
            go_on()
        })?;
        let triangles = mesh.indices.len();
        pace.bar.say("counting and comparing");
        let mut rows = rows_while(
            &contenders,
            &builds,
            &self.sets,
            &heats,
            &probe,
            triangles,
            &go_on,
        );
        for (row, who) in rows.iter_mut().zip(&contenders) {
            row.agreement = self.agreement(&**who, row, &go_on);
        }
        let scene = SceneInfo {
            name: self.loaded.name.clone(),
            triangles,
            rays_per_set: self.sets.first().map_or(0, |set| set.rays.len()),
            sets: self.sets.iter().map(|set| set.name.to_owned()).collect(),
        };
        Ok(Report {
            command_line: command_line(),
            rounds: self.plan.rounds,
            threads: self.plan.threads,
            complete: go_on().is_continue(),
            ..Report::new(scene, probe, machine, &heats, rows)
        })
    }

    /// Whether the answers are right, over as many rays as the contender can do in a moment; none if that was ended.
    fn agreement(
        &self,
        who: &dyn boxwood_measure::Contender,
        row: &Row,
        go_on: &dyn Fn() -> ControlFlow<()>,
    ) -> Option<Agreement> {
        let mut sum = Agreement::default();
        for mode in Mode::ALL {
            for set in &self.sets {
                if go_on().is_break() {
                    return None;
                }
                let Some(cell) = row.cell(set.name, mode, 1) else {
                    continue;
                };
                let rays = cell.rays.min(COMPARED);
                let judge = (&self.judge as &dyn boxwood_measure::Contender, Mode::Single);
                sum = sum.and(agreement(judge, (who, mode), set, rays, 0.0));
            }
        }
        Some(sum)
    }
}

/// How far the race has come. A build counts as a turn does, so that what is left can be told from both.
struct Pace {
    bar: Progress,
    builds: u64,
    builds_begun: u64,
    /// Of a heat.
    turns: u64,
    /// The heat at work, and its turns so far.
    heat: (usize, u64),
}

impl Pace {
    fn new(builds: usize, heats: usize, turns: u64) -> Self {
        let builds = builds as u64;
        Self {
            bar: Progress::new(builds + heats as u64 * turns, "turns"),
            builds,
            builds_begun: 0,
            turns,
            heat: (0, 0),
        }
    }

    /// Before a build.
    fn building(&mut self, who: &str) {
        self.bar.set(self.builds_begun);
        self.builds_begun += 1;
        self.bar.say(format!("building {who}"));
    }

    /// Before a turn.
    fn racing(&mut self, step: Step<'_>) {
        let turn = match self.heat {
            (heat, turn) if heat == step.done => turn + 1,
            _ => 0,
        };
        self.heat = (step.done, turn);
        let turns = step.done as u64 * self.turns + turn.min(self.turns);
        self.bar.set(self.builds + turns);
        self.bar
            .say(format!("{} rays, threads: {}", step.set, step.threads));
    }
}

/// About how many turns so many contenders have: some to find out how fast each is, one to warm up, the rounds.
fn turns_of_a_heat(contenders: usize, rounds: usize) -> u64 {
    let lanes = contenders * Mode::ALL.len();
    (lanes * 4 + (lanes + 1) * rounds) as u64
}

/// As typed, without the program's own path.
fn command_line() -> String {
    let args = std::env::args().skip(1);
    std::iter::once("boxwood".to_owned())
        .chain(args)
        .collect::<Vec<_>>()
        .join(" ")
}

/// What was typed, else the scene's own, else none.
fn camera(args: &Args, loaded: &Loaded) -> Option<Camera> {
    match (args.vp, args.vi) {
        (Some(eye), Some(target)) => Some(Camera {
            eye,
            target,
            up: [0.0, 1.0, 0.0],
            fov: 50.0,
        }),
        _ => loaded.model.cameras.first().copied(),
    }
}

fn entry<'a>(contender: &'a Contender, mesh: &'a FlatMesh) -> Entry<'a> {
    let build = move |threads| {
        let clock = Clock::of_work_on(threads);
        let (built, time) = with_threads(threads, || {
            let start = clock.now();
            (contender.build(mesh), clock.now() - start)
        })?;
        let built = built.map_err(|error| MeasureError::Contender {
            name: contender.name(),
            cause: format!("{error:#}"),
            remedy: "leave it out with --only".to_owned(),
        })?;
        Ok(Built {
            time,
            bytes: Some(built.scene.query().bytes() as u64),
            contender: Box::new(Asked::new(built.name, built.scene)),
        })
    };
    Entry {
        name: contender.name(),
        build: Box::new(build),
    }
}
