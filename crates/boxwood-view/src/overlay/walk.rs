//! The steps of a picked ray, in words.

use crate::{
    canvas::Canvas,
    walk::{MEANINGS, Picked},
};

/// On the right: the steps around the one at work, the answer, and what the strokes mean.
pub(crate) fn draw(canvas: &mut Canvas<'_>, picked: &Picked) {
    let rows = (canvas.height() / canvas.line_height()) as usize;
    // Not over more than half of the picture, if that leaves room for a step.
    let letters = canvas.letters_in(canvas.width() / 2).clamp(32, 64);
    let mut lines = picked.lines(rows.saturating_sub(MEANINGS.len() + 2), letters);
    let steps = lines.len() as i32;
    lines.extend(
        MEANINGS
            .iter()
            .map(|&(what, color, _)| (format!("         {what}"), color)),
    );
    let [width, _] = canvas.paragraph_size(&lines);
    let (x, y) = (canvas.width() - width - canvas.margin(), canvas.margin());
    canvas.paragraph(x, y, &lines);
    let (margin, step) = (canvas.margin(), canvas.line_height());
    for (row, &(_, color, stroke)) in (steps..).zip(MEANINGS) {
        let middle = (y + margin / 2 + row * step + step / 2) as f32;
        let (left, right) = (
            (x + margin) as f32,
            (x + margin + 8 * canvas.advance()) as f32,
        );
        canvas.line([left, middle], [right, middle], color, stroke);
    }
}
