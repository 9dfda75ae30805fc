//! OpenEXR: linear light and every layer of the film.

use std::io::{Cursor, Write};

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, IntegerBounds, Layer, LayerAttributes,
    ReadChannels, ReadLayers, Text, Vec2, WritableImage,
};

use super::{Picture, check_pixels, damaged};
use crate::{Film, RenderError};

/// Writes all layers of `film` as channels of one part, ZIP-compressed without loss:
///
/// | channels | type | |
/// |---|---|---|
/// | `R G B` | f32 | linear, before exposure |
/// | `Z` | f32 | distance from the eye, infinite for background |
/// | `N.X N.Y N.Z` | f32 | shading normal, zero for background |
/// | `prim`, `material` | u32 | numbers, 4294967295 for none |
/// | `boxTests`, `primTests` | f32 | of the ray through the pixel's centre |
///
/// A crop is stored as the data window within the display window of the full picture. Takes memory
/// for one copy of the film. Fails if `out` does.
pub fn write_exr(film: &Film, mut out: impl Write) -> Result<(), RenderError> {
    let failed = |cause: String| RenderError::Encode {
        format: "EXR",
        cause,
    };
    let size = Vec2(film.width() as usize, film.height() as usize);
    let mut layer = Layer::new(
        size,
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        channels(film),
    );
    let place = |x: u32| x.min(i32::MAX as u32) as i32;
    layer.attributes.layer_position = Vec2(place(film.window.x), place(film.window.y));
    layer.attributes.software_name = Some(Text::from("Boxwood"));
    let mut image = exr::image::Image::from_layer(layer);
    let [width, height] = film.full_size.map(|side| side as usize);
    image.attributes.display_window = IntegerBounds::from_dimensions(Vec2(width, height));

    // The format wants to go back and fill in its table of offsets, which a pipe cannot do.
    let mut bytes = Cursor::new(Vec::new());
    image
        .write()
        .non_parallel()
        .to_buffered(&mut bytes)
        .map_err(|cause| failed(cause.to_string()))?;
    out.write_all(bytes.get_ref())
        .map_err(|cause| failed(cause.to_string()))
}

fn channels(film: &Film) -> AnyChannels<FlatSamples> {
    let floats = |name: &str, samples: Vec<f32>| AnyChannel::new(name, FlatSamples::F32(samples));
    let numbers =
        |name: &str, samples: &[u32]| AnyChannel::new(name, FlatSamples::U32(samples.to_vec()));
    let part = |layer: &[[f32; 3]], k: usize| layer.iter().map(|v| v[k]).collect::<Vec<f32>>();
    // Viewers show counts only as floats; below 2^24 these are exact.
    let counts =
        |name: &str, samples: &[u32]| floats(name, samples.iter().map(|&n| n as f32).collect());
    AnyChannels::sort(
        [
            floats("R", part(&film.color, 0)),
            floats("G", part(&film.color, 1)),
            floats("B", part(&film.color, 2)),
            floats("Z", film.depth.clone()),
            floats("N.X", part(&film.normal, 0)),
            floats("N.Y", part(&film.normal, 1)),
            floats("N.Z", part(&film.normal, 2)),
            numbers("prim", &film.prim),
            numbers("material", &film.material),
            counts("boxTests", &film.box_tests),
            counts("primTests", &film.prim_tests),
        ]
        .into_iter()
        .collect(),
    )
}

pub(super) fn read(bytes: &[u8]) -> Result<Picture, RenderError> {
    let meta =
        exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(damaged)?;
    for header in &meta.headers {
        check_pixels(header.layer_size.0, header.layer_size.1)?;
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0f32; 3]; size.area()]),
            |(width, pixels), at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(damaged)?;
    let size = image.layer_data.size;
    let side = |n: usize| u32::try_from(n).map_err(damaged);
    let rgb = image.layer_data.channel_data.pixels.1;
    Ok(Picture {
        width: side(size.width())?,
        height: side(size.height())?,
        rgb,
        coded: false,
    })
}

#[cfg(test)]
mod tests {
    use boxwood::Counts;

    use super::{super::read_picture, *};
    use crate::{Crop, Tone};

    fn film() -> Film {
        let window = Crop {
            x: 3,
            y: 5,
            width: 17,
            height: 9,
        };
        let mut film = Film::unexposed(window, [40, 30], Tone::Neutral, 1.0).unwrap();
        for i in 0..film.color.len() {
            let x = i as f32;
            film.color[i] = [x * 0.37, 1.0 / (x + 1.0), 1e4 * x];
            film.depth[i] = if i % 3 == 0 { f32::INFINITY } else { x + 0.1 };
            film.normal[i] = [0.6, -0.8, x];
            film.prim[i] = u32::MAX - i as u32;
            film.material[i] = 70_000 + i as u32;
            film.box_tests[i] = 16_777_216 - i as u32;
            film.prim_tests[i] = i as u32;
        }
        film.counts = Counts::default();
        film
    }

    #[test]
    fn the_colours_come_back_bit_for_bit() {
        let mut bytes = Vec::new();
        write_exr(&film(), &mut bytes).unwrap();
        let picture = read_picture(&bytes).unwrap();
        assert_eq!(
            (picture.width, picture.height, picture.coded),
            (17, 9, false)
        );
        assert_eq!(picture.rgb, film().color);
    }

    #[test]
    fn every_layer_and_the_place_of_the_crop_are_in_the_file() {
        let mut bytes = Vec::new();
        write_exr(&film(), &mut bytes).unwrap();
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(&bytes))
            .unwrap();
        assert_eq!(image.attributes.display_window.size, Vec2(40, 30));
        assert_eq!(image.layer_data.attributes.layer_position, Vec2(3, 5));
        let find = |name: &str| {
            let channels = &image.layer_data.channel_data.list;
            channels
                .iter()
                .find(|channel| channel.name.eq(name))
                .unwrap()
                .sample_data
                .clone()
        };
        let film = film();
        assert_eq!(find("Z"), FlatSamples::F32(film.depth));
        assert_eq!(
            find("N.Z"),
            FlatSamples::F32(film.normal.iter().map(|n| n[2]).collect())
        );
        assert_eq!(find("prim"), FlatSamples::U32(film.prim));
        assert_eq!(find("material"), FlatSamples::U32(film.material));
        assert_eq!(
            find("boxTests"),
            FlatSamples::F32(film.box_tests.iter().map(|&n| n as f32).collect())
        );
        assert_eq!(
            find("primTests"),
            FlatSamples::F32(film.prim_tests.iter().map(|&n| n as f32).collect())
        );
    }

    #[test]
    fn a_file_cut_short_is_refused() {
        let mut bytes = Vec::new();
        write_exr(&film(), &mut bytes).unwrap();
        for cut in [4, 60, bytes.len() / 2] {
            assert!(read_picture(&bytes[..cut]).is_err(), "cut at {cut}");
        }
    }
}
