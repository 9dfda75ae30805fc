//! Files that are whole or not there; what is no plain file is written to as it is.

use std::{fs, io::Write, path::Path};

use boxwood_render::{RenderError, save_atomically};

use crate::ViewError;

/// Writes to `path` what `write` gives.
pub(crate) fn save(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<(), RenderError>,
) -> Result<(), ViewError> {
    // A link stays a link.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let is_device = target
        .metadata()
        .is_ok_and(|found| !found.is_file() && !found.is_dir());
    let saved = match is_device {
        true => through(&target, write),
        false => save_atomically(&target, write),
    };
    saved.map_err(|error| ViewError::output(path, error))
}

/// The whole at once: encoders speak of errors in their own words.
fn through(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<(), RenderError>,
) -> Result<(), RenderError> {
    let mut bytes = Vec::new();
    write(&mut bytes)?;
    fs::write(path, bytes).map_err(|cause| RenderError::Save {
        path: path.to_owned(),
        cause,
        remedy: "choose another place and try again",
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Matter;

    fn hello(out: &mut dyn Write) -> Result<(), RenderError> {
        out.write_all(b"hello")
            .map_err(|error| RenderError::Encode {
                format: "PNG",
                cause: error.to_string(),
            })
    }

    fn broken(_: &mut dyn Write) -> Result<(), RenderError> {
        Err(RenderError::Encode {
            format: "PNG",
            cause: "as planned".to_owned(),
        })
    }

    #[test]
    fn a_failure_names_the_file_and_keeps_what_stood_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        save(&path, hello).unwrap();
        let error = save(&path, broken).unwrap_err();
        assert_eq!(error.kind, Matter::Output);
        assert!(error.cause.contains("a.png"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"hello");
        let error = save(&folder.path().join("no/a.png"), hello).unwrap_err();
        assert!(error.remedy.unwrap().contains("create it"));
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_written_to_and_links_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        save(Path::new("/dev/null"), hello).unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
        fs::write(at("real"), b"old").unwrap();
        std::os::unix::fs::symlink(at("real"), at("link")).unwrap();
        save(&at("link"), hello).unwrap();
        assert_eq!(fs::read(at("real")).unwrap(), b"hello");
        assert!(fs::symlink_metadata(at("link")).unwrap().is_symlink());
    }
}
