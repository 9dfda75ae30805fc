//! Who takes part: Boxwood's builds, Embree's, and the others.

use crate::rivals::{embree, obvhs, parry, svenstaro};
use anyhow::{Error, Result, anyhow};
use boxwood::{
    BUILDERS, BuildOptions, InstructionSet, PRESETS, STRUCTURES, Scene, Structure, VOLUMES,
};
use boxwood_measure::{Asked, Built, Clock, Entry, MeasureError, with_threads};
use boxwood_scene::FlatMesh;
use libloading::Library;

/// What Boxwood builds, and how.
#[derive(Clone, Debug)]
struct Build {
    structure: &'static str,
    options: BuildOptions,
}

/// A word of a name, and what it changes in a build.
type Word = (&'static str, fn(&mut Build));

/// Builds of Boxwood's that take part unasked besides the usual one, the presets and [`NARROW`], as `boxwood-NAME`. RESULTS
/// looks for `compact`. Add a line here.
const WORDS: &[Word] = &[("compact", |build| build.structure = "compact")];
/// Instruction sets that take part unasked where the machine has them, so that old machines are seen too.
const NARROW: [&str; 2] = ["avx2", "sse2"];
/// The names of the rivals that are not Embree.
const OTHERS: [&str; 4] = ["obvhs", "obvhs-slow", "parry3d", "bvh"];

impl Build {
    /// Of a name: presets and instruction sets and words of the tables of structures, builders and volumes, as in `boxwood-bvh2-sweep`; what is
    /// not said is as usual.
    fn named(name: &str) -> Option<Self> {
        let mut words = name.split('-');
        if words.next() != Some("boxwood") {
            return None;
        }
        let mut build = Self {
            structure: Structure::DEFAULT,
            options: BuildOptions::default(),
        };
        for word in words {
            if let Some((_, change)) = WORDS.iter().find(|(name, _)| *name == word) {
                change(&mut build);
                continue;
            }
            if let Some(set) = InstructionSet::named(word) {
                build.options.instructions = set;
                continue;
            }
            if let Some(preset) = PRESETS.iter().find(|preset| preset.name == word) {
                build.options = (preset.options)();
                continue;
            }
            let structure = STRUCTURES.iter().find(|s| s.name == word);
            let builder = BUILDERS.iter().find(|b| b.name == word);
            let volume = VOLUMES.iter().find(|v| v.name == word);
            match (structure, builder, volume) {
                (Some(structure), ..) => build.structure = structure.name,
                (_, Some(builder), _) => build.options.builder = *builder,
                (.., Some(volume)) => build.options.volume = volume.name,
                _ => return None,
            }
        }
        Some(build)
    }

    /// From positions and indices to a scene that answers.
    fn run(&self, name: &str, mesh: &FlatMesh, threads: usize) -> Result<Built, MeasureError> {
        let (scene, time) = with_threads(threads, || {
            let clock = Clock::of_work_on(threads);
            let start = clock.now();
            let scene = Scene::builder()
                .mesh(&mesh.positions, &mesh.indices)
                .structure(self.structure)
                .options(self.options.clone())
                .build();
            (scene, clock.now() - start)
        })?;
        let scene = scene?;
        let bytes = scene.query().bytes() as u64;
        Ok(Built {
            contender: Box::new(Asked::new(name, scene)),
            time,
            bytes: Some(bytes),
        })
    }
}

/// Looks at names before anything is measured.
///
/// # Errors
/// If one is not known, with those that are.
pub(crate) fn check(only: &[String]) -> Result<()> {
    let is_known = |name: &str| {
        let embree = embree::BUILDS.iter().any(|build| build.name == name);
        embree || OTHERS.contains(&name) || Build::named(name).is_some()
    };
    match only.iter().find(|name| !is_known(name)) {
        Some(name) => Err(unknown(name)),
        None => Ok(()),
    }
}

fn unknown(name: &str) -> Error {
    anyhow!(
        "--only: nobody is called '{name}'; there are {}, {}, and boxwood with words of `boxwood list` as in boxwood-bvh2-sweep",
        embree::BUILDS.map(|build| build.name).join(", "),
        OTHERS.join(", ")
    )
}

/// Whether any of `only` (all, if there are none) is of Embree.
pub(crate) fn want_embree(only: &[String]) -> bool {
    only.is_empty() || only.iter().any(|name| name.starts_with("embree"))
}

/// All contenders, or those of `only` in its order.
///
/// # Errors
/// If a name is not known.
pub(crate) fn entries<'a>(
    mesh: &'a FlatMesh,
    embree: Option<&'static Library>,
    only: &[String],
) -> Result<Vec<Entry<'a>>> {
    let names = if only.is_empty() {
        usual()
    } else {
        only.to_vec()
    };
    names
        .into_iter()
        .map(|name| entry(name, mesh, embree))
        .collect()
}

