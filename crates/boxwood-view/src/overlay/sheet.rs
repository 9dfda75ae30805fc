//! The cheat sheet.

use crate::{
    canvas::{Canvas, DARK, GREY, WHITE, YELLOW},
    keys::cheat_sheet,
};

/// How the sheet fits the window, in letters and lines.
struct Layout {
    /// Width of the keys, and of a column.
    keys: usize,
    column: usize,
    columns: usize,
    rows: usize,
    pages: usize,
}

impl Layout {
    fn of(canvas: &Canvas<'_>, lines: &[(String, String)]) -> Self {
        let longest = |text: fn(&(String, String)) -> &String| {
            let lengths = lines.iter().map(|line| text(line).chars().count());
            lengths.max().unwrap_or(0)
        };
        let keys = longest(|line| &line.0) + 2;
        let column = keys + longest(|line| &line.1) + 2;
        let space = 4 * canvas.margin();
        let fits = ((canvas.height() - space) / canvas.line_height()).max(2) as usize - 1;
        let most_columns = (canvas.letters_in(canvas.width() - space) / column).max(1);
        let columns = lines.len().div_ceil(fits).clamp(1, most_columns);
        let rows = lines.len().div_ceil(columns).min(fits);
        Self {
            keys,
            column,
            columns,
            rows,
            pages: lines.len().div_ceil(rows * columns),
        }
    }
}

/// How many pages the sheet has in this window.
pub(crate) fn pages(canvas: &Canvas<'_>) -> usize {
    Layout::of(canvas, &cheat_sheet()).pages
}

/// A page of all keys, counted from 1, in the middle of the window.
pub(crate) fn draw(canvas: &mut Canvas<'_>, page: usize) {
    let lines = cheat_sheet();
    let layout = Layout::of(canvas, &lines);
    let (margin, step, advance) = (canvas.margin(), canvas.line_height(), canvas.advance());
    let width = (layout.column * layout.columns) as i32 * advance;
    let height = (layout.rows as i32 + 1) * step;
    let left = ((canvas.width() - width) / 2).max(margin);
    let top = (canvas.height() - height) / 2;
    let panel = [width + 3 * margin, height + 2 * margin];
    canvas.fill(
        left - 2 * margin,
        top - margin,
        panel[0],
        panel[1],
        DARK,
        235,
    );
    let first = page.saturating_sub(1) * layout.rows * layout.columns;
    let shown = lines.iter().skip(first).take(layout.rows * layout.columns);
    for (number, (key, about)) in shown.enumerate() {
        let x = left + (number / layout.rows * layout.column) as i32 * advance;
        let y = top + (number % layout.rows) as i32 * step;
        canvas.text(x, y, key, YELLOW);
        canvas.text(x + layout.keys as i32 * advance, y, about, WHITE);
    }
    let end = match page < layout.pages {
        true => format!("h: more ({page} of {})", layout.pages),
        false => "h: close".to_owned(),
    };
    canvas.text(left, top + height - step, &end, GREY);
}

#[cfg(test)]
mod tests {
    use boxwood_render::Image;

    use super::*;

    #[test]
    fn large_windows_show_all_keys_at_once_and_small_ones_in_pages() {
        let pages_of = |width: u32, height: u32| {
            let rgb = vec![[0; 3]; (width * height) as usize];
            let mut image = Image { width, height, rgb };
            pages(&Canvas::new(&mut image))
        };
        assert_eq!(pages_of(1280, 720), 1);
        assert_eq!(pages_of(3840, 2160), 1);
        assert!((2..4).contains(&pages_of(640, 480)));
        assert!(pages_of(1, 1) >= 30);
    }
}
