//! Whether a file has changed since it was read.

use std::{
    fs,
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

/// Between two looks at a file.
pub(crate) const INTERVAL: Duration = Duration::from_millis(500);

/// When a file was written, and how long it is.
type Stamp = (SystemTime, u64);

/// A file that is looked at now and then.
#[derive(Clone, Debug)]
pub(crate) struct Watched {
    path: PathBuf,
    read: Option<Stamp>,
    /// As of the last look.
    seen: Option<Stamp>,
    since: Duration,
}

impl Watched {
    /// The file with that name, as it is now, or is to come. Built-in scenes and standard input never change.
    pub(crate) fn new(name: &str) -> Option<Self> {
        if name == "-" || name.starts_with("builtin:") {
            return None;
        }
        let path = PathBuf::from(name);
        let stamp = stamp(&path);
        Some(Self {
            path,
            read: stamp,
            seen: stamp,
            since: Duration::ZERO,
        })
    }

    /// `time` has passed. True, once, when the file is another than before and has not changed between two looks: whoever
    /// writes it has finished.
    pub(crate) fn has_changed(&mut self, time: Duration) -> bool {
        self.since += time;
        if self.since < INTERVAL {
            return false;
        }
        self.since = Duration::ZERO;
        let now = stamp(&self.path);
        let is_stable = now == std::mem::replace(&mut self.seen, now);
        if now.is_none() || !is_stable || now == self.read {
            return false;
        }
        self.read = now;
        true
    }
}

fn stamp(path: &Path) -> Option<Stamp> {
    let metadata = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
    Some((metadata.modified().ok()?, metadata.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_told_once_and_only_when_it_is_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.obj");
        fs::write(&path, "v 0 0 0\n").unwrap();
        let mut watched = Watched::new(path.to_str().unwrap()).unwrap();
        assert!(!watched.has_changed(INTERVAL));
        fs::write(&path, "v 0 0 0\nv 1 2 3.5\n").unwrap();
        assert!(!watched.has_changed(INTERVAL), "it may be written still");
        assert!(!watched.has_changed(INTERVAL / 2), "too early to look");
        assert!(watched.has_changed(INTERVAL));
        assert!(!watched.has_changed(INTERVAL));
        fs::remove_file(&path).unwrap();
        assert!(!watched.has_changed(INTERVAL) && !watched.has_changed(INTERVAL));
    }

    #[test]
    fn a_file_that_is_to_come_has_changed_when_it_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.obj");
        let mut watched = Watched::new(path.to_str().unwrap()).unwrap();
        assert!(!watched.has_changed(INTERVAL) && !watched.has_changed(INTERVAL));
        fs::write(&path, "v 0 0 0\n").unwrap();
        assert!(!watched.has_changed(INTERVAL), "it may be written still");
        assert!(watched.has_changed(INTERVAL));
        assert!(!watched.has_changed(INTERVAL));
    }

    #[test]
    fn what_is_no_file_is_not_watched() {
        assert!(Watched::new("builtin:bush").is_none() && Watched::new("-").is_none());
    }
}
