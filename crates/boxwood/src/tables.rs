//! The two tables that everything else loops over: structures and bounding volumes. (Builders have theirs in
//! [`crate::build`].)

use crate::build::{BuildInput, BuildOptions, BuildWalk, LeafRule};
use crate::error::BuildError;
use crate::geom::{Aabb, Obb, Sphere};
use crate::prims::{Geometry, build_over};
use crate::query::Query;
use crate::simd::InstructionSet;
#[cfg(feature = "compact")]
use crate::structure::Compact;
use crate::structure::{
    Accel, BoundedTree, Bvh2, Full, Grid, Indexed, List, WideSlots, WideTriangles,
};
use crate::volume::{BoundingVolume, FittedVolume};

type Build = fn(&Geometry, &BuildOptions) -> Result<Box<dyn Query>, BuildError>;
type Explain = fn(&Geometry, &BuildOptions, usize) -> Result<BuildWalk, BuildError>;

/// A structure in the table.
#[derive(Clone, Copy)]
pub struct Structure {
    /// `list`, `bounded`, `bvh2`, `wide`, `compact`, `grid`.
    pub name: &'static str,
    /// One line for `boxwood list`.
    pub about: &'static str,
    /// True if [`BuildOptions::builder`] and [`BuildOptions::volume`] matter.
    pub is_tree: bool,
    /// True if [`BuildOptions::instructions`] matters.
    pub has_kernels: bool,
    volumes: &'static [Volume],
    build: Build,
    explain: Explain,
}

/// Every structure. Add a line here.
pub static STRUCTURES: &[Structure] = &[
    Structure::of::<List>(
        "list",
        "brute force: every primitive for every ray; the oracle",
        |_, _, _| Ok(BuildWalk::default()),
    ),
    Structure::over_volumes(
        "bounded",
        "the lecture's BoundedObject, nested objects",
        |geometry, options| (Volume::named(options.volume)?.build_bounded)(geometry, options),
    ),
    Structure::over_volumes(
        "bvh2",
        "bounding volume hierarchy, a flat binary tree",
        |geometry, options| (Volume::named(options.volume)?.build_bvh2)(geometry, options),
    ),
    Structure {
        name: "wide",
        about: "eight-wide hierarchy with a kernel for each instruction set",
        is_tree: true,
        has_kernels: true,
        volumes: VOLUMES.split_at(1).0,
        build: |geometry, options| {
            build_over!(
                geometry,
                triangles prims => WideTriangles::boxed_or_compact(prims, options),
                prims => Indexed::<WideSlots<Full>, _>::boxed(prims, options)
            )
        },
        explain: explain_rows_of_8,
    },
    #[cfg(feature = "compact")]
    Structure {
        name: "compact",
        about: "wide in 0.6 of the memory: quantised boxes, corners shared in leaves",
        is_tree: true,
        has_kernels: true,
        volumes: VOLUMES.split_at(1).0,
        build: |geometry, options| {
            build_over!(
                geometry,
                triangles prims => WideTriangles::<Compact>::boxed(prims, options),
                prims => Indexed::<WideSlots<Compact>, _>::boxed(prims, options)
            )
        },
        explain: explain_rows_of_8,
    },
    Structure::of::<Grid>(
        "grid",
        "uniform grid, walked cell by cell",
        |geometry, options, limit| Ok(Grid::explain(&geometry.boxes(), options, limit)),
    ),
];

/// The binary tree that a builder makes.
fn explain_tree(
    geometry: &Geometry,
    options: &BuildOptions,
    limit: usize,
) -> Result<BuildWalk, BuildError> {
    explain(geometry, options, limit, None)
}

/// The binary tree that is collapsed to eight wide.
fn explain_rows_of_8(
    geometry: &Geometry,
    options: &BuildOptions,
    limit: usize,
) -> Result<BuildWalk, BuildError> {
    explain(geometry, options, limit, Some(LeafRule::ROWS_OF_8))
}

fn explain(
    geometry: &Geometry,
    options: &BuildOptions,
    limit: usize,
    leaves: Option<LeafRule>,
) -> Result<BuildWalk, BuildError> {
    build_over!(geometry, prims => {
        let boxes = geometry.boxes();
        let mut input = BuildInput::new(prims, &boxes);
        if let Some(rule) = leaves {
            input = input.with_leaves(rule);
        }
        options.builder.explain(&input, options, limit)
    })
}

/// Every bounding volume. Add a line here.
pub static VOLUMES: &[Volume] = &[
    Volume::of::<Aabb>("axis-aligned box: cheapest test, loose round diagonal things"),
    other_volume::<Sphere>("smallest enclosing sphere: turns for free, loose round flat things"),
    other_volume::<Obb>("oriented box: tightest, dearest test"),
];

/// One that only the feature `volumes` makes trees of.
const fn other_volume<V: BoundingVolume>(about: &'static str) -> Volume {
    #[cfg(feature = "volumes")]
    return Volume::of::<V>(about);
    #[cfg(not(feature = "volumes"))]
    {
        let refuse: Build = |_, _| Err(BuildError::NotCompiled { feature: "volumes" });
        Volume::with_trees::<V>(about, refuse, refuse)
    }
}

