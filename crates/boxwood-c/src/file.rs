//! Scenes in files.

use crate::error::{BwError, Failure};
use crate::threads::on_threads;
use boxwood::Scene;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use tempfile::{Builder, NamedTempFile};

/// Writes the scene beside `path` and renames it there, so that whoever reads or has mapped what stood there keeps it, and nobody sees a half.
pub(crate) fn save(scene: &Scene, threads: u32, path: &Path) -> Result<(), Failure> {
    let refused =
        |error: io::Error| Failure::new(BwError::File, format!("{}: {error}", path.display()));
    // What a link leads to is replaced, not the link.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let old = target.metadata().ok();
    if old.as_ref().is_some_and(|old| !old.is_file()) {
        return Err(refused(io::Error::other("is no file that can be replaced")));
    }
    let mut file = beside(&target).map_err(refused)?;
    let mut to = BufWriter::new(file.as_file_mut());
    on_threads(threads, || scene.save(&mut to))?.map_err(|error| error_at(error, path))?;
    to.flush().map_err(refused)?;
    drop(to);
    if let Some(old) = old {
        file.as_file()
            .set_permissions(old.permissions())
            .map_err(refused)?;
    }
    file.as_file().sync_all().map_err(refused)?;
    file.persist(&target)
        .map_err(|error| refused(error.error))?;
    Ok(())
}

/// The scene in the file at `path`, mapped or copied.
pub(crate) fn opened(path: &Path, is_mapped: bool) -> Result<Scene, Failure> {
    let open = || match is_mapped {
        true => Scene::open(path),
        false => Scene::read(path),
    };
    Ok(on_threads(0, open)??)
}

/// With the permissions of a file that any program makes, not the closed ones of a secret.
fn beside(target: &Path) -> io::Result<NamedTempFile<File>> {
    let folder = target
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let mut builder = Builder::new();
    builder.prefix(".boxwood-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder.unwrap_or(Path::new(".")))
}

fn error_at(error: boxwood::FileError, path: &Path) -> Failure {
    let file = Some(path.to_owned());
    boxwood::FileError { file, ..error }.into()
}
