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
    /// No structure, volume or builder has this name.
    UnknownName {
        /// `structure`, `volume` or `builder`.
        kind: &'static str,
        /// What was asked for.
        name: String,
        /// What there is.
        known: Vec<&'static str>,
    },
    /// Triangles and other primitives in one scene: write a mixture as one set of shapes
    /// ([`SceneBuilder::shapes`](crate::SceneBuilder::shapes)) or nest it ([`BoundedObject`](crate::BoundedObject)).
    MixedPrimitives,
    /// The system did not grant the memory.
    OutOfMemory {
        /// What was asked for.
        bytes: usize,
    },
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
            Self::UnknownName { kind, name, known } => {
                write!(
                    f,
                    "no {kind} is called '{name}'; there are: {}",
                    known.join(", ")
                )
            }
            Self::MixedPrimitives => {
                write!(
                    f,
                    "a scene holds one kind of primitives; write a mixture as one set of shapes"
                )
            }
            Self::OutOfMemory { bytes } => {
                write!(f, "{bytes} bytes of memory were refused by the system")
            }
        }
    }
}

impl std::error::Error for BuildError {}
