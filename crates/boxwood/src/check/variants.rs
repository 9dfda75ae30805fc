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
        Self { name: name.into(), build: Box::new(build) }
    }

    /// A structure of the table. The name says what matters to it: `bvh2 binned aabb`, `grid`.
    pub fn of(structure: Structure, options: BuildOptions) -> Self {
        let mut name = structure.name.to_owned();
        if structure.is_tree {
            name = format!("{name} {} {}", options.builder.name, options.volume);
        }
        if options.axis == AxisRule::RoundRobin {
            name.push_str(" round-robin");
        }
        Self::new(name, move |geometry| structure.build(geometry, &options))
    }

    /// Builds the structure over the primitives.
    pub fn build(&self, geometry: &Geometry) -> Result<Box<dyn Query>, BuildError> {
        (self.build)(geometry)
    }
}

impl std::fmt::Debug for Variant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Variant").field("name", &self.name).finish_non_exhaustive()
    }
}

/// Every structure of the tables, trees by every builder over every volume, and the lecture's partition along axes in
/// turn. The default structure comes first; `list` is not there, being what the others are compared with.
pub fn variants() -> Vec<Variant> {
    let named = |name: &str| STRUCTURES.iter().filter(move |s| s.name == name).copied();
    let default = named(Structure::DEFAULT).map(|s| Variant::of(s, BuildOptions::default()));
    let rest = STRUCTURES.iter().filter(|s| s.name != ORACLE).flat_map(|s| variants_of(*s));
    let mut all: Vec<Variant> = default.chain(rest).collect();
    let first = all.first().map(|v| v.name.clone());
    let mut position = 0;
    all.retain(|variant| {
        position += 1;
        position == 1 || Some(&variant.name) != first.as_ref()
    });
    all
}

/// What all others are compared with.
pub(super) const ORACLE: &str = "list";

fn variants_of(structure: Structure) -> Vec<Variant> {
    if !structure.is_tree {
        return vec![Variant::of(structure, BuildOptions::default())];
    }
    let each = BUILDERS.iter().flat_map(|builder| {
        VOLUMES.iter().map(|v| BuildOptions { volume: v.name, ..BuildOptions::with(*builder) })
    });
    let in_turn = [Builder::MEDIAN, Builder::MIDPOINT]
        .map(|b| BuildOptions { axis: AxisRule::RoundRobin, ..BuildOptions::with(b) });
    each.chain(in_turn).map(|options| Variant::of(structure, options)).collect()
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
        assert_eq!(names.len(), trees * (BUILDERS.len() * VOLUMES.len() + 2) + others);
        let mut unique = names.clone();
        unique.sort();
        unique.dedup();
        assert_eq!(unique.len(), names.len(), "{names:?}");
        assert!(names.iter().any(|n| n == "bounded sweep obb") && names.iter().any(|n| n == "grid"));
    }
}
