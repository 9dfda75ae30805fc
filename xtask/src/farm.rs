//! The render farm: its Open Job Description template, run by the reference implementation, and a hundred kills.

use crate::shell::{command, root, step, target};
use anyhow::{Result, ensure};
use std::fs;
use std::path::Path;

const TEMPLATE: &str = "docs/farm/openjd.yaml";
/// Small, so that the whole chore takes a minute once things are built.
const LOOK: [&str; 2] = ["--size=109x67", "--shading=ao"];

/// `cargo xtask farm-test`: builds the command line, checks and runs the template with it, and kills renders.
pub(crate) fn test(_: &[String]) -> Result<()> {
    let build = command("cargo", &["build", "--release", "--bins", "--examples"]);
    step("the command line", build)?;
    let home = target().join("farm");
    if home.exists() {
        fs::remove_dir_all(&home)?;
    }
    let shots = home.join("shots");
    fs::create_dir_all(&shots)?;
    let openjd = openjd(&home.join("venv"))?;
    step("the template", command(&openjd, &["check", TEMPLATE]))?;
    for (step_name, rest) in [("Frames", ""), ("Merge", "--run-dependencies")] {
        run(&openjd, step_name, rest, &shots)?;
    }
    compare(&shots)?;
    let kills = ["test", "--release", "--test", "farm", "--", "--ignored"];
    step("a hundred kills", command("cargo", &kills))
}

/// The path of `openjd` in a fresh environment.
fn openjd(venv: &Path) -> Result<String> {
    let mut fresh = command("python3", &["-m", "venv"]);
    fresh.arg(venv);
    step("a fresh Python environment", fresh)?;
    let python = venv.join("bin/python").display().to_string();
    let install = ["-m", "pip", "install", "--quiet", "openjd-cli>=0.8,<1"];
    step("openjd-cli", command(&python, &install))?;
    Ok(venv.join("bin/openjd").display().to_string())
}

fn boxwood() -> String {
    target().join("release/boxwood").display().to_string()
}

/// A step of the template, with all that it depends on if `rest` says so.
fn run(openjd: &str, name: &str, rest: &str, shots: &Path) -> Result<()> {
    let mut run = command(openjd, &["run", TEMPLATE, "--step", name]);
    run.args((!rest.is_empty()).then_some(rest));
    let parameters = [
        "Scene=builtin:bush".to_owned(),
        format!("Output={}", shots.display()),
        "Frames=1-8:3".to_owned(),
        "Turn=8".to_owned(),
        "Shards=3".to_owned(),
        "Size=109x67".to_owned(),
        "Shading=ao".to_owned(),
        format!("Boxwood={}", boxwood()),
    ];
    for parameter in parameters {
        run.args(["-p", &parameter]);
    }
    step(&format!("the template's step {name}"), run)
}

/// What the template's tasks made is what one process makes.
fn compare(shots: &Path) -> Result<()> {
    let pictures = [
        ("picture.png", vec![]),
        ("frame.0004.png", vec!["--turntable=8", "--frame=4"]),
    ];
    for (name, args) in pictures {
        let alone = shots.join("alone.png");
        let mut render = command(&boxwood(), &["render", "builtin:bush"]);
        render.args(LOOK).args(args).arg("-o").arg(&alone);
        step(&format!("{name}, by one process"), render)?;
        let same = fs::read(shots.join(name))? == fs::read(&alone)?;
        ensure!(same, "{name} differs from what one process makes");
    }
    let frames = [1, 4, 7].map(|frame| shots.join(format!("frame.{frame:04}.png")));
    ensure!(
        frames.iter().all(|frame| frame.exists()),
        "frames are missing in {}",
        shots.strip_prefix(root()).unwrap_or(shots).display()
    );
    Ok(())
}
