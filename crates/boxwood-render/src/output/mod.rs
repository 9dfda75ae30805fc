//! Pictures to files and back.

mod exr;
mod png;
mod save;

pub use self::{
    exr::write_exr,
    png::write_png,
    save::{followed, save_atomically, save_atomically_telling},
};

#[cfg(feature = "farm")]
pub(crate) use self::save::remedy;
use crate::RenderError;

/// A picture read from a file, in linear light.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// In pixels.
    pub width: u32,
    /// In pixels.
    pub height: u32,
    /// Linear RGB, `width * height` pixels, row by row from the upper left.
    pub rgb: Vec<[f32; 3]>,
    /// Decoded from sRGB codes (PNG); else the numbers were linear in the file (EXR).
    pub coded: bool,
}

/// Most pixels of a picture that is read.
const MAX_READ_PIXELS: u64 = 1 << 28;

/// Reads a PNG (8 or 16 bits; grey, palette, RGB; transparency is ignored) or an EXR (its first RGB
/// layer), whichever `bytes` are.
///
/// Fails on anything else, on damage, and above 268 million pixels, before memory is taken for
/// them.
pub fn read_picture(bytes: &[u8]) -> Result<Picture, RenderError> {
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        png::read(bytes)
    } else if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        exr::read(bytes)
    } else {
        Err(RenderError::Decode {
            cause: "these bytes are neither PNG nor EXR".to_owned(),
            remedy: "convert the picture to one of the two",
        })
    }
}

#[expect(clippy::needless_pass_by_value, reason = "fits map_err")]
fn damaged(cause: impl ToString) -> RenderError {
    RenderError::Decode {
        cause: cause.to_string(),
        remedy: "the file may be damaged or cut short: make it again",
    }
}

fn check_pixels(width: usize, height: usize) -> Result<(), RenderError> {
    if (width as u64).saturating_mul(height as u64) <= MAX_READ_PIXELS {
        return Ok(());
    }
    Err(RenderError::Decode {
        cause: format!("it claims {width}x{height} pixels"),
        remedy: "at most 268 million pixels are read",
    })
}
