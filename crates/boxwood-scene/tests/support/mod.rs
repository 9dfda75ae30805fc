//! The real test meshes, which lie outside the repository.

use std::path::PathBuf;

/// The folder of test scenes; `None`, with a word about it, where it is absent.
pub(crate) fn scenes() -> Option<PathBuf> {
    let folder = PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/scenes"
    ));
    if folder.join("MANIFEST.tsv").is_file() {
        return Some(folder);
    }
    println!("skipped: no test scenes in {}", folder.display());
    None
}

/// A manifest: one map from column name to cell for each row.
pub(crate) struct Manifest {
    columns: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Manifest {
    pub(crate) fn read(path: PathBuf) -> Self {
        let text = std::fs::read_to_string(path).unwrap();
        let mut rows = text
            .lines()
            .map(|line| line.split('\t').map(str::to_owned).collect());
        Self {
            columns: rows.next().unwrap(),
            rows: rows.collect(),
        }
    }

    /// Calls `f` with a function from column name to cell, for each row.
    pub(crate) fn for_each_row(&self, mut f: impl FnMut(&dyn Fn(&str) -> String)) {
        for row in &self.rows {
            let cell = |name: &str| {
                let column = self
                    .columns
                    .iter()
                    .position(|column| column == name)
                    .unwrap();
                row.get(column).cloned().unwrap_or_default()
            };
            f(&cell);
        }
    }
}
