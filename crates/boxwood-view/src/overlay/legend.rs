//! What the colours of costs and depths mean.

use boxwood_render::{Scale, linear_to_srgb8};

use crate::canvas::{Canvas, WHITE};

/// From its upper edge to the lower edge of the picture.
pub(crate) fn height(canvas: &Canvas<'_>) -> i32 {
    3 * canvas.line_height() + 3 * canvas.margin()
}

/// Title, colours, both ends, mean and maximum: in the lower left corner of the part of the picture that begins at `left`.
pub(crate) fn draw(canvas: &mut Canvas<'_>, left: i32, scale: &Scale, structure: &str) {
    let (margin, step) = (canvas.margin(), canvas.line_height());
    let width = 36 * canvas.advance();
    let height = 2 * step + step;
    let (x, y) = (left + 2 * margin, canvas.height() - height - 2 * margin);
    canvas.panel(
        x - margin,
        y - margin,
        width + 2 * margin,
        height + 2 * margin,
    );
    let log = if scale.log { " (log)" } else { "" };
    canvas.text(x, y, &format!("{structure}: {}{log}", scale.title), WHITE);
    for dx in 0..width {
        let color = scale.color_at(dx as f32 / (width - 1) as f32);
        let color = color.to_array().map(linear_to_srgb8);
        canvas.fill(x + dx, y + step + step / 8, 1, step * 3 / 4, color, 255);
    }
    let numbers = format!("mean {}  max {}", short(scale.mean), short(scale.max));
    let [low, high] = [scale.low, scale.high].map(short);
    let right = |text: &str| x + width - text.len() as i32 * canvas.advance();
    let (at_high, below) = (right(&high), y + 2 * step);
    let middle = (x + right(&numbers)) / 2;
    canvas.text(x, below, &low, WHITE);
    canvas.text(middle, below, &numbers, WHITE);
    canvas.text(at_high, below, &high, WHITE);
}

/// Four letters or so.
fn short(x: f32) -> String {
    match x {
        x if x >= 1e6 => format!("{:.1}M", x / 1e6),
        x if x >= 1e4 => format!("{:.1}k", x / 1e3),
        x if x >= 100.0 || x == x.round() => format!("{x:.0}"),
        x => format!("{x:.1}"),
    }
}
