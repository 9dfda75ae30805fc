//! Packs the page: glue for the WebAssembly, the plain files, a zip, and a bill of its bytes.
//!
//! A program of its own behind the feature `pack`, as its libraries are many and only the page needs them. Called by `cargo
//! xtask web`: `web-pack FILES STILLS PAGE ZIP (WASM NAME)...`.
#![forbid(unsafe_code)]

use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use wasm_bindgen_cli_support::Bindgen;
use zip::{CompressionMethod, DateTime, ZipWriter, write::SimpleFileOptions};

/// Compressed bytes that a reader may have to load: of the forms of the laboratory the heavier; the reader of files only for who
/// has one, stills only for who can run neither.
const BUDGET: u64 = 400_000;

fn main() -> Result<()> {
    let args: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [files, stills, page, archive, forms @ ..] = &args[..] else {
        bail!("web-pack FILES STILLS PAGE ZIP (WASM NAME)...");
    };
    if page.exists() {
        fs::remove_dir_all(page)?;
    }
    for form in forms.as_chunks::<2>().0 {
        glue(&form[0], &form[1], &page.join("wasm"))?;
    }
    for folder in [".", "js", "js/figures"] {
        copy(&files.join(folder), &page.join(folder))?;
    }
    copy(stills, &page.join("still"))?;
    let mut names = Vec::new();
    list(page, page, &mut names)?;
    names.sort();
    pack(page, &names, archive)
}

/// Writes `NAME.js` and `NAME_bg.wasm`.
fn glue(wasm: &Path, name: &Path, folder: &Path) -> Result<()> {
    let name = name.to_str().context("a name of letters")?;
    Bindgen::new()
        .input_path(wasm)
        .out_name(name)
        .web(true)?
        .typescript(false)
        .remove_name_section(true)
        .remove_producers_section(true)
        // The library's default differs from that of the command line.
        .omit_default_module_path(false)
        .generate(folder)
        .with_context(|| format!("no glue for {}", wasm.display()))
}

/// The page's own files of one folder.
fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from).with_context(|| format!("{}", from.display()))? {
        let path = entry?.path();
        if let Some(name) = path.file_name()
            && path.is_file()
        {
            fs::copy(&path, to.join(name))?;
        }
    }
    Ok(())
}

/// All files below `folder`, by their names from `root` on.
fn list(root: &Path, folder: &Path, names: &mut Vec<String>) -> Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            list(root, &path, names)?;
        } else {
            let name = path.strip_prefix(root)?.to_str().context("a plain name")?;
            names.push(name.replace('\\', "/"));
        }
    }
    Ok(())
}

/// Writes the zip, the same bytes for the same page, and prints what each file weighs in it.
fn pack(page: &Path, names: &[String], archive: &Path) -> Result<()> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default());
    for name in names {
        zip.start_file(name, options)?;
        zip.write_all(&fs::read(page.join(name))?)?;
    }
    let bytes = zip.finish()?.into_inner();
    fs::write(archive, &bytes)?;
    let mut reader = zip::ZipArchive::new(Cursor::new(&bytes))?;
    let (mut always, mut files, mut forms) = (0, 0, Vec::new());
    for at in 0..reader.len() {
        let file = reader.by_index_raw(at)?;
        let (name, weight) = (file.name()?, file.compressed_size());
        println!("{:>9} {weight:>9}  {name}", file.size());
        match name.split_once('/') {
            Some(("still", _)) => {}
            Some(("wasm", name)) if name.starts_with("files") => files += weight,
            Some(("wasm", name)) if name.ends_with(".wasm") => forms.push(weight),
            _ => always += weight,
        }
    }
    let loaded = always + forms.iter().max().copied().unwrap_or(0);
    println!("{loaded:>19}  loaded by one reader, compressed (at most {BUDGET})");
    println!("{files:>19}  more for a file of one's own");
    ensure!(loaded <= BUDGET, "the page is too heavy");
    Ok(())
}
