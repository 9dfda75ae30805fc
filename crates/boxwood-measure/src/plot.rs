//! Plots as SVG text: readable on paper, without colours, and by those who see fewer of them.
//!
//! The colours are those of Okabe and Ito ("Color Universal Design", 2008); every series has a mark of its own besides.

mod mark;
mod scale;

use crate::error::MeasureError;
use mark::{Mark, colour};
use plotters::{coord::Shift, prelude::*};
use scale::{Rows, Scale};
use std::fmt::Display;

const GREY: RGBColor = RGBColor(120, 120, 120);
const PALE: RGBColor = RGBColor(225, 225, 225);
const FONT: &str = "sans-serif";
/// In pixels.
const WIDTH: u32 = 760;
/// Of a letter, about.
const LETTER: u32 = 7;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Outcome = Result<(), MeasureError>;

/// One mark per value, row by row (Cleveland, "The Elements of Graphing Data", 1985).
#[derive(Clone, Debug, Default)]
pub struct Dots {
    /// Above the plot.
    pub title: String,
    /// Below it, with the unit.
    pub axis: String,
    /// What the marks stand for.
    pub series: Vec<String>,
    /// Each with one value per series, as far as there is one.
    pub rows: Vec<(String, Vec<Option<f64>>)>,
    /// A line across, for "as fast as that".
    pub reference: Option<f64>,
}

/// Marks joined by lines, both axes logarithmic.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    /// Above the plot.
    pub title: String,
    /// Below it and beside it, with the units.
    pub axes: [String; 2],
    /// Each with its name and its points.
    pub series: Vec<(String, Vec<[f64; 2]>)>,
}

impl Dots {
    /// The SVG. The axis is logarithmic, and says so, if the values differ much; values that are not positive are left out.
    ///
    /// # Errors
    /// [`MeasureError::Plot`] in the words of the plotting library.
    pub fn svg(&self) -> Result<String, MeasureError> {
        self.drawn(Scale::around(self.values()))
    }

    /// The SVGs of plots that stand side by side: if the axis of one must be logarithmic, so are all.
    ///
    /// # Errors
    /// As [`Dots::svg`].
    pub fn neighbours(plots: &[Self]) -> Result<Vec<String>, MeasureError> {
        let scales = plots.iter().map(|plot| Scale::around(plot.values()));
        let logarithmic = scales.flatten().any(|scale| scale.is_logarithmic());
        let draw = |plot: &Self| match logarithmic {
            true => plot.drawn(Scale::decades(plot.values())),
            false => plot.svg(),
        };
        plots.iter().map(draw).collect()
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        let values = self.rows.iter().flat_map(|(_, values)| values).flatten();
        values.copied().chain(self.reference)
    }

    fn drawn(&self, scale: Option<Scale>) -> Result<String, MeasureError> {
        let height = head_height(&self.series) + 60 + 20 * self.rows.len() as u32;
        draw(height, |area| {
            let body = head(area, &self.title, &self.series)?;
            let Some(scale) = scale else { return Ok(()) };
            self.on(&body, scale)
        })
    }

    fn on(&self, body: &Area<'_>, scale: Scale) -> Outcome {
        let rows = Rows(self.rows.len() as i32);
        let longest = self.rows.iter().map(|(name, _)| name.chars().count()).max();
        let (low, high) = scale.ends();
        let mut chart = ChartBuilder::on(body)
            .margin_right(16)
            .y_label_area_size((longest.unwrap_or(0) as u32 * LETTER + 14).min(WIDTH / 2))
            .x_label_area_size(44)
            .build_cartesian_2d(scale, rows)
            .map_err(cause)?;
        chart
            .configure_mesh()
            .bold_line_style(PALE)
            .light_line_style(TRANSPARENT)
            .axis_style(GREY)
            .x_desc(named(&self.axis, scale))
            .axis_desc_style((FONT, 14))
            .label_style((FONT, 13))
            .x_labels(12)
            .x_label_formatter(&|x| short(*x))
            .y_labels(self.rows.len() + 2)
            .y_label_formatter(&|row| self.label(*row))
            .draw()
            .map_err(cause)?;
        if let Some(x) = self.reference {
            let ends = [(x, -1), (x, self.rows.len() as i32)];
            let line = PathElement::new(ends, BLACK.stroke_width(1));
            chart.draw_series([line]).map_err(cause)?;
        }
        for (row, (_, values)) in self.rows.iter().enumerate() {
            let marks = values.iter().enumerate().filter_map(|(series, value)| {
                let value = value.filter(|x| (low..=high).contains(x))?;
                Some(Mark::new((value, row as i32), series))
            });
            chart.draw_series(marks).map_err(cause)?;
        }
        Ok(())
    }

