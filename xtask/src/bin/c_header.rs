//! Makes the C header of `boxwood-c`'s sources: `c-header FOLDER`, the crate's. `--check` compares with the one that is there.
#![forbid(unsafe_code)]

use anyhow::{Context, Result, bail, ensure};
use cbindgen::{Builder, Config};
use std::path::Path;
use std::{env, fs};

/// What C sees, in the order of the header.
const SOURCES: [&str; 4] = ["error.rs", "types.rs", "scene.rs", "api.rs"];

fn main() -> Result<()> {
    let args: Vec<String> = env::args().skip(1).collect();
    let (folder, is_check) = match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [folder] => (Path::new(folder), false),
        [folder, "--check"] => (Path::new(folder), true),
        _ => bail!("c-header FOLDER [--check]"),
    };
    let header = folder.join("include/boxwood.h");
    let text = generate(folder)?;
    if is_check {
        let there = fs::read_to_string(&header).context("the header is missing")?;
        ensure!(
            there == text,
            "{} is not what its sources say: `cargo xtask c-header` makes it anew",
            header.display()
        );
    } else {
        fs::write(&header, text)?;
    }
    Ok(())
}

fn generate(folder: &Path) -> Result<String> {
    let config = Config::from_file(folder.join("cbindgen.toml")).map_err(anyhow::Error::msg)?;
    let sources = SOURCES.map(|name| folder.join("src").join(name));
    let builder = sources
        .iter()
        .fold(Builder::new().with_config(config), Builder::with_src);
    let mut text = Vec::new();
    builder.generate()?.write(&mut text);
    Ok(String::from_utf8(text)?)
}
