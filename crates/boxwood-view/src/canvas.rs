//! Letters, lines and panels on a picture.

use boxwood_render::Image;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Eight-bit sRGB.
pub(crate) type Color = [u8; 3];

pub(crate) const WHITE: Color = [240, 240, 240];
pub(crate) const GREY: Color = [165, 168, 175];
pub(crate) const DARK: Color = [14, 15, 18];
/// Four colours of Okabe and Ito (2008), which colour-blind people tell apart.
pub(crate) const GREEN: Color = [30, 205, 145];
pub(crate) const BLUE: Color = [86, 180, 233];
pub(crate) const ORANGE: Color = [240, 165, 20];
pub(crate) const YELLOW: Color = [240, 228, 66];
pub(crate) const RED: Color = [255, 120, 80];

/// How a line is drawn, so that nothing is told by colour alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stroke {
    Solid,
    Dashed,
    Dotted,
}

/// A picture that is drawn on, with letters of a size that suits it.
#[derive(Debug)]
pub(crate) struct Canvas<'a> {
    image: &'a mut Image,
    letters: RasterHeight,
    /// How wide lines are, in pixels.
    pen: i32,
}

impl<'a> Canvas<'a> {
    /// Letters are a 45th of the height or so, 16 to 32 pixels.
    pub(crate) fn new(image: &'a mut Image) -> Self {
        let (letters, pen) = match image.height {
            0..800 => (RasterHeight::Size16, 1),
            800..1000 => (RasterHeight::Size20, 1),
            1000..1400 => (RasterHeight::Size24, 2),
            _ => (RasterHeight::Size32, 3),
        };
        Self {
            image,
            letters,
            pen,
        }
    }

    pub(crate) fn width(&self) -> i32 {
        self.image.width as i32
    }

    pub(crate) fn height(&self) -> i32 {
        self.image.height as i32
    }

    /// From one line of text to the next.
    pub(crate) fn line_height(&self) -> i32 {
        self.letters.val() as i32 * 5 / 4
    }

    /// From one letter to the next.
    pub(crate) fn advance(&self) -> i32 {
        get_raster_width(FontWeight::Regular, self.letters) as i32
    }

    /// Space around text.
    pub(crate) fn margin(&self) -> i32 {
        self.letters.val() as i32 / 2
    }

    /// Letters that fit into `width` pixels.
    pub(crate) fn letters_in(&self, width: i32) -> usize {
        (width / self.advance()).max(0) as usize
    }

    /// One line of Latin text with its upper left corner at `(x, y)`.
    pub(crate) fn text(&mut self, x: i32, y: i32, line: &str, color: Color) {
        let advance = self.advance();
        for (place, letter) in (0..).zip(line.chars()) {
            let raster = get_raster(letter, FontWeight::Regular, self.letters)
                .or_else(|| get_raster('?', FontWeight::Regular, self.letters));
            let Some(raster) = raster else { continue };
            for (dy, row) in (0..).zip(raster.rows()) {
                for (dx, &coverage) in (0..).zip(row) {
                    if coverage > 0 {
                        self.blend(x + place * advance + dx, y + dy, color, coverage);
                    }
                }
            }
        }
    }

    /// A panel dark enough for light text on any picture.
    pub(crate) fn panel(&mut self, x: i32, y: i32, width: i32, height: i32) {
        self.fill(x, y, width, height, DARK, 208);
    }

    /// A rectangle; `coverage` 255 hides what is below.
    pub(crate) fn fill(
        &mut self,
        x: i32,
        y: i32,
        width: i32,
        height: i32,
        color: Color,
        coverage: u8,
    ) {
        for y in y.max(0)..(y + height).min(self.height()) {
            for x in x.max(0)..(x + width).min(self.width()) {
                self.blend(x, y, color, coverage);
            }
        }
    }

    /// Lines of text on a panel whose upper left corner is at `(x, y)`; its size.
    pub(crate) fn paragraph(&mut self, x: i32, y: i32, lines: &[(String, Color)]) -> [i32; 2] {
        let [width, height] = self.paragraph_size(lines);
        self.panel(x, y, width, height);
        let (margin, step) = (self.margin(), self.line_height());
        for (row, (line, color)) in (0..).zip(lines) {
            self.text(x + margin, y + margin / 2 + row * step, line, *color);
        }
        [width, height]
    }

    /// Of the panel of [`Canvas::paragraph`].
    pub(crate) fn paragraph_size(&self, lines: &[(String, Color)]) -> [i32; 2] {
        let longest = lines.iter().map(|(line, _)| line.chars().count()).max();
        let width = longest.unwrap_or(0) as i32 * self.advance() + 2 * self.margin();
        [
            width,
            lines.len() as i32 * self.line_height() + self.margin(),
        ]
    }

    /// A straight line between two points in pixels, cut off at the edges.
    pub(crate) fn line(&mut self, from: [f32; 2], to: [f32; 2], color: Color, stroke: Stroke) {
        self.stroke(from, to, color, stroke, 230);
    }

