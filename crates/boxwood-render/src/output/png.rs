//! PNG: eight bits per channel, sRGB.

use std::io::{Cursor, Write};

use super::{Picture, check_pixels, damaged};
use crate::{Image, RenderError, tone::srgb_to_linear};

/// Writes `image` with its sRGB tag. `texts` become text chunks: keyword (1 to 79 Latin characters)
/// and text, such as `("Camera", "--vp 1 2 3")`.
///
/// Fails if `out` does, or for a keyword that PNG does not allow.
pub fn write_png(
    image: &Image,
    texts: &[(&str, &str)],
    out: impl Write,
) -> Result<(), RenderError> {
    let failed = |cause: png::EncodingError| RenderError::Encode {
        format: "PNG",
        cause: cause.to_string(),
    };
    let mut encoder = png::Encoder::new(out, image.width, image.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    for (keyword, text) in texts {
        encoder
            .add_itxt_chunk((*keyword).to_owned(), (*text).to_owned())
            .map_err(failed)?;
    }
    let mut writer = encoder.write_header().map_err(failed)?;
    writer
        .write_image_data(image.rgb.as_flattened())
        .map_err(failed)?;
    writer.finish().map_err(failed)
}

pub(super) fn read(bytes: &[u8]) -> Result<Picture, RenderError> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(damaged)?;
    let (width, height) = (reader.info().width, reader.info().height);
    check_pixels(width as usize, height as usize)?;
    let size = reader
        .output_buffer_size()
        .ok_or_else(|| damaged("its size is beyond this machine"))?;
    let mut samples = vec![0; size];
    let frame = reader.next_frame(&mut samples).map_err(damaged)?;
    let channels = frame.color_type.samples();
    let rgb = samples[..frame.buffer_size()]
        .chunks_exact(channels)
        .map(|pixel| {
            let color = if channels < 3 {
                [pixel[0]; 3]
            } else {
                [pixel[0], pixel[1], pixel[2]]
            };
            color.map(srgb_to_linear)
        });
    Ok(Picture {
        width,
        height,
        rgb: rgb.collect(),
        coded: true,
    })
}

#[cfg(test)]
mod tests {
    use super::{super::read_picture, *};
    use crate::tone::linear_to_srgb8;

    #[test]
    fn a_png_comes_back_bit_for_bit() {
        let rgb: Vec<[u8; 3]> = (0..5 * 3)
            .map(|i: u8| [i * 17, 255 - i, i.wrapping_mul(91)])
            .collect();
        let image = Image {
            width: 5,
            height: 3,
            rgb,
        };
        let mut bytes = Vec::new();
        write_png(&image, &[("Camera", "--fov 60")], &mut bytes).unwrap();
        assert!(bytes.windows(8).any(|w| w == b"--fov 60"));
        let picture = read_picture(&bytes).unwrap();
        assert_eq!((picture.width, picture.height, picture.coded), (5, 3, true));
        let codes: Vec<[u8; 3]> = picture.rgb.iter().map(|p| p.map(linear_to_srgb8)).collect();
        assert_eq!(codes, image.rgb);
    }

    #[test]
    fn damaged_and_foreign_bytes_are_refused() {
        let mut bytes = Vec::new();
        write_png(
            &Image {
                width: 9,
                height: 9,
                rgb: vec![[7; 3]; 81],
            },
            &[],
            &mut bytes,
        )
        .unwrap();
        for cut in [8, 20, bytes.len() / 2] {
            assert!(read_picture(&bytes[..cut]).is_err(), "cut at {cut}");
        }
        assert!(
            read_picture(b"GIF89a")
                .unwrap_err()
                .to_string()
                .contains("neither PNG nor EXR")
        );
    }
}
