//! The race: every contender, every set of rays, every way to ask.

use crate::{
    clock::Clock,
    contender::{Contender, Mode, new_pool},
    error::MeasureError,
    rays::{Question, RaySet, sample},
    rounds::{Rounds, Task},
    yardstick::Yardstick,
};
use boxwood::Ray;
use rayon::ThreadPool;
use std::{ops::ControlFlow, time::Duration};

/// How to race.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Turns of each contender. More: less noise.
    pub rounds: usize,
    /// Besides one thread, so many; 1 for no more than that.
    pub threads: usize,
    /// A turn may take about so long: who is slower gets a sample of the rays.
    pub turn: Duration,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            rounds: 9,
            threads: 1,
            turn: Duration::from_millis(30),
        }
    }
}

/// One contender asked in one way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lane {
    /// Its place in the list.
    pub contender: usize,
    /// How it is asked.
    pub mode: Mode,
    /// Rays of a turn; fewer than there are if it is slow.
    pub rays: usize,
}

/// All lanes on the same rays: those that took turns, so that their ratios hold.
#[derive(Clone, Debug)]
pub struct Heat {
    /// The set's place in the list.
    pub set: usize,
    /// Threads.
    pub threads: usize,
    /// Who ran.
    pub lanes: Vec<Lane>,
    /// What they took, in the order of `lanes`; behind them the yardstick.
    pub rounds: Rounds,
}

impl Heat {
    /// Million rays per second in `lane`.
    pub fn mrays(&self, lane: usize) -> f64 {
        self.lanes[lane].rays as f64 / self.rounds.median(lane) / 1e6
    }

    /// How many times as fast as lane `b` lane `a` is: the median of the rounds.
    pub fn speed_against(&self, a: usize, b: usize) -> f64 {
        let rays = self.lanes[a].rays as f64 / self.lanes[b].rays as f64;
        self.rounds.ratio(b, a) * rays
    }

    /// Seconds of the fixed piece of work that took its turn too, and how far its rounds lie apart.
    pub fn yardstick(&self) -> (f64, f64) {
        let task = self.lanes.len();
        (self.rounds.median(task), self.rounds.noise(task))
    }

    /// The lane of a contender.
    pub fn lane(&self, contender: usize, mode: Mode) -> Option<usize> {
        let is_it = |lane: &Lane| lane.contender == contender && lane.mode == mode;
        self.lanes.iter().position(is_it)
    }
}

/// How far a race has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step<'a> {
    /// Heats that are done.
    pub done: usize,
    /// Heats in all.
    pub of: usize,
    /// The set at work.
    pub set: &'a str,
    /// The threads at work.
    pub threads: usize,
}

