//! From linear light to the eight bits of a PNG.

use glam::Vec3;

/// How the linear colours of a film become display colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Clamped to `0..=1`: colours that stand for data are shown as they are.
    Clamp,
    /// [`neutral`]: light, whose range has no end.
    Neutral,
}

impl Tone {
    /// Linear colour in `0..=1`.
    pub fn apply(self, linear: Vec3) -> Vec3 {
        match self {
            Self::Clamp => linear,
            Self::Neutral => neutral(linear.max(Vec3::ZERO)),
        }
        .clamp(Vec3::ZERO, Vec3::ONE)
    }
}

/// Leaves colours as they are up to about 0.76, and rolls brighter light off towards white.
///
/// Base colours come out as the material says, which film-like curves do not give. Khronos PBR
/// Neutral tone mapper, 2024.
pub fn neutral(color: Vec3) -> Vec3 {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let least = color.min_element();
    let toe = if least < 0.08 {
        least - 6.25 * least * least
    } else {
        0.04
    };
    let color = color - toe;
    let peak = color.max_element();
    if peak < START {
        return color;
    }
    let room = 1.0 - START;
    let new_peak = 1.0 - room * room / (peak + room - START);
    let to_white = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    (color * (new_peak / peak)).lerp(Vec3::splat(new_peak), to_white)
}

/// The luminance of linear Rec. 709 / sRGB light.
pub(crate) fn luminance(linear: Vec3) -> f32 {
    linear.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Linear `0..=1` to the sRGB code in `0..=1` (IEC 61966-2-1).
pub(crate) fn linear_to_srgb(x: f32) -> f32 {
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * libm::powf(x, 1.0 / 2.4) - 0.055
    }
}

/// The nearest eight-bit sRGB code; values outside `0..=1` are clamped.
pub fn linear_to_srgb8(x: f32) -> u8 {
    (linear_to_srgb(x.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8
}

/// The linear value of an eight-bit sRGB code, from a table.
pub(crate) fn srgb_to_linear(code: u8) -> f32 {
    static TABLE: std::sync::LazyLock<[f32; 256]> = std::sync::LazyLock::new(|| {
        std::array::from_fn(|code| {
            let c = code as f64 / 255.0;
            (if c <= 0.04045 {
                c / 12.92
            } else {
                libm::pow((c + 0.055) / 1.055, 2.4)
            }) as f32
        })
    });
    TABLE[usize::from(code)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_srgb_code_survives_the_round_trip() {
        for code in 0..=255 {
            assert_eq!(linear_to_srgb8(srgb_to_linear(code)), code);
        }
    }

    #[test]
    fn brighter_light_never_gets_darker_and_never_leaves_the_range() {
        let mut last = -1.0;
        for i in 0..2000 {
            let shown = Tone::Neutral.apply(Vec3::new(1.0, 0.7, 0.4) * (i as f32 * 0.013));
            assert!(shown.min_element() >= 0.0 && shown.max_element() <= 1.0);
            assert!(luminance(shown) >= last - 1e-6, "step {i}");
            last = luminance(shown);
        }
        assert!(last > 0.9);
    }

    #[test]
    fn nan_is_shown_as_black() {
        assert_eq!(linear_to_srgb8(f32::NAN), 0);
    }
}
