//! The marks of plots: told apart by their shape, and by colour where there is any.

use plotters::{
    element::{Drawable, PointCollection},
    prelude::*,
};
use plotters_backend::{BackendCoord, DrawingErrorKind};

use std::iter::{Once, once};

/// Blue, vermilion, green, purple, orange, sky blue, black.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

/// The colour of a series.
pub(super) fn colour(series: usize) -> RGBColor {
    COLOURS[series % COLOURS.len()]
}

/// The mark of a series at a place: a disc, a ring, a triangle, a cross, a square, and again from the first.
pub(super) struct Mark<C> {
    at: C,
    series: usize,
}

impl<C> Mark<C> {
    pub(super) fn new(at: C, series: usize) -> Self {
        Self { at, series }
    }
}

impl<'a, C> PointCollection<'a, C> for &'a Mark<C> {
    type IntoIter = Once<&'a C>;
    type Point = &'a C;

    fn point_iter(self) -> Self::IntoIter {
        once(&self.at)
    }
}

impl<C, B: DrawingBackend> Drawable<B> for Mark<C> {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        mut places: I,
        backend: &mut B,
        _: (u32, u32),
    ) -> Result<(), DrawingErrorKind<B::ErrorType>> {
        let Some((x, y)) = places.next() else {
            return Ok(());
        };
        let colour = colour(self.series);
        let line = colour.stroke_width(2);
        match self.series % 5 {
            0 => backend.draw_circle((x, y), 5, &colour, true),
            1 => backend.draw_circle((x, y), 5, &line, false),
            2 => backend.fill_polygon([(x, y - 6), (x - 6, y + 4), (x + 6, y + 4)], &colour),
            3 => {
                backend.draw_line((x - 4, y - 4), (x + 4, y + 4), &line)?;
                backend.draw_line((x - 4, y + 4), (x + 4, y - 4), &line)
            }
            _ => backend.draw_rect((x - 4, y - 4), (x + 4, y + 4), &colour, true),
        }
    }
}
