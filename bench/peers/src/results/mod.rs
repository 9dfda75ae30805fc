//! RESULTS.md: what was aimed at and what was reached, scene by scene, with all that a reader needs to repeat it.

mod beside;
mod goals;

use crate::{
    frame::Frames,
    growth::{Curve, SCENE},
    measure::{Bench, Measured, Peer, Settings},
};
use boxwood_measure::{Cell, Mode};
use goals::{GOALS, Goal, Value, better_build};
use std::fmt::Write;

/// All that was measured.
pub(crate) struct Results<'a> {
    pub(crate) scenes: &'a [Measured],
    /// With the reason.
    pub(crate) skipped: &'a [(String, String)],
    pub(crate) growth: &'a [Curve],
    pub(crate) frames: &'a [Frames],
    pub(crate) bench: &'a Bench,
    pub(crate) settings: &'a Settings,
}

/// A table of Markdown, built line by line.
#[derive(Default)]
struct Table(String);

impl Table {
    fn new(titles: &[&str]) -> Self {
        let mut table = Self::default();
        table.row(titles.iter().map(|&title| title.to_owned()));
        table.row(titles.iter().map(|_| "---".to_owned()));
        table
    }

    fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        let cells: Vec<String> = cells
            .into_iter()
            .map(|cell| cell.replace('|', "/"))
            .collect();
        let _ = writeln!(self.0, "| {} |", cells.join(" | "));
    }
}

