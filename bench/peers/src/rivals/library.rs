//! Where Embree comes from: the library that the user names, else the one in the PyPI wheel `embreex`, which is fetched once.

use anyhow::{Context, Result, anyhow, bail};
use libloading::Library;
use std::{
    env,
    path::{Path, PathBuf},
    process::Command,
};

/// The wheel whose library is measured: Embree 4.4.
const WHEEL: &str = "embreex==4.4.0.post1";
/// What to do where it cannot be had.
const REMEDY: &str =
    "set EMBREE_LIB (and TBB_LIB) to the libraries of Embree 4, or leave Embree out with --only";

/// Loads Embree, for the rest of the process.
///
/// # Errors
/// With the remedy, if it is neither named nor to be had.
pub(crate) fn open() -> Result<&'static Library> {
    let (embree, tbb) = match env::var_os("EMBREE_LIB") {
        Some(path) => (
            PathBuf::from(path),
            env::var_os("TBB_LIB").map(PathBuf::from),
        ),
        None => fetched().with_context(|| format!("Embree could not be fetched; {REMEDY}"))?,
    };
    if let Some(tbb) = tbb {
        // Embree finds it by its name once it is there.
        load(&tbb)?;
    }
    load(&embree)
}

fn load(path: &Path) -> Result<&'static Library> {
    // SAFETY: loading runs the library's initialisers; the user has named it, or it is the pinned wheel's.
    let library = unsafe { Library::new(path) };
    let library =
        library.with_context(|| format!("{}: cannot be loaded; {REMEDY}", path.display()))?;
    // Its code is called until the process ends.
    Ok(Box::leak(Box::new(library)))
}

/// Python's environment for the wheel and for the generators of scenes; it may not be there.
pub(crate) fn environment() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("target/embree")
}

/// Embree and TBB of the wheel, fetched if they are not there.
fn fetched() -> Result<(PathBuf, Option<PathBuf>)> {
    let environment = environment();
    if find(&environment, "embree4").is_none() {
        fetch(&environment)?;
    }
    let missing = || anyhow!("the wheel {WHEEL} holds no libembree4 for this system");
    Ok((
        find(&environment, "embree4").ok_or_else(missing)?,
        find(&environment, "tbb"),
    ))
}

fn fetch(environment: &Path) -> Result<()> {
    eprintln!("fetching {WHEEL} into {} (once)", environment.display());
    run(Command::new("python3")
        .args(["-m", "venv"])
        .arg(environment))?;
    let pip = environment.join("bin/pip");
    run(Command::new(pip).args(["install", "--quiet", "--no-deps", WHEEL]))
}

/// Runs a program, and says what it said if it fails.
pub(crate) fn run(command: &mut Command) -> Result<()> {
    let output = command
        .output()
        .with_context(|| format!("{command:?} cannot be started"))?;
    if !output.status.success() {
        bail!(
            "{command:?} failed: {}",
            String::from_utf8_lossy(&output.stderr).trim()
        );
    }
    Ok(())
}

/// The library of the wheel whose name begins with `lib` and `name`.
fn find(environment: &Path, name: &str) -> Option<PathBuf> {
    let is_named = |path: &PathBuf, start: &str| {
        path.file_name()
            .is_some_and(|file| file.to_string_lossy().starts_with(start))
    };
    let inside = |folder: &Path, start: &str| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        entries
            .map(|entry| entry.path())
            .filter(|path| is_named(path, start))
            .collect()
    };
    inside(&environment.join("lib"), "python3")
        .into_iter()
        .flat_map(|python| inside(&python.join("site-packages"), "embreex"))
        // Beside the package on Linux, inside of it on macOS.
        .flat_map(|folder| [folder.clone(), folder.join(".dylibs")])
        .flat_map(|folder| inside(&folder, &format!("lib{name}")))
        .next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_library_is_found_in_the_folder_beside_the_package() {
        let root = env::temp_dir().join(format!("boxwood-peers-{}", std::process::id()));
        let folder = root.join("lib/python3.11/site-packages/embreex.libs");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("libembree4-1a2b.so.4"), "").unwrap();
        let found = (find(&root, "embree4"), find(&root, "tbb"));
        std::fs::remove_dir_all(&root).unwrap();
        assert_eq!(found, (Some(folder.join("libembree4-1a2b.so.4")), None));
    }
}
