//! Numbered pieces of work, shared out to the threads of the pool.

use std::sync::atomic::{AtomicU32, Ordering};

/// Calls `work` once for each number below `count`, on all threads of the caller's rayon pool.
///
/// Every thread opens one `desk`, keeps its buffers there, and takes the next number as soon as it is
/// free: pieces may differ in cost, and cost a few nanoseconds to hand out. Which thread gets which
/// number is left to chance.
pub(crate) fn share_out<D>(
    count: u32,
    desk: impl Fn() -> D + Sync,
    work: impl Fn(&mut D, u32) + Sync,
) {
    let next = AtomicU32::new(0);
    let take_turns = || {
        let mut own = None;
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count {
                return;
            }
            work(own.get_or_insert_with(&desk), number);
        }
    };
    #[cfg(feature = "rayon")]
    rayon::scope(|scope| {
        for _ in 0..rayon::current_num_threads().min(count as usize) {
            scope.spawn(|_| take_turns());
        }
    });
    #[cfg(not(feature = "rayon"))]
    take_turns();
}

/// `work` of each number below `count`, in order, on all threads of the caller's rayon pool.
pub(crate) fn map_each<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    #[cfg(feature = "rayon")]
    return {
        use rayon::prelude::*;
        (0..count).into_par_iter().map(work).collect()
    };
    #[cfg(not(feature = "rayon"))]
    (0..count).map(work).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn each_number_is_handed_out_once_and_desks_are_few() {
        for count in [0, 1, 7, 1000] {
            let (seen, desks) = (Mutex::new(Vec::new()), AtomicU32::new(0));
            let open = || desks.fetch_add(1, Ordering::Relaxed);
            share_out(count, open, |_, number| seen.lock().unwrap().push(number));
            let mut seen = seen.into_inner().unwrap();
            seen.sort_unstable();
            assert!(seen.into_iter().eq(0..count), "{count}");
            #[cfg(feature = "rayon")]
            let threads = rayon::current_num_threads() as u32;
            #[cfg(not(feature = "rayon"))]
            let threads = 1;
            assert!(desks.into_inner() <= threads.min(count));
        }
    }
}