    fn label(&self, row: i32) -> String {
        let row = usize::try_from(row).ok().and_then(|row| self.rows.get(row));
        row.map_or(String::new(), |(name, _)| name.clone())
    }
}

impl Lines {
    /// The SVG. Points that are not positive are left out.
    ///
    /// # Errors
    /// [`MeasureError::Plot`] in the words of the plotting library.
    pub fn svg(&self) -> Result<String, MeasureError> {
        let names: Vec<String> = self.series.iter().map(|(name, _)| name.clone()).collect();
        let points = || self.series.iter().flat_map(|(_, points)| points).copied();
        let scales = [0, 1].map(|axis| Scale::decades(points().map(move |point| point[axis])));
        draw(head_height(&names) + 380, |area| {
            let body = head(area, &self.title, &names)?;
            let [Some(x), Some(y)] = scales else {
                return Ok(());
            };
            self.on(&body, x, y)
        })
    }

    fn on(&self, body: &Area<'_>, x: Scale, y: Scale) -> Outcome {
        let ends = [x.ends(), y.ends()];
        let mut chart = ChartBuilder::on(body)
            .margin_right(16)
            .y_label_area_size(64)
            .x_label_area_size(44)
            .build_cartesian_2d(x, y)
            .map_err(cause)?;
        chart
            .configure_mesh()
            .bold_line_style(PALE)
            .light_line_style(TRANSPARENT)
            .axis_style(GREY)
            .x_desc(named(&self.axes[0], x))
            .y_desc(named(&self.axes[1], y))
            .axis_desc_style((FONT, 14))
            .label_style((FONT, 13))
            .x_labels(12)
            .y_labels(12)
            .x_label_formatter(&|x| short(*x))
            .y_label_formatter(&|y| short(*y))
            .draw()
            .map_err(cause)?;
        for (number, (_, points)) in self.series.iter().enumerate() {
            let inside = |p: &&[f64; 2]| (0..2).all(|k| ends[k].0 <= p[k] && p[k] <= ends[k].1);
            let points: Vec<(f64, f64)> =
                points.iter().filter(inside).map(|p| (p[0], p[1])).collect();
            let line = LineSeries::new(points.iter().copied(), colour(number).stroke_width(2));
            chart.draw_series(line).map_err(cause)?;
            let marks = points.into_iter().map(|point| Mark::new(point, number));
            chart.draw_series(marks).map_err(cause)?;
        }
        Ok(())
    }
}

/// What stands at an axis.
fn named(axis: &str, scale: Scale) -> String {
    let log = if scale.is_logarithmic() { " (log)" } else { "" };
    format!("{axis}{log}")
}

/// An SVG of the usual width, drawn by `paint`.
fn draw(height: u32, paint: impl FnOnce(&Area<'_>) -> Outcome) -> Result<String, MeasureError> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (WIDTH, height)).into_drawing_area();
        area.fill(&WHITE).map_err(cause)?;
        paint(&area)?;
        area.present().map_err(cause)?;
    }
    Ok(text)
}

fn cause(error: impl Display) -> MeasureError {
    MeasureError::Plot {
        cause: error.to_string(),
    }
}

/// Where each name of the legend stands: line and left edge.
fn legend(series: &[String]) -> Vec<(i32, i32)> {
    let (mut line, mut x) = (0, 16);
    let mut places = Vec::new();
    for name in series {
        let width = (name.chars().count() as u32 * LETTER + 34) as i32;
        if x + width > WIDTH as i32 && x > 16 {
            (line, x) = (line + 1, 16);
        }
        places.push((line, x));
        x += width;
    }
    places
}

