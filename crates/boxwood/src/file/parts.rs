//! The sections of a scene: what stands in them, and how they become a scene again.

use super::error::{FileCause, FileError};
use super::sections::{self, Section};
use crate::build::{AxisRule, BUILDERS, BuildOptions};
use crate::geom::{Aabb, Triangle};
use crate::prims::{Geometry, Triangles};
use crate::scene::{Notes, Scene};
use crate::simd::{Kept, bytes_of};
use crate::structure::{Flaw, opened as opened_tree};
use crate::tables::Structure;
use std::sync::OnceLock;

/// The sections that every file has, in this order. Notes follow, ascending by name.
const NAMES: [&str; 4] = [SCENE, MESHES, TRIANGLES, TREE];
const SCENE: &str = "scene";
const MESHES: &str = "meshes";
const TRIANGLES: &str = "triangles";
const TREE: &str = "tree";
/// Before the name of a note.
const NOTE: &str = "note:";

/// A scene as its file has it.
pub(super) struct Saved<'a> {
    scene: &'a Scene,
    facts: Vec<u8>,
    triangles: &'a [Triangle],
    tree: &'a [u8],
}

impl<'a> Saved<'a> {
    pub(super) fn of(scene: &'a Scene) -> Result<Self, FileError> {
        if cfg!(target_endian = "big") {
            return Err(FileError::new(FileCause::OtherMachine));
        }
        let not_saved = |what: String| FileError::new(FileCause::NotSaved { what });
        let triangles = match scene.geometry() {
            Geometry::Triangles(triangles) => triangles.as_slice(),
            Geometry::Instances(_) => return Err(not_saved("instances".into())),
            _ => return Err(not_saved("other shapes than triangles".into())),
        };
        let (tree, around) = scene.query().saved().ok_or_else(|| {
            let compact = scene.structure() == Structure::DEFAULT;
            not_saved(match compact {
                true => "more than 4 GB (a compact tree)".into(),
                false => format!("structure {}", scene.structure()),
            })
        })?;
        Ok(Self {
            scene,
            facts: Facts::of(scene, around).bytes(),
            triangles,
            tree,
        })
    }

    pub(super) fn sections(&self) -> Vec<Section<'_>> {
        let parts: [&[u8]; 4] = [
            &self.facts,
            bytes_of(self.scene.starts()),
            bytes_of(self.triangles),
            self.tree,
        ];
        let notes = self.scene.all_notes().by_name.iter();
        let known = NAMES.map(str::to_owned).into_iter().zip(parts);
        let notes = notes.map(|(name, bytes)| (format!("{NOTE}{name}"), &**bytes));
        let all = known.chain(notes);
        all.map(|(name, bytes)| Section { name, bytes }).collect()
    }
}

/// The numbers of a scene that are not lists.
struct Facts {
    triangles: u64,
    skipped: u64,
    /// Of the tree.
    bounds: Aabb,
    options: BuildOptions,
}

/// Bytes of the section `scene`.
const FACTS: usize = 88;
/// Of them, those of a builder's name.
const BUILDER: usize = 16;

impl Facts {
    fn of(scene: &Scene, bounds: Aabb) -> Self {
        Self {
            triangles: scene.len() as u64,
            skipped: scene.skipped() as u64,
            bounds,
            options: scene.options().clone(),
        }
    }

    /// What `wide` does not look at is left out of the options.
    fn bytes(&self) -> Vec<u8> {
        let options = &self.options;
        let mut bytes = Vec::with_capacity(FACTS);
        bytes.extend(self.triangles.to_le_bytes());
        bytes.extend(self.skipped.to_le_bytes());
        for x in self.bounds.min.iter().chain(&self.bounds.max) {
            bytes.extend(x.to_le_bytes());
        }
        let mut name = [0; BUILDER];
        name[..options.builder.name.len()].copy_from_slice(options.builder.name.as_bytes());
        bytes.extend(name);
        let axis = u32::from(options.axis == AxisRule::RoundRobin);
        for x in [axis, options.max_leaf, options.bins, options.rounds] {
            bytes.extend(x.to_le_bytes());
        }
        for x in [
            options.primitive_cost,
            options.round_share,
            options.split_budget,
        ] {
            bytes.extend(x.to_le_bytes());
        }
        bytes.resize(FACTS, 0);
        bytes
    }