    /// A line through which the picture shows.
    pub(crate) fn faint_line(
        &mut self,
        from: [f32; 2],
        to: [f32; 2],
        color: Color,
        stroke: Stroke,
    ) {
        self.stroke(from, to, color, stroke, 110);
    }

    fn stroke(&mut self, from: [f32; 2], to: [f32; 2], color: Color, stroke: Stroke, coverage: u8) {
        let size = [self.width() as f32, self.height() as f32];
        let Some([from, to]) = clip(from, to, size) else {
            return;
        };
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let steps = dx.abs().max(dy.abs()).ceil().max(1.0) as i32;
        for step in 0..=steps {
            let period = step / self.pen;
            let is_drawn = match stroke {
                Stroke::Solid => true,
                Stroke::Dashed => period % 12 < 8,
                Stroke::Dotted => period % 5 < 2,
            };
            if !is_drawn {
                continue;
            }
            let share = step as f32 / steps as f32;
            let [x, y] = [(from[0] + dx * share) as i32, (from[1] + dy * share) as i32];
            for breadth in 0..self.pen {
                // Steep lines are broad to the side, flat ones downwards.
                let [bx, by] = if dx.abs() > dy.abs() {
                    [0, breadth]
                } else {
                    [breadth, 0]
                };
                self.blend(x + bx, y + by, color, coverage);
            }
        }
    }

    /// Lays `color` over a pixel; `coverage` 255 covers it. Outside the picture nothing happens.
    fn blend(&mut self, x: i32, y: i32, color: Color, coverage: u8) {
        if x < 0 || y < 0 || x >= self.width() || y >= self.height() {
            return;
        }
        let at = y as usize * self.image.width as usize + x as usize;
        let pixel = &mut self.image.rgb[at];
        for (old, new) in pixel.iter_mut().zip(color) {
            let mixed =
                u16::from(*old) * u16::from(255 - coverage) + u16::from(new) * u16::from(coverage);
            *old = (mixed / 255) as u8;
        }
    }
}

/// The part of a line within `0..=size` (Liang and Barsky, 1984); none if it is all outside or not finite.
fn clip(from: [f32; 2], to: [f32; 2], size: [f32; 2]) -> Option<[[f32; 2]; 2]> {
    // In f64, for lines from far away.
    let [from, to, size] = [from, to, size].map(|p| p.map(f64::from));
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let way = to[axis] - from[axis];
        let [to_low, to_high] = [-from[axis], size[axis] - from[axis]];
        if !way.is_finite() {
            return None;
        }
        if way == 0.0 {
            if to_low > 0.0 || to_high < 0.0 {
                return None;
            }
            continue;
        }
        let [a, b] = [to_low / way, to_high / way];
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    let at = |share: f64| [0, 1].map(|axis| (from[axis] + (to[axis] - from[axis]) * share) as f32);
    (first <= last).then(|| [at(first), at(last)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn black(width: u32, height: u32) -> Image {
        Image {
            width,
            height,
            rgb: vec![[0; 3]; (width * height) as usize],
        }
    }

    fn lit(image: &Image) -> usize {
        image.rgb.iter().filter(|pixel| **pixel != [0; 3]).count()
    }

    #[test]
    fn text_is_drawn_where_it_is_put_and_cut_off_at_the_edges() {
        let mut image = black(200, 40);
        Canvas::new(&mut image).text(100, 10, "ray", WHITE);
        assert!(lit(&image) > 40);
        let left_half = |i: usize| i % 200 < 100;
        assert!((0..image.rgb.len()).all(|i| !left_half(i) || image.rgb[i] == [0; 3]));
        Canvas::new(&mut image).text(-1000, -1000, "ray", WHITE);
        Canvas::new(&mut image).text(190, 35, "ray", WHITE);
    }

    #[test]
    fn letters_grow_with_the_window() {
        let advance = |height| Canvas::new(&mut black(1, height)).advance();
        assert!(advance(720) < advance(1080) && advance(1080) < advance(2160));
    }

    #[test]
    fn strokes_differ_in_more_than_colour() {
        let drawn = [Stroke::Solid, Stroke::Dashed, Stroke::Dotted].map(|stroke| {
            let mut image = black(120, 9);
            Canvas::new(&mut image).line([0.0, 4.0], [119.0, 4.0], GREEN, stroke);
            lit(&image)
        });
        assert!(drawn[0] > drawn[1] && drawn[1] > drawn[2], "{drawn:?}");
    }

    #[test]
    fn lines_from_far_outside_are_cut_off() {
        let mut image = black(30, 20);
        let mut canvas = Canvas::new(&mut image);
        canvas.line([-1e9, 10.0], [1e9, 10.0], BLUE, Stroke::Solid);
        canvas.line([f32::NAN, 0.0], [3.0, 3.0], BLUE, Stroke::Solid);
        canvas.line([-5.0, -5.0], [-9.0, 30.0], BLUE, Stroke::Solid);
        assert_eq!(lit(&image), 30);
    }
}
