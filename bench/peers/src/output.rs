//! What is printed of one scene: text for people, JSON for programs, a page for browsers.

use crate::measure::{Bench, Measured, Peer};
use anyhow::Result;
use boxwood_measure::{
    Machine, Mode, Probe, SceneInfo,
    html::{self, Page, Section},
    plot::Dots,
};
use serde::Serialize;
use std::fmt::Write;

/// Version of [`Answer`]. New fields may come within a version.
const SCHEMA: u32 = 1;

/// The JSON object.
#[derive(Serialize)]
struct Answer<'a> {
    schema: u32,
    tool: &'static str,
    date: &'a str,
    command: &'a str,
    machine: &'a Machine,
    probe: &'a Probe,
    embree: Option<&'a str>,
    scene: &'a SceneInfo,
    rounds: usize,
    threads: usize,
    peers: &'a [Peer],
}

/// One line of JSON-able data per scene.
pub(crate) fn json(measured: &Measured, bench: &Bench) -> Result<serde_json::Value> {
    let report = &measured.report;
    Ok(serde_json::to_value(Answer {
        schema: SCHEMA,
        tool: "boxwood-peers",
        date: &report.date,
        command: &report.command_line,
        machine: &report.machine,
        probe: &report.probe,
        embree: bench.embree_version.as_deref(),
        scene: &report.scene,
        rounds: report.rounds,
        threads: report.threads,
        peers: &measured.peers,
    })?)
}

/// Tables for people.
pub(crate) fn text(measured: &Measured, bench: &Bench) -> String {
    let report = &measured.report;
    let mut text = format!(
        "{}: {} triangles, {} rays a set, {} rounds\n{}\n",
        report.scene.name,
        report.scene.triangles,
        report.scene.rays_per_set,
        report.rounds,
        report.machine.line()
    );
    if let Some(version) = &bench.embree_version {
        let _ = writeln!(
            text,
            "Embree {version}, not told to be robust unless named so"
        );
    }
    let _ = write!(
        text,
        "\n{:<24}{:>10}{:>10}{:>8}",
        "million rays per second", "build ms", "B/tri", "way"
    );
    for set in &report.scene.sets {
        let _ = write!(text, "{set:>10}");
    }
    text.push('\n');
    for peer in &measured.peers {
        for threads in [1, report.threads] {
            for mode in Mode::ALL {
                line(&mut text, peer, measured, mode, threads);
            }
            if report.threads == 1 {
                break;
            }
        }
    }
    text += &standings(measured);
    text += &differences(measured);
    text
}

fn line(text: &mut String, peer: &Peer, measured: &Measured, mode: Mode, threads: usize) {
    let row = &peer.row;
    let sets = &measured.report.scene.sets;
    let cells: Vec<_> = sets
        .iter()
        .map(|set| row.cell(set, mode, threads))
        .collect();
    if cells.iter().all(Option::is_none) {
        return;
    }
    let build = if threads == 1 {
        Some(row.build_ms)
    } else {
        row.build_ms_all
    };
    let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.1}"));
    let way = if threads == 1 {
        mode.name().to_owned()
    } else {
        format!("{} x{threads}", mode.name())
    };
    let _ = write!(
        text,
        "{:<24}{:>10}{:>10}{way:>10}",
        row.name,
        number(build),
        number(row.bytes_per_triangle)
    );
    for cell in cells {
        let _ = write!(
            text,
            "{:>10}",
            cell.map_or("-".to_owned(), |cell| format!("{:.2}", cell.mrays))
        );
    }
    text.push('\n');
}

/// Where all stand against Embree.
fn standings(measured: &Measured) -> String {
    let mut text = String::new();
    for (title, of) in [
        (
            "single rays / Embree's single rays",
            (|peer| &peer.vs_embree_single) as fn(&Peer) -> &Option<_>,
        ),
        ("batches / Embree's fastest on each set", |peer| {
            &peer.vs_embree_best
        }),
    ] {
        if measured.peers.iter().all(|peer| of(peer).is_none()) {
            continue;
        }
        let _ = writeln!(text, "\n{title:<42}{:>8}{:>8}", "geomean", "worst");
        for peer in &measured.peers {
            if let Some(standing) = of(peer) {
                let _ = writeln!(
                    text,
                    "{:<42}{:>8.3}{:>8.3}  {}",
                    peer.row.name, standing.geomean, standing.worst, standing.worst_set
                );
            }
        }
    }
    for (set, way, mrays) in &measured.best {
        let _ = writeln!(text, "Embree's fastest on {set}: {way}, {mrays:.2}");
    }
    text
}

/// Who gives other answers than the exact ones.
fn differences(measured: &Measured) -> String {
    let mut text = "\nanswers, against Boxwood's exact ones:\n".to_owned();
    for peer in &measured.peers {
        if let Some(a) = peer.row.agreement {
            let _ = writeln!(
                text,
                "{:<24}{} rays: {} elsewhere, {} not seen, {} seen where there is nothing",
                peer.row.name, a.rays, a.elsewhere, a.only_first, a.only_second
            );
        }
    }
    text
}

/// The page of one scene or several.
pub(crate) fn page(all: &[Measured], more: Vec<Section>, bench: &Bench) -> Result<String> {
    let mut page = Page {
        title: "Boxwood and its peers".to_owned(),
        lead: vec![
            bench.machine.line(),
            "The contenders take turns in one process on the same rays; ratios are medians of the rounds' ratios.".to_owned(),
        ],
        sections: Vec::new(),
    };
    for measured in all {
        page.lead.extend(
            (page.sections.is_empty())
                .then(|| format!("{}, {}", measured.report.date, measured.report.command_line)),
        );
        page.sections.push(against(measured)?);
        for mut section in html::sections(&measured.report)? {
            section.title = format!(
                "{}: {}",
                measured.report.scene.name,
                section.title.to_lowercase()
            );
            page.sections.push(section);
        }
    }
    page.sections.extend(more);
    Ok(html::page(&page))
}

/// Ratios to Embree as a plot.
fn against(measured: &Measured) -> Result<Section> {
    let scene = &measured.report.scene;
    let mut plots = Vec::new();
    for (title, of) in [
        (
            "single rays against Embree's single rays",
            (|peer| &peer.vs_embree_single) as fn(&Peer) -> &Option<_>,
        ),
        ("batches against Embree's fastest on each set", |peer| {
            &peer.vs_embree_best
        }),
    ] {
        let standing = |peer: &Peer| {
            let standing = of(peer).as_ref()?;
            let ratios = scene
                .sets
                .iter()
                .map(|set| standing.by_set.get(set).copied());
            Some((peer.row.name.clone(), ratios.collect()))
        };
        let dots = Dots {
            title: title.to_owned(),
            axis: "times as fast as Embree".to_owned(),
            series: scene.sets.clone(),
            rows: measured.peers.iter().filter_map(standing).collect(),
            reference: Some(1.0),
        };
        plots.push(dots.svg()?);
    }
    Ok(Section {
        title: format!("{}: against Embree", scene.name),
        text: vec![
            format!(
                "{} triangles, {} rays a set.",
                scene.triangles, scene.rays_per_set
            ),
            differences(measured),
        ],
        plots,
        ..Section::default()
    })
}
