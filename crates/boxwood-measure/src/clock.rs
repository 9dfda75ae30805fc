//! Clocks: the one on the wall, and the processor's for one thread.

use std::{
    sync::LazyLock,
    time::{Duration, Instant},
};

/// What time is taken by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// As users see it; the only one for work on several threads.
    Wall,
    /// Only while the calling thread has a processor: whoever else wants that does not show. The wall's where the system has
    /// no such clock.
    Thread,
}

impl Clock {
    /// For work on so many threads: if it is one, then this one, by what it takes of the processor, so that a busy machine does
    /// not show. (Nor do other threads of the program: those of libraries spin for a while after they have worked.)
    pub fn of_work_on(threads: usize) -> Self {
        if threads == 1 {
            Self::Thread
        } else {
            Self::Wall
        }
    }

    /// Since some moment; only differences on the same thread mean anything.
    pub fn now(self) -> Duration {
        match self {
            Self::Wall => wall(),
            Self::Thread => thread(),
        }
    }
}

fn wall() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}

#[cfg(unix)]
fn thread() -> Duration {
    use rustix::time::{ClockId, clock_gettime};
    let time = clock_gettime(ClockId::ThreadCPUTime);
    // It is never negative.
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

#[cfg(not(unix))]
fn thread() -> Duration {
    wall()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_that_sleeps_takes_no_time_of_its_own() {
        let [wall, thread] = [Clock::Wall, Clock::Thread].map(Clock::now);
        std::thread::sleep(Duration::from_millis(30));
        let waited = Clock::Wall.now() - wall;
        assert!(waited >= Duration::from_millis(30));
        if cfg!(unix) {
            assert!(Clock::Thread.now() - thread < Duration::from_millis(20));
        }
    }
}
