//! Taking turns: in every round each task runs once, so that a machine that slows down does so for all.

use crate::{
    clock::Clock,
    statistics::{median, spread},
};
use std::{ops::ControlFlow, time::Duration};

/// A piece of work, told the number of the round.
pub type Task<'a> = Box<dyn FnMut(usize) + 'a>;

/// What the rounds took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rounds {
    /// Seconds of each task in each round: `times[task][round]`. All tasks have the same number of rounds.
    times: Vec<Vec<f64>>,
}

impl Rounds {
    /// Runs `rounds` rounds, at least one, timed by `clock`, each beginning with another task. `go_on` is asked before every task
    /// and may end it: a round that is not whole does not count, so that there may be none.
    pub fn run(
        clock: Clock,
        rounds: usize,
        tasks: &mut [Task<'_>],
        go_on: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Self {
        let mut times = vec![Vec::with_capacity(rounds); tasks.len()];
        'rounds: for round in 0..rounds.max(1) {
            // Whoever follows a neighbour that empties the caches does not always follow it first.
            for turn in 0..tasks.len() {
                if go_on().is_break() {
                    times.iter_mut().for_each(|times| times.truncate(round));
                    break 'rounds;
                }
                let task = (turn + round) % tasks.len();
                let start = clock.now();
                tasks[task](round);
                times[task].push((clock.now() - start).as_secs_f64());
            }
        }
        Self { times }
    }

    /// Whether not even one round was whole.
    pub fn is_empty(&self) -> bool {
        self.times.first().is_none_or(Vec::is_empty)
    }

    /// From seconds, `times[task][round]`.
    pub fn of(times: Vec<Vec<f64>>) -> Self {
        Self { times }
    }

    /// The median of `task` in seconds.
    pub fn median(&self, task: usize) -> f64 {
        median(&self.times[task])
    }

    /// How many times as long `a` takes as `b`: the median of the rounds' ratios, which a slow round does not move.
    pub fn ratio(&self, a: usize, b: usize) -> f64 {
        let pairs = self.times[a].iter().zip(&self.times[b]);
        median(&pairs.map(|(a, b)| a / b).collect::<Vec<_>>())
    }

    /// How far the rounds of `task` lie apart, as a part of its time; what slows all tasks of a round is no noise.
    pub fn noise(&self, task: usize) -> f64 {
        let own: Vec<f64> = (self.times[task].iter().enumerate())
            .map(|(round, time)| time / self.pace(round))
            .collect();
        spread(&own)
    }

    /// How slow a round was, 1 as a rule: the median of all tasks' times over their own medians. With few tasks always 1, as it
    /// would hide what it is to show.
    fn pace(&self, round: usize) -> f64 {
        if self.times.len() < 3 {
            return 1.0;
        }
        let of = |times: &Vec<f64>| times[round] / median(times).max(f64::MIN_POSITIVE);
        median(&self.times.iter().map(of).collect::<Vec<_>>()).max(f64::MIN_POSITIVE)
    }
}

/// How long each task takes by `clock`: the median over `rounds`. Turns shorter than a time slice of the system, some
/// milliseconds, are the steadiest.
pub fn interleaved(clock: Clock, rounds: usize, tasks: &mut [Task<'_>]) -> Vec<Duration> {
    let rounds = Rounds::run(clock, rounds, tasks, &mut || ControlFlow::Continue(()));
    (0..tasks.len())
        .map(|task| Duration::from_secs_f64(rounds.median(task)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    #[test]
    fn tasks_take_turns_and_each_begins_once() {
        let order = RefCell::new(String::new());
        let note = |name: char, round| order.borrow_mut().push_str(&format!("{name}{round} "));
        let mut tasks: [Task<'_>; 2] = [
            Box::new(|round| note('a', round)),
            Box::new(|round| note('b', round)),
        ];
        assert_eq!(interleaved(Clock::Wall, 3, &mut tasks).len(), 2);
        drop(tasks);
        assert_eq!(order.into_inner(), "a0 b0 b1 a1 a2 b2 ");
    }

    #[test]
    fn a_round_that_is_not_whole_does_not_count() {
        let whole_rounds = |turns: usize| {
            let mut left = turns;
            let mut go_on = || match left.checked_sub(1) {
                None => ControlFlow::Break(()),
                Some(fewer) => {
                    left = fewer;
                    ControlFlow::Continue(())
                }
            };
            let mut tasks: [Task<'_>; 2] = [Box::new(|_| ()), Box::new(|_| ())];
            let rounds = Rounds::run(Clock::Thread, 9, &mut tasks, &mut go_on);
            assert_eq!(rounds.is_empty(), turns < 2);
            [rounds.times[0].len(), rounds.times[1].len()]
        };
        assert_eq!(
            [0, 1, 2, 5].map(whole_rounds),
            [[0, 0], [0, 0], [1, 1], [2, 2]]
        );
    }

    #[test]
    fn a_round_that_is_slow_for_all_is_neither_ratio_nor_noise() {
        let slow = |x: f64| vec![x, x, 3.0 * x, x, x];
        let rounds = Rounds::of(vec![slow(1.0), slow(2.0), slow(5.0)]);
        assert_eq!((rounds.ratio(1, 0), rounds.ratio(0, 2)), (2.0, 0.2));
        assert_eq!(rounds.noise(0), 0.0);
        let uneven = Rounds::of(vec![slow(1.0), vec![2.0, 2.4, 6.6, 2.2, 1.8], slow(5.0)]);
        assert!(uneven.noise(1) > 0.05, "{}", uneven.noise(1));
    }
}
