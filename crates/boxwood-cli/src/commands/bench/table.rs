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
    format!(
        "{}: {}, {} rays a set, {} rounds",
        scene.name,
        counted(scene.triangles, "triangle"),
        grouped(scene.rays_per_set as u64),
        report.rounds,
    )
}

/// The tables, the comparison, the verdict.
pub(super) fn text(report: &Report, comparison: Option<&Comparison>) -> String {
    let mut parts = report.notices();
    parts.push(format!("{}\n{}", heading(report), report.machine.line()));
    parts.push(rates(report));
    if report.cells().any(|cell| cell.of_floor.is_some()) {
        parts.push(limits(report));
    }
    let wrong: Vec<&str> = report
        .rows
        .iter()
        .filter(|row| !has_same_answer(row))
        .map(|row| &*row.name)
        .collect();
    if !wrong.is_empty() {
        parts.push(format!("NOT THE SAME ANSWER: {}", wrong.join(", ")));
    }
    parts.extend(comparison.map(compared));
    parts.extend(report.verdict());
    parts.join("\n\n")
}

/// A line for each contender and way, a column for each set of which there is a figure.
fn lines<'a>(
    report: &'a Report,
    ways: &[(Mode, usize)],
    titles: &[&str],
    head: impl Fn(&Row, usize) -> Vec<String>,
    value: impl Fn(&'a Cell) -> String,
) -> Table {
    let sets = report.measured_sets();
    let mut table = Table::new(titles.iter().chain(&sets).copied());
    for row in &report.rows {
        for &(mode, threads) in ways {
            let cells: Vec<_> = sets
                .iter()
                .map(|set| row.cell(set, mode, threads))
                .collect();
            if cells.iter().any(Option::is_some) {
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

fn rates(report: &Report) -> String {
    if report.cells().next().is_none() {
        return format!("Built, but not raced:\n{}", builds(report));
    }
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
    let ways = report.measured_ways();
    let table = lines(report, &ways, &titles, head, |cell| {
        let unsteady = if cell.is_unsteady() { "~" } else { "" };
        let sampled = if cell.rays < report.scene.rays_per_set {
            " est."
        } else {
            ""
        };
        format!("{unsteady}{}{sampled}", short(cell.mrays))
    });
    let clocks = match report.threads {
        1 => "x1: processor time of the thread".to_owned(),
        many => format!("x1: processor time of the thread, x{many}: wall time"),
    };
    let mut lines = vec![
        format!("Million rays per second ({clocks}):"),
        table.to_string(),
    ];
    lines.extend(report.estimates());
    lines.extend(report.busy());
    lines.join("\n")
}

/// All that there is of a race that ended before its first round.
fn builds(report: &Report) -> Table {
    let mut table = Table::new(["structure", "build ms", "B/triangle"]);
    for row in &report.rows {
        let bytes = row.bytes_per_triangle.map_or(String::new(), short);
        table.row([row.name.clone(), short(row.build_ms), bytes]);
    }
    table
}

fn limits(report: &Report) -> String {
    let ways = Mode::ALL.map(|mode| (mode, 1));
    let none = |_: &Row, _| Vec::new();
    let table = lines(report, &ways, &["structure", "asked"], none, |cell| {
        cell.of_floor
            .map_or(String::new(), |part| format!("{part:.2}"))
    });
    let mut lines = vec![
        "Part of the estimated limit, one thread (1: what the nodes and leaves visited must cost here, by an estimate that assumes\n\
         how many lines of memory are fetched at once):"
            .to_owned(),
        table.to_string(),
    ];
    let one_thread = report.cells().filter(|cell| cell.threads == 1);
    lines.extend(Report::too_high(one_thread));
    lines.join("\n")
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