/// Races. `watch` is told of the heat at work before every turn and may end the race there; the heats so far, and the rounds of
/// the last one that are whole, are the answer then. Each contender warms up before the first round. One thread is timed while it has a processor, several are timed by
/// the clock on the wall.
///
/// # Errors
/// If the system does not grant `plan.threads` threads.
pub fn race(
    contenders: &[Box<dyn Contender>],
    sets: &[RaySet],
    plan: &Plan,
    watch: &mut dyn FnMut(Step<'_>) -> ControlFlow<()>,
) -> Result<Vec<Heat>, MeasureError> {
    let mut threads = vec![1];
    threads.extend((plan.threads > 1).then_some(plan.threads));
    let of = threads.len() * sets.len();
    let mut heats = Vec::new();
    for &threads in &threads {
        let pool = (threads > 1).then(|| new_pool(threads)).transpose()?;
        for (number, set) in sets.iter().enumerate() {
            let step = Step {
                done: heats.len(),
                of,
                set: set.name,
                threads,
            };
            if watch(step).is_break() {
                return Ok(heats);
            }
            let heat = heat(contenders, set, plan, pool.as_ref(), &mut || watch(step));
            let Some((lanes, rounds)) = heat else {
                return Ok(heats);
            };
            heats.push(Heat {
                set: number,
                threads,
                lanes,
                rounds,
            });
        }
    }
    Ok(heats)
}

/// One set by all lanes, in turn; none if it was ended before a round was whole.
fn heat(
    contenders: &[Box<dyn Contender>],
    set: &RaySet,
    plan: &Plan,
    pool: Option<&ThreadPool>,
    go_on: &mut dyn FnMut() -> ControlFlow<()>,
) -> Option<(Vec<Lane>, Rounds)> {
    let mut lanes = Vec::new();
    let mut runners = Vec::new();
    for (contender, who) in contenders.iter().enumerate() {
        for mode in Mode::ALL.into_iter().filter(|mode| who.has(*mode)) {
            let rays = within(&**who, mode, set, plan.turn, pool, go_on)?;
            lanes.push(Lane {
                contender,
                mode,
                rays: rays.len(),
            });
            runners.push(Runner::new(&**who, mode, set.question, rays, pool));
        }
    }
    let yardstick = Yardstick::new();
    let mut tasks: Vec<Task<'_>> = Vec::new();
    for runner in &mut runners {
        if go_on().is_break() {
            return None;
        }
        // The pilot was too short to warm the caches for a whole turn.
        runner.run();
        tasks.push(Box::new(move |_| runner.run()));
    }
    // On all threads it takes as long as on the one that is disturbed the most.
    tasks.push(Box::new(|_| match pool {
        None => yardstick.walk(),
        Some(pool) => drop(pool.broadcast(|_| yardstick.walk())),
    }));
    let rounds = Rounds::run(clock(pool), plan.rounds, &mut tasks, go_on);
    drop(tasks);
    (!rounds.is_empty()).then_some((lanes, rounds))
}

/// A thread alone has a clock of its own.
fn clock(pool: Option<&ThreadPool>) -> Clock {
    if pool.is_some() {
        Clock::Wall
    } else {
        Clock::Thread
    }
}

/// A set of so few rays is asked whole, unless that takes several turns' time.
const FEW: usize = 4096;
/// So many.
const SEVERAL: f64 = 4.0;

/// As many of the rays as fit a turn; none if it was ended.
fn within(
    who: &dyn Contender,
    mode: Mode,
    set: &RaySet,
    turn: Duration,
    pool: Option<&ThreadPool>,
    go_on: &mut dyn FnMut() -> ControlFlow<()>,
) -> Option<Vec<Ray>> {
    let clock = clock(pool);
    let mut count = 64;
    while go_on().is_continue() {
        let mut runner = Runner::new(who, mode, set.question, sample(&set.rays, count), pool);
        let start = clock.now();
        runner.run();
        let time = (clock.now() - start).max(Duration::from_nanos(100));
        let asked = runner.rays.len();
        // Short trials are dominated by cold caches: they only say that more can be tried.
        if time * 8 >= turn || asked == set.rays.len() {
            let fitting = asked as f64 * turn.as_secs_f64() / time.as_secs_f64();
            if set.rays.len() <= FEW && set.rays.len() as f64 <= fitting * SEVERAL {
                return Some(set.rays.clone());
            }
            return Some(sample(&set.rays, (fitting as usize).max(64)));
        }
        count *= 4;
    }
    None
}

/// A lane with its answers.
struct Runner<'a> {
    who: &'a dyn Contender,
    mode: Mode,
    question: Question,
    rays: Vec<Ray>,
    hits: Vec<Option<boxwood::Hit>>,
    occluded: Vec<bool>,
    /// Where all threads are; none: this thread alone.
    pool: Option<&'a ThreadPool>,
}

impl<'a> Runner<'a> {
    fn new(
        who: &'a dyn Contender,
        mode: Mode,
        question: Question,
        rays: Vec<Ray>,
        pool: Option<&'a ThreadPool>,
    ) -> Self {
        let (hits, occluded) = match question {
            Question::Closest => (vec![None; rays.len()], Vec::new()),
            Question::Occluded => (Vec::new(), vec![false; rays.len()]),
        };
        Self {
            who,
            mode,
            question,
            rays,
            hits,
            occluded,
            pool,
        }
    }

