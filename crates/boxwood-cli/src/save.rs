//! Where results go: files that are whole or not there, or standard output.

use std::{
    io::{self, Write},
    path::Path,
};

use anyhow::Context;
use boxwood_render::{RenderError, followed, save_atomically_telling};

use crate::{
    output::{Output, STDOUT, Trouble},
    progress::unfinished,
};

/// Checks before the work what can be known before: the extension (one of `extensions`), the folder, and that stdout is
/// not to be a file and a JSON object at once; that a file to be replaced is not protected. Nothing to write is fine.
pub(crate) fn check(name: Option<&str>, out: &Output, extensions: &[&str]) -> anyhow::Result<()> {
    let Some(name) = name else { return Ok(()) };
    if name == "-" {
        return match out.is_json() {
            true => Err(Trouble::usage(
                "-o - and --json both want standard output",
                "name a file with -o",
            )
            .into()),
            false => Ok(()),
        };
    }
    if name.is_empty() {
        return Err(Trouble::usage("the name of the output is empty", "name a file").into());
    }
    let path = &*followed(Path::new(name)).map_err(|error| {
        Trouble::usage(
            format!("{name}: {error}"),
            "remove it or choose another name",
        )
    })?;
    if !extensions.contains(&&*extension(name)) {
        let known: Vec<String> = extensions
            .iter()
            .map(|extension| format!(".{extension}"))
            .collect();
        let cause = format!("{name}: the name does not end in {}", known.join(" or "));
        return Err(Trouble::usage(cause, "the extension says how to write the file").into());
    }
    if path.is_dir() {
        return Err(Trouble::usage(format!("{name}: is a folder"), "add a file name").into());
    }
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    if !folder.is_dir() {
        let cause = format!("{name}: there is no folder {}", folder.display());
        return Err(Trouble::usage(cause, "create it or choose another").into());
    }
    if path
        .metadata()
        .is_ok_and(|found| found.is_file() && found.permissions().readonly())
    {
        let cause = format!("{name}: is there, and is read-only");
        return Err(Trouble::usage(cause, "make it writable or choose another name").into());
    }
    Ok(())
}

/// In lower case, without the dot; empty if there is none.
pub(crate) fn extension(name: &str) -> String {
    Path::new(name)
        .extension()
        .map(|extension| extension.to_string_lossy().to_lowercase())
        .unwrap_or_default()
}

/// Writes to the file called `name`, which is replaced as a whole or not at all; `-` is standard output. What is not a
/// plain file (a pipe, a device) is written to as it is.
pub(crate) fn save(
    name: &str,
    write: impl FnOnce(&mut dyn Write) -> Result<(), RenderError>,
) -> anyhow::Result<()> {
    if name == "-" {
        return stream(io::stdout().lock(), write).context(STDOUT);
    }
    Ok(unfinished(|begun| {
        save_atomically_telling(Path::new(name), begun, write)
    })?)
}

/// The whole at once: encoders speak of errors in their own words, and a broken pipe must stay one.
fn stream(
    mut out: impl Write,
    write: impl FnOnce(&mut dyn Write) -> Result<(), RenderError>,
) -> anyhow::Result<()> {
    let mut bytes = Vec::new();
    write(&mut bytes)?;
    out.write_all(&bytes)?;
    out.flush()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn what_cannot_be_written_is_found_before_the_work() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).display().to_string();
        let text = Output::new("render", false);
        let refusal = |name: &str| {
            check(Some(name), &text, &["png", "exr"])
                .unwrap_err()
                .to_string()
        };
        assert!(refusal("a.jpg").contains("does not end in .png or .exr"));
        assert!(refusal("a").contains("does not end"));
        assert!(refusal(&at("no/a.png")).contains("there is no folder"));
        fs::create_dir(at("b.png")).unwrap();
        assert!(refusal(&at("b.png")).contains("is a folder"));
        for fine in [Some("a.PNG"), Some("-"), None] {
            check(fine, &text, &["png"]).unwrap();
        }
        assert!(check(Some("-"), &Output::new("render", true), &["png"]).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_that_leads_to_itself_is_refused_before_the_work() {
        let folder = tempfile::tempdir().unwrap();
        let name = folder.path().join("loop.png");
        std::os::unix::fs::symlink(&name, &name).unwrap();
        let text = Output::new("render", false);
        let error = check(Some(&name.display().to_string()), &text, &["png"]).unwrap_err();
        assert!(error.to_string().contains("leads to itself"), "{error}");
    }

    #[test]
    fn a_protected_file_is_refused_before_the_work() {
        let folder = tempfile::tempdir().unwrap();
        let name = folder.path().join("a.png");
        fs::write(&name, "dear").unwrap();
        let mut permissions = name.metadata().unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&name, permissions).unwrap();
        let text = Output::new("render", false);
        let error = check(Some(&name.display().to_string()), &text, &["png"]).unwrap_err();
        assert!(error.to_string().contains("read-only"), "{error}");
    }
}
