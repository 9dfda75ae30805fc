//! The file to which finished tiles are appended, so that whoever is killed loses none of them.

use std::{
    fs::{File, OpenOptions, TryLockError},
    io::{self, BufReader, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use super::{
    Difference, PartHeader,
    header::Flaw as HeaderFlaw,
    plain,
    record::{self, Flaw, Record},
};
use crate::{Film, RenderError, TileWork, output::remedy};

/// An open file of tiles, locked against others.
///
/// It is a header, and a record with a checksum for each finished tile. A process may be killed at any moment: the last
/// record may be torn, and is dropped by the next [`TileLog::open`]; one whose bits have changed is passed over, and its tile
/// is made again. 44 bytes a pixel.
#[derive(Debug)]
pub struct TileLog {
    path: PathBuf,
    file: Mutex<File>,
}

/// What a file of tiles held when it was opened.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Resumed {
    /// Now on the film.
    pub tiles: usize,
    /// Whose checksum is wrong. They stay in the file, and nobody reads them.
    pub damaged: usize,
    /// Of a last record that is not whole, which is gone.
    pub dropped_bytes: u64,
    /// What the system said if it does not lock the file: nothing keeps other processes from it.
    pub lock_error: Option<String>,
}

/// To get hold of a file that others end and begin.
const ATTEMPTS: usize = 100;

impl TileLog {
    /// Opens the file, or begins it, and lays down its tiles on `film`, which is `header`'s.
    ///
    /// # Errors
    /// If another process is at work on it, if it is of another picture (the error names what differs) or no file of tiles,
    /// if it is damaged so that what follows cannot be found, or if the system does not let it be written.
    pub fn open(
        path: &Path,
        header: &PartHeader,
        film: &mut Film,
    ) -> Result<(Self, Resumed), RenderError> {
        let failed = |cause| failed(path, cause);
        let (mut file, lock_error) = locked(path)?;
        let length = file.metadata().map_err(failed)?.len();
        let mut reader = BufReader::new(&file);
        let (good, mut resumed) = match PartHeader::read(&mut reader) {
            Ok((found, start)) => {
                agree(path, &found, header)?;
                lay_down(path, &mut reader, start, film)?
            }
            Err(HeaderFlaw::Torn) => (0, Resumed::default()),
            Err(HeaderFlaw::Foreign(what)) => return Err(refused(path, plain(&what))),
            Err(HeaderFlaw::Io(cause)) => return Err(failed(cause)),
        };
        file.set_len(good).map_err(failed)?;
        file.seek(SeekFrom::End(0)).map_err(failed)?;
        if good == 0 {
            file.write_all(&header.bytes()?).map_err(failed)?;
        }
        let log = Self {
            path: path.to_owned(),
            file: Mutex::new(file),
        };
        resumed.dropped_bytes = length - good;
        resumed.lock_error = lock_error;
        Ok((log, resumed))
    }

    /// Appends a tile of `film`, in one write. What a failed write leaves (half a record, on a full disk) is taken back.
    pub fn keep(&self, film: &Film, tile: &TileWork) -> Result<(), RenderError> {
        let bytes = record::encode(film, tile);
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let end = file
            .stream_position()
            .map_err(|cause| failed(&self.path, cause))?;
        file.write_all(&bytes).map_err(|cause| {
            let _ = file.set_len(end);
            let _ = file.seek(SeekFrom::Start(end));
            failed(&self.path, cause)
        })
    }

    /// Brings all to the disk, and renames the file to `path`: it is whole.
    pub fn finish(self, path: &Path) -> Result<(), RenderError> {
        let file = self
            .file
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        file.sync_all()
            .and_then(|()| std::fs::rename(&self.path, path))
            .map_err(|cause| failed(&self.path, cause))
    }

    /// Removes the file: the picture is there.
    pub fn remove(self) -> Result<(), RenderError> {
        std::fs::remove_file(&self.path).map_err(|cause| failed(&self.path, cause))
    }
}

/// Opens, or creates, and locks. A system without locks does without: then with what it said.
fn locked(path: &Path) -> Result<(File, Option<String>), RenderError> {
    for _ in 0..ATTEMPTS {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(|cause| failed(path, cause))?;
        let lock_error = match file.try_lock() {
            Ok(()) => None,
            Err(TryLockError::WouldBlock) => break,
            Err(TryLockError::Error(cause)) => Some(cause.to_string()),
        };
        // Whoever had the lock before may have finished, and taken the file away; and the next may have begun another.
        if is_at(&file, path) {
            return Ok((file, lock_error));
        }
    }
    Err(RenderError::Busy {
        path: path.to_owned(),
    })
}

/// Whether `path` names this very file.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |found: std::fs::Metadata| (found.dev(), found.ino());
    let [ours, there] = [file.metadata(), path.metadata()].map(|found| found.ok().map(identity));
    ours.is_some() && ours == there
}

/// Elsewhere the standard library tells no identity: whether anything is there.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

/// The file goes on only as what it was begun as.
fn agree(path: &Path, found: &PartHeader, header: &PartHeader) -> Result<(), RenderError> {
    let difference = header.difference(found).or_else(|| {
        (found.shard != header.shard).then(|| Difference {
            name: "--shard".to_owned(),
            ours: header.shard.to_string(),
            theirs: found.shard.to_string(),
        })
    });
    let Some(Difference { name, ours, theirs }) = difference else {
        return Ok(());
    };
    let what = format!("was begun for another picture: {name} is {ours} here and {theirs} there");
    Err(refused(path, what))
}

fn refused(path: &Path, what: String) -> RenderError {
    RenderError::File {
        path: path.to_owned(),
        place: None,
        what,
        remedy: "remove the file to begin anew, or give the output another name".to_owned(),
    }
}

/// All whole records, in turn. Gives the place behind the last that is complete, and how many there are.
fn lay_down(
    path: &Path,
    reader: &mut BufReader<&File>,
    start: u64,
    film: &mut Film,
) -> Result<(u64, Resumed), RenderError> {
    let (mut good, mut resumed) = (start, Resumed::default());
    loop {
        match Record::read(reader, film.window) {
            Ok(Some(record)) => {
                resumed.tiles += usize::from(record.lay_down(film));
                good += record.len();
            }
            Err(Flaw::Damaged(length)) => {
                resumed.damaged += 1;
                good += length;
            }
            Ok(None) | Err(Flaw::Torn) => return Ok((good, resumed)),
            Err(Flaw::Lost) => {
                let what = format!("is damaged at byte {good}, where a tile should begin");
                return Err(refused(path, what));
            }
            Err(Flaw::Io(cause)) => return Err(failed(path, cause)),
        }
    }
}

fn failed(path: &Path, cause: io::Error) -> RenderError {
    RenderError::Save {
        path: path.to_owned(),
        remedy: remedy(&cause),
        cause,
    }
}
