//! Clocks: the one on the wall, and the processor's for one thread or for the whole program.

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
    /// As long as any thread of the program has a processor, each counted: for work that one thread does, whichever.
    Program,
}

impl Clock {
    /// For work on so many threads, which may be started by another: what it takes of the processor, if it is one, so that a
    /// busy machine does not show.
    pub fn of_work_on(threads: usize) -> Self {
        if threads == 1 {
            Self::Program
        } else {
            Self::Wall
        }
    }

    /// Since some moment; only differences on the same thread mean anything.
    pub fn now(self) -> Duration {
        match self {
            Self::Wall => wall(),
            Self::Thread => processor(false),
            Self::Program => processor(true),
        }
    }
}

fn wall() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}

#[cfg(unix)]
fn processor(of_program: bool) -> Duration {
    use rustix::time::{ClockId, clock_gettime};
    let time = clock_gettime(if of_program {
        ClockId::ProcessCPUTime
    } else {
        ClockId::ThreadCPUTime
    });
    // Neither is ever negative.
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

#[cfg(not(unix))]
fn processor(_: bool) -> Duration {
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
