//! The guarded door: the only code of this crate that opens files.
//!
//! A loader gets bytes and a [`Door`]. What it wants to read beside them (a `.bin`, an `.mtl`, a picture) it asks the
//! door for by name. The door decides by three rules: nothing but files beside the named one, nothing but regular
//! files, nothing beyond the limits.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::{LoadError, Place};

/// How much one scene may ask of the machine. Everything beyond is refused with an error that names the limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most bytes to read, the named file and all that is read beside it together.
    pub max_file_bytes: u64,
    /// Most triangles, stored and (in [`crate::Model::flatten`]) multiplied out.
    pub max_triangles: u64,
    /// Most texels in one picture.
    pub max_texture_pixels: u64,
    /// Most texels in all pictures of a scene.
    pub max_all_texture_pixels: u64,
}

impl Default for Limits {
    /// 8 GiB of files (1 GiB on 32-bit machines), 2^28 triangles, 2^26 texels a picture, 2^28 in all.
    fn default() -> Self {
        let max_file_bytes = if cfg!(target_pointer_width = "32") {
            1 << 30
        } else {
            8 << 30
        };
        Self {
            max_file_bytes,
            max_triangles: 1 << 28,
            max_texture_pixels: 1 << 26,
            max_all_texture_pixels: 1 << 28,
        }
    }
}

/// What a loader may reach besides its bytes, and what it has to say to the user.
#[derive(Debug)]
pub struct Door {
    name: String,
    folder: Option<PathBuf>,
    limits: Limits,
    bytes_read: u64,
    #[cfg(feature = "files")]
    pixels_decoded: u64,
    warnings: Vec<String>,
    warnings_dropped: u64,
}

/// More warnings than these are counted, not kept: a hostile file may cause one per line.
const MAX_WARNINGS: usize = 100;

