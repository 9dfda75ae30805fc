//! The pictures of the README: each is one command of the project, and the list is what the README shows.

use crate::shell::{command, root, step};
use anyhow::{Context, Result, ensure};

/// File in `docs/figures`, and the arguments that draw it.
const FIGURES: &[(&str, &str)] = &[
    (
        "bush.png",
        "render builtin:bush --shading whitted --size 640x480 --spp 9",
    ),
    (
        "cornell.png",
        "render builtin:cornell --shading path --size 480x480 --spp 100",
    ),
    (
        "stadium-grid.png",
        "render builtin:stadium --shading heat-prims --structure grid --size 640x360 --log --top 15000",
    ),
    (
        "stadium-bvh.png",
        "render builtin:stadium --shading heat-prims --structure bvh2 --size 640x360 --log --top 15000",
    ),
    (
        "view.png",
        "view builtin:bush --headless --size 960x540 --script docs/figures/view.script",
    ),
];

/// Draws all of them again.
pub(crate) fn run(_: &[String]) -> Result<()> {
    for (file, arguments) in FIGURES {
        let output = format!("docs/figures/{file}");
        let mut args = vec!["run", "--release", "--"];
        args.extend(arguments.split(' '));
        // A script says itself where its picture goes.
        if !args.contains(&"--script") {
            args.extend(["-o", &output]);
        }
        step(file, command("cargo", &args))?;
    }
    Ok(())
}

/// Every figure is there, and the README shows it.
pub(crate) fn check() -> Result<()> {
    let readme = std::fs::read_to_string(root().join("README.md")).context("README.md")?;
    for (file, _) in FIGURES {
        let path = format!("docs/figures/{file}");
        ensure!(
            root().join(&path).exists(),
            "{path} is missing: cargo xtask figures"
        );
        ensure!(readme.contains(&path), "the README does not show {path}");
    }
    Ok(())
}