impl Structure {
    /// What [`Scene::new`](crate::Scene::new) builds.
    pub const DEFAULT: &'static str = "wide";

    const fn of<A: Accel>(name: &'static str, about: &'static str, explain: Explain) -> Self {
        let build: Build = |geometry, options| build_over!(geometry, prims => Indexed::<A, _>::boxed(prims, options));
        Self {
            name,
            about,
            is_tree: false,
            has_kernels: false,
            volumes: &[],
            build,
            explain,
        }
    }

    const fn over_volumes(name: &'static str, about: &'static str, build: Build) -> Self {
        Self {
            name,
            about,
            is_tree: true,
            has_kernels: false,
            volumes: VOLUMES,
            build,
            explain: explain_tree,
        }
    }

    /// The bounding volumes that it can be of, the usual one first; none if it has none.
    pub fn volumes(&self) -> &'static [Volume] {
        self.volumes
    }

    /// The instruction sets that it can be asked to use on this machine, the usual one first.
    pub fn instruction_sets(&self) -> Vec<InstructionSet> {
        if self.has_kernels {
            InstructionSet::available()
        } else {
            vec![InstructionSet::best()]
        }
    }

    /// What matters to it of the options: `["binned", "aabb"]`, `["binned", "avx2"]`, nothing for a grid. A choice that it
    /// has not, and the usual instruction set, are left out.
    pub fn choices(&self, options: &BuildOptions) -> Vec<&'static str> {
        let builder = self.is_tree.then_some(options.builder.name);
        let volume = (self.volumes.len() > 1).then_some(options.volume);
        let unusual = self.has_kernels && options.instructions != InstructionSet::best();
        let instructions = unusual.then(|| options.instructions.name());
        builder
            .into_iter()
            .chain(volume)
            .chain(instructions)
            .collect()
    }

    /// Looks a structure up by name.
    pub fn named(name: &str) -> Result<Self, BuildError> {
        find("structure", name, STRUCTURES, |s| s.name)
    }

    /// Builds the structure over the primitives.
    pub fn build(
        &self,
        geometry: &Geometry,
        options: &BuildOptions,
    ) -> Result<Box<dyn Query>, BuildError> {
        (self.build)(geometry, options)
    }

    /// How [`Structure::build`] comes to the binary tree under the structure, or to its grid: see
    /// [`Builder::explain`](crate::Builder::explain).
    ///
    /// # Errors
    /// As [`Structure::build`].
    pub fn explain_build(
        &self,
        geometry: &Geometry,
        options: &BuildOptions,
        limit: usize,
    ) -> Result<BuildWalk, BuildError> {
        (self.explain)(geometry, options, limit)
    }
}

impl std::fmt::Debug for Structure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Structure")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

/// A bounding volume in the table: the structures over it, and its fit to points.
#[derive(Clone, Copy)]
pub struct Volume {
    /// `aabb`, `sphere`, `obb`.
    pub name: &'static str,
    /// One line for `boxwood list`.
    pub about: &'static str,
    /// Operations of one test.
    pub flops: u32,
    build_bvh2: Build,
    build_bounded: Build,
    fit: fn(&[[f32; 3]]) -> Box<dyn FittedVolume>,
}

impl Volume {
    const fn of<V: BoundingVolume>(about: &'static str) -> Self {
        Self::with_trees::<V>(
            about,
            |geometry, options| build_over!(geometry, prims => Indexed::<Bvh2<V>, _>::boxed(prims, options)),
            |geometry, options| build_over!(geometry, prims => BoundedTree::<V, _>::boxed(prims, options)),
        )
    }

    const fn with_trees<V: BoundingVolume>(
        about: &'static str,
        build_bvh2: Build,
        build_bounded: Build,
    ) -> Self {
        Self {
            name: V::NAME,
            about,
            flops: V::FLOPS,
            build_bvh2,
            build_bounded,
            fit: |points| Box::new(V::of_points(points)),
        }
    }

    /// Looks a volume up by name.
    pub fn named(name: &str) -> Result<Self, BuildError> {
        find("volume", name, VOLUMES, |v| v.name)
    }

    /// The volume around points, for measuring its tightness.
    pub fn fit(&self, points: &[[f32; 3]]) -> Box<dyn FittedVolume> {
        (self.fit)(points)
    }
}

impl std::fmt::Debug for Volume {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Volume")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

/// The entry of a name, or an error that says which names there are.
pub(crate) fn find<T: Copy>(
    kind: &'static str,
    name: &str,
    table: &[T],
    name_of: fn(&T) -> &'static str,
) -> Result<T, BuildError> {
    table
        .iter()
        .copied()
        .find(|entry| name_of(entry) == name)
        .ok_or_else(|| BuildError::UnknownName {
            kind,
            name: name.to_owned(),
            known: table.iter().map(name_of).collect(),
        })
}
