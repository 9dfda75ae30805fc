//! The table of file formats and the ways in: by name, by path, by bytes.

#[cfg(feature = "saved")]
mod bwx;
pub(crate) mod gltf;
mod mtl;
pub(crate) mod obj;
pub(crate) mod ply;
mod polygon;
pub(crate) mod stl;
mod text;

#[cfg(feature = "saved")]
pub use bwx::with_vertices;

use std::path::Path;

use crate::{Door, Limits, LoadError, Model};

/// One file format. A new one is a file in `format/` and a line in [`FORMATS`].
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Lower case, as on the command line.
    pub name: &'static str,
    /// Lower case, without the dot.
    pub extensions: &'static [&'static str],
    /// One line for `boxwood list`.
    pub about: &'static str,
    /// Does a file that begins like this look like the format? Gets the whole file.
    pub sniff: fn(&[u8]) -> bool,
    /// Reads the file. Whether the model keeps its promises is checked once more before anyone sees it.
    pub load: fn(&[u8], &mut Door) -> Result<Model, LoadError>,
}

/// Every format that can be read, the surest to recognise by content first.
pub const FORMATS: &[Format] = &[
    #[cfg(feature = "saved")]
    bwx::FORMAT,
    gltf::FORMAT,
    ply::FORMAT,
    stl::FORMAT,
    obj::FORMAT,
];

/// Loads what `name` says: `builtin:bush`, `builtin:soup?n=1000`, or the path of a file.
pub fn open(name: &str) -> Result<Model, LoadError> {
    match name.strip_prefix("builtin:") {
        Some(spec) => crate::builtin(spec),
        None => load(Path::new(name)),
    }
}

/// Loads a scene file with the usual [`Limits`]: the format by its extension (upper or lower case), else by its content.
///
/// Refused: what [`Door::beside`] would refuse, broken data, non-finite coordinates. Tolerated things (a missing
/// texture, an unknown material) are in [`Model::warnings`].
pub fn load(path: &Path) -> Result<Model, LoadError> {
    load_with(path, Limits::default())
}

/// [`load`] with limits of your own.
pub fn load_with(path: &Path, limits: Limits) -> Result<Model, LoadError> {
    let mut door = Door::for_file(path, limits);
    let bytes = door
        .read(path)
        .map_err(|cause| unreadable(&door, path, cause))?;
    let format = match by_extension(&path.to_string_lossy()) {
        Some(format) => format,
        None => by_content(&bytes, &door)?,
    };
    read(format, &bytes, door)
}

/// Loads a scene from bytes. Opens no file: what stands beside the scene (textures, `.bin`) is missing.
///
/// `name` is what errors call it. The format is `format` (a name of [`FORMATS`]) if given, else by the extension of
/// `name`, else by content.
pub fn load_bytes(
    name: &str,
    format: Option<&str>,
    bytes: &[u8],
    limits: Limits,
) -> Result<Model, LoadError> {
    let door = Door::without_files(name, limits);
    if bytes.len() as u64 > limits.max_file_bytes {
        return Err(door.error(
            None,
            format!(
                "has {} bytes, the limit is {}",
                bytes.len(),
                limits.max_file_bytes
            ),
        ));
    }
    let format = match format {
        Some(wanted) => match FORMATS
            .iter()
            .find(|format| format.name.eq_ignore_ascii_case(wanted))
        {
            Some(format) => format,
            None => {
                return Err(door
                    .error(None, format!("unknown format \"{wanted}\""))
                    .with_remedy(known()));
            }
        },
        None => match by_extension(name) {
            Some(format) => format,
            None => by_content(bytes, &door)?,
        },
    };
    read(format, bytes, door)
}

/// The last steps of every way in: load, check, hand over the warnings.
fn read(format: &Format, bytes: &[u8], mut door: Door) -> Result<Model, LoadError> {
    let mut model = (format.load)(bytes, &mut door)?;
    model.check(&door)?;
    if model.triangle_count() == 0 {
        door.warn(format!("{}: shows no triangles", door.name()));
    }
    model.warnings.append(&mut door.into_warnings());
    Ok(model)
}

fn by_extension(name: &str) -> Option<&'static Format> {
    let (_, extension) = name.rsplit_once('.')?;
    FORMATS.iter().find(|format| {
        format
            .extensions
            .iter()
            .any(|known| known.eq_ignore_ascii_case(extension))
    })
}

fn by_content(bytes: &[u8], door: &Door) -> Result<&'static Format, LoadError> {
    FORMATS
        .iter()
        .find(|format| (format.sniff)(bytes))
        .ok_or_else(|| {
            door.error(None, "neither name nor content tells the format")
                .with_remedy(known())
        })
}

fn known() -> String {
    let names: Vec<_> = FORMATS
        .iter()
        .flat_map(|format| format.extensions)
        .copied()
        .collect();
    format!("known: {}", names.join(", "))
}

fn unreadable(door: &Door, path: &Path, cause: String) -> LoadError {
    let error = door.error(None, cause);
    match path.metadata() {
        Ok(metadata) if !metadata.is_file() && !metadata.is_dir() => {
            error.with_remedy("pipe it into `-`")
        }
        _ => error,
    }
}
