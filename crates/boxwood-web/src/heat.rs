//! Counts as colours: the scale of the command line's heat maps.

use boxwood_render::{Scale, ScaleOptions};
use serde::Serialize;

/// A scale from 0 over the counts of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HeatScale {
    /// The count at the bright end: 995 of 1000 pixels are not above it, rounded up to two digits.
    pub high: f32,
    /// Of all pixels.
    pub mean: f32,
    /// Of all pixels.
    pub max: f32,
}

/// The scale that fits `counts`, one per pixel.
pub fn heat_scale(counts: &[u32]) -> HeatScale {
    let Scale {
        high, mean, max, ..
    } = scale(counts, ScaleOptions::default());
    HeatScale { high, mean, max }
}

/// RGBA of each count on a scale from 0 to `top`, by its logarithm if `log`.
pub fn heat_codes(counts: &[u32], top: f32, log: bool) -> Vec<u8> {
    let options = ScaleOptions {
        top: Some(top),
        log,
    };
    let scale = scale(&[], options);
    let code = |&count: &u32| {
        let [r, g, b] = scale.code_at(scale.share(count as f32));
        [r, g, b, 255]
    };
    counts.iter().flat_map(code).collect()
}

fn scale(counts: &[u32], options: ScaleOptions) -> Scale {
    let numbers: Vec<f32> = counts.iter().map(|&count| count as f32).collect();
    Scale::of_counts("tests per ray", &numbers, options)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_has_mean_and_maximum_and_brighter_is_more() {
        let found = heat_scale(&[0, 3, 30, 121]);
        assert_eq!((found.mean, found.max), (38.5, 121.0));
        for log in [false, true] {
            let codes = heat_codes(&[0, 3, 30, 120, 500], 120.0, log);
            let light = |i: usize| codes[4 * i..4 * i + 3].iter().map(|&c| u32::from(c)).sum();
            let lights: [u32; 5] = std::array::from_fn(light);
            assert!(lights[..4].is_sorted_by(|a, b| a < b), "{lights:?}");
            assert_eq!(lights[3], lights[4]);
        }
    }
}
