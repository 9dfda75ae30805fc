//! Everybody beside Embree's single rays, in one number per scene: the table of the README.

use super::Table;
use crate::measure::{Measured, Peer};
use boxwood_measure::{Mode, Row, geometric_mean};

/// By whom all others are divided.
const YARDSTICK: &str = "embree";

/// The section; empty where the yardstick did not run.
pub(super) fn section(scenes: &[Measured]) -> String {
    let names = scenes.iter().map(|scene| &*scene.report.scene.name);
    let titles: Vec<&str> = ["who", "way"]
        .into_iter()
        .chain(names)
        .chain(["all", "build", "bytes"])
        .collect();
    let mut table = Table::new(&titles);
    let peers = scenes.first().map_or(&[][..], |scene| &scene.peers);
    let rows: Vec<_> = peers
        .iter()
        .flat_map(|peer| Mode::ALL.map(|mode| row(scenes, &peer.row.name, mode)))
        .flatten()
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    rows.into_iter().for_each(|row| table.row(row));
    format!(
        "## Beside Embree's single rays\n\nRates as a part of those of `{YARDSTICK}`, single rays, one thread, from the table of all rates: the \
         geometric mean over the sets of a scene, then over the scenes that a contender ran on; above 1: faster. Behind them the time to \
         build on one thread and the bytes, as a part of `{YARDSTICK}`'s; below 1: less.\n\n{}",
        table.0
    )
}

/// A contender's line; `None` if it has no such way.
fn row(scenes: &[Measured], name: &str, mode: Mode) -> Option<Vec<String>> {
    let pairs: Vec<Option<(&Row, &Row)>> = scenes
        .iter()
        .map(|scene| Some((find(&scene.peers, name)?, find(&scene.peers, YARDSTICK)?)))
        .collect();
    let speeds: Vec<Option<f64>> = scenes
        .iter()
        .zip(&pairs)
        .map(|(scene, pair)| speed(&scene.report.scene.sets, (*pair)?, mode))
        .collect();
    let both = || pairs.iter().flatten();
    let builds = both().map(|(row, yardstick)| row.build_ms / yardstick.build_ms);
    let bytes = both().filter_map(|(row, yardstick)| {
        Some(row.bytes_per_triangle? / yardstick.bytes_per_triangle?)
    });
    speeds.iter().any(Option::is_some).then(|| {
        [name.to_owned(), mode.name().to_owned()]
            .into_iter()
            .chain(
                speeds
                    .iter()
                    .map(|speed| told(speed.as_slice().iter().copied())),
            )
            .chain([
                told(speeds.iter().flatten().copied()),
                told(builds),
                told(bytes),
            ])
            .collect()
    })
}

fn find<'a>(peers: &'a [Peer], name: &str) -> Option<&'a Row> {
    peers
        .iter()
        .map(|peer| &peer.row)
        .find(|row| row.name == name)
}

/// The mean of the ratios over the sets that both ran.
fn speed(sets: &[String], (row, yardstick): (&Row, &Row), mode: Mode) -> Option<f64> {
    let ratios: Vec<f64> = sets
        .iter()
        .filter_map(|set| {
            let ours = row.cell(set, mode, 1)?.mrays;
            Some(ours / yardstick.cell(set, Mode::Single, 1)?.mrays)
        })
        .collect();
    (!ratios.is_empty()).then(|| geometric_mean(ratios))
}

/// A mean in two digits; a dash for the mean of nothing.
fn told(ratios: impl Iterator<Item = f64>) -> String {
    let ratios: Vec<f64> = ratios.collect();
    match ratios.is_empty() {
        true => "-".to_owned(),
        false => format!("{:.2}", geometric_mean(ratios)),
    }
}
