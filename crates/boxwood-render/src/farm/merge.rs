//! The picture of which several files hold the tiles.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use super::{
    Difference, PartHeader, Shard, header,
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
/// Reads each file twice: the memory of a film is taken only when all tiles have turned out to be there.
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
    for path in paths {
        let claim = |record: Record| claim(&mut owners, record.number, path);
        scan(path, &header, first, claim)?;
    }
    let missing: Vec<usize> = (0..owners.len())
        .filter(|&tile| owners[tile].is_none())
        .collect();
    if !missing.is_empty() {
        return Err(incomplete(first, &header, &missing));
    }
    let mut film = header.film()?;
    for path in paths {
        let lay_down = |record: Record| {
            record.lay_down(&mut film);
            Ok(())
        };
        scan(path, &header, first, lay_down)?;
    }
    film.develop(header.shading()?, header.scale);
    Ok(Merged { film, header })
}

/// Calls `each` with every record of a file that goes together with the first one.
fn scan(
    path: &Path,
    header: &PartHeader,
    first: &Path,
    mut each: impl FnMut(Record) -> Result<(), RenderError>,
) -> Result<(), RenderError> {
    let (found, start, mut file) = header::open(path)?;
    if let Some(Difference { name, ours, theirs }) = header.difference(&found) {
        return Err(refused(
            path,
            format!("{name} is {theirs} here and {ours} in {}", first.display()),
            "make all parts from one scene with the same options and program",
        ));
    }
    let mut place = start;
    loop {
        match Record::read(&mut file, header.window) {
            Ok(Some(record)) => {
                place += record.len();
                each(record)?;
            }
            // Its shard was stopped there; what is missing is listed.
            Ok(None) | Err(Flaw::Torn) => return Ok(()),
            Err(Flaw::Damaged) => {
                return Err(refused(
                    path,
                    format!("is damaged at byte {place}: its checksum is wrong"),
                    format!(
                        "copy it again, or make it again:\n{}",
                        command(&found, found.shard)
                    ),
                ));
            }
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

/// Each tile comes from one file, once.
fn claim<'a>(
    owners: &mut [Option<&'a Path>],
    tile: u32,
    path: &'a Path,
) -> Result<(), RenderError> {
    match owners[tile as usize].replace(path) {
        None => Ok(()),
        Some(other) => Err(refused(
            path,
            format!("tile {tile} is in {} too", other.display()),
            "name each part once",
        )),
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
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_=./:,+@%".contains(c);
    let quoted = |word: &String| match word.chars().all(plain) && !word.is_empty() {
        true => word.clone(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    };
    let words: Vec<String> = header.command.iter().map(quoted).collect();
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
