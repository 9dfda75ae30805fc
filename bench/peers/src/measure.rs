//! One scene, all contenders.

use crate::{
    entries::entries,
    standing::{Against, Standing},
};
use anyhow::Result;
use boxwood::Scene;
use boxwood_measure::{
    Contender, Heat, Machine, Mode, Plan, Probe, RaySet, Report, Row, SceneInfo,
    agree::{Agreement, agreement},
    build_all, race, ray_sets, rows,
};
use boxwood_scene::{Camera, FlatMesh};
use libloading::Library;
use serde::Serialize;
use std::{io::Write, ops::ControlFlow, time::Duration};

/// What does not depend on the scene.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// Who takes part; all if empty.
    pub(crate) only: Vec<String>,
    /// Rays of a set: this squared.
    pub(crate) size: usize,
    /// Turns.
    pub(crate) rounds: usize,
    /// Besides one.
    pub(crate) threads: usize,
    /// As typed.
    pub(crate) command: String,
}

/// The machine, looked at once.
pub(crate) struct Bench {
    pub(crate) machine: Machine,
    pub(crate) probe: Probe,
    /// None if it is not to take part.
    pub(crate) embree: Option<&'static Library>,
    /// Its version.
    pub(crate) embree_version: Option<String>,
}

/// A contender's figures and, for all but Embree, where it stands against Embree.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Peer {
    #[serde(flatten)]
    pub(crate) row: Row,
    /// Single rays against Embree's single rays.
    pub(crate) vs_embree_single: Option<Standing>,
    /// Batches (single rays where it has none) against Embree's fastest on each set.
    pub(crate) vs_embree_best: Option<Standing>,
}

/// A scene's figures.
pub(crate) struct Measured {
    /// With the peers' rows in it.
    pub(crate) report: Report,
    /// In the order of the rows.
    pub(crate) peers: Vec<Peer>,
    /// Which of Embree's ways is the fastest for each set, and its million rays per second.
    pub(crate) best: Vec<(String, String, f64)>,
}

/// A turn may take so long before a contender gets fewer rays.
const TURN: Duration = Duration::from_millis(700);
/// Above so many triangles there is one build instead of three.
const LARGE: usize = 500_000;
/// Rays of each set whose answers are compared.
const COMPARED: usize = 1 << 16;

/// Measures one scene.
pub(crate) fn measure(
    name: &str,
    mesh: &FlatMesh,
    camera: Option<Camera>,
    settings: &Settings,
    bench: &Bench,
) -> Result<Measured> {
    let judge = Scene::new(&mesh.positions, &mesh.indices)?;
    let sets = ray_sets(&judge, camera, settings.size)?;
    let entries = entries(mesh, bench.embree, &settings.only)?;
    let rounds = if mesh.indices.len() > LARGE { 1 } else { 3 };
    let mut watch = |who: &str| told(format_args!("{name}: building {who}"));
    let (contenders, builds) = build_all(&entries, rounds, settings.threads, &mut watch)?;
    let plan = Plan {
        rounds: settings.rounds,
        threads: settings.threads,
        turn: TURN,
    };
    let mut watch = |step: boxwood_measure::Step<'_>| {
        told(format_args!(
            "{name}: {}, {} thread(s), {} of {}",
            step.set,
            step.threads,
            step.done + 1,
            step.of
        ))
    };
    let heats = race(&contenders, &sets, &plan, &mut watch)?;
    let mut rows = rows(
        &contenders,
        &builds,
        &sets,
        &heats,
        &bench.probe,
        mesh.indices.len(),
    );
    let agreements = agreements(&contenders, &judge, &sets);
    rows.iter_mut()
        .zip(agreements)
        .for_each(|(row, agreement)| row.agreement = Some(agreement));
    let _ = told(format_args!(""));
    let scene = SceneInfo {
        name: name.to_owned(),
        triangles: mesh.indices.len(),
        rays_per_set: settings.size * settings.size,
        sets: sets.iter().map(|set| set.name.to_owned()).collect(),
    };
    let report = Report::new(
        scene,
        bench.probe,
        bench.machine.clone(),
        &heats,
        rows.clone(),
    );
    let peers = rows.into_iter().enumerate();
    let peers = peers
        .map(|(number, row)| peer(number, row, &contenders, &heats, &sets))
        .collect();
    let best = sets
        .iter()
        .filter_map(|set| best(&contenders, &heats, &sets, set))
        .collect();
    Ok(Measured {
        report: Report {
            command_line: settings.command.clone(),
            rounds: settings.rounds,
            ..report
        },
        peers,
        best,
    })
}