impl Door {
    /// A door that opens files beside `path`, and only there.
    pub fn for_file(path: &Path, limits: Limits) -> Self {
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
            _ => PathBuf::from("."),
        };
        Self {
            folder: Some(folder),
            ..Self::without_files(&path.display().to_string(), limits)
        }
    }

    /// A door that opens nothing: for bytes which did not come from a file (a pipe, a web page, a fuzzer).
    pub fn without_files(name: &str, limits: Limits) -> Self {
        Self {
            name: name.to_owned(),
            folder: None,
            limits,
            bytes_read: 0,
            #[cfg(feature = "files")]
            pixels_decoded: 0,
            warnings: Vec::new(),
            warnings_dropped: 0,
        }
    }

    /// What errors call the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What the scene may cost.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Reads the file that the relative URI reference `uri` (as in glTF) names.
    ///
    /// Percent escapes are decoded once. Refused: absolute paths, drives, UNC paths, schemes, `..`, NUL, links that
    /// lead out of the folder, all that is not a regular file, and what is over the limits. A local attacker who
    /// swaps files between check and opening is out of scope.
    pub fn beside(&mut self, uri: &str) -> Result<Vec<u8>, LoadError> {
        match percent_decoded(uri) {
            Some(name) => self.beside_named(&name),
            None => Err(self.refused(uri, "is not a valid URI: a percent escape is broken")),
        }
    }

    /// As [`Door::beside`] for a plain file name (as in OBJ and MTL), which knows no escapes. A backslash separates
    /// folders as a slash does.
    pub fn beside_named(&mut self, name: &str) -> Result<Vec<u8>, LoadError> {
        let relative = relative_path(name).map_err(|why| self.refused(name, why))?;
        let Some(folder) = &self.folder else {
            return Err(self
                .refused(
                    name,
                    "is not at hand: only the bytes of the scene itself were given",
                )
                .with_remedy(
                    "name the scene by its path, or use a file that holds everything, such as .glb",
                ));
        };
        let missing =
            |error: std::io::Error| self.refused(name, &format!("cannot be read: {error}"));
        let folder = folder.canonicalize().map_err(missing)?;
        let path = folder.join(relative).canonicalize().map_err(missing)?;
        if !path.starts_with(&folder) {
            return Err(self.refused(name, "is a link that leads out of the scene's folder"));
        }
        self.read(&path).map_err(|cause| self.refused(name, &cause))
    }

    /// Reads a file whole. The error says what is wrong, without the file's name.
    pub(crate) fn read(&mut self, path: &Path) -> Result<Vec<u8>, String> {
        let cannot = |error: std::io::Error| format!("cannot be read: {error}");
        // The kind is looked at before opening, since opening a FIFO waits for its writer.
        let metadata = path.metadata().map_err(cannot)?;
        if metadata.is_dir() {
            return Err("is a folder: name a file in it".to_owned());
        }
        if !metadata.is_file() {
            return Err("is not a regular file".to_owned());
        }
        let left = self.limits.max_file_bytes.saturating_sub(self.bytes_read);
        let over = format!(
            "is too large: {left} bytes are left of the limit of {}",
            self.limits.max_file_bytes
        );
        let length = metadata.len();
        if length > left {
            return Err(over);
        }

        let mut bytes = Vec::new();
        let capacity = usize::try_from(length).map_err(|_| over.clone())?;
        bytes
            .try_reserve_exact(capacity)
            .map_err(|_| format!("needs {length} bytes, more than there are"))?;
        File::open(path)
            .and_then(|file| file.take(length).read_to_end(&mut bytes))
            .map_err(cannot)?;
        self.bytes_read += length;
        Ok(bytes)
    }

    /// Books `pixels` texels against the limits; `Err` says which limit they break.
    #[cfg(feature = "files")]
    pub(crate) fn book_pixels(&mut self, pixels: u64) -> Result<(), String> {
        if pixels > self.limits.max_texture_pixels {
            return Err(format!(
                "{pixels} texels, the limit for one picture is {}",
                self.limits.max_texture_pixels
            ));
        }
        let all = self.pixels_decoded.saturating_add(pixels);
        if all > self.limits.max_all_texture_pixels {
            return Err(format!(
                "the limit of {} texels in a scene is used up",
                self.limits.max_all_texture_pixels
            ));
        }
        self.pixels_decoded = all;
        Ok(())
    }

    /// An error about the scene's main file.
    pub fn error(&self, place: Option<Place>, cause: impl Into<String>) -> LoadError {
        LoadError {
            place,
            ..LoadError::new(&self.name, cause)
        }
    }

    /// Notes what was tolerated, for [`crate::Model::warnings`].
    pub fn warn(&mut self, message: impl Into<String>) {
        if self.warnings.len() < MAX_WARNINGS {
            self.warnings.push(message.into());
        } else {
            self.warnings_dropped += 1;
        }
    }

    /// What was noted so far.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Takes what was noted, with a last line for those beyond the first hundred.
    pub fn into_warnings(self) -> Vec<String> {
        let mut warnings = self.warnings;
        if self.warnings_dropped > 0 {
            warnings.push(format!("{} more warnings", self.warnings_dropped));
        }
        warnings
    }

    fn refused(&self, name: &str, why: &str) -> LoadError {
        self.error(None, format!("\"{name}\" {why}"))
    }
}

/// Decodes `%41` escapes once. `None` if one is cut short or the result is not UTF-8.
fn percent_decoded(uri: &str) -> Option<String> {
    let mut decoded = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        if *first != b'%' {
            decoded.push(*first);
            continue;
        }
        let [high, low, tail @ ..] = rest else {
            return None;
        };
        let digit = |byte: u8| char::from(byte).to_digit(16);
        decoded.push(u8::try_from(digit(*high)? * 16 + digit(*low)?).ok()?);
        rest = tail;
    }
    String::from_utf8(decoded).ok()
}

/// `name` as a path that stays below wherever it is joined to, or why it can't be one.
fn relative_path(name: &str) -> Result<PathBuf, &'static str> {
    if name.contains('\0') {
        return Err("holds a NUL character");
    }
    if name.contains(':') {
        return Err("names a drive or a scheme; only files beside the scene are read");
    }
    if name.starts_with(['/', '\\']) {
        return Err("is an absolute path; only files beside the scene are read");
    }
    let mut path = PathBuf::new();
    for part in name.split(['/', '\\']) {
        match part {
            "" | "." => {}
            ".." => {
                return Err(
                    "leads out of the scene's folder by `..`; only files beside the scene are read",
                );
            }
            part => path.push(part),
        }
    }
    if path.as_os_str().is_empty() {
        return Err("names no file");
    }
    Ok(path)
}
