//! Threads: a pool for each number that was asked for, and for each process, as a fork leaves a pool without its threads.

use crate::error::{BwError, Failure};
use arc_swap::ArcSwapOption;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::collections::HashMap;
use std::sync::Arc;

/// More threads than this are a mistake.
pub(crate) const MAX_THREADS: u32 = 4096;

/// By process and number of threads.
type Pools = HashMap<(u32, u32), Arc<ThreadPool>>;

/// Without a lock: one that another thread holds at a fork would be held for ever in the child.
static POOLS: ArcSwapOption<Pools> = ArcSwapOption::const_empty();

/// Runs `work` on so many threads of the library's own, on one too; 0: on as many as the machine has.
pub(crate) fn on_threads<T: Send>(
    threads: u32,
    work: impl FnOnce() -> T + Send,
) -> Result<T, Failure> {
    Ok(pool(threads)?.install(work))
}

fn pool(threads: u32) -> Result<Arc<ThreadPool>, Failure> {
    let key = (std::process::id(), threads);
    if let Some(pool) = POOLS.load().as_ref().and_then(|pools| pools.get(&key)) {
        return Ok(Arc::clone(pool));
    }
    let mut pool = Arc::new(started(threads)?);
    POOLS.rcu(|pools| {
        let mut pools = pools.as_deref().cloned().unwrap_or_default();
        // Who was first meanwhile stays; the other pool ends.
        pool = Arc::clone(pools.entry(key).or_insert_with(|| Arc::clone(&pool)));
        Some(Arc::new(pools))
    });
    Ok(pool)
}

fn started(threads: u32) -> Result<ThreadPool, Failure> {
    ThreadPoolBuilder::new()
        .num_threads(threads as usize)
        .thread_name(|number| format!("boxwood-{number}"))
        .build()
        .map_err(|error| Failure::new(BwError::NoThreads, format!("no {threads} threads: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_who_ask_for_as_many_threads_at_once_get_the_same_pool() {
        let ask = || pool(3).unwrap();
        let pools: Vec<_> = std::thread::scope(|scope| {
            let askers: Vec<_> = (0..8).map(|_| scope.spawn(ask)).collect();
            askers
                .into_iter()
                .map(|asker| asker.join().unwrap())
                .collect()
        });
        assert!(pools.iter().all(|pool| Arc::ptr_eq(pool, &pools[0])));
        assert_eq!(on_threads(3, rayon::current_num_threads).unwrap(), 3);
    }
}