/// A line on stderr that the next one overwrites.
fn told(text: std::fmt::Arguments<'_>) -> ControlFlow<()> {
    use std::io::IsTerminal;
    if std::io::stderr().is_terminal() {
        eprint!("\r\x1b[K{text}");
        let _ = std::io::stderr().flush();
    }
    ControlFlow::Continue(())
}

fn peer(
    number: usize,
    row: Row,
    contenders: &[Box<dyn Contender>],
    heats: &[Heat],
    sets: &[RaySet],
) -> Peer {
    let is_embree = row.name.starts_with("embree");
    let standing = |mode, against| {
        let standing = Standing::of(contenders, heats, sets, (number, mode), against);
        standing.filter(|_| !is_embree)
    };
    let many = if contenders[number].has(Mode::Batch) {
        Mode::Batch
    } else {
        Mode::Single
    };
    Peer {
        vs_embree_single: standing(Mode::Single, Against::Single),
        vs_embree_best: standing(many, Against::Best),
        row,
    }
}

/// The fastest of Embree's ways on a set: its name and rate.
fn best(
    contenders: &[Box<dyn Contender>],
    heats: &[Heat],
    sets: &[RaySet],
    set: &RaySet,
) -> Option<(String, String, f64)> {
    let heat = heats
        .iter()
        .find(|heat| heat.threads == 1 && sets[heat.set].name == set.name)?;
    let lanes = heat.lanes.iter().enumerate();
    let ours = lanes
        .filter(|(_, lane)| matches!(contenders[lane.contender].name(), "embree" | "embree-high"));
    let (number, lane) = ours.max_by(|a, b| heat.mrays(a.0).total_cmp(&heat.mrays(b.0)))?;
    let way = if lane.mode == Mode::Batch {
        "16-packets"
    } else {
        "single"
    };
    let name = format!("{} {way}", contenders[lane.contender].name());
    Some((set.name.to_owned(), name, heat.mrays(number)))
}

/// Each contender's answers against Boxwood's exact ones, over all sets and ways.
fn agreements(contenders: &[Box<dyn Contender>], judge: &Scene, sets: &[RaySet]) -> Vec<Agreement> {
    let scale = judge.bounds().diagonal() as f32;
    let judge = Judge(judge);
    let of = |who: &dyn Contender| {
        let ways = Mode::ALL.into_iter().filter(|mode| who.has(*mode));
        let compared = ways.flat_map(|mode| {
            let judge = &judge;
            sets.iter()
                .map(move |set| agreement((judge, Mode::Single), (who, mode), set, COMPARED, scale))
        });
        compared.fold(Agreement::default(), Agreement::and)
    };
    contenders.iter().map(|who| of(&**who)).collect()
}

/// The scene that the rays were made by.
struct Judge<'a>(&'a Scene);

impl Contender for Judge<'_> {
    fn name(&self) -> &str {
        "judge"
    }

    fn has(&self, _: Mode) -> bool {
        true
    }

    fn closest_hits(&self, _: Mode, rays: &[boxwood::Ray], hits: &mut [Option<boxwood::Hit>]) {
        self.0.closest_hits(rays, hits);
    }

    fn occluded(&self, _: Mode, rays: &[boxwood::Ray], occluded: &mut [bool]) {
        self.0.occluded_each(rays, occluded);
    }
}
