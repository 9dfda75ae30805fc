//! The picture of which several files hold the tiles.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use super::{
    Difference, PartHeader, Shard, header, plain,
    record::{Flaw, Record},
};
use crate::{Film, RenderError};

/// A whole film, as one process would have exposed it.
#[derive(Clone, Debug)]
pub struct Merged {
    /// Developed.
    pub film: Film,
    /// Of the first file.
    pub header: PartHeader,
}

/// Puts the tiles of `paths` together.
///
/// Reads each file twice: the memory of a film is taken only when all tiles have turned out to be there. A damaged tile does
/// no harm if it is there again.
///
/// # Errors
/// If a file is damaged, if two are of different pictures (the error names what differs) or hold the same tile, or if tiles are
/// missing (the error lists them, with the commands that make them).
pub fn merge(paths: &[PathBuf]) -> Result<Merged, RenderError> {
    let Some(first) = paths.first() else {
        return Err(refused(
            Path::new("merge"),
            "there are no files",
            "name those of the shards",
        ));
    };
    let header = header::read_header(first)?;
    let mut owners = vec![None; header.window.tile_count()];
    let mut damage = None;
    for (file, path) in paths.iter().enumerate() {
        let claim = |record: Record| claim(&mut owners, record.number, (file, path), paths);
        let found = scan(path, &header, first, claim)?;
        damage = damage.or(found);
    }
    let missing: Vec<usize> = (0..owners.len())
        .filter(|&tile| owners[tile].is_none())
        .collect();
    if !missing.is_empty() {
        return Err(damage.unwrap_or_else(|| incomplete(first, &header, &missing)));
    }
    let mut film = laid_down(paths, &header, first)?;
    film.develop(header.shading()?, header.scale);
    Ok(Merged { film, header })
}

/// All tiles of all files. They were there a moment ago.
fn laid_down(paths: &[PathBuf], header: &PartHeader, first: &Path) -> Result<Film, RenderError> {
    let mut film = header.film()?;
    for path in paths {
        let lay_down = |record: Record| {
            record.lay_down(&mut film);
            Ok(())
        };
        scan(path, header, first, lay_down)?;
    }
    match film.is_complete() {
        true => Ok(film),
        false => Err(refused(
            first,
            "it, or a file named with it, has changed while it was read",
            "merge again when all shards are done",
        )),
    }
}

/// Calls `each` with every whole record of a file that goes together with the first one. Gives the first damage that was
/// passed over.
fn scan(
    path: &Path,
    header: &PartHeader,
    first: &Path,
    mut each: impl FnMut(Record) -> Result<(), RenderError>,
) -> Result<Option<RenderError>, RenderError> {
    let (found, start, mut file) = header::open(path)?;
    if let Some(Difference { name, ours, theirs }) = header.difference(&found) {
        return Err(refused(
            path,
            format!("{name} is {theirs} here and {ours} in {}", first.display()),
            "make all parts from one scene with the same options and program",
        ));
    }
    let damaged = |place: u64, what: &str| {
        refused(
            path,
            format!("is damaged at byte {place}: {what}"),
            format!(
                "copy it again, or make it again:\n{}",
                command(&found, found.shard)
            ),
        )
    };
    let (mut place, mut damage) = (start, None);
    loop {
        match Record::read(&mut file, header.window) {
            Ok(Some(record)) => {
                place += record.len();
                each(record)?;
            }
            // Its shard was stopped there; what is missing is listed.
            Ok(None) | Err(Flaw::Torn) => return Ok(damage),
            Err(Flaw::Damaged(length)) => {
                damage.get_or_insert_with(|| damaged(place, "its checksum is wrong"));
                place += length;
            }
            Err(Flaw::Lost) => return Err(damaged(place, "no tile begins there")),
            Err(Flaw::Io(cause)) => {
                return Err(refused(
                    path,
                    cause.to_string(),
                    "name files that can be read",
                ));
            }
        }
    }
}