    fn read(bytes: &[u8]) -> Result<Self, FileError> {
        let broken = |byte, rule| FileError::broken(SCENE, byte, rule);
        let (words, rest) = bytes.as_chunks::<4>();
        if bytes.len() != FACTS || !rest.is_empty() {
            return Err(broken(0, "the section has another length"));
        }
        let u32_at = |at: usize| u32::from_le_bytes(words[at]);
        let u64_at = |at: usize| u64::from(u32_at(at + 1)) << 32 | u64::from(u32_at(at));
        let f32_at = |at: usize| f32::from_le_bytes(words[at]);
        let corner = |at: usize| [0, 1, 2].map(|k| f32_at(at + k));
        let name = words[10..14].as_flattened();
        let is_it = |known: &str| {
            name.strip_prefix(known.as_bytes())
                .is_some_and(|rest| rest.iter().all(|byte| *byte == 0))
        };
        let builder = BUILDERS.iter().find(|builder| is_it(builder.name));
        let builder = *builder.ok_or(broken(40, "there is no such builder"))?;
        if u32_at(14) > 1 || u32_at(21) != 0 {
            return Err(broken(56, "what is unused is not zero"));
        }
        let [primitive_cost, round_share, split_budget] = [18, 19, 20].map(f32_at);
        let axis = match u32_at(14) {
            0 => AxisRule::Longest,
            _ => AxisRule::RoundRobin,
        };
        Ok(Self {
            triangles: u64_at(0),
            skipped: u64_at(2),
            bounds: Aabb {
                min: corner(4),
                max: corner(7),
            },
            options: BuildOptions {
                axis,
                max_leaf: u32_at(15),
                bins: u32_at(16),
                rounds: u32_at(17),
                primitive_cost,
                round_share,
                split_budget,
                ..BuildOptions::with(builder)
            },
        })
    }
}

/// The scene in aligned bytes.
pub(super) fn opened(bytes: &Kept<u8>) -> Result<Scene, FileError> {
    let sections::Read { hash, sections } = sections::read(bytes)?;
    let mut sections = sections.into_iter();
    let mut next = |name: &'static str| match sections.next() {
        Some((found, section)) if found == name => Ok(section),
        _ => Err(FileError::broken(
            "table",
            0,
            "a section is missing or not in its place",
        )),
    };
    let [facts, meshes, triangles, tree] =
        [next(SCENE)?, next(MESHES)?, next(TRIANGLES)?, next(TREE)?];
    let facts = Facts::read(&facts)?;
    let triangles = triangles_of(&triangles, &facts)?;
    let starts = starts_of(&meshes, &facts)?;
    let notes = Notes {
        by_name: notes_of(sections)?,
        hash: OnceLock::from(hash),
    };
    let query =
        opened_tree(&tree, facts.bounds, &triangles, &facts.options).map_err(
            |flaw| match flaw {
                Flaw::Broken { byte, rule } => FileError::broken(TREE, byte as u64, rule),
                Flaw::OutOfMemory { bytes } => FileError::out_of_memory(bytes as u64),
            },
        )?;
    let geometry = Geometry::Triangles(triangles);
    let scene = Scene::of(
        geometry,
        starts,
        Structure::DEFAULT,
        &facts.options,
        Some(query),
    )
    .map_err(|_| FileError::broken(SCENE, 0, "there are too many triangles"))?;
    if scene.skipped() as u64 != facts.skipped || scene.bounds() != facts.bounds {
        return Err(FileError::broken(
            SCENE,
            8,
            "the triangles are others than those counted",
        ));
    }
    Ok(scene.with_notes(notes))
}

fn triangles_of(bytes: &Kept<u8>, facts: &Facts) -> Result<Triangles, FileError> {
    let triangles = bytes
        .elements()
        .filter(|list| list.len() as u64 == facts.triangles);
    let rule = "there are more or fewer triangles than counted";
    triangles
        .map(Triangles::kept)
        .ok_or(FileError::broken(TRIANGLES, 0, rule))
}

/// First triangle of each mesh: ascending from 0.
fn starts_of(bytes: &Kept<u8>, facts: &Facts) -> Result<Vec<u32>, FileError> {
    let broken = |rule| FileError::broken(MESHES, 0, rule);
    let starts = bytes
        .elements::<u32>()
        .ok_or(broken("the section has another length"))?;
    let is_ascending = starts.is_sorted() && starts.first().is_none_or(|first| *first == 0);
    let is_inside = starts
        .last()
        .is_none_or(|last| u64::from(*last) <= facts.triangles);
    if !is_ascending || !is_inside || (starts.is_empty() && facts.triangles > 0) {
        return Err(broken("meshes do not follow each other"));
    }
    Ok(starts.to_vec())
}

/// Notes: ascending by name.
fn notes_of(
    sections: impl Iterator<Item = (String, Kept<u8>)>,
) -> Result<Vec<(String, Kept<u8>)>, FileError> {
    let broken = || FileError::broken("table", 0, "a section is not known");
    let named = sections.map(|(name, section)| {
        let name = name.strip_prefix(NOTE).filter(|name| Notes::is_name(name));
        Ok((name.ok_or_else(broken)?.to_owned(), section))
    });
    let notes = named.collect::<Result<Vec<_>, FileError>>()?;
    match notes.is_sorted_by(|(a, _), (b, _)| a < b) {
        true => Ok(notes),
        false => Err(broken()),
    }
}
