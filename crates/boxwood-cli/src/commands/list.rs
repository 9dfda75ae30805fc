//! `boxwood list`: everything that can be chosen by name, from the tables themselves.

use boxwood::{BUILDERS, PRESETS, STRUCTURES, VOLUMES};
use boxwood_render::SHADINGS;
use boxwood_scene::{BUILTINS, FORMATS, Size};
use serde::Serialize;

use crate::output::{Exit, Output, grouped};

/// List structures, builders, presets, volumes, shadings, file formats, built-in scenes.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  boxwood list\n  boxwood list --json")]
pub(crate) struct Args {}

/// All tables, in the words of the JSON object.
#[derive(Serialize)]
struct Tables {
    structures: Vec<Entry>,
    builders: Vec<Entry>,
    presets: Vec<Entry>,
    volumes: Vec<Entry>,
    shadings: Vec<Entry>,
    formats: Vec<Entry>,
    builtins: Vec<Entry>,
}

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

/// Prints the tables.
pub(crate) fn run(_: &Args, out: &Output) -> anyhow::Result<Exit> {
    let tables = tables();
    if out.is_json() {
        out.json(&tables)?;
        return Ok(Exit::Ok);
    }
    let sections = [
        ("Structures (--structure)", &tables.structures),
        ("Builders of trees (--builder)", &tables.builders),
        ("Presets of a build (--preset)", &tables.presets),
        ("Bounding volumes of trees (--volume)", &tables.volumes),
        ("Shadings (--shading)", &tables.shadings),
        ("File formats", &tables.formats),
        ("Built-in scenes (builtin:NAME)", &tables.builtins),
    ];
    let width = sections
        .iter()
        .flat_map(|(_, entries)| *entries)
        .map(|entry| entry.name.len())
        .max()
        .unwrap_or(0);
    let section = |(title, entries): &(&str, &Vec<Entry>)| {
        let lines = entries
            .iter()
            .map(|entry| format!("\n  {:<width$}  {}", entry.name, entry.about));
        format!("{title}{}", lines.collect::<String>())
    };
    out.text(
        sections
            .iter()
            .map(section)
            .collect::<Vec<_>>()
            .join("\n\n"),
    )?;
    Ok(Exit::Ok)
}

fn tables() -> Tables {
    Tables {
        structures: STRUCTURES.iter().map(|s| entry(s.name, s.about)).collect(),
        builders: BUILDERS.iter().map(|b| entry(b.name, b.about)).collect(),
        presets: PRESETS.iter().map(|p| entry(p.name, p.about)).collect(),
        volumes: VOLUMES.iter().map(|v| entry(v.name, v.about)).collect(),
        shadings: SHADINGS.iter().map(|s| entry(s.name, s.about)).collect(),
        formats: FORMATS
            .iter()
            .map(|f| {
                entry(
                    f.name,
                    format!("{} (.{})", f.about, f.extensions.join(", .")),
                )
            })
            .collect(),
        builtins: BUILTINS
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
