//! The times of the last frames.

use std::{collections::VecDeque, time::Duration};

use crate::canvas::{Canvas, GREEN, GREY, ORANGE, Stroke, WHITE};

/// The top of the graph, in seconds.
const TOP: f32 = 0.05;
/// Thirty a second.
const LIMIT: f32 = 1.0 / 30.0;

/// A bar for each frame, in the lower right corner, with a line where 30 a second would be.
pub(crate) fn draw(canvas: &mut Canvas<'_>, times: &VecDeque<Duration>) {
    let (margin, step) = (canvas.margin(), canvas.line_height());
    let width = (canvas.width() / 3).min(30 * canvas.advance());
    let height = 4 * step;
    let (left, bottom) = (
        canvas.width() - width - 2 * margin,
        canvas.height() - 2 * margin,
    );
    canvas.panel(
        left - margin,
        bottom - height - step - margin,
        width + 2 * margin,
        height + step + 2 * margin,
    );
    let seconds: Vec<f32> = times.iter().map(Duration::as_secs_f32).collect();
    let shown = &seconds[seconds.len().saturating_sub(width as usize)..];
    for (x, &time) in (left..).zip(shown) {
        let bar = ((time / TOP).min(1.0) * height as f32) as i32;
        let color = if time <= LIMIT { GREEN } else { ORANGE };
        canvas.fill(x, bottom - bar, 1, bar, color, 255);
    }
    let y = bottom as f32 - LIMIT / TOP * height as f32;
    canvas.line(
        [left as f32, y],
        [(left + width) as f32, y],
        GREY,
        Stroke::Dashed,
    );
    let latest = shown.last().copied().unwrap_or(0.0);
    let worst = shown.iter().copied().fold(0.0, f32::max);
    let title = format!("{:.1} ms, worst {:.1} ms", latest * 1e3, worst * 1e3);
    canvas.text(left, bottom - height - step, &title, WHITE);
}
