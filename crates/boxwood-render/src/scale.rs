//! The one colour scale for numbers.

use glam::Vec3;

use crate::{shade::Layer, tone::srgb_to_linear};

/// What the user may want different about a scale.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "farm", derive(serde::Serialize, serde::Deserialize))]
pub struct ScaleOptions {
    /// The number at the bright end. Give the same one to pictures that are to be compared; none:
    /// see [`Scale::high`].
    pub top: Option<f32>,
    /// Colours by the logarithm: shows differences among small numbers.
    pub log: bool,
}

/// From numbers to colours: the "inferno" map, dark to bright, even to the eye and to the
/// colour-blind (Smith and van der Walt, 2015).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// What the numbers are.
    pub title: &'static str,
    /// The number at the left end of the legend.
    pub low: f32,
    /// The number at the right end; larger ones look the same. By default 995 of 1000 pixels are
    /// not above it, rounded up to two digits.
    pub high: f32,
    /// Of all pixels with a number.
    pub mean: f32,
    /// Of all pixels with a number.
    pub max: f32,
    /// Colours by the logarithm.
    pub log: bool,
    /// The low end is the bright one.
    pub reversed: bool,
}

impl Scale {
    /// A scale from 0 that fits counts, such as the tests of each pixel; called `title`.
    pub fn of_counts(title: &'static str, counts: &[f32], options: ScaleOptions) -> Self {
        let layer = Layer {
            title,
            value: |_, _| None,
            near_is_bright: false,
        };
        Self::of(&layer, counts, options)
    }

    /// A scale that fits `numbers`; all zero for none.
    pub(crate) fn of(layer: &Layer, numbers: &[f32], options: ScaleOptions) -> Self {
        let mut sorted = numbers.to_vec();
        sorted.sort_unstable_by(f32::total_cmp);
        let at = |share: f32| {
            sorted
                .get((sorted.len().saturating_sub(1) as f32 * share) as usize)
                .copied()
        };
        let low = if layer.near_is_bright {
            at(0.0).unwrap_or(0.0)
        } else {
            0.0
        };
        let high = options
            .top
            .unwrap_or_else(|| round_up(at(0.995).unwrap_or(0.0)));
        let sum: f64 = sorted.iter().map(|&x| f64::from(x)).sum();
        Self {
            title: layer.title,
            low,
            high: if high > low { high } else { low + 1.0 },
            mean: (sum / sorted.len().max(1) as f64) as f32,
            max: at(1.0).unwrap_or(0.0),
            log: options.log,
            reversed: layer.near_is_bright,
        }
    }

    /// The linear colour of `number`.
    pub fn color(&self, number: f32) -> Vec3 {
        self.color_at(self.share(number))
    }

    /// The linear colour at the share 0 to 1 of the way from `low` to `high`.
    pub fn color_at(&self, share: f32) -> Vec3 {
        Vec3::from(self.code_at(share).map(srgb_to_linear))
    }

    /// The sRGB code of [`Scale::color_at`].
    pub fn code_at(&self, share: f32) -> [u8; 3] {
        let share = if self.reversed { 1.0 - share } else { share };
        let share = f64::from(share.clamp(0.0, 1.0));
        colorous::INFERNO.eval_continuous(share).as_array()
    }

    /// How far `number` is from `low` to `high`, 0 to 1.
    pub fn share(&self, number: f32) -> f32 {
        let (x, range) = ((number - self.low).max(0.0), self.high - self.low);
        let share = if self.log {
            libm::log1pf(x) / libm::log1pf(range)
        } else {
            x / range
        };
        share.clamp(0.0, 1.0)
    }

    /// The number at `share` of the way: the inverse of [`Scale::share`].
    pub fn number_at(&self, share: f32) -> f32 {
        let range = self.high - self.low;
        self.low
            + if self.log {
                libm::expm1f(share * libm::log1pf(range))
            } else {
                share * range
            }
    }
}

/// The next number with at most two digits before its zeros.
fn round_up(x: f32) -> f32 {
    if !(x > 0.0 && x.is_finite()) {
        return 1.0;
    }
    let x = f64::from(x);
    let step = libm::pow(10.0, libm::floor(libm::log10(x)) - 1.0);
    // A hair less, so that 120 stays 120.
    (libm::ceil(x / step - 1e-6) * step) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAYER: Layer = Layer {
        title: "tests",
        value: |_, _| None,
        near_is_bright: false,
    };

    #[test]
    fn the_scale_ends_above_nearly_all_pixels_and_names_mean_and_maximum() {
        let mut numbers = vec![10.0; 997];
        numbers.extend([120.0, 500.0, 1234.0]);
        let scale = Scale::of(&LAYER, &numbers, ScaleOptions::default());
        assert_eq!((scale.low, scale.high, scale.max), (0.0, 10.0, 1234.0));
        assert!((scale.mean - 11.824).abs() < 1e-3);
        let fixed = Scale::of(
            &LAYER,
            &numbers,
            ScaleOptions {
                top: Some(77.0),
                log: false,
            },
        );
        assert_eq!(fixed.high, 77.0);
    }

    #[test]
    fn linear_and_logarithmic_scales_invert_themselves_and_get_brighter() {
        for log in [false, true] {
            let scale = Scale::of(
                &LAYER,
                &[0.0, 350.0],
                ScaleOptions {
                    top: Some(350.0),
                    log,
                },
            );
            let mut last = -1.0;
            for number in [0.0, 3.0, 17.0, 99.0, 348.0] {
                let share = scale.share(number);
                assert!((scale.number_at(share) - number).abs() < 1e-2);
                let brightness = crate::tone::luminance(scale.color(number));
                assert!(brightness > last, "log {log}, {number}");
                last = brightness;
            }
        }
    }

    #[test]
    fn no_numbers_and_equal_numbers_still_make_a_scale() {
        for numbers in [&[][..], &[0.0, 0.0], &[5.0]] {
            let scale = Scale::of(&LAYER, numbers, ScaleOptions::default());
            assert!(scale.high > scale.low && scale.color(5.0).is_finite());
        }
    }

    #[test]
    fn round_up_keeps_two_digits() {
        for (x, up) in [
            (120.0, 120.0),
            (121.0, 130.0),
            (0.0, 1.0),
            (7.0, 7.0),
            (98.5, 99.0),
            (995.0, 1000.0),
        ] {
            assert!(
                (round_up(x) - up).abs() < 1e-4 * up,
                "{x} to {}",
                round_up(x)
            );
        }
    }
}
