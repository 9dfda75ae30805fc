//! Pictures in the terminal: by the protocols of kitty and iTerm2 where the terminal says that it knows one, else as
//! coloured half blocks, two pixels to a character.

use std::{
    env,
    fmt::Write,
    io::{self, IsTerminal},
};

use base64::{Engine, engine::general_purpose::STANDARD};
use boxwood_render::{Image, RenderError, write_png};

/// How pictures can be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Show {
    /// The graphics protocol of kitty; Ghostty and WezTerm know it too.
    Kitty,
    /// The inline images of iTerm2.
    Iterm,
    /// Half blocks in 24-bit colours.
    Blocks,
}

impl Show {
    /// For people.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Kitty => "kitty graphics",
            Self::Iterm => "iTerm2 inline images",
            Self::Blocks => "half blocks in 24-bit colours",
        }
    }

    /// What stdout can show, if it is a terminal that can show anything.
    pub(crate) fn of_stdout() -> Option<Self> {
        let variable = |name| env::var(name).unwrap_or_default();
        if !io::stdout().is_terminal() {
            return None;
        }
        Self::of(&variable("TERM"), &variable("TERM_PROGRAM"))
    }

    fn of(term: &str, program: &str) -> Option<Self> {
        match (term, program) {
            ("" | "dumb" | "linux", _) => None,
            // A multiplexer does not pass protocols on, and calls itself so in TERM_PROGRAM too.
            (_, "tmux" | "screen") => Some(Self::Blocks),
            (_, "ghostty" | "WezTerm") => Some(Self::Kitty),
            (_, "iTerm.app") => Some(Self::Iterm),
            _ if term.contains("kitty") => Some(Self::Kitty),
            _ => Some(Self::Blocks),
        }
    }

    /// The text that shows `image`, at most `columns` wide.
    pub(crate) fn draw(self, image: &Image, columns: u16) -> Result<String, RenderError> {
        match self {
            Self::Kitty => Ok(kitty(&png(image)?, columns)),
            Self::Iterm => Ok(format!(
                "\x1b]1337;File=inline=1;width={columns}:{}\x07",
                STANDARD.encode(png(image)?)
            )),
            Self::Blocks => Ok(blocks(image, u32::from(columns))),
        }
    }
}

/// Columns of the terminal, 80 if it does not say; at most 160, which is a good picture.
pub(crate) fn columns() -> u16 {
    terminal_size::terminal_size()
        .map_or(80, |(width, _)| width.0)
        .clamp(20, 160)
}

/// Columns that `image` may take so that it is at most `lines` high, where a character is twice as high as wide.
pub(crate) fn columns_for(image: &Image, lines: u16) -> u16 {
    let fitting = u64::from(lines) * 2 * u64::from(image.width) / u64::from(image.height.max(1));
    columns().min(fitting.max(1).try_into().unwrap_or(u16::MAX))
}

/// Lines of the terminal, 24 if it does not say.
pub(crate) fn lines() -> u16 {
    terminal_size::terminal_size().map_or(24, |(_, height)| height.0)
}

fn png(image: &Image) -> Result<Vec<u8>, RenderError> {
    let mut bytes = Vec::new();
    write_png(image, &[], &mut bytes)?;
    Ok(bytes)
}

/// In pieces of at most 4096 bytes; `m` says whether more follow.
fn kitty(png: &[u8], columns: u16) -> String {
    let code = STANDARD.encode(png);
    let pieces: Vec<&str> = code
        .as_bytes()
        .chunks(4096)
        .filter_map(|piece| str::from_utf8(piece).ok())
        .collect();
    let mut text = String::new();
    for (i, piece) in pieces.iter().enumerate() {
        let keys = if i == 0 {
            format!("a=T,f=100,c={columns},")
        } else {
            String::new()
        };
        let more = u8::from(i + 1 < pieces.len());
        let _ = write!(text, "\x1b_G{keys}m={more};{piece}\x1b\\");
    }
    text
}

/// The upper half block shows its own colour above and the background's below.
fn blocks(image: &Image, columns: u32) -> String {
    let width = columns.min(image.width).max(1);
    // A character is twice as high as wide, so that its halves are square.
    let height = (u64::from(image.height) * u64::from(width))
        .div_ceil(u64::from(image.width.max(1)))
        .max(1) as u32;
    let mut text = String::new();
    for row in (0..height).step_by(2) {
        for x in 0..width {
            let [r, g, b] = mean(image, [width, height], [x, row]);
            let _ = write!(text, "\x1b[38;2;{r};{g};{b}m");
            if row + 1 < height {
                let [r, g, b] = mean(image, [width, height], [x, row + 1]);
                let _ = write!(text, "\x1b[48;2;{r};{g};{b}m");
            }
            text.push('▀');
        }
        text.push_str("\x1b[0m\n");
    }
    text.pop();
    text
}

/// The mean colour of the pixels under one of `sides[0]` x `sides[1]` cells.
fn mean(image: &Image, sides: [u32; 2], cell: [u32; 2]) -> [u8; 3] {
    let range = |all: u32, side: u32, at: u32| {
        let edge = |at: u32| (u64::from(at) * u64::from(all) / u64::from(side)) as usize;
        edge(at)..edge(at + 1).max(edge(at) + 1)
    };
    let mut sum = [0u64; 3];
    let mut count = 0;
    for y in range(image.height, sides[1], cell[1]) {
        for x in range(image.width, sides[0], cell[0]) {
            let pixel = image
                .rgb
                .get(y * image.width as usize + x)
                .copied()
                .unwrap_or_default();
            sum.iter_mut()
                .zip(pixel)
                .for_each(|(sum, channel)| *sum += u64::from(channel));
            count += 1;
        }
    }
    sum.map(|sum| (sum / count) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32) -> Image {
        Image {
            width,
            height,
            rgb: (0..width * height).map(|i| [i as u8, 100, 200]).collect(),
        }
    }

    #[test]
    fn half_blocks_keep_the_proportions_and_reset_each_line() {
        let text = blocks(&image(8, 6), 4);
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines.len(), 2, "3 rows of cells are 2 lines");
        assert!(
            lines
                .iter()
                .all(|line| line.matches('▀').count() == 4 && line.ends_with("\x1b[0m"))
        );
        // The mean of 0, 1, 8, 9.
        assert!(text.starts_with("\x1b[38;2;4;100;200m"), "{text:?}");
    }

    #[test]
    fn small_pictures_are_not_blown_up() {
        assert_eq!(blocks(&image(3, 1), 80).matches('▀').count(), 3);
    }

    #[test]
    fn kitty_pieces_are_short_and_only_the_last_is_the_last() {
        let text = kitty(&[7; 9000], 80);
        let pieces: Vec<_> = text
            .split("\x1b\\")
            .filter(|piece| !piece.is_empty())
            .collect();
        assert_eq!(pieces.len(), 3);
        assert!(
            pieces[0].starts_with("\x1b_Ga=T,f=100,c=80,m=1;")
                && pieces[2].starts_with("\x1b_Gm=0;")
        );
        assert!(pieces.iter().all(|piece| piece.len() < 4200));
    }

    #[test]
    fn terminals_are_told_apart() {
        assert_eq!(Show::of("xterm-256color", ""), Some(Show::Blocks));
        assert_eq!(Show::of("xterm-kitty", ""), Some(Show::Kitty));
        assert_eq!(Show::of("screen-256color", "tmux"), Some(Show::Blocks));
        assert_eq!(Show::of("xterm-256color", "iTerm.app"), Some(Show::Iterm));
        assert_eq!(Show::of("dumb", ""), None);
    }
}
