//! A report as one HTML page: everything in it, nothing fetched, readable on paper.

use crate::{
    baseline::Comparison,
    contender::Mode,
    error::MeasureError,
    machine::Machine,
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
}

const STYLE: &str = "\
body { font: 16px/1.5 system-ui, sans-serif; color: #111; background: #fff; max-width: 60rem; margin: 2rem auto; padding: 0 1rem }
h1 { line-height: 1.2 } h2 { margin-top: 2.5rem; border-bottom: 1px solid #bbb }
svg { max-width: 100%; height: auto; display: block; margin: 1rem 0 }
.wide { overflow-x: auto } table { border-collapse: collapse; font-size: 0.85rem; font-variant-numeric: tabular-nums }
th, td { padding: 0.2rem 0.7rem; text-align: right; border-bottom: 1px solid #ddd; white-space: nowrap }
th:first-child, td:first-child { text-align: left } thead th { border-bottom: 2px solid #555 }
@media print { body { max-width: none; margin: 0; font-size: 10pt } svg, tr { break-inside: avoid } .wide { overflow: visible } table { font-size: 7.5pt } }";

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
        table(&mut html, &section.table);
    }
    html += "</body>\n</html>\n";
    html
}

fn paragraphs(html: &mut String, texts: &[String]) {
    for text in texts {
        let _ = writeln!(html, "<p>{}</p>", escaped(text));
    }
}

fn table(html: &mut String, rows: &[Vec<String>]) {
    let Some((titles, rows)) = rows.split_first() else {
        return;
    };
    let line = |html: &mut String, cells: &[String], tag: &str| {
        *html += "<tr>";
        for cell in cells {
            let _ = write!(html, "<{tag}>{}</{tag}>", escaped(cell));
        }
        *html += "</tr>\n";
    };
    *html += "<div class=\"wide\">\n<table>\n<thead>\n";
    line(html, titles, "th");
    *html += "</thead>\n<tbody>\n";
    rows.iter().for_each(|row| line(html, row, "td"));
    *html += "</tbody>\n</table>\n</div>\n";
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// What every report shows: speed by set, part of the floor, building, memory, and all numbers.
///
/// # Errors
/// If a plot cannot be drawn.
pub fn sections(report: &Report) -> Result<Vec<Section>, MeasureError> {
    let mut sections = vec![speed(report)?, building(report)?];
    if report
        .rows
        .iter()
        .flat_map(|row| &row.cells)
        .any(|cell| cell.of_floor.is_some())
    {
        sections.push(of_floor(report)?);
    }
    sections.push(numbers(report));
    sections.push(machine(&report.machine, &report.probe));
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

/// The ways in which cells were asked, and their names.
fn ways(report: &Report) -> Vec<(Mode, usize, String)> {
    let threads = if report.threads > 1 {
        vec![1, report.threads]
    } else {
        vec![1]
    };
    let way = |threads| {
        Mode::ALL.map(|mode| {
            let plural = if threads == 1 { "" } else { "s" };
            (
                mode,
                threads,
                format!("{}, {threads} thread{plural}", mode.name()),
            )
        })
    };
    threads.into_iter().flat_map(way).collect()
}

/// One plot per set, of what `value` says of each cell.
fn by_set(
    report: &Report,
    axis: &str,
    reference: Option<f64>,
    value: impl Fn(&Cell) -> Option<f64>,
) -> Result<Vec<String>, MeasureError> {
    let ways = ways(report);
    let plot = |set: &String| {
        let of = |row: &Row| {
            let of_way =
                |(mode, threads, _): &(Mode, usize, String)| value(row.cell(set, *mode, *threads)?);
            (row.name.clone(), ways.iter().map(of_way).collect())
        };
        let dots = Dots {
            title: set.clone(),
            axis: axis.to_owned(),
            series: ways.iter().map(|(.., name)| name.clone()).collect(),
            rows: report.rows.iter().map(of).collect(),
            reference,
        };
        dots.svg()
    };
    report.scene.sets.iter().map(plot).collect()
}

fn speed(report: &Report) -> Result<Section, MeasureError> {
    Ok(Section {
        title: "Rays per second".to_owned(),
        text: vec!["Farther right is faster. primary: through the pixels of a picture; shadow: to a point light; ao: short rays of \
                    ambient occlusion; diffuse: one bounce; random: from anywhere to anywhere."
            .to_owned()],
        plots: by_set(report, "million rays per second", None, |cell| Some(cell.mrays))?,
        ..Section::default()
    })
}

fn of_floor(report: &Report) -> Result<Section, MeasureError> {
    Ok(Section {
        title: "Part of this machine's limit".to_owned(),
        text: vec![
            "1 is the limit: what the nodes and leaves that a ray visits must cost on this machine by arithmetic, waiting and memory, \
             with no bookkeeping. A structure that visits less has a lower limit to reach."
                .to_owned(),
        ],
        plots: by_set(report, "limit / measured", Some(1.0), |cell| cell.of_floor)?,
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
        plots: vec![time.svg()?, memory.svg()?],
        ..Section::default()
    })
}

fn numbers(report: &Report) -> Section {
    let mut titles = vec![
        "contender".to_owned(),
        "way".to_owned(),
        "build ms".to_owned(),
        "bytes/triangle".to_owned(),
    ];
    titles.extend(report.scene.sets.iter().cloned());
    let mut table = vec![titles];
    for row in &report.rows {
        for (mode, threads, way) in ways(report) {
            let cells: Vec<String> = report
                .scene
                .sets
                .iter()
                .map(|set| {
                    row.cell(set, mode, threads)
                        .map_or(String::new(), |cell| numbers_of(cell, report))
                })
                .collect();
            if cells.iter().any(|cell| !cell.is_empty()) {
                let build = if threads == 1 {
                    Some(row.build_ms)
                } else {
                    row.build_ms_all
                };
                let mut line = vec![row.name.clone(), way, build.map_or(String::new(), digits)];
                line.push(row.bytes_per_triangle.map_or(String::new(), digits));
                line.extend(cells);
                table.push(line);
            }
        }
    }
    Section {
        title: "All numbers".to_owned(),
        text: vec![
            "Million rays per second; in brackets how far the rounds lay apart and, where it is known, which part of the limit was \
             reached. est.: asked about a sample of the rays."
                .to_owned(),
        ],
        table,
        ..Section::default()
    }
}

/// `3.21 (1 %, 0.31 of the limit)`.
fn numbers_of(cell: &Cell, report: &Report) -> String {
    let limit = cell
        .of_floor
        .map_or(String::new(), |part| format!(", {part:.2}"));
    let sampled = if cell.rays < report.scene.rays_per_set {
        " est."
    } else {
        ""
    };
    format!(
        "{} ({:.0} %{limit}){sampled}",
        digits(cell.mrays),
        cell.noise * 100.0
    )
}

/// The machine, and the constants of the floor.
pub fn machine(machine: &Machine, probe: &Probe) -> Section {
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    let ns = |x: f64| format!("{} ns", digits(x));
    let cycle = probe.cycle_ns;
    Section {
        title: "The machine".to_owned(),
        text: vec![
            machine.line(),
            "Measured just before the race, on one thread. The limits are made of these."
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
fn digits(x: f64) -> String {
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
        assert_eq!(html.matches("<svg").count(), 2 * 2 + 2);
        assert_eq!(html.matches("<svg").count(), html.matches("</svg>").count());
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
