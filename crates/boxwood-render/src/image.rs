//! A finished picture for screens.

/// Eight-bit sRGB, row by row from the upper left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// In pixels.
    pub width: u32,
    /// In pixels.
    pub height: u32,
    /// `width * height` pixels.
    pub rgb: Vec<[u8; 3]>,
}
