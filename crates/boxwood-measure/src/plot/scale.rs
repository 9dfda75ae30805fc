//! The axes of plots.

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use std::ops::Range;

/// Positive numbers along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    low: f64,
    high: f64,
    logarithmic: bool,
}

impl Scale {
    /// Around positive values: from 0, or logarithmic if they differ much. `None` without such values.
    pub(super) fn around(values: impl Iterator<Item = f64>) -> Option<Self> {
        let (low, high) = ends(values)?;
        let logarithmic = high > 20.0 * low;
        Some(Self {
            low: if logarithmic { low / 1.3 } else { 0.0 },
            high: high * if logarithmic { 1.3 } else { 1.05 },
            logarithmic,
        })
    }

    /// Around positive values, logarithmic.
    pub(super) fn decades(values: impl Iterator<Item = f64>) -> Option<Self> {
        let (low, high) = ends(values)?;
        Some(Self {
            low: low / 1.3,
            high: high * 1.3,
            logarithmic: true,
        })
    }

    /// Whether a tenfold is as long anywhere.
    pub(super) fn is_logarithmic(&self) -> bool {
        self.logarithmic
    }

    /// Lowest and highest number.
    pub(super) fn ends(&self) -> (f64, f64) {
        (self.low, self.high)
    }

    /// 0 at the low end, 1 at the high one.
    fn part(&self, x: f64) -> f64 {
        let height = |x: f64| {
            if self.logarithmic {
                x.max(f64::MIN_POSITIVE).ln()
            } else {
                x
            }
        };
        (height(x) - height(self.low)) / (height(self.high) - height(self.low))
    }

    /// Round numbers, at most about `most`.
    fn round_numbers(&self, most: usize) -> Vec<f64> {
        let inside = |x: &f64| (self.low..=self.high).contains(x);
        if self.logarithmic {
            let powers = (self.low.log10().floor() as i32)..=(self.high.log10().ceil() as i32);
            let of = |digits: &'static [f64]| {
                let numbers = powers
                    .clone()
                    .flat_map(|power| digits.iter().map(move |d| d * 10_f64.powi(power)));
                numbers.filter(inside).collect::<Vec<f64>>()
            };
            let [fine, coarse] = [of(&[1.0, 2.0, 5.0]), of(&[1.0])];
            return if fine.len() <= most { fine } else { coarse };
        }
        let rough = (self.high - self.low) / most.clamp(2, 8) as f64;
        let power = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|digit| digit * power)
            .find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * power);
        (0..=most as u32 * 2)
            .map(|i| f64::from(i) * step)
            .filter(inside)
            .collect()
    }
}

/// Of the finite positive values.
fn ends(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let values = values.filter(|x| x.is_finite() && *x > 0.0);
    values.fold(None, |ends, x| {
        let (low, high) = ends.unwrap_or((x, x));
        Some((x.min(low), x.max(high)))
    })
}

/// From the low end of the pixels to the high one.
fn pixel(part: f64, limits: (i32, i32)) -> i32 {
    limits.0 + (f64::from(limits.1 - limits.0) * part).round() as i32
}

impl Ranged for Scale {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limits: (i32, i32)) -> i32 {
        pixel(self.part(*value), limits)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        self.round_numbers(hint.max_num_points())
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

/// So many rows, the first on top.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rows(pub(super) i32);

impl Ranged for Rows {
    type FormatOption = DefaultFormatting;
    type ValueType = i32;

    fn map(&self, row: &i32, limits: (i32, i32)) -> i32 {
        // Plots have their low end at the bottom.
        pixel(
            1.0 - (f64::from(*row) + 0.5) / f64::from(self.0.max(1)),
            limits,
        )
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<i32> {
        (0..self.0).collect()
    }

    fn range(&self) -> Range<i32> {
        0..self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_round_numbers() {
        let near = Scale::around([3.0, 7.0].into_iter()).unwrap();
        assert_eq!(near.round_numbers(6), [0.0, 2.0, 4.0, 6.0]);
        let far = Scale::around([0.03, 7.0, f64::NAN, -1.0].into_iter()).unwrap();
        assert_eq!(far.round_numbers(12), [0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0]);
        assert_eq!(far.round_numbers(5), [0.1, 1.0]);
        assert_eq!(Scale::around([0.0].into_iter()), None);
    }

    #[test]
    fn a_tenfold_is_as_long_anywhere_on_a_logarithmic_axis() {
        let scale = Scale::decades([1.0, 1000.0].into_iter()).unwrap();
        let at = |x: f64| scale.map(&x, (0, 3000));
        assert!((at(10.0) - at(1.0) - (at(1000.0) - at(100.0))).abs() <= 1);
        assert_eq!(Rows(4).map(&0, (100, 0)), 12);
        assert_eq!(Rows(4).map(&3, (100, 0)), 87);
    }
}
