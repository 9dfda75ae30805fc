//! Who takes part in a race.

use crate::{error::MeasureError, floor::Work, rays::Question};
use boxwood::{Hit, Ray};
use rayon::{ThreadPool, prelude::*};
use serde::{Deserialize, Serialize};

/// How rays are handed over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// One ray per call.
    Single,
    /// Many rays per call.
    Batch,
}

impl Mode {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Single, Self::Batch];

    /// `single`, `batch`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Batch => "batch",
        }
    }
}

/// Something that answers rays: a structure of Boxwood's, or another library. Each writes its answers in Boxwood's own form, so
/// that none has less to write than another.
pub trait Contender: Sync {
    /// For tables.
    fn name(&self) -> &str;

    /// Whether it has calls for rays handed over in this way.
    fn has(&self, mode: Mode) -> bool;

    /// The closest hit of each ray, on the calling thread. The slices have the same length.
    fn closest_hits(&self, mode: Mode, rays: &[Ray], hits: &mut [Option<Hit>]);

    /// Whether anything is in the range of each ray, on the calling thread. The slices have the same length.
    fn occluded(&self, mode: Mode, rays: &[Ray], occluded: &mut [bool]);

    /// [`Contender::closest_hits`] on the threads of the caller's rayon pool.
    fn closest_hits_on_all(&self, mode: Mode, rays: &[Ray], hits: &mut [Option<Hit>]) {
        in_pieces(rays, hits, |rays, hits| self.closest_hits(mode, rays, hits));
    }

    /// [`Contender::occluded`] on the threads of the caller's rayon pool.
    fn occluded_on_all(&self, mode: Mode, rays: &[Ray], occluded: &mut [bool]) {
        in_pieces(rays, occluded, |rays, is| self.occluded(mode, rays, is));
    }

    /// What the rays cost, counted; `None` where the contender does not count.
    fn work(&self, _question: Question, _rays: &[Ray]) -> Option<Work> {
        None
    }
}

/// Rays of one task: small enough to keep all threads busy to the end.
const PIECE: usize = 1024;

/// Answers pieces of the rays on the threads of the caller's pool.
pub(crate) fn in_pieces<T: Send>(
    rays: &[Ray],
    answers: &mut [T],
    answer: impl Fn(&[Ray], &mut [T]) + Sync,
) {
    let pieces = rays.par_chunks(PIECE).zip(answers.par_chunks_mut(PIECE));
    pieces.for_each(|(rays, answers)| answer(rays, answers));
}

/// Runs `work` where rayon has so many threads.
///
/// # Errors
/// [`MeasureError::Threads`] if the system does not grant them.
pub fn with_threads<T: Send>(
    threads: usize,
    work: impl FnOnce() -> T + Send,
) -> Result<T, MeasureError> {
    Ok(new_pool(threads)?.install(work))
}

/// So many threads.
pub(crate) fn new_pool(threads: usize) -> Result<ThreadPool, MeasureError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|cause| MeasureError::Threads {
        threads,
        cause: cause.to_string(),
    })
}