    fn run(&mut self) {
        let (who, mode, rays) = (self.who, self.mode, &self.rays);
        let (hits, occluded) = (&mut self.hits, &mut self.occluded);
        match (self.question, self.pool) {
            (Question::Closest, None) => who.closest_hits(mode, rays, hits),
            (Question::Closest, Some(pool)) => {
                pool.install(|| who.closest_hits_on_all(mode, rays, hits));
            }
            (Question::Occluded, None) => who.occluded(mode, rays, occluded),
            (Question::Occluded, Some(pool)) => {
                pool.install(|| who.occluded_on_all(mode, rays, occluded));
            }
        }
        std::hint::black_box((&*hits, &*occluded));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use boxwood::Hit;

    /// Takes its time, and counts the rays that it was asked about.
    struct Slow(Duration);

    impl Contender for Slow {
        fn name(&self) -> &str {
            "slow"
        }

        fn has(&self, mode: Mode) -> bool {
            mode == Mode::Single
        }

        fn closest_hits(&self, _: Mode, rays: &[Ray], _: &mut [Option<Hit>]) {
            let start = Clock::Thread.now();
            while Clock::Thread.now() - start < self.0 * rays.len() as u32 {
                std::hint::spin_loop();
            }
        }

        fn occluded(&self, _: Mode, _: &[Ray], _: &mut [bool]) {}
    }

    fn set(count: usize) -> RaySet {
        RaySet {
            name: "random",
            question: Question::Closest,
            coherent: false,
            rays: vec![Ray::new([0.0; 3], [1.0; 3]); count],
        }
    }

    fn slow(nanos: &[u64]) -> Vec<Box<dyn Contender>> {
        let one = |nanos: &u64| Box::new(Slow(Duration::from_nanos(*nanos))) as Box<dyn Contender>;
        nanos.iter().map(one).collect()
    }

    #[test]
    fn who_is_slow_gets_fewer_rays() {
        let plan = Plan {
            turn: Duration::from_millis(4),
            ..Plan::default()
        };
        let mut watch = |_: Step<'_>| ControlFlow::Continue(());
        let heats = race(&slow(&[200, 20_000]), &[set(6400)], &plan, &mut watch).unwrap();
        let heat = &heats[0];
        assert_eq!(heat.lanes.len(), 2, "single only");
        assert_eq!(heat.lanes[0].rays, 6400);
        assert!(heat.lanes[1].rays <= 256, "{:?}", heat.lanes);
        assert!(heat.mrays(0) > 0.0 && heat.yardstick().0 > 0.0);
    }

    #[test]
    fn a_set_of_few_rays_is_asked_whole() {
        let plan = Plan {
            turn: Duration::from_millis(4),
            rounds: 1,
            threads: 1,
        };
        let mut watch = |_: Step<'_>| ControlFlow::Continue(());
        let heats = race(&slow(&[20_000, 200_000]), &[set(512)], &plan, &mut watch).unwrap();
        let [whole, sample] = [0, 1].map(|lane: usize| heats[0].lanes[lane].rays);
        assert_eq!(whole, 512, "10 of 4 ms");
        assert!(sample < 512, "{sample}");
    }

    #[test]
    fn speeds_are_of_rays_and_not_of_turns() {
        let lane = |contender, rays| Lane {
            contender,
            mode: Mode::Single,
            rays,
        };
        let heat = Heat {
            set: 0,
            threads: 1,
            lanes: vec![lane(0, 8000), lane(1, 1000)],
            rounds: Rounds::of(vec![vec![2e-3; 3], vec![1e-3; 3], vec![5e-4; 3]]),
        };
        assert_eq!((heat.mrays(0), heat.mrays(1)), (4.0, 1.0));
        assert_eq!(
            (heat.speed_against(0, 1), heat.yardstick()),
            (4.0, (5e-4, 0.0))
        );
        assert_eq!(heat.lane(1, Mode::Single), Some(1));
        assert_eq!(heat.lane(1, Mode::Batch), None);
    }

    #[test]
    fn a_race_ends_at_the_next_turn_wherever_it_is() {
        let plan = Plan {
            turn: Duration::from_micros(100),
            rounds: 3,
            threads: 1,
        };
        let turns_after = |end: usize| {
            let mut asked = 0;
            let mut watch = |_: Step<'_>| {
                asked += 1;
                match asked {
                    turn if turn < end => ControlFlow::Continue(()),
                    _ => ControlFlow::Break(()),
                }
            };
            let heats = race(&slow(&[1, 1]), &[set(64)], &plan, &mut watch).unwrap();
            (asked, heats.len())
        };
        // The beginning, two pilots, two turns to warm up, then rounds of two contenders and the yardstick.
        for end in 1..=8 {
            assert_eq!(turns_after(end), (end, 0));
        }
        assert_eq!(turns_after(9), (9, 1));
    }

    #[test]
    fn a_race_that_is_ended_keeps_what_it_has() {
        let plan = Plan {
            turn: Duration::from_millis(1),
            rounds: 1,
            threads: 2,
        };
        let mut watch = |step: Step<'_>| match step.done {
            0..2 => ControlFlow::Continue(()),
            _ => ControlFlow::Break(()),
        };
        let heats = race(&slow(&[100]), &[set(640), set(640)], &plan, &mut watch).unwrap();
        assert_eq!(heats.len(), 2);
        assert!(heats.iter().all(|heat| heat.threads == 1));
    }
}