impl Results<'_> {
    /// The whole file.
    pub(crate) fn markdown(&self) -> String {
        let parts = [
            self.head(),
            self.goals(),
            self.scene_by_scene(),
            beside::section(self.scenes),
            self.frames(),
            self.growth(),
            self.limits(),
            self.rivals_win(),
            self.answers(),
            self.rates(),
            self.skipped(),
        ];
        let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        parts.join("\n")
    }

    fn head(&self) -> String {
        let date = self.scenes.first().map_or("", |scene| &*scene.report.date);
        let settings = self.settings;
        let machine = &self.bench.machine;
        let embree = self.bench.embree_version.as_deref().unwrap_or("absent");
        format!(
            "# Results\n\n\
             Written by a command, not by hand:\n\n```sh\n{}\n```\n\n\
             {date}. {}.\n\
             Embree {embree}, not robust; the Rust rivals compiled for {}, as Boxwood is. {} rays a set, {} rounds; the contenders take \
             turns in one process, ratios are medians of the rounds' ratios. One thread unless said otherwise, and then by the \
             processor's clock, which a busy machine does not disturb; several by the clock on the wall. A rate above 1 is in \
             Boxwood's favour; a time or size below 1 is.\n",
            settings.command,
            machine.line(),
            machine.compiled_for.join(" "),
            settings.size * settings.size,
            settings.rounds,
        )
    }

    /// Each goal over all scenes.
    fn goals(&self) -> String {
        let titles = [
            "what",
            "goal: mean",
            "measured",
            "goal: worst",
            "measured",
            "where",
            "reached",
        ];
        let mut table = Table::new(&titles);
        for goal in GOALS {
            table.row(goal_row(goal, &goal.values(self.scenes)));
        }
        format!("## Goals\n\n{}", table.0)
    }

    fn scene_by_scene(&self) -> String {
        let mut titles = vec!["scene", "triangles"];
        titles.extend(GOALS.iter().map(|goal| goal.short));
        titles.push("batches by");
        let mut table = Table::new(&titles);
        for scene in self.scenes {
            let info = &scene.report.scene;
            let mut row = vec![info.name.clone(), info.triangles.to_string()];
            row.extend(GOALS.iter().map(|goal| goal.of_scene(scene)));
            let build = better_build(scene).map_or("-", |peer| &peer.row.name);
            row.push(build.to_owned());
            table.row(row);
        }
        format!(
            "## Scene by scene\n\nGeometric mean over the sets of rays, behind it the worst and where that is. -: not measured.\n\n{}",
            table.0
        )
    }

    fn frames(&self) -> String {
        if self.frames.is_empty() {
            return String::new();
        }
        let mut table = Table::new(&["scene", "who", "rays handed over", "frames per second"]);
        for frames in self.frames {
            for (who, mode, rate) in &frames.rates {
                let row = [
                    frames.scene.clone(),
                    who.clone(),
                    mode.name().to_owned(),
                    format!("{rate:.1}"),
                ];
                table.row(row);
            }
        }
        format!(
            "## Frames\n\n1280 x 720 pixels from outside, a primary ray and a shadow ray each, shading, {} threads; the same small renderer \
             for all, a call per 16 x 16 pixels. Embree's batches are coherent packets of 16.\n\n{}",
            self.settings.threads, table.0
        )
    }

    fn growth(&self) -> String {
        if self.growth.is_empty() {
            return String::new();
        }
        let sizes: Vec<f64> = self.growth[0].points.iter().map(|point| point[0]).collect();
        let mut titles = vec!["rays".to_owned(), "who".to_owned()];
        titles.extend(sizes.iter().map(|size| format!("{size}")));
        let titles: Vec<&str> = titles.iter().map(|title| &**title).collect();
        let mut table = Table::new(&titles);
        for curve in self.growth {
            let rates = curve.points.iter().map(|point| format!("{:.2}", point[1]));
            table.row(
                [curve.set.clone(), curve.who.clone()]
                    .into_iter()
                    .chain(rates),
            );
        }
        format!(
            "## The cost of growth\n\nMillion rays per second through {SCENE} of so many triangles.\n\n{}",
            table.0
        )
    }

    /// Where the time goes, as far as the floor says it.
    fn limits(&self) -> String {
        let mut table = Table::new(&[
            "scene",
            "rays",
            "way",
            "ns/ray",
            "limit, ns",
            "reached",
            "nodes",
            "leaves",
            "lines",
        ]);
        for scene in self.scenes {
            for cell in scene
                .peers
                .iter()
                .filter(|peer| peer.row.name == "boxwood")
                .flat_map(|peer| &peer.row.cells)
            {
                if let (1, Some(floor), Some(of_floor), Some(work)) =
                    (cell.threads, cell.floor_ns, cell.of_floor, cell.work)
                {
                    table.row([
                        scene.report.scene.name.clone(),
                        cell.set.clone(),
                        cell.mode.name().to_owned(),
                        format!("{:.0}", 1e3 / cell.mrays),
                        format!("{floor:.0}"),
                        format!("{of_floor:.2}"),
                        format!("{:.1}", work.nodes),
                        format!("{:.1}", work.leaves),
                        format!("{:.0}", work.bytes / 64.0),
                    ]);
                }
            }
        }
        let probe = &self.bench.probe;
        format!(
            "## Part of the limit\n\n\
             The limit is what the nodes and leaves that a ray visits must cost on this machine by arithmetic, waiting and memory \
             (`crates/boxwood-measure/src/floor.rs`). The machine, probed: cycle {:.3} ns, loads that wait {:.1} / {:.1} / {:.1} / {:.0} ns from the \
             three caches and memory, {:.1} ns per line from memory eight at once, {:.0} * 10^9 products and sums a second as compiled.\n\n{}",
            probe.cycle_ns,
            probe.l1_ns,
            probe.l2_ns,
            probe.l3_ns,
            probe.dram_ns,
            probe.dram_parallel_ns,
            probe.gflops,
            table.0
        )
    }

    /// Every cell in which somebody is faster, smaller or quicker to build than all of Boxwood's.
    fn rivals_win(&self) -> String {
        let mut wins = Vec::new();
        for scene in self.scenes {
            let name = &scene.report.scene.name;
            for set in &scene.report.scene.sets {
                for mode in Mode::ALL {
                    wins.extend(
                        fastest_rival(scene, set, mode).map(|win| format!("{name}: {win}")),
                    );
                }
            }
        }
        let text = match wins.len() {
            0 => "Nobody is faster than Boxwood on any set, one thread, single rays against single rays and batches against batches.\n".to_owned(),
            _ => wins.iter().fold(String::new(), |text, win| format!("{text}- {win}\n")),
        };
        format!(
            "## What rivals win\n\nOne thread; single rays against single rays, batches against batches.\n\n{text}"
        )
    }

    fn answers(&self) -> String {
        let mut table = Table::new(&[
            "scene",
            "who",
            "rays compared",
            "another place",
            "not seen",
            "seen where nothing is",
        ]);
        for scene in self.scenes {
            for peer in &scene.peers {
                if let Some(a) = peer
                    .row
                    .agreement
                    .filter(|a| a.differences() > 0 || peer.row.name == "boxwood")
                {
                    let counts =
                        [a.rays, a.elsewhere, a.only_first, a.only_second].map(|n| n.to_string());
                    table.row(
                        [scene.report.scene.name.clone(), peer.row.name.clone()]
                            .into_iter()
                            .chain(counts),
                    );
                }
            }
        }
        format!(
            "## Answers\n\nAgainst Boxwood's exact answers over the same rays; contenders that never differ are left out. Another place: both hit, but \
             more than a 10^4th of the distance apart. Rivals that round differently differ at grazing hits and along edges.\n\n{}",
            table.0
        )
    }

    fn rates(&self) -> String {
        let mut text = "## All rates\n\nMillion rays per second; behind them how far the rounds lay apart. est.: over a sample of the rays.\n".to_owned();
        for scene in self.scenes {
            let info = &scene.report.scene;
            let mut titles = vec!["who", "way", "build ms", "bytes/triangle"];
            titles.extend(info.sets.iter().map(|set| &**set));
            let mut table = Table::new(&titles);
            for peer in &scene.peers {
                for threads in if scene.report.threads > 1 {
                    vec![1, scene.report.threads]
                } else {
                    vec![1]
                } {
                    Mode::ALL
                        .iter()
                        .filter_map(|mode| rates_row(scene, peer, *mode, threads))
                        .for_each(|row| table.row(row));
                }
            }
            let _ = write!(
                text,
                "\n### {}\n\n{} triangles.\n\n{}",
                info.name, info.triangles, table.0
            );
        }
        text
    }

    fn skipped(&self) -> String {
        if self.skipped.is_empty() {
            return String::new();
        }
        let lines = self
            .skipped
            .iter()
            .map(|(name, reason)| format!("- {name}: {reason}\n"));
        format!("## Skipped\n\n{}", lines.collect::<String>())
    }
}

