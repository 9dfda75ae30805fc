//! A report as one HTML page: everything in it, nothing fetched, readable on paper.

use crate::{
    baseline::Comparison,
    contender::Mode,
    error::MeasureError,
    plot::Dots,
    probe::Probe,
    report::{Cell, Report, Row},
};
use std::fmt::Write;

/// What a page holds.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// Its heading.
    pub title: String,
    /// Paragraphs below it.
    pub lead: Vec<String>,
    /// What follows.
    pub sections: Vec<Section>,
}

/// A part of a page.
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// Its heading.
    pub title: String,
    /// Paragraphs.
    pub text: Vec<String>,
    /// SVG.
    pub plots: Vec<String>,
    /// Rows of cells, the first of titles.
    pub table: Vec<Vec<String>>,
    /// What a cell of the table says when it is pointed at, by row and column; may be shorter than the table.
    pub hints: Vec<Vec<String>>,
}

const STYLE: &str = "\
body { font: 16px/1.5 system-ui, sans-serif; color: #111; background: #fff; max-width: 60rem; margin: 2rem auto; padding: 0 1rem }
h1 { line-height: 1.2 } h2 { margin-top: 2.5rem; border-bottom: 1px solid #bbb }
figure { margin: 1rem 0; overflow-x: auto } svg { width: 100%; min-width: 28rem; max-width: 760px; height: auto; display: block }
.wide { overflow-x: auto; width: max-content; min-width: 100%; max-width: calc(100vw - 3rem); position: relative; left: 50%; transform: translateX(-50%) }
table { border-collapse: collapse; font-size: 0.85rem; font-variant-numeric: tabular-nums }
th, td { padding: 0.2rem 0.7rem; text-align: right; border-bottom: 1px solid #ddd; white-space: nowrap }
th:first-child, td:first-child { text-align: left } thead th { border-bottom: 2px solid #555 }
@media print { body { max-width: none; margin: 0; font-size: 10pt } svg, tr { break-inside: avoid } .wide { overflow: visible; width: auto; max-width: none; left: 0; transform: none } svg { min-width: 0 } table { font-size: 7.5pt } }";

/// The page as one file. Text is escaped, plots are put in as they are.
pub fn page(page: &Page) -> String {
    let mut html = String::new();
    let title = escaped(&page.title);
    let _ = write!(
        html,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{STYLE}\n</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
    );
    paragraphs(&mut html, &page.lead);
    for section in &page.sections {
        let _ = writeln!(html, "<h2>{}</h2>", escaped(&section.title));
        paragraphs(&mut html, &section.text);
        for plot in &section.plots {
            let _ = writeln!(html, "<figure>\n{plot}\n</figure>");
        }
        table(&mut html, &section.table, &section.hints);
    }
    html += "</body>\n</html>\n";
    html
}

fn paragraphs(html: &mut String, texts: &[String]) {
    for text in texts {
        let _ = writeln!(html, "<p>{}</p>", escaped(text));
    }
}

fn table(html: &mut String, rows: &[Vec<String>], hints: &[Vec<String>]) {
    if rows.is_empty() {
        return;
    }
    let line = |html: &mut String, row: usize, tag: &str| {
        *html += "<tr>";
        for (column, cell) in rows[row].iter().enumerate() {
            let hint = hints.get(row).and_then(|hints| hints.get(column));
            let hint = hint.filter(|hint| !hint.is_empty());
            let hint = hint.map_or(String::new(), |h| format!(" title=\"{}\"", escaped(h)));
            let _ = write!(html, "<{tag}{hint}>{}</{tag}>", escaped(cell));
        }
        *html += "</tr>\n";
    };
    *html += "<div class=\"wide\">\n<table>\n<thead>\n";
    line(html, 0, "th");
    *html += "</thead>\n<tbody>\n";
    (1..rows.len()).for_each(|row| line(html, row, "td"));
    *html += "</tbody>\n</table>\n</div>\n";
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// What every report shows: speed by set, part of the floor, building, memory, and all numbers. The machine itself, and what
/// the report comes to ([`Report::notices`], [`Report::verdict`], [`Report::busy`]), are for the page's lead.
///
/// # Errors
/// If a plot cannot be drawn.
pub fn sections(report: &Report) -> Result<Vec<Section>, MeasureError> {
    let mut sections = Vec::new();
    if report.cells().next().is_some() {
        sections.push(speed(report)?);
    }
    sections.push(building(report)?);
    if report.cells().any(|cell| cell.of_floor.is_some()) {
        sections.push(of_floor(report)?);
    }
    sections.push(numbers(report));
    sections.push(constants(&report.probe));
    Ok(sections)
}

/// What got better or worse since the run that it was compared with.
pub fn comparison(comparison: &Comparison) -> Section {
    let mut table = vec![
        ["figure", "before", "now", "better by", "noise", ""]
            .map(str::to_owned)
            .to_vec(),
    ];
    let mut changes: Vec<_> = comparison.changes.iter().collect();
    changes.sort_by(|a, b| a.better.total_cmp(&b.better));
    for change in changes {
        let verdict = match change {
            change if change.is_regression() => "worse",
            change if change.is_improvement() => "better",
            _ => "",
        };
        table.push(vec![
            format!("{}, {}", change.contender, change.what),
            format!("{} {}", digits(change.before), change.unit),
            format!("{} {}", digits(change.now), change.unit),
            percent(change.better),
            percent(change.noise),
            verdict.to_owned(),
        ]);
    }
    Section {
        title: "Against the baseline".to_owned(),
        text: vec![format!(
            "The baseline is {}. By a fixed piece of work the machine is now {:.2} times as fast; that is taken out of the changes of times.",
            comparison.baseline, comparison.machine_speed
        )],
        table,
        ..Section::default()
    }
}

/// `batch, 2 threads`.
fn way_name(mode: Mode, threads: usize) -> String {
    let plural = if threads == 1 { "" } else { "s" };
    format!("{}, {threads} thread{plural}", mode.name())
}

/// One plot per set, of what `value` says of each cell; without the rows of which it says nothing.
fn by_set(
    report: &Report,
    axis: &str,
    reference: Option<f64>,
    value: impl Fn(&Cell) -> Option<f64>,
) -> Result<Vec<String>, MeasureError> {
    let ways = report.measured_ways();
    let plot = |set: &str| {
        let of = |row: &Row| {
            let of_way = |&(mode, threads): &(Mode, usize)| value(row.cell(set, mode, threads)?);
            let values: Vec<Option<f64>> = ways.iter().map(of_way).collect();
            let is_any = values.iter().any(Option::is_some);
            is_any.then(|| (row.name.clone(), values))
        };
        Dots {
            title: set.to_owned(),
            axis: axis.to_owned(),
            series: (ways.iter())
                .map(|&(mode, threads)| way_name(mode, threads))
                .collect(),
            rows: report.rows.iter().filter_map(of).collect(),
            reference,
        }
    };
    let plots = report.measured_sets().into_iter().map(plot);
    let plots: Vec<Dots> = plots.filter(|plot| !plot.rows.is_empty()).collect();
    Dots::neighbours(&plots)
}

fn speed(report: &Report) -> Result<Section, MeasureError> {
    Ok(Section {
        title: "Rays per second".to_owned(),
        text: vec![
            "Farther right is faster. primary: through the pixels of a picture; shadow: to a point light; ao: short rays of \
             ambient occlusion; diffuse: one bounce; random: from anywhere to anywhere."
                .to_owned(),
            CLOCKS.to_owned(),
        ],
        plots: by_set(report, "million rays per second", None, |cell| Some(cell.mrays))?,
        ..Section::default()
    })
}

/// How rates are timed.
const CLOCKS: &str =
    "One thread is timed while it has a processor, several threads by the clock on the wall.";

fn of_floor(report: &Report) -> Result<Section, MeasureError> {
    let mut text = vec![
        "1 is the estimated limit: what the nodes and leaves that a ray visits must cost on this machine by arithmetic, waiting and \
         memory, with no bookkeeping. It assumes how many lines of memory are fetched at once. A structure that visits less has a \
         lower limit to reach."
            .to_owned(),
    ];
    text.extend(Report::too_high(report.cells()));
    Ok(Section {
        title: "Part of the estimated limit".to_owned(),
        text,
        plots: by_set(report, "estimated limit / measured", Some(1.0), |cell| {
            cell.of_floor
        })?,
        ..Section::default()
    })
}

fn building(report: &Report) -> Result<Section, MeasureError> {
    let rows = |value: &dyn Fn(&Row) -> Vec<Option<f64>>| {
        report
            .rows
            .iter()
            .map(|row| (row.name.clone(), value(row)))
            .collect()
    };
    let mut series = vec!["1 thread".to_owned()];
    series.extend((report.threads > 1).then(|| format!("{} threads", report.threads)));
    let time = Dots {
        title: "building".to_owned(),
        axis: "milliseconds".to_owned(),
        series,
        rows: rows(&|row| vec![Some(row.build_ms), row.build_ms_all]),
        reference: None,
    };
    let memory = Dots {
        title: "memory".to_owned(),
        axis: "bytes per triangle".to_owned(),
        series: vec!["structure".to_owned()],
        rows: rows(&|row| vec![row.bytes_per_triangle]),
        reference: None,
    };
    Ok(Section {
        title: "Building and memory".to_owned(),
        text: vec!["Farther left is better.".to_owned()],
        plots: Dots::neighbours(&[time, memory])?,
        ..Section::default()
    })
}

fn numbers(report: &Report) -> Section {
    let sets = report.measured_sets();
    let head = ["contender", "way", "build ms", "bytes/triangle"];
    let titles: Vec<String> = (head.iter().chain(&sets))
        .map(|&title| title.to_owned())
        .collect();
    let (mut table, mut hints) = (vec![titles], vec![Vec::new()]);
    for row in &report.rows {
        for (mode, threads) in report.measured_ways() {
            let cells: Vec<Option<&Cell>> = sets
                .iter()
                .map(|set| row.cell(set, mode, threads))
                .collect();
            if cells.iter().any(Option::is_some) {
                let (line, hint) = numbers_line(row, (mode, threads), &cells, report);
                table.push(line);
                hints.push(hint);
            }
        }
    }
    let mut text = vec![
        "Million rays per second. Pointed at, a number says how far the rounds lay apart and, where it is known, which part of the \
         estimated limit was reached."
            .to_owned(),
    ];
    text.extend(report.estimates());
    Section {
        title: "All numbers".to_owned(),
        text,
        table: if table.len() > 1 { table } else { Vec::new() },
        hints,
        ..Section::default()
    }
}

/// A line of the table of all numbers, and what its cells say when they are pointed at.
fn numbers_line(
    row: &Row,
    (mode, threads): (Mode, usize),
    cells: &[Option<&Cell>],
    report: &Report,
) -> (Vec<String>, Vec<String>) {
    let build = if threads == 1 {
        Some(row.build_ms)
    } else {
        row.build_ms_all
    };
    let or_nothing = |x: Option<f64>| x.map_or(String::new(), digits);
    let mut line = vec![row.name.clone(), way_name(mode, threads)];
    line.extend([build, row.bytes_per_triangle].map(or_nothing));
    let mut hint = vec![String::new(); line.len()];
    for cell in cells {
        line.push(cell.map_or(String::new(), |cell| rate(cell, report)));
        hint.push(cell.map_or(String::new(), |cell| hint_of(cell, report)));
    }
    (line, hint)
}

/// `3.21`, `~3.21 est.`
fn rate(cell: &Cell, report: &Report) -> String {
    let unsteady = if cell.is_unsteady() { "~" } else { "" };
    let sampled = if cell.rays < report.scene.rays_per_set {
        " est."
    } else {
        ""
    };
    format!("{unsteady}{}{sampled}", digits(cell.mrays))
}

/// `varies by 1 %; 0.31 of the estimated limit; over 64 of 4096 rays`.
fn hint_of(cell: &Cell, report: &Report) -> String {
    let mut parts = vec![format!("varies by {:.0} %", cell.noise * 100.0)];
    let limit = |part: f64| format!("{part:.2} of the estimated limit");
    parts.extend(cell.of_floor.map(limit));
    parts.push(format!(
        "over {} of {} rays",
        cell.rays, report.scene.rays_per_set
    ));
    parts.join("; ")
}

/// The constants of the floor.
fn constants(probe: &Probe) -> Section {
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    let ns = |x: f64| format!("{} ns", digits(x));
    let cycle = probe.cycle_ns;
    Section {
        title: "The machine's constants".to_owned(),
        text: vec![
            "Measured just before the race, on one thread. The estimated limits are made of these."
                .to_owned(),
        ],
        table: vec![
            row("constant", "value".to_owned()),
            row(
                "clock cycle",
                format!("{} ({:.2} GHz)", ns(cycle), 1.0 / cycle),
            ),
            row("load that waits, first cache", ns(probe.l1_ns)),
            row("second cache", ns(probe.l2_ns)),
            row("third cache", ns(probe.l3_ns)),
            row("memory", ns(probe.dram_ns)),
            row(
                "memory, eight at once, per line",
                ns(probe.dram_parallel_ns),
            ),
            row(
                "products and sums, as compiled",
                format!("{} * 10^9/s", digits(probe.gflops)),
            ),
            row("vectors", format!("{} bit", probe.vector_bits)),
        ],
        ..Section::default()
    }
}

/// Three digits that count.
pub(crate) fn digits(x: f64) -> String {
    let decimals = (2 - x.abs().max(1e-6).log10().floor() as i32).clamp(0, 6) as usize;
    format!("{x:.decimals$}")
}

fn percent(part: f64) -> String {
    format!("{:+.1} %", part * 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{baseline, report::tests::report};

    #[test]
    fn a_page_is_whole_and_fetches_nothing() {
        let report = report(1.0);
        let mut sections = sections(&report).unwrap();
        sections.push(comparison(
            &baseline::compare(&report, &report, "a", 0.05).unwrap(),
        ));
        let html = page(&Page {
            title: report.scene.name.clone(),
            lead: vec!["a & b".to_owned()],
            sections,
        });
        assert!(html.starts_with("<!DOCTYPE html>") && html.ends_with("</html>\n"));
        assert!(html.contains("builtin:&lt;soup&gt;") && html.contains("a &amp; b"));
        // Namespaces of SVG are names, not addresses.
        let addresses = html.replace("http://www.w3.org/", "");
        for word in ["http:", "https:", "<script", "<link", "url(", "src="] {
            assert!(!addresses.contains(word), "{word}");
        }
        assert!(html.contains(
            "title=\"varies by 1 %; 0.38 of the estimated limit; over 4096 of 4096 rays\""
        ));
        assert_eq!(html.matches("<svg").count(), 2 * 2 + 2);
        assert_eq!(html.matches("<svg").count(), html.matches("</svg>").count());
    }

    #[test]
    fn what_was_not_measured_has_no_plot_and_no_column() {
        let mut report = report(1.0);
        report.complete = false;
        report.threads = 2;
        report.rows.iter_mut().for_each(|row| row.cells.truncate(1));
        let shown = |report: &Report| {
            page(&Page {
                sections: sections(report).unwrap(),
                ..Page::default()
            })
        };
        let html = shown(&report);
        assert!(!html.contains("random</th>") && !html.contains("batch, 1 thread"));
        assert_eq!(html.matches("<svg").count(), 1 + 1 + 2);
        report.rows.iter_mut().for_each(|row| row.cells.clear());
        assert_eq!(shown(&report).matches("<svg").count(), 2);
    }

    #[test]
    fn numbers_keep_three_digits() {
        for (x, text) in [
            (0.001_234, "0.00123"),
            (3.456, "3.46"),
            (1234.5, "1234"),
            (99.96, "100.0"),
        ] {
            assert_eq!(digits(x), text);
        }
        assert_eq!(percent(-0.123), "-12.3 %");
    }
}