/// Everybody, Boxwood's builds first.
fn usual() -> Vec<String> {
    // `default` is what one gets without a word.
    let presets = PRESETS
        .iter()
        .map(|preset| preset.name)
        .filter(|name| *name != "default");
    let sets = NARROW
        .into_iter()
        .filter(|set| InstructionSet::named(set).is_some());
    let words = presets
        .chain(WORDS.iter().map(|(word, _)| *word))
        .chain(sets);
    let words = words.map(|word| format!("boxwood-{word}"));
    let rivals = embree::BUILDS.iter().map(|build| build.name).chain(OTHERS);
    let ours = std::iter::once("boxwood".to_owned()).chain(words);
    ours.chain(rivals.map(str::to_owned)).collect()
}

fn entry<'a>(
    name: String,
    mesh: &'a FlatMesh,
    embree: Option<&'static Library>,
) -> Result<Entry<'a>> {
    type BuildFn<'a> = Box<dyn Fn(usize) -> Result<Built, MeasureError> + 'a>;
    let build: BuildFn<'a> = match (&*name, Build::named(&name)) {
        (_, Some(ours)) => {
            let name = name.clone();
            Box::new(move |threads| ours.run(&name, mesh, threads))
        }
        ("obvhs", _) => Box::new(|threads| obvhs::build(mesh, false, threads)),
        ("obvhs-slow", _) => Box::new(|threads| obvhs::build(mesh, true, threads)),
        ("parry3d", _) => Box::new(|_| parry::build(mesh)),
        ("bvh", _) => Box::new(|threads| svenstaro::build(mesh, threads)),
        (name, _) => {
            let build = embree::BUILDS.into_iter().find(|build| build.name == name);
            match (build, embree) {
                (Some(build), Some(library)) => {
                    Box::new(move |threads| embree::build(library, mesh, build, threads))
                }
                _ => return Err(unknown(name)),
            }
        }
    };
    Ok(Entry { name, build })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxwood_is_named_by_the_words_of_its_tables() {
        let build = Build::named("boxwood-grid").unwrap();
        assert_eq!(build.structure, "grid");
        let build = Build::named("boxwood-bvh2-sweep-sphere").unwrap();
        assert_eq!(
            (
                build.structure,
                build.options.builder.name,
                build.options.volume
            ),
            ("bvh2", "sweep", "sphere")
        );
        assert!(Build::named("boxwood-nonsense").is_none());
        assert!(Build::named("obvhs").is_none());
        let ours = usual()
            .into_iter()
            .filter(|name| name.starts_with("boxwood"));
        assert!(
            ours.clone().all(|name| Build::named(&name).is_some()) && ours.count() > WORDS.len()
        );
    }

    #[test]
    fn unknown_names_are_refused_with_the_known_ones() {
        for name in ["embre", "embree-16", "boxwood-nonsense", ""] {
            let error = check(&["bvh".to_owned(), name.to_owned()])
                .unwrap_err()
                .to_string();
            assert!(
                error.contains(&format!("nobody is called '{name}'"))
                    && error.contains("embree-high")
                    && !error.contains('\n'),
                "{error}"
            );
        }
        assert!(check(&usual()).is_ok());
    }
}
