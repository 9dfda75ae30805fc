//! Work on the library's own threads.

use crate::error::{BwError, Failure};

/// More threads than this are a mistake.
pub(crate) const MAX_THREADS: u32 = 4096;

/// Runs `work` on so many threads of the library's own, on one too; 0: on as many as the machine has.
pub(crate) fn on_threads<T: Send>(
    threads: u32,
    work: impl FnOnce() -> T + Send,
) -> Result<T, Failure> {
    let pool = boxwood_host::pool(threads as usize).map_err(|error| {
        Failure::new(BwError::NoThreads, format!("no {threads} threads: {error}"))
    })?;
    Ok(pool.install(work))
}
