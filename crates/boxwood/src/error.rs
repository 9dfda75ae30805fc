//! Why a scene could not be built.

use std::fmt;

/// What is wrong with the input of a build. Primitives that can never be hit are no error: non-finite ones are kept out
/// and counted (see [`Scene::skipped`](crate::Scene::skipped)), flat ones simply miss.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum BuildError {
    /// A triangle names a vertex that does not exist.
    IndexOutOfRange {
        /// Mesh, in the order added.
        geom: usize,
        /// Triangle within the mesh.
        triangle: usize,
        /// The index it names.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// More primitives than 32-bit ids can tell apart.
    TooManyPrimitives {
        /// How many were given.
        count: usize,
        /// How many are allowed.
        limit: usize,
    },
    /// More memory than 32-bit references can tell apart.
    TooLarge {
        /// Bytes that the structure would take.
        bytes: u64,
        /// How many are allowed.
        limit: u64,
    },
    /// No structure, volume or builder has this name.
    UnknownName {
        /// `structure`, `volume` or `builder`.
        kind: &'static str,
        /// What was asked for.
        name: String,
        /// What there is.
        known: Vec<&'static str>,
    },
    /// A kind of primitive, or a bounding volume, that this build of Boxwood leaves out.
    NotCompiled {
        /// The Cargo feature that brings it.
        feature: &'static str,
    },
    /// Two of meshes, instances and other primitives in one scene: make each a scene of its own and put them together as
    /// instances ([`SceneBuilder::instance`](crate::SceneBuilder::instance)), or write a mixture as one set of shapes
    /// ([`SceneBuilder::shapes`](crate::SceneBuilder::shapes)).
    MixedPrimitives,
    /// Scenes stand too deep inside each other.
    NestedTooDeep {
        /// Levels of instances.
        depth: u32,
        /// How many are allowed.
        limit: u32,
    },
    /// Instances inside instances multiply to more than 32-bit ids can tell apart.
    TooManyPaths {
        /// How many ways lead to scenes of primitives.
        count: u64,
        /// How many are allowed.
        limit: u32,
    },
    /// A scene is to be changed in a mesh that it has not.
    NoSuchMesh {
        /// The mesh asked for.
        geom: u32,
        /// How many it has.
        meshes: usize,
    },
    /// A scene is to be changed by more or fewer things than it has.
    WrongCount {
        /// `transforms` or `triangles`.
        what: &'static str,
        /// How many it has.
        expected: usize,
        /// How many were given.
        found: usize,
    },
    /// The system did not grant the memory.
    OutOfMemory {
        /// What was asked for.
        bytes: usize,
    },
    /// [`BuildOptions::progress`](crate::BuildOptions::progress) ended the build.
    Cancelled,
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::IndexOutOfRange {
                geom,
                triangle,
                index,
                vertices,
            } => {
                write!(
                    f,
                    "mesh {geom}, triangle {triangle}: vertex {index} of {vertices}"
                )
            }
            Self::TooManyPrimitives { count, limit } => {
                write!(f, "{count} primitives, at most {limit} are possible")
            }
            Self::TooLarge { bytes, limit } => {
                write!(
                    f,
                    "the structure would take {bytes} bytes, at most {limit} are possible; make parts of the scene instances"
                )
            }
            Self::UnknownName { kind, name, known } => {
                write!(
                    f,
                    "no {kind} is called '{name}'; there are: {}",
                    known.join(", ")
                )
            }
            Self::NotCompiled { feature } => {
                write!(
                    f,
                    "this build of Boxwood leaves that out: compile it with the feature `{feature}`"
                )
            }
            Self::MixedPrimitives => {
                write!(
                    f,
                    "a scene holds one kind of primitives, or instances; make each kind a scene of its own and put those together"
                )
            }
            Self::NestedTooDeep { depth, limit } => {
                write!(
                    f,
                    "{depth} levels of scenes inside scenes, at most {limit} are possible"
                )
            }
            Self::TooManyPaths { count, limit } => {
                write!(
                    f,
                    "instances multiply to {count}, fewer than {limit} are possible"
                )
            }
            Self::NoSuchMesh { geom, meshes } => {
                write!(f, "mesh {geom} is to change, the scene has {meshes}")
            }
            Self::WrongCount {
                what,
                expected,
                found,
            } => write!(f, "{found} {what} for {expected}"),
            Self::OutOfMemory { bytes } => {
                write!(f, "{bytes} bytes of memory were refused by the system")
            }
            Self::Cancelled => write!(f, "the build was cancelled"),
        }
    }
}

impl std::error::Error for BuildError {}