fn goal_row(goal: &Goal, values: &[Value]) -> [String; 7] {
    let number = |x: f64| format!("{x:.2}");
    let (mean, worst) = (goal.mean(values), goal.worst(values));
    let reached = match (mean, &worst) {
        (Some(mean), Some(worst)) => match goal.is_reached(mean, worst.ratio) {
            true => "yes",
            false => "no",
        },
        _ => "not measured",
    };
    [
        goal.what.to_owned(),
        number(goal.mean),
        mean.map_or("-".to_owned(), number),
        number(goal.worst),
        worst
            .as_ref()
            .map_or("-".to_owned(), |worst| number(worst.ratio)),
        worst.map_or("-".to_owned(), |worst| worst.place),
        reached.to_owned(),
    ]
}

/// Who is ahead of all of Boxwood's builds on a set, if anybody is, and by how much.
fn fastest_rival(scene: &Measured, set: &str, mode: Mode) -> Option<String> {
    let best = |ours: bool| {
        let peers = scene
            .peers
            .iter()
            .filter(|peer| peer.row.name.starts_with("boxwood") == ours);
        let cells =
            peers.filter_map(|peer| Some((&peer.row.name, peer.row.cell(set, mode, 1)?.mrays)));
        cells.max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let ((name, rival), (_, ours)) = (best(false)?, best(true)?);
    let ratio = rival / ours;
    (ratio > 1.0).then(|| {
        format!(
            "{set}, {}: {name} is {ratio:.2} times as fast ({rival:.2} against {ours:.2})",
            mode.name()
        )
    })
}

fn rates_row(scene: &Measured, peer: &Peer, mode: Mode, threads: usize) -> Option<Vec<String>> {
    let row = &peer.row;
    let info = &scene.report.scene;
    let cells: Vec<Option<&Cell>> = info
        .sets
        .iter()
        .map(|set| row.cell(set, mode, threads))
        .collect();
    if cells.iter().all(Option::is_none) {
        return None;
    }
    let build = if threads == 1 {
        Some(row.build_ms)
    } else {
        row.build_ms_all
    };
    let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.1}"));
    let mut line = vec![
        row.name.clone(),
        format!("{} x{threads}", mode.name()),
        number(build),
        number(row.bytes_per_triangle),
    ];
    line.extend(cells.into_iter().map(|cell| match cell {
        Some(cell) if cell.rays < info.rays_per_set => format!("{:.2} est.", cell.mrays),
        Some(cell) => format!("{:.2} ({:.0} %)", cell.mrays, 100.0 * cell.noise),
        None => "-".to_owned(),
    }));
    Some(line)
}
