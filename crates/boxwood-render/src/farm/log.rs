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
    record::{self, Flaw, Record},
};
use crate::{Film, RenderError, TileWork, output::remedy};

/// An open file of tiles, locked against others.
///
/// It is a header, and a record with a checksum for each finished tile. A process may be killed at any moment: the last
/// record may be torn, and is dropped by the next [`TileLog::open`]. 44 bytes a pixel.
#[derive(Debug)]
pub struct TileLog {
    path: PathBuf,
    file: Mutex<File>,
}

/// What a file of tiles held when it was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Resumed {
    /// Now on the film.
    pub tiles: usize,
    /// Of a torn or damaged tail, which is gone.
    pub dropped_bytes: u64,
}

impl TileLog {
    /// Opens the file, or begins it, and lays down its tiles on `film`, which is `header`'s.
    ///
    /// # Errors
    /// If another process is at work on it, if it is of another picture (the error names what differs) or no file of tiles,
    /// or if the system does not let it be written.
    pub fn open(
        path: &Path,
        header: &PartHeader,
        film: &mut Film,
    ) -> Result<(Self, Resumed), RenderError> {
        let failed = |cause| failed(path, cause);
        let mut file = locked(path)?;
        let length = file.metadata().map_err(failed)?.len();
        let mut reader = BufReader::new(&file);
        let (good, tiles) = match PartHeader::read(&mut reader) {
            Ok((found, start)) => {
                agree(path, &found, header)?;
                lay_down(&mut reader, start, film).map_err(failed)?
            }
            Err(HeaderFlaw::Torn) => (0, 0),
            Err(HeaderFlaw::Foreign(what)) => return Err(refused(path, what)),
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
        let dropped_bytes = length - good;
        Ok((
            log,
            Resumed {
                tiles,
                dropped_bytes,
            },
        ))
    }

    /// Appends a tile of `film`, in one write.
    pub fn keep(&self, film: &Film, tile: &TileWork) -> Result<(), RenderError> {
        let bytes = record::encode(film, tile);
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.write_all(&bytes)
            .map_err(|cause| failed(&self.path, cause))
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

/// Opens, or creates, and locks. A system without locks does without.
fn locked(path: &Path) -> Result<File, RenderError> {
    loop {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(|cause| failed(path, cause))?;
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(RenderError::File {
                path: path.to_owned(),
                place: None,
                what: "another process is at work on it".to_owned(),
                remedy: "let it finish, or end it".to_owned(),
            });
        }
        // Whoever had the lock before may have finished, and taken the file away.
        if path.exists() {
            return Ok(file);
        }
    }
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

/// All whole records, in turn, up to the first that is none. Gives the place behind them, and their number.
fn lay_down(
    reader: &mut BufReader<&File>,
    start: u64,
    film: &mut Film,
) -> io::Result<(u64, usize)> {
    let (mut good, mut tiles) = (start, 0);
    loop {
        match Record::read(reader, film.window) {
            Ok(Some(record)) => {
                // One that is there twice counts once.
                if !film.finished[record.number as usize] {
                    record.lay_down(film);
                    tiles += 1;
                }
                good += record.len();
            }
            Ok(None) | Err(Flaw::Torn | Flaw::Damaged) => return Ok((good, tiles)),
            Err(Flaw::Io(cause)) => return Err(cause),
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
