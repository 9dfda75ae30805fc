//! A film to its file.

use boxwood_render::{Film, write_exr, write_png};
use boxwood_scene::Camera;

use crate::{args::camera_flags, save};

/// By the extension of `output`. Camera, shading and program go into PNG files as text.
pub(crate) fn write(
    output: &str,
    film: &Film,
    camera: &Camera,
    shading: &str,
) -> anyhow::Result<()> {
    if save::extension(output) == "exr" {
        return save::save(output, |file| write_exr(film, file));
    }
    let camera = camera_flags(camera);
    let program = concat!("boxwood ", env!("CARGO_PKG_VERSION"));
    let texts = [
        ("Software", program),
        ("Camera", &camera),
        ("Shading", shading),
    ];
    save::save(output, |file| write_png(&film.to_image(), &texts, file))
}
