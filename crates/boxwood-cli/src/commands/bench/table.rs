//! What `boxwood bench` says to people.

use boxwood_measure::{
    Cell, Mode, Report, Row,
    baseline::{Change, Comparison},
};

use super::has_same_answer;
use crate::output::{Table, counted, grouped, short};

/// Scene, rays, rounds.
pub(super) fn heading(report: &Report) -> String {
    let scene = &report.scene;
    let (cells, all) = (
        report.rows.iter().flat_map(|row| &row.cells),
        scene.rays_per_set,
    );
    let estimates = if cells.into_iter().any(|cell| cell.rays < all) {
        "; est.: over a sample of the rays"
    } else {
        ""
    };
    format!(
        "{}: {}, {} rays a set, {} rounds{estimates}",
        scene.name,
        counted(scene.triangles, "triangle"),
        grouped(all as u64),
        report.rounds,
    )
}

/// The tables, and the comparison.
pub(super) fn text(report: &Report, comparison: Option<&Comparison>) -> String {
    let mut parts = vec![
        format!("{}\n{}", heading(report), report.machine.line()),
        format!("Million rays per second:\n{}", rates(report)),
        format!(
            "Part of this machine's limit, one thread (1: it cannot be done faster with the same nodes and leaves):\n{}",
            limits(report)
        ),
    ];
    let wrong: Vec<&str> = report
        .rows
        .iter()
        .filter(|row| !has_same_answer(row))
        .map(|row| &*row.name)
        .collect();
    if !wrong.is_empty() {
        parts.push(format!("NOT THE SAME ANSWER: {}", wrong.join(", ")));
    }
    if !report.machine.optimised {
        parts.push("This is a debug build: the figures are worthless.".to_owned());
    }
    if !report.complete {
        parts.push("Interrupted: what is missing was not measured.".to_owned());
    }
    parts.extend(comparison.map(compared));
    parts.join("\n\n")
}

/// The ways to ask that there are.
fn ways(report: &Report) -> Vec<(Mode, usize)> {
    let mut threads = vec![1, report.threads];
    threads.dedup();
    threads
        .into_iter()
        .flat_map(|threads| Mode::ALL.map(|mode| (mode, threads)))
        .collect()
}

/// A line for each contender and way, a column for each set.
fn lines<'a>(
    report: &'a Report,
    ways: &[(Mode, usize)],
    titles: &[&str],
    head: impl Fn(&Row, usize) -> Vec<String>,
    value: impl Fn(&'a Cell) -> String,
) -> Table {
    let sets = &report.scene.sets;
    let titles = titles.iter().map(|&title| title.to_owned());
    let mut table = Table::new(titles.chain(sets.iter().cloned()));
    for row in &report.rows {
        for &(mode, threads) in ways {
            let cells: Vec<_> = sets
                .iter()
                .map(|set| row.cell(set, mode, threads))
                .collect();
            // Who was built, but not raced before the end, is there with that.
            if cells.iter().any(Option::is_some) || row.cells.is_empty() {
                let mut line = vec![row.name.clone(), format!("{} x{threads}", mode.name())];
                line.extend(head(row, threads));
                line.extend(
                    cells
                        .into_iter()
                        .map(|cell| cell.map_or(String::new(), &value)),
                );
                table.row(line);
            }
        }
    }
    table
}

fn rates(report: &Report) -> Table {
    let titles = ["structure", "asked", "build ms", "B/triangle"];
    let head = |row: &Row, threads| {
        let build = if threads == 1 {
            Some(row.build_ms)
        } else {
            row.build_ms_all
        };
        [build, row.bytes_per_triangle]
            .map(|x| x.map_or(String::new(), short))
            .to_vec()
    };
    lines(report, &ways(report), &titles, head, |cell| {
        let sampled = if cell.rays < report.scene.rays_per_set {
            " est."
        } else {
            ""
        };
        format!("{}{sampled}", short(cell.mrays))
    })
}

fn limits(report: &Report) -> Table {
    let ways = Mode::ALL.map(|mode| (mode, 1));
    let none = |_: &Row, _| Vec::new();
    lines(report, &ways, &["structure", "asked"], none, |cell| {
        cell.of_floor
            .map_or(String::new(), |part| format!("{part:.2}"))
    })
}

/// What got worse and what got better.
fn compared(comparison: &Comparison) -> String {
    let mut lines = vec![format!(
        "Against {}, on a machine that is {:.2} times as fast by a fixed piece of work:",
        comparison.baseline, comparison.machine_speed
    )];
    if !comparison.same_machine {
        lines.push("  that was another machine: the changes say little".to_owned());
    }
    let line = |change: &Change| {
        format!(
            "  {} {}, {}: {} -> {} {}, {:+.1} % (noise: {:.1} %)",
            if change.is_regression() {
                "WORSE "
            } else {
                "better"
            },
            change.contender,
            change.what,
            short(change.before),
            short(change.now),
            change.unit,
            100.0 * change.better,
            100.0 * change.noise
        )
    };
    let regressions = comparison.regressions();
    lines.extend(regressions.iter().map(|change| line(change)));
    lines.extend(
        comparison
            .changes
            .iter()
            .filter(|change| change.is_improvement())
            .map(line),
    );
    lines.extend(
        comparison
            .missing
            .iter()
            .map(|name| format!("  not in this run: {name}")),
    );
    lines.push(format!(
        "  {} of {} figures got worse by more than noise",
        regressions.len(),
        comparison.changes.len()
    ));
    lines.join("\n")
}
