//! Why something could not be measured.

use boxwood::BuildError;

/// Cause and remedy, as in "cause; remedy".
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeasureError {
    /// The scene could not be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// There is nothing to be hit.
    #[error("the scene has no triangles; give one that has some")]
    NoTriangles,
    /// No primary ray hits anything, so there is nothing to shade or to bounce from.
    #[error(
        "the camera sees nothing of the scene; give another camera, or none to look from outside"
    )]
    SeesNothing,
    /// The system does not grant threads.
    #[error("the system does not grant {threads} threads: {cause}; ask for fewer")]
    Threads {
        /// That many were asked for.
        threads: usize,
        /// In the words of the system.
        cause: String,
    },
    /// Another library could not take part.
    #[error("{name}: {cause}; {remedy}")]
    Contender {
        /// Which one.
        name: String,
        /// What happened.
        cause: String,
        /// What to do.
        remedy: String,
    },
    /// A saved report cannot be read.
    #[error("{file}: {cause}; save one with --save")]
    Report {
        /// As the user named it.
        file: String,
        /// What is wrong with it.
        cause: String,
    },
    /// A plot could not be drawn.
    #[error("a plot cannot be drawn: {cause}; leave the report out")]
    Plot {
        /// In the words of the plotting library.
        cause: String,
    },
}
