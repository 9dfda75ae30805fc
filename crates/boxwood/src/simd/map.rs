//! A file as memory.

use memmap2::{Mmap, MmapOptions};
use std::fs::File;
use std::io;

/// The whole file as memory, read at once: whoever opens a scene looks at all of it.
///
/// The bytes are those of the file for as long as the map lives. That nobody changes or shortens it meanwhile is the promise of
/// whoever calls [`Scene::open`](crate::Scene::open), which says so.
pub(crate) fn mapped(file: &File) -> io::Result<Mmap> {
    let mut options = MmapOptions::new();
    options.populate();
    // SAFETY: as documented above; a broken promise is a wrong answer or a signal, as with every map.
    unsafe { options.map(file) }
}
