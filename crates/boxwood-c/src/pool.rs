//! Threads: a pool for each number that was asked for, and for each process, as a fork leaves a pool without its threads.

use crate::error::{BwError, Failure};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// More threads than this are a mistake.
pub(crate) const MAX_THREADS: u32 = 4096;

/// By process and number of threads.
type Pools = HashMap<(u32, u32), Arc<ThreadPool>>;

static POOLS: Mutex<Option<Pools>> = Mutex::new(None);

/// Runs `work` on so many threads; 0: as many as the machine has, 1: on the caller's own.
pub(crate) fn on_threads<T: Send>(
    threads: u32,
    work: impl FnOnce() -> T + Send,
) -> Result<T, Failure> {
    Ok(pool(threads)?.install(work))
}

fn pool(threads: u32) -> Result<Arc<ThreadPool>, Failure> {
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let pools = pools.get_or_insert_default();
    let key = (std::process::id(), threads);
    if let Some(pool) = pools.get(&key) {
        return Ok(Arc::clone(pool));
    }
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads as usize)
        .thread_name(|number| format!("boxwood-{number}"))
        .build()
        .map_err(|error| {
            Failure::new(BwError::NoThreads, format!("no {threads} threads: {error}"))
        })?;
    let pool = Arc::new(pool);
    pools.insert(key, Arc::clone(&pool));
    Ok(pool)
}
