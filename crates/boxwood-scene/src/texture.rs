//! Pictures: PNG and JPEG bytes to texels.

use std::io::Cursor;

use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::{Door, LoadError, Texture};

/// Decodes a PNG or JPEG picture, told apart by content. 16 bits are cut to 8, grey and palettes spread to RGBA.
///
/// `name` is what errors and [`Texture::name`] say. The size is checked against the door's limits before memory for
/// the texels is asked for.
pub(crate) fn decode(name: &str, bytes: &[u8], door: &mut Door) -> Result<Texture, LoadError> {
    let decoded = if bytes.starts_with(b"\x89PNG") {
        decode_png(bytes, door)
    } else if bytes.starts_with(b"\xff\xd8") {
        decode_jpeg(bytes, door)
    } else {
        Err("is neither a PNG nor a JPEG picture".to_owned())
    };
    let (width, height, rgba) = decoded.map_err(|cause| LoadError::new(name, cause))?;
    Ok(Texture {
        name: name.to_owned(),
        width,
        height,
        rgba,
    })
}

/// [`decode`] for a picture that the scene can do without: what is wrong becomes a warning.
pub(crate) fn decode_or_warn(
    name: &str,
    bytes: Result<Vec<u8>, LoadError>,
    door: &mut Door,
) -> Option<Texture> {
    match bytes.and_then(|bytes| decode(name, &bytes, door)) {
        Ok(texture) => Some(texture),
        Err(error) => {
            door.warn(format!("{error}; shown without this texture"));
            None
        }
    }
}

type Texels = (u32, u32, Vec<[u8; 4]>);

fn decode_png(bytes: &[u8], door: &mut Door) -> Result<Texels, String> {
    let broken = |error: png::DecodingError| format!("broken PNG: {error}");
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(broken)?;
    let (width, height) = reader.info().size();
    door.book_pixels(u64::from(width) * u64::from(height))?;

    let size = reader.output_buffer_size().ok_or("broken PNG: too large")?;
    let mut samples = vec![0; size];
    let frame = reader.next_frame(&mut samples).map_err(broken)?;
    samples.truncate(frame.buffer_size());
    let rgba = match frame.color_type {
        png::ColorType::Grayscale => samples.iter().map(|&v| [v, v, v, 255]).collect(),
        png::ColorType::GrayscaleAlpha => pixels(&samples).map(|[v, a]| [v, v, v, a]).collect(),
        png::ColorType::Rgb => pixels(&samples).map(|[r, g, b]| [r, g, b, 255]).collect(),
        png::ColorType::Rgba => pixels(&samples).collect(),
        png::ColorType::Indexed => return Err("broken PNG: a palette was not resolved".to_owned()),
    };
    Ok((width, height, rgba))
}

fn decode_jpeg(bytes: &[u8], door: &mut Door) -> Result<Texels, String> {
    let options = DecoderOptions::default()
        .set_max_width(usize::from(u16::MAX))
        .set_max_height(usize::from(u16::MAX))
        .jpeg_set_out_colorspace(ColorSpace::RGBA);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder
        .decode_headers()
        .map_err(|error| format!("broken JPEG: {error}"))?;
    let (width, height) = decoder.dimensions().ok_or("broken JPEG: no size")?;
    door.book_pixels(width as u64 * height as u64)?;

    let samples = decoder
        .decode()
        .map_err(|error| format!("broken JPEG: {error}"))?;
    let rgba: Vec<[u8; 4]> = pixels(&samples).collect();
    if rgba.len() != width * height {
        return Err("broken JPEG: it ends too early".to_owned());
    }
    let side =
        |length: usize| u32::try_from(length).map_err(|_| "broken JPEG: too large".to_owned());
    Ok((side(width)?, side(height)?, rgba))
}

