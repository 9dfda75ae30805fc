//! Numbers drawn into a picture.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use crate::{Image, Scale, tone::linear_to_srgb8};

const MARGIN: u32 = 10;
const PADDING: u32 = 8;
const BAR_WIDTH: u32 = 264;
const BAR_HEIGHT: u32 = 10;
const LINE: u32 = 16;
/// Title, bar, numbers, and what lies between them.
const HEIGHT: u32 = 2 * PADDING + 2 * LINE + BAR_HEIGHT + 8;
const WIDTH: u32 = 2 * PADDING + BAR_WIDTH;

/// Draws the scale into the lower left corner: title, colours, both ends, mean and maximum.
///
/// Pictures narrower than 320 or lower than 100 pixels are left as they are.
pub(crate) fn draw(image: &mut Image, scale: &Scale) {
    if image.width < 320 || image.height < 100 {
        return;
    }
    let (left, top) = (MARGIN, image.height - MARGIN - HEIGHT);
    dim(image, left, top);
    let (x, y) = (left + PADDING, top + PADDING);
    let log = if scale.log { " (log)" } else { "" };
    text(image, x, y, &format!("{}{log}", scale.title), Align::Left);
    bar(image, x, y + LINE + 2, scale);
    let below = y + LINE + BAR_HEIGHT + 6;
    text(image, x, below, &short(scale.low), Align::Left);
    text(
        image,
        x + BAR_WIDTH,
        below,
        &short(scale.high),
        Align::Right,
    );
    let numbers = format!("mean {} max {}", short(scale.mean), short(scale.max));
    text(image, x + BAR_WIDTH / 2, below, &numbers, Align::Middle);
}

#[derive(Clone, Copy)]
enum Align {
    Left,
    Middle,
    Right,
}

/// A panel dark enough for light text on any picture.
fn dim(image: &mut Image, left: u32, top: u32) {
    for y in top..top + HEIGHT {
        for x in left..left + WIDTH {
            blend(image, x, y, [14, 15, 18], 200);
        }
    }
}

fn bar(image: &mut Image, left: u32, top: u32, scale: &Scale) {
    for x in 0..BAR_WIDTH {
        let color = scale
            .color_at(x as f32 / (BAR_WIDTH - 1) as f32)
            .to_array()
            .map(linear_to_srgb8);
        for y in 0..BAR_HEIGHT {
            blend(image, left + x, top + y, color, 255);
        }
    }
}

/// One line of Latin text; `x` is its left end, middle or right end, `y` its top.
fn text(image: &mut Image, x: u32, y: u32, line: &str, align: Align) {
    let advance = get_raster_width(FontWeight::Regular, RasterHeight::Size16) as u32;
    let width = advance * line.chars().count() as u32;
    let left = match align {
        Align::Left => x,
        Align::Middle => x.saturating_sub(width / 2),
        Align::Right => x.saturating_sub(width),
    };
    for (place, letter) in (0..).zip(line.chars()) {
        let Some(raster) = get_raster(letter, FontWeight::Regular, RasterHeight::Size16) else {
            continue;
        };
        for (dy, row) in (0..).zip(raster.rows()) {
            for (dx, &coverage) in (0..).zip(row) {
                blend(
                    image,
                    left + place * advance + dx,
                    y + dy,
                    [235, 235, 235],
                    coverage,
                );
            }
        }
    }
}

/// Lays `color` over a pixel; `coverage` 255 covers it. Outside the picture nothing happens.
fn blend(image: &mut Image, x: u32, y: u32, color: [u8; 3], coverage: u8) {
    if x >= image.width || y >= image.height {
        return;
    }
    let pixel = &mut image.rgb[y as usize * image.width as usize + x as usize];
    for (old, new) in pixel.iter_mut().zip(color) {
        let mixed =
            u16::from(*old) * u16::from(255 - coverage) + u16::from(new) * u16::from(coverage);
        *old = (mixed / 255) as u8;
    }
}

/// At most five characters or so: `0`, `7.25`, `143`, `12.5k`, `3.1M`.
fn short(x: f32) -> String {
    let (x, unit) = match x {
        x if x >= 1e6 => (x / 1e6, "M"),
        x if x >= 1e4 => (x / 1e3, "k"),
        x => (x, ""),
    };
    let digits = if x == x.round() || x >= 100.0 {
        0
    } else if x >= 10.0 {
        1
    } else {
        2
    };
    format!("{x:.digits$}{unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale() -> Scale {
        Scale {
            title: "box tests per ray",
            low: 0.0,
            high: 130.0,
            mean: 41.3,
            max: 286.0,
            log: false,
            reversed: false,
        }
    }

    #[test]
    fn the_legend_stands_in_the_lower_left_corner_and_nowhere_else() {
        let mut image = Image {
            width: 320,
            height: 200,
            rgb: vec![[90; 3]; 320 * 200],
        };
        draw(&mut image, &scale());
        let at = |x: usize, y: usize| image.rgb[y * 320 + x];
        assert_eq!(at(300, 20), [90; 3]);
        let bar_y = (200 - MARGIN - HEIGHT + PADDING + LINE + 5) as usize;
        let bar_x = (MARGIN + PADDING) as usize;
        let brightness = |x: usize| at(x, bar_y).iter().map(|&c| u32::from(c)).sum::<u32>();
        assert!(brightness(bar_x) < 20 && brightness(bar_x + 263) > 500);
        // There is text above and below the bar.
        for y in [bar_y - 12, bar_y + 18] {
            assert!(
                (bar_x..bar_x + 264).any(|x| (0..8).any(|dy| at(x, y - 4 + dy)[0] > 180)),
                "row {y}"
            );
        }
    }

    #[test]
    fn small_pictures_stay_without_a_legend() {
        let mut image = Image {
            width: 64,
            height: 64,
            rgb: vec![[90; 3]; 64 * 64],
        };
        draw(&mut image, &scale());
        assert!(image.rgb.iter().all(|&pixel| pixel == [90; 3]));
    }

    #[test]
    fn numbers_stay_short() {
        for (x, shown) in [
            (0.0, "0"),
            (7.25, "7.25"),
            (41.3, "41.3"),
            (143.4, "143"),
            (12_500.0, "12.5k"),
            (3e6, "3M"),
        ] {
            assert_eq!(short(x), shown);
        }
    }
}
