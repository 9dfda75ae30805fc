//! How far two pictures are apart.

use glam::Vec3;

use crate::{Image, Picture, RenderError, flip, tone::linear_to_srgb, tone::linear_to_srgb8};

/// What [`compare`] found.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Root mean square difference over all channels: of sRGB codes in `0..=1` if both pictures are
    /// coded (PNG), else of linear numbers.
    pub rmse: f64,
    /// Largest difference of one channel, in the same numbers.
    pub max: f32,
    /// Pixels that differ at all.
    pub differing: u64,
    /// Mean FLIP error, 0 (equal) to 1: what a viewer notices who flips between the two.
    pub flip: f64,
    /// FLIP error of each pixel, 0 to 1.
    pub flip_map: Vec<f32>,
    /// In pixels.
    pub width: u32,
    /// In pixels.
    pub height: u32,
}

/// Compares `test` with `reference`; the order matters to no number.
///
/// Fails if their sizes differ. Pixels that are not finite count as black, and as differing unless
/// both are the same.
pub fn compare(reference: &Picture, test: &Picture) -> Result<Comparison, RenderError> {
    let (a, b) = (
        [reference.width, reference.height],
        [test.width, test.height],
    );
    if a != b {
        return Err(RenderError::SizesDiffer { a, b });
    }
    let coded = reference.coded && test.coded;
    let numbers =
        |pixel: &[f32; 3]| pixel.map(|x| if coded { linear_to_srgb(x) } else { finite(x) });
    let (mut sum, mut max, mut differing) = (0.0, 0.0f32, 0);
    for (a, b) in reference.rgb.iter().zip(&test.rgb) {
        differing += u64::from(a.map(f32::to_bits) != b.map(f32::to_bits));
        for (a, b) in numbers(a).into_iter().zip(numbers(b)) {
            sum += f64::from(a - b) * f64::from(a - b);
            max = max.max((a - b).abs());
        }
    }
    let flip_map = flip::flip(
        &clamped(reference),
        &clamped(test),
        reference.width as usize,
    );
    let n = flip_map.len().max(1) as f64;
    Ok(Comparison {
        rmse: (sum / (3.0 * n)).sqrt(),
        max,
        differing,
        flip: flip_map.iter().map(|&x| f64::from(x)).sum::<f64>() / n,
        flip_map,
        width: reference.width,
        height: reference.height,
    })
}

impl Comparison {
    /// The FLIP map in the colours of its paper ("magma"): black where nobody sees a difference.
    pub fn flip_image(&self) -> Image {
        let color = |&error: &f32| {
            let c = colorous::MAGMA.eval_continuous(f64::from(error.clamp(0.0, 1.0)));
            [c.r, c.g, c.b]
        };
        Image {
            width: self.width,
            height: self.height,
            rgb: self.flip_map.iter().map(color).collect(),
        }
    }
}

impl Image {
    /// The same picture as it would be read from a PNG.
    pub fn to_picture(&self) -> Picture {
        let rgb = self
            .rgb
            .iter()
            .map(|pixel| pixel.map(crate::tone::srgb_to_linear))
            .collect();
        Picture {
            width: self.width,
            height: self.height,
            rgb,
            coded: true,
        }
    }
}

impl Picture {
    /// Eight-bit sRGB codes; what is brighter than 1 is cut.
    pub fn to_image(&self) -> Image {
        let rgb = self
            .rgb
            .iter()
            .map(|pixel| pixel.map(linear_to_srgb8))
            .collect();
        Image {
            width: self.width,
            height: self.height,
            rgb,
        }
    }
}

fn finite(x: f32) -> f32 {
    if x.is_finite() { x } else { 0.0 }
}

fn clamped(picture: &Picture) -> Vec<Vec3> {
    picture
        .rgb
        .iter()
        .map(|pixel| Vec3::from(pixel.map(finite)).clamp(Vec3::ZERO, Vec3::ONE))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, coded: bool, values: &[f32]) -> Picture {
        let rgb: Vec<[f32; 3]> = values.iter().map(|&x| [x; 3]).collect();
        Picture {
            width,
            height: values.len() as u32 / width,
            rgb,
            coded,
        }
    }

    #[test]
    fn equal_pictures_do_not_differ() {
        let a = picture(2, true, &[0.1, 0.5, 0.7, 1.0]);
        let found = compare(&a, &a).unwrap();
        assert_eq!(
            (found.rmse, found.max, found.differing, found.flip),
            (0.0, 0.0, 0, 0.0)
        );
        assert!(
            found
                .flip_image()
                .rgb
                .iter()
                .all(|p| p.iter().all(|&c| c < 8))
        );
    }

    #[test]
    fn one_pixel_of_four_counts_as_the_formula_says() {
        let a = picture(2, false, &[0.0, 2.0, 3.0, 4.0]);
        let b = picture(2, false, &[0.0, 2.0, 3.0, 4.5]);
        let found = compare(&a, &b).unwrap();
        assert!((found.rmse - 0.25).abs() < 1e-9);
        assert_eq!((found.max, found.differing), (0.5, 1));
    }

    #[test]
    fn pictures_of_different_size_are_refused_with_both_sizes() {
        let message = compare(&picture(2, true, &[0.0; 4]), &picture(1, true, &[0.0; 3]))
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("2x2") && message.contains("1x3"),
            "{message}"
        );
    }

    #[test]
    fn infinite_pixels_do_not_spoil_the_numbers() {
        let found = compare(
            &picture(2, false, &[f32::INFINITY, 1.0]),
            &picture(2, false, &[1.0, f32::NAN]),
        )
        .unwrap();
        assert!(found.rmse.is_finite() && found.flip.is_finite() && found.differing == 2);
    }
}