fn head_height(series: &[String]) -> u32 {
    let lines = legend(series)
        .last()
        .map_or(0, |(line, _)| *line as u32 + 1);
    34 + 20 * lines
}

/// Title and legend; gives what is left below them.
fn head<'a>(area: &Area<'a>, title: &str, series: &[String]) -> Result<Area<'a>, MeasureError> {
    let (head, body) = area.split_vertically(head_height(series));
    let bold = (FONT, 17).into_font().style(FontStyle::Bold);
    head.draw(&Text::new(title.to_owned(), (8, 8), bold))
        .map_err(cause)?;
    for (number, (line, x)) in legend(series).into_iter().enumerate() {
        let y = 42 + 20 * line;
        head.draw(&Mark::new((x, y), number)).map_err(cause)?;
        let name = Text::new(series[number].clone(), (x + 10, y - 8), (FONT, 14));
        head.draw(&name).map_err(cause)?;
    }
    Ok(body)
}

/// `0.05`, `3`, `20k`, `10M`.
fn short(x: f64) -> String {
    match x.abs() {
        a if a >= 1e6 => format!("{}M", rounded(x / 1e6)),
        a if a >= 1e4 => format!("{}k", rounded(x / 1e3)),
        _ => rounded(x),
    }
}

/// Without the noise of binary fractions.
fn rounded(x: f64) -> String {
    let text = format!("{x:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dots(values: [f64; 2]) -> Dots {
        Dots {
            title: "Speed & <more>".to_owned(),
            axis: "Mray/s".to_owned(),
            series: vec!["single".to_owned(), "batch".to_owned()],
            rows: vec![
                ("list".to_owned(), vec![Some(values[0]), None]),
                ("grid".to_owned(), vec![Some(values[1]), Some(f64::NAN)]),
            ],
            reference: Some(1.0),
        }
    }

    #[test]
    fn a_plot_is_svg_with_every_name_and_a_mark_per_value() {
        let svg = dots([2.0, 3.0]).svg().unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        for word in [
            "Speed &amp; &lt;more&gt;",
            "single",
            "batch",
            "list",
            "grid",
            "Mray/s",
        ] {
            assert!(svg.contains(word), "{word}");
        }
        // Two marks in the legend, two values; the NaN is left out.
        assert_eq!(svg.matches("<circle").count(), 4);
    }

    #[test]
    fn neighbours_have_the_same_kind_of_axis() {
        let [near, far] = [[2.0, 3.0], [2.0, 300.0]].map(dots);
        let is_log = |svg: &String| svg.contains("Mray/s (log)");
        let alone = [near.svg().unwrap(), far.svg().unwrap()];
        assert_eq!(alone.each_ref().map(is_log), [false, true]);
        let together = Dots::neighbours(&[near.clone(), far]).unwrap();
        assert!(together.iter().all(is_log));
        let calm = Dots::neighbours(&[near.clone(), near]).unwrap();
        assert!(!calm.iter().any(is_log));
    }

    #[test]
    fn nothing_to_show_is_no_error() {
        assert!(dots([f64::NAN, -3.0]).svg().is_ok());
        assert!(Dots::default().svg().is_ok());
        assert!(Lines::default().svg().is_ok());
    }

    #[test]
    fn lines_join_their_points() {
        let lines = Lines {
            title: "Growth".to_owned(),
            axes: ["triangles".to_owned(), "Mray/s".to_owned()],
            series: (0..5)
                .map(|i| {
                    (
                        format!("s{i}"),
                        vec![[1e3, 3.0], [1e6, 0.5 + f64::from(i)], [0.0, 1.0]],
                    )
                })
                .collect(),
        };
        let svg = lines.svg().unwrap();
        assert!(svg.contains("1M") && svg.contains("polyline"));
    }

    #[test]
    fn labels_are_short() {
        let cases = [
            (0.05, "0.05"),
            (3.0, "3"),
            (20_000.0, "20k"),
            (1e7, "10M"),
            (0.300_000_004, "0.3"),
        ];
        for (x, text) in cases {
            assert_eq!(short(x), text);
        }
    }
}
