//! `boxwood list`: everything that can be chosen by name, from the tables themselves.

use std::collections::BTreeMap;

use boxwood::{BUILDERS, PRESETS, STRUCTURES, VOLUMES};
use boxwood_render::SHADINGS;
use boxwood_scene::{BUILTINS, FORMATS, Size};
use serde::Serialize;

use crate::output::{Exit, Output, grouped};

/// List structures, builders, presets, volumes, shadings, file formats, built-in scenes.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  boxwood list\n  boxwood list shadings\n  boxwood list --json")]
pub(crate) struct Args {
    /// Only this section.
    #[arg(value_name = "SECTION", value_parser = SECTIONS.map(|(name, _)| name))]
    section: Option<String>,
}

/// Names, also of the fields of the JSON object, and titles.
const SECTIONS: [(&str, &str); 7] = [
    ("structures", "Structures (--structure)"),
    ("builders", "Builders of trees (--builder)"),
    ("presets", "Presets of a build (--preset)"),
    ("volumes", "Bounding volumes of trees (--volume)"),
    ("shadings", "Shadings (--shading)"),
    ("formats", "File formats"),
    ("builtins", "Built-in scenes (builtin:NAME)"),
];

#[derive(Serialize)]
struct Entry {
    name: &'static str,
    about: String,
}

fn entry(name: &'static str, about: impl Into<String>) -> Entry {
    Entry {
        name,
        about: about.into(),
    }
}

/// Prints the tables, or the one that was asked for.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let is_wanted = |name: &str| args.section.as_ref().is_none_or(|section| section == name);
    let tables: Vec<_> = (SECTIONS.iter())
        .filter(|(name, _)| is_wanted(name))
        .map(|&(name, title)| (name, title, entries(name)))
        .collect();
    if out.is_json() {
        let by_name = tables.into_iter().map(|(name, _, entries)| (name, entries));
        out.json(&by_name.collect::<BTreeMap<_, _>>())?;
        return Ok(Exit::Ok);
    }
    let width = (tables.iter().flat_map(|(.., entries)| entries))
        .map(|entry| entry.name.len())
        .max()
        .unwrap_or(0);
    let section = |(_, title, entries): &(&str, &str, Vec<Entry>)| {
        let lines = entries
            .iter()
            .map(|entry| format!("\n  {:<width$}  {}", entry.name, entry.about));
        format!("{title}{}", lines.collect::<String>())
    };
    out.text(tables.iter().map(section).collect::<Vec<_>>().join("\n\n"))?;
    Ok(Exit::Ok)
}

/// Of the section of this name.
fn entries(section: &str) -> Vec<Entry> {
    match section {
        "structures" => STRUCTURES.iter().map(|s| entry(s.name, s.about)).collect(),
        "builders" => BUILDERS.iter().map(|b| entry(b.name, b.about)).collect(),
        "presets" => PRESETS.iter().map(|p| entry(p.name, p.about)).collect(),
        "volumes" => VOLUMES.iter().map(|v| entry(v.name, v.about)).collect(),
        "shadings" => SHADINGS.iter().map(|s| entry(s.name, s.about)).collect(),
        "formats" => FORMATS
            .iter()
            .map(|f| {
                let extensions = f.extensions.join(", .");
                entry(f.name, format!("{} (.{extensions})", f.about))
            })
            .collect(),
        _ => BUILTINS
            .iter()
            .map(|b| entry(b.name, format!("{}{}", b.about, sizes(b.size, b.seeded))))
            .collect(),
    }
}

/// The parameters of a built-in scene.
fn sizes(size: Size, seeded: bool) -> String {
    let n = match size {
        Size::Fixed => None,
        Size::Exact { default, .. } => Some(format!("n={default}, {} triangles", grouped(default))),
        Size::AtMost { default, .. } => Some(format!("n={default}, at most so many triangles")),
    };
    let parameters: Vec<String> = n
        .into_iter()
        .chain(seeded.then(|| "seed=0".to_owned()))
        .collect();
    if parameters.is_empty() {
        String::new()
    } else {
        format!(" [{}]", parameters.join("; "))
    }
}