/// Each tile comes from one file; that it is in there twice is no matter.
fn claim(
    owners: &mut [Option<usize>],
    tile: u32,
    (file, path): (usize, &Path),
    paths: &[PathBuf],
) -> Result<(), RenderError> {
    match owners[tile as usize].replace(file) {
        Some(other) if other != file => Err(refused(
            path,
            format!("tile {tile} is in {} too", paths[other].display()),
            "name each part once",
        )),
        _ => Ok(()),
    }
}

fn incomplete(first: &Path, header: &PartHeader, missing: &[usize]) -> RenderError {
    let count = header.shard.count;
    let shard = |&tile: &usize| Shard::of(tile, count).number;
    let shards: BTreeSet<u32> = missing.iter().map(shard).collect();
    let commands: Vec<String> = shards
        .iter()
        .map(|&number| command(header, Shard { number, count }))
        .collect();
    let tiles: Vec<String> = missing.iter().map(usize::to_string).collect();
    let what = format!(
        "{} of the picture's {} tiles are missing: {}",
        missing.len(),
        header.window.tile_count(),
        shortened(&tiles, ", ")
    );
    let remedy = "make them, and name their files too";
    refused(
        first,
        what,
        format!("{remedy}:\n{}", shortened(&commands, "\n")),
    )
}

/// The first few, and how many more there are.
fn shortened(list: &[String], between: &str) -> String {
    const SHOWN: usize = 12;
    let shown = list[..list.len().min(SHOWN)].join(between);
    match list.len().saturating_sub(SHOWN) {
        0 => shown,
        more => format!("{shown}{between}and {more} more"),
    }
}

/// As it is typed into a shell.
fn command(header: &PartHeader, shard: Shard) -> String {
    let simple = |c: char| c.is_ascii_alphanumeric() || "-_=./:,+@%".contains(c);
    let quoted = |word: String| match word.chars().all(simple) && !word.is_empty() {
        true => word,
        false => format!("'{}'", word.replace('\'', r"'\''")),
    };
    let words: Vec<String> = header
        .command
        .iter()
        .map(|word| quoted(plain(word)))
        .collect();
    format!("boxwood {} --shard {shard}", words.join(" "))
}

fn refused(path: &Path, what: impl Into<String>, remedy: impl Into<String>) -> RenderError {
    RenderError::File {
        path: path.to_owned(),
        place: None,
        what: what.into(),
        remedy: remedy.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{TileLog, TileWork, farm::header::tests::header};

    /// A file with these tiles; the folder goes with the first.
    fn file(tiles: impl Iterator<Item = u32>) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.part");
        let mut film = header().film().unwrap();
        let (log, _) = TileLog::open(&path, &header(), &mut film).unwrap();
        for number in tiles {
            let counts = boxwood::Counts::default();
            let work = TileWork {
                number,
                rays: 1,
                counts,
            };
            log.keep(&film, &work).unwrap();
        }
        (folder, path)
    }

    #[test]
    fn a_tile_that_is_in_a_file_twice_counts_once() {
        let count = header().window.tile_count() as u32;
        let (_folder, path) = file((0..count).chain([1]));
        let merged = merge(&[path]).unwrap();
        assert_eq!(merged.film.rays, u64::from(count));
    }

    #[test]
    fn a_file_that_was_whole_a_moment_ago_leaves_no_holes() {
        let count = header().window.tile_count() as u32;
        let (_folder, path) = file(0..count - 1);
        let error = laid_down(std::slice::from_ref(&path), &header(), &path).unwrap_err();
        assert!(error.to_string().contains("has changed"), "{error}");
    }

    #[test]
    fn what_a_file_says_of_its_command_cannot_steer_the_terminal() {
        let mut hostile = header();
        hostile.command.push("\u{1b}]0;x\u{7}".to_owned());
        let text = command(&hostile, Shard::WHOLE);
        assert!(!text.contains(char::is_control), "{text:?}");
    }
}
