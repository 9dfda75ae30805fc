//! Threads: a pool for each number that was asked for, and for each process, as a fork leaves a pool without its threads.

use crate::FloatModes;
use arc_swap::ArcSwapOption;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::collections::HashMap;
use std::sync::Arc;

/// By process and number of threads.
type Pools = HashMap<(u32, usize), Arc<ThreadPool>>;

/// Without a lock: one that another thread holds at a fork would be held for ever in the child.
static POOLS: ArcSwapOption<Pools> = ArcSwapOption::const_empty();

/// So many threads of the library's own, in the usual floating-point modes; 0: as many as the machine has. They stay for whoever asks for
/// as many again.
///
/// # Errors
/// If the system does not grant them.
pub fn pool(threads: usize) -> Result<Arc<ThreadPool>, ThreadPoolBuildError> {
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

fn started(threads: usize) -> Result<ThreadPool, ThreadPoolBuildError> {
    ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|number| format!("boxwood-{number}"))
        // Threads inherit the modes of the one that makes them.
        .start_handler(|_| std::mem::forget(FloatModes::enter()))
        .build()
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
        assert_eq!(pools[0].install(rayon::current_num_threads), 3);
    }
}
