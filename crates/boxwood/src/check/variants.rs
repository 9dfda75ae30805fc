//! What is checked: structures with their options, under names.

use crate::build::{AxisRule, BUILDERS, BuildOptions, Builder};
use crate::error::BuildError;
use crate::prims::Geometry;
use crate::query::Query;
use crate::tables::{STRUCTURES, Structure};

type Build = dyn Fn(&Geometry) -> Result<Box<dyn Query>, BuildError> + Send + Sync;

/// A structure and the way to build it.
pub struct Variant {
    /// As reports call it.
    pub name: String,
    build: Box<Build>,
}

impl Variant {
    /// Anything that answers queries: the way to check a structure of your own.
    pub fn new(
        name: impl Into<String>,
        build: impl Fn(&Geometry) -> Result<Box<dyn Query>, BuildError> + Send + Sync + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            build: Box::new(build),
        }
    }

    /// A structure of the table. The name says what matters to it: `bvh2 binned aabb`, `grid`.
    pub fn of(structure: Structure, options: BuildOptions) -> Self {
        let name = name_of(&structure, &options);
        Self::new(name, move |geometry| structure.build(geometry, &options))
    }

    /// Builds the structure over the primitives.
    pub fn build(&self, geometry: &Geometry) -> Result<Box<dyn Query>, BuildError> {
        (self.build)(geometry)
    }
}

impl std::fmt::Debug for Variant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Variant")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

/// Every structure of the tables, trees by every builder over every volume, and the lecture's partition along axes in
/// turn. The default structure comes first; `list` is not there, being what the others are compared with.
pub fn variants() -> Vec<Variant> {
    let variant = |(structure, options)| Variant::of(structure, options);
    choices().into_iter().map(variant).collect()
}

/// The same as structures with their options.
pub(super) fn choices() -> Vec<(Structure, BuildOptions)> {
    let others = STRUCTURES.iter().filter(|s| s.name != ORACLE);
    let mut choices: Vec<_> = others.flat_map(|s| choices_of(*s)).collect();
    choices.sort_by_key(|(structure, options)| {
        structure.name != Structure::DEFAULT || *options != BuildOptions::default()
    });
    choices
}

/// What all others are compared with.
pub(super) const ORACLE: &str = "list";

/// `bvh2 binned aabb`, `wide binned avx2`, `grid`.
pub(super) fn name_of(structure: &Structure, options: &BuildOptions) -> String {
    let turn = (structure.is_tree && options.axis == AxisRule::RoundRobin).then_some("round-robin");
    let choices = structure.choices(options);
    let words = [structure.name].into_iter().chain(choices).chain(turn);
    words.collect::<Vec<_>>().join(" ")
}

fn choices_of(structure: Structure) -> Vec<(Structure, BuildOptions)> {
    if !structure.is_tree {
        return vec![(structure, BuildOptions::default())];
    }
    let each = BUILDERS.iter().flat_map(|builder| {
        structure.volumes().iter().map(|v| BuildOptions {
            volume: v.name,
            ..BuildOptions::with(*builder)
        })
    });
    let in_turn = [Builder::MEDIAN, Builder::MIDPOINT].map(|b| BuildOptions {
        axis: AxisRule::RoundRobin,
        ..BuildOptions::with(b)
    });
    let instructions = structure.instruction_sets().into_iter().skip(1);
    let narrower = instructions.map(|instructions| BuildOptions {
        instructions,
        ..BuildOptions::default()
    });
    each.chain(in_turn)
        .chain(narrower)
        .map(|options| (structure, options))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_structure_builder_and_volume_has_its_variant_once() {
        let names: Vec<String> = variants().into_iter().map(|v| v.name).collect();
        assert_eq!(names[0], "wide binned");
        let of = |s: &Structure| match s.is_tree {
            true => s.volumes().len() * BUILDERS.len() + 2 + s.instruction_sets().len() - 1,
            false => 1,
        };
        assert_eq!(
            names.len(),
            STRUCTURES.iter().map(of).sum::<usize>() - 1,
            "all but the list"
        );
        let mut unique = names.clone();
        unique.sort();
        unique.dedup();
        assert_eq!(unique.len(), names.len(), "{names:?}");
        assert!(
            names.iter().any(|n| n == "bounded sweep obb") && names.iter().any(|n| n == "grid")
        );
    }
}