fn pixels<const N: usize>(samples: &[u8]) -> impl Iterator<Item = [u8; N]> {
    samples.as_chunks().0.iter().copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;
    use crate::mutate::{Random, mutate};

    fn png_of(color: png::ColorType, width: u32, height: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(color);
        encoder.set_depth(png::BitDepth::Eight);
        if color == png::ColorType::Indexed {
            encoder.set_palette(vec![1, 2, 3, 4, 5, 6]);
        }
        encoder
            .write_header()
            .unwrap()
            .write_image_data(data)
            .unwrap();
        bytes
    }

    fn decoded(bytes: &[u8]) -> Result<Texture, LoadError> {
        decode(
            "t",
            bytes,
            &mut Door::without_files("scene", Limits::default()),
        )
    }

    #[test]
    fn every_png_colour_type_becomes_rgba() {
        let texels = |color, data: &[u8]| decoded(&png_of(color, 2, 1, data)).unwrap().rgba;
        assert_eq!(
            texels(png::ColorType::Grayscale, &[7, 9]),
            [[7, 7, 7, 255], [9, 9, 9, 255]]
        );
        assert_eq!(
            texels(png::ColorType::GrayscaleAlpha, &[7, 8, 9, 10]),
            [[7, 7, 7, 8], [9, 9, 9, 10]]
        );
        assert_eq!(
            texels(png::ColorType::Rgb, &[1, 2, 3, 4, 5, 6]),
            [[1, 2, 3, 255], [4, 5, 6, 255]]
        );
        assert_eq!(
            texels(png::ColorType::Rgba, &[1, 2, 3, 4, 5, 6, 7, 8]),
            [[1, 2, 3, 4], [5, 6, 7, 8]]
        );
        assert_eq!(
            texels(png::ColorType::Indexed, &[1, 0]),
            [[4, 5, 6, 255], [1, 2, 3, 255]]
        );
    }

    #[test]
    fn broken_and_unknown_pictures_are_refused() {
        let whole = png_of(png::ColorType::Rgb, 2, 1, &[1, 2, 3, 4, 5, 6]);
        assert!(decoded(&whole[..whole.len() - 20]).is_err());
        assert!(
            decoded(b"GIF89a")
                .unwrap_err()
                .to_string()
                .contains("neither a PNG nor a JPEG")
        );
        assert!(
            decoded(b"\xff\xd8\xff")
                .unwrap_err()
                .to_string()
                .contains("JPEG")
        );
    }

    #[test]
    fn a_picture_over_the_limit_is_refused_before_it_is_decoded() {
        // A header that promises 60,000 x 60,000 texels, and nothing behind it.
        let mut bytes = png_of(png::ColorType::Grayscale, 1, 1, &[0]);
        bytes[16..20].copy_from_slice(&60_000u32.to_be_bytes());
        bytes[20..24].copy_from_slice(&60_000u32.to_be_bytes());
        let crc = crc(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&crc.to_be_bytes());
        assert!(
            decoded(&bytes)
                .unwrap_err()
                .to_string()
                .contains("3600000000 texels")
        );
    }

    /// 8 x 8 texels, quantised by 16; Huffman tables of one code each. The scan holds "0 100": DC 4, "0": no AC.
    fn grey_jpeg() -> Vec<u8> {
        let mut bytes = b"\xff\xd8\xff\xdb\0\x43\0".to_vec();
        bytes.extend([16; 64]);
        bytes.extend(b"\xff\xc0\0\x0b\x08\0\x08\0\x08\x01\x01\x11\0");
        for (table, symbol) in [(0x00, 3), (0x10, 0)] {
            bytes.extend(b"\xff\xc4\0\x14");
            bytes.push(table);
            bytes.push(1);
            bytes.extend([0; 15]);
            bytes.push(symbol);
        }
        bytes.extend(b"\xff\xda\0\x08\x01\x01\0\0\x3f\0\x47\xff\xd9");
        bytes
    }

    #[test]
    fn a_grey_jpeg_becomes_rgba() {
        let texture = decoded(&grey_jpeg()).unwrap();
        assert_eq!((texture.width, texture.height), (8, 8));
        assert_eq!(texture.rgba, [[136, 136, 136, 255]; 64]);
    }

    #[test]
    fn mutated_pictures_never_panic() {
        let limits = Limits {
            max_texture_pixels: 1 << 16,
            ..Limits::default()
        };
        let rgba: Vec<u8> = (0..4 * 7 * 9).collect();
        for seed in [
            grey_jpeg(),
            png_of(png::ColorType::Rgba, 7, 9, &rgba),
            png_of(png::ColorType::Indexed, 2, 1, &[1, 0]),
        ] {
            let mut random = Random(1992);
            for _ in 0..20_000 {
                let mut bytes = seed.clone();
                mutate(&mut bytes, &mut random);
                if let Ok(texture) = decode("t", &bytes, &mut Door::without_files("scene", limits))
                {
                    assert_eq!(
                        texture.rgba.len(),
                        texture.width as usize * texture.height as usize
                    );
                }
            }
        }
    }

    /// PNG's check sum (ISO 3309), bit by bit.
    fn crc(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |crc, _| {
                (crc >> 1) ^ (0xedb8_8320 * (crc & 1))
            })
        })
    }
}
