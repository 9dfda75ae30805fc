//! The arrows of ARCHITECTURE.md: a module imports only what stands below it, a crate only what it may.

use std::fs;
use std::path::{Path, PathBuf};

/// Modules of the core, lowest first. A module may import from those before it and from itself.
const LAYERS: &[&str] = &[
    "geom",
    "simd",
    "observe",
    "lecture",
    "error",
    "volume",
    "prims",
    "build",
    "query",
    "structure",
    "tables",
    "stats",
    "scene",
    "file",
    "check",
];

/// Crates, lowest first, with the project's crates that each may depend on.
const CRATES: &[(&str, &[&str])] = &[
    ("boxwood", &[]),
    ("boxwood-scene", &["boxwood"]),
    ("boxwood-render", &["boxwood", "boxwood-scene"]),
    ("boxwood-measure", &["boxwood", "boxwood-scene"]),
    ("boxwood-trace", &["boxwood"]),
    ("boxwood-host", &[]),
    ("boxwood-c", &["boxwood", "boxwood-host"]),
    (
        "boxwood-view",
        &[
            "boxwood",
            "boxwood-scene",
            "boxwood-render",
            "boxwood-trace",
        ],
    ),
    (
        "boxwood-web",
        &[
            "boxwood",
            "boxwood-scene",
            "boxwood-render",
            "boxwood-trace",
        ],
    ),
    (
        "boxwood-cli",
        &[
            "boxwood",
            "boxwood-scene",
            "boxwood-render",
            "boxwood-measure",
            "boxwood-trace",
            "boxwood-view",
        ],
    ),
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        if entry.path().is_dir() {
            sources(&entry.path(), found);
        } else if entry.path().extension().is_some_and(|e| e == "rs") {
            found.push(entry.path());
        }
    }
}

/// The module of the core that a `crate::` path starts with, for every such path in code.
fn imports(text: &str) -> Vec<String> {
    let code: String = text
        .split("#[cfg(test)]")
        .next()
        .unwrap_or("")
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect::<Vec<_>>()
        .join("\n");
    code.split("crate::")
        .skip(1)
        .map(|rest| {
            rest.chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect()
        })
        .collect()
}

#[test]
fn modules_of_the_core_import_only_downwards() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    let mut seen = 0;
    for file in files {
        let relative = file.strip_prefix(&src).unwrap();
        let module = relative
            .iter()
            .next()
            .unwrap()
            .to_str()
            .unwrap()
            .trim_end_matches(".rs")
            .to_owned();
        if ["lib", "testing"].contains(&module.as_str()) {
            continue;
        }
        let layer = LAYERS
            .iter()
            .position(|l| *l == module)
            .unwrap_or_else(|| panic!("{module} has no layer"));
        for import in imports(&fs::read_to_string(&file).unwrap()) {
            if import.starts_with(char::is_uppercase) || ["find", ""].contains(&import.as_str()) {
                continue;
            }
            let below = LAYERS.iter().position(|l| *l == import).unwrap_or_else(|| {
                panic!(
                    "{} imports {import}, which has no layer",
                    relative.display()
                )
            });
            assert!(
                below <= layer,
                "{} imports {import}, which stands above it",
                relative.display()
            );
            seen += 1;
        }
    }
    assert!(seen > 20, "the test must find imports: {seen}");
}

#[test]
fn crates_depend_only_downwards() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    for (name, allowed) in CRATES {
        let manifest = fs::read_to_string(crates.join(name).join("Cargo.toml")).unwrap();
        let used = manifest
            .lines()
            .filter_map(|line| line.split_once('='))
            .map(|(key, _)| key.trim());
        for dependency in used.filter(|key| key.starts_with("boxwood")) {
            assert!(
                allowed.contains(&dependency),
                "{name} depends on {dependency}"
            );
        }
    }
}

#[test]
fn the_core_reads_no_clock_prints_nothing_and_opens_no_file_but_saved_scenes() {
    let mut files = Vec::new();
    sources(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("src"),
        &mut files,
    );
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        for forbidden in [
            "std::fs",
            "std::time",
            "std::env",
            "println!",
            "std::process",
            "static mut",
        ] {
            // Where the user's own file is opened and becomes memory.
            let is_file = ["file/mod.rs", "simd/map.rs"];
            let may = is_file.iter().any(|allowed| file.ends_with(allowed));
            if forbidden == "std::fs" && may {
                continue;
            }
            assert!(
                !text.contains(forbidden),
                "{} uses {forbidden}",
                file.display()
            );
        }
    }
}
