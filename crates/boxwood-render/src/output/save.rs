//! Files that are whole or not there.

use std::{
    fs,
    io::{self, BufWriter, ErrorKind, Write},
    path::{Path, PathBuf},
};

use tempfile::Builder;

use crate::RenderError;

/// Lets `write` fill a file beside `path`, brings it to the disk, and then renames it to `path`.
///
/// Whoever reads `path` sees the old file or the new one, never a half. On any error what stood
/// there stays, and the new file is removed; the error names the path, the cause and what to do.
/// A file that is replaced hands its permissions on; a new one gets the usual ones. A link stays a
/// link: what it leads to is replaced. What is no plain file, such as a pipe or a device, is written
/// to as it is, once `write` has given all.
pub fn save_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<(), RenderError>,
) -> Result<(), RenderError> {
    save_atomically_telling(path, |_| (), write)
}

/// [`save_atomically`] for programs that may be ended in the middle of it: `begun` is told the path
/// of the new file before it is filled, so that it can be removed by whoever ends the process.
pub fn save_atomically_telling(
    path: &Path,
    begun: impl FnOnce(&Path),
    write: impl FnOnce(&mut dyn Write) -> Result<(), RenderError>,
) -> Result<(), RenderError> {
    let failed = |cause: io::Error| {
        let remedy = remedy(&cause);
        RenderError::Save {
            path: path.to_owned(),
            cause,
            remedy,
        }
    };
    let target = &*followed(path).map_err(failed)?;
    match target.metadata() {
        Ok(found) if found.is_dir() => {
            return Err(failed(io::Error::from(ErrorKind::IsADirectory)));
        }
        Ok(found) if !found.is_file() => {
            let mut bytes = Vec::new();
            write(&mut bytes)?;
            return fs::write(target, bytes).map_err(failed);
        }
        _ => {}
    }
    let folder = target
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let mut file = new_file(folder).map_err(failed)?;
    begun(file.path());
    let mut out = Watched {
        inner: BufWriter::new(file.as_file_mut()),
        error: None,
    };
    let written = write(&mut out).and_then(|()| out.flush().map_err(failed));
    // The system's own error says more than the encoder's words about it.
    if let Some(cause) = out.error.take() {
        return Err(failed(cause));
    }
    written?;
    drop(out);
    if let Ok(old) = target.metadata() {
        file.as_file()
            .set_permissions(old.permissions())
            .map_err(failed)?;
    }
    file.as_file().sync_all().map_err(failed)?;
    file.persist(target).map_err(|error| failed(error.error))?;
    Ok(())
}

/// The file that `path` leads to by links, which may be yet to come.
///
/// # Errors
/// If they lead back to themselves.
pub fn followed(path: &Path) -> io::Result<PathBuf> {
    /// As many as Linux follows.
    const MOST_LINKS: usize = 40;
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(next) = fs::read_link(&path) else {
            return Ok(path);
        };
        // A relative link begins in its own folder.
        path = path.parent().unwrap_or(Path::new("")).join(next);
    }
    Err(io::Error::other("is a link that leads to itself"))
}

/// With the permissions of a file that any program makes, not the closed ones of a secret.
fn new_file(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(".boxwood-").suffix(".part");
    #[cfg(unix)]
    {
        use std::{fs::Permissions, os::unix::fs::PermissionsExt};
        builder.permissions(Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

pub(crate) fn remedy(cause: &io::Error) -> &'static str {
    match cause.kind() {
        ErrorKind::NotFound => "the folder does not exist: create it or choose another",
        ErrorKind::PermissionDenied => "you may not write there: choose another folder",
        ErrorKind::ReadOnlyFilesystem => "the disk is read-only: choose another folder",
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "the disk is full: make room or choose another"
        }
        ErrorKind::IsADirectory => "this is a folder: add a file name",
        _ => "choose another place and try again",
    }
}

/// Keeps the first error of the file.
struct Watched<W: Write> {
    inner: W,
    error: Option<io::Error>,
}

impl<W: Write> Watched<W> {
    fn keep<T>(&mut self, result: io::Result<T>) -> io::Result<T> {
        result.map_err(|error| {
            let kind = error.kind();
            if kind == ErrorKind::Interrupted {
                return error;
            }
            self.error.get_or_insert(error);
            io::Error::from(kind)
        })
    }
}

impl<W: Write> Write for Watched<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let result = self.inner.write(bytes);
        self.keep(result)
    }

    fn flush(&mut self) -> io::Result<()> {
        let result = self.inner.flush();
        self.keep(result)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn failing(_: &mut dyn Write) -> Result<(), RenderError> {
        Err(RenderError::Encode {
            format: "PNG",
            cause: "as planned".to_owned(),
        })
    }

    #[test]
    fn a_failure_keeps_the_old_file_and_leaves_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        save_atomically(&path, |out| {
            out.write_all(b"old").map_err(|_| unreachable!())
        })
        .unwrap();
        let error = save_atomically(&path, |out| {
            let _ = out.write_all(b"half");
            failing(out)
        });
        assert!(error.unwrap_err().to_string().contains("as planned"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        save_atomically(&path, |out| {
            out.write_all(b"new").map_err(|_| unreachable!())
        })
        .unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_is_replaced_hands_its_permissions_on() {
        use std::{fs::Permissions, os::unix::fs::PermissionsExt};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, Permissions::from_mode(0o604)).unwrap();
        let mut begun = None;
        save_atomically_telling(&path, |new| begun = Some(new.to_owned()), |_| Ok(())).unwrap();
        assert_eq!(path.metadata().unwrap().permissions().mode() & 0o777, 0o604);
        assert_eq!(begun.unwrap().parent(), Some(folder.path()));
    }

    #[test]
    fn missing_folders_and_folders_in_place_of_files_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let message = save_atomically(&folder.path().join("no/a.png"), |_| Ok(()))
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("a.png") && message.contains("does not exist"),
            "{message}"
        );
        let message = save_atomically(folder.path(), |_| Ok(()))
            .unwrap_err()
            .to_string();
        assert!(message.contains("add a file name"), "{message}");
    }

    #[test]
    fn a_full_disk_is_told_as_such() {
        struct Full;
        impl Write for Full {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::Error::from(ErrorKind::StorageFull))
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let mut watched = Watched {
            inner: Full,
            error: None,
        };
        assert!(watched.write(b"x").is_err());
        assert!(remedy(&watched.error.unwrap()).contains("full"));
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_written_to_and_links_are_kept() {
        use std::os::unix::fs::symlink;
        let hello = |out: &mut dyn Write| out.write_all(b"hello").map_err(|_| unreachable!());
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        save_atomically(Path::new("/dev/null"), hello).unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
        fs::write(at("real"), b"old").unwrap();
        symlink(at("real"), at("link")).unwrap();
        fs::create_dir(at("sub")).unwrap();
        symlink("sub/b", at("first")).unwrap();
        symlink("to come", at("sub/b")).unwrap();
        for (link, file) in [("link", "real"), ("first", "sub/to come")] {
            save_atomically(&at(link), hello).unwrap();
            assert_eq!(fs::read(at(file)).unwrap(), b"hello");
            assert!(fs::symlink_metadata(at(link)).unwrap().is_symlink());
        }
        symlink(at("loop"), at("loop")).unwrap();
        let error = save_atomically(&at("loop"), hello).unwrap_err();
        assert!(error.to_string().contains("leads to itself"), "{error}");
    }
}
