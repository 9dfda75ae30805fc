//! What is checked: structures with their options, under names.

use crate::build::{AxisRule, BUILDERS, BuildOptions, Builder};
use crate::error::BuildError;
use crate::prims::Geometry;
use crate::query::Query;
use crate::tables::{STRUCTURES, Structure, VOLUMES};

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
        let name = name_of(structure.name, structure.is_tree, &options);
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
    let others = STRUCTURES.iter().filter(|s| s.name != ORACLE);
    let mut variants: Vec<Variant> = others.flat_map(|s| variants_of(*s)).collect();
    let default = name_of(Structure::DEFAULT, true, &BuildOptions::default());
    variants.sort_by_key(|variant| variant.name != default);
    variants
}

/// What all others are compared with.
pub(super) const ORACLE: &str = "list";

fn name_of(structure: &str, is_tree: bool, options: &BuildOptions) -> String {
    let turn = if options.axis == AxisRule::RoundRobin {
        " round-robin"
    } else {
        ""
    };
    match is_tree {
        true => format!(
            "{structure} {} {}{turn}",
            options.builder.name, options.volume
        ),
        false => structure.to_owned(),
    }
}

fn variants_of(structure: Structure) -> Vec<Variant> {
    if !structure.is_tree {
        return vec![Variant::of(structure, BuildOptions::default())];
    }
    let each = BUILDERS.iter().flat_map(|builder| {
        VOLUMES.iter().map(|v| BuildOptions {
            volume: v.name,
            ..BuildOptions::with(*builder)
        })
    });
    let in_turn = [Builder::MEDIAN, Builder::MIDPOINT].map(|b| BuildOptions {
        axis: AxisRule::RoundRobin,
        ..BuildOptions::with(b)
    });
    each.chain(in_turn)
        .map(|options| Variant::of(structure, options))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_structure_builder_and_volume_has_its_variant_once() {
        let names: Vec<String> = variants().into_iter().map(|v| v.name).collect();
        assert_eq!(names[0], "bvh2 binned aabb");
        let trees = STRUCTURES.iter().filter(|s| s.is_tree).count();
        let others = STRUCTURES.len() - trees - 1;
        assert_eq!(
            names.len(),
            trees * (BUILDERS.len() * VOLUMES.len() + 2) + others
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
