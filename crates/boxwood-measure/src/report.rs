//! A race as data: for programs, for the HTML page, for comparing with another day.

use crate::{
    agree::Agreement,
    builds::BuildTimes,
    contender::{Contender, Mode},
    floor::{How, Work, floor},
    machine::Machine,
    probe::Probe,
    race::Heat,
    rays::{RaySet, sample},
    statistics::{median, spread},
};
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, ops::ControlFlow, time::SystemTime};

/// Version of [`Report`]. New fields may come within a version; one that goes or changes its meaning makes a new one.
pub const SCHEMA: u32 = 1;

/// All that was measured in one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: u32,
    /// When, in UTC, as in `2026-01-31T12:00:00Z`.
    pub date: String,
    /// How it was asked for.
    pub command_line: String,
    /// On what.
    pub machine: Machine,
    /// What that can do.
    pub probe: Probe,
    /// Of what.
    pub scene: SceneInfo,
    /// Turns of each contender.
    pub rounds: usize,
    /// The larger number of threads; 1 if there is no other.
    pub threads: usize,
    /// False if it was interrupted: then cells are missing.
    pub complete: bool,
    /// Nanoseconds of a fixed piece of work on one thread, timed throughout: how fast the machine was at that time.
    pub yardstick_ns: f64,
    /// How much it varied, as a part of that.
    pub yardstick_noise: f64,
    /// The contenders.
    pub rows: Vec<Row>,
}

/// The scene and the rays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneInfo {
    /// As the user named it.
    pub name: String,
    /// All instances multiplied out.
    pub triangles: usize,
    /// Rays of each set.
    pub rays_per_set: usize,
    /// The sets.
    pub sets: Vec<String>,
}

/// One contender.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "RowWithRates")]
pub struct Row {
    /// Its name.
    pub name: String,
    /// Milliseconds on one thread.
    pub build_ms: f64,
    /// How far the builds lay apart, as a part of that.
    pub build_noise: f64,
    /// Milliseconds on all threads.
    pub build_ms_all: Option<f64>,
    /// Memory of the structure.
    pub bytes: Option<u64>,
    /// The same, per triangle.
    pub bytes_per_triangle: Option<f64>,
    /// Whether its answers are right.
    pub agreement: Option<Agreement>,
    /// Its rates.
    pub cells: Vec<Cell>,
}

/// One rate: a set, asked in one way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Name of the set.
    pub set: String,
    /// How it was asked.
    pub mode: Mode,
    /// On so many threads.
    pub threads: usize,
    /// Rays of a turn; fewer than the set has: an estimate.
    pub rays: usize,
    /// Million rays per second.
    pub mrays: f64,
    /// How far the rounds lay apart, as a part of the time.
    pub noise: f64,
    /// Nanoseconds of the fixed piece of work that took its turns between these, on as many threads.
    pub yardstick_ns: f64,
    /// How far its rounds lay apart, as a part of that.
    pub yardstick_noise: f64,
    /// What a ray costs on average.
    pub work: Option<Work>,
    /// Nanoseconds per ray on one thread that this machine needs for that work at least, by the estimate of [`floor`](mod@crate::floor).
    pub floor_ns: Option<f64>,
    /// That by the nanoseconds that were needed: 1 is the estimated limit, and above that the estimate is too high.
    pub of_floor: Option<f64>,
}

impl Cell {
    /// `primary, batch, 2 threads`.
    pub fn label(&self) -> String {
        let threads = if self.threads == 1 {
            "1 thread".to_owned()
        } else {
            format!("{} threads", self.threads)
        };
        format!("{}, {}, {threads}", self.set, self.mode.name())
    }
}

/// As it is written: with the rates once more, by the name of the set.
#[derive(Serialize)]
struct RowWithRates {
    name: String,
    build_ms: f64,
    build_noise: f64,
    build_ms_all: Option<f64>,
    bytes: Option<u64>,
    bytes_per_triangle: Option<f64>,
    agreement: Option<Agreement>,
    single: BTreeMap<String, f64>,
    batch: BTreeMap<String, f64>,
    single_all: BTreeMap<String, f64>,
    batch_all: BTreeMap<String, f64>,
    cells: Vec<Cell>,
}

impl From<Row> for RowWithRates {
    fn from(row: Row) -> Self {
        Self {
            single: row.rates(Mode::Single, true),
            batch: row.rates(Mode::Batch, true),
            single_all: row.rates(Mode::Single, false),
            batch_all: row.rates(Mode::Batch, false),
            name: row.name,
            build_ms: row.build_ms,
            build_noise: row.build_noise,
            build_ms_all: row.build_ms_all,
            bytes: row.bytes,
            bytes_per_triangle: row.bytes_per_triangle,
            agreement: row.agreement,
            cells: row.cells,
        }
    }
}

impl Row {
    /// Million rays per second by set, on one thread or on all.
    pub fn rates(&self, mode: Mode, one_thread: bool) -> BTreeMap<String, f64> {
        let wanted = |cell: &&Cell| cell.mode == mode && (cell.threads == 1) == one_thread;
        let rates = self.cells.iter().filter(wanted);
        rates.map(|cell| (cell.set.clone(), cell.mrays)).collect()
    }

    /// The cell of a set.
    pub fn cell(&self, set: &str, mode: Mode, threads: usize) -> Option<&Cell> {
        let is_it = |cell: &&Cell| cell.set == set && cell.mode == mode && cell.threads == threads;
        self.cells.iter().find(is_it)
    }
}

impl Report {
    /// With all but the rows' agreement filled in.
    pub fn new(
        scene: SceneInfo,
        probe: Probe,
        machine: Machine,
        heats: &[Heat],
        rows: Vec<Row>,
    ) -> Self {
        let yardsticks: Vec<f64> = heats
            .iter()
            .filter(|heat| heat.threads == 1)
            .map(|heat| heat.yardstick().0 * 1e9)
            .collect();
        let threads = heats.iter().map(|heat| heat.threads).max().unwrap_or(1);
        Self {
            schema: SCHEMA,
            date: today(),
            command_line: String::new(),
            machine,
            probe,
            scene,
            rounds: 0,
            threads,
            complete: true,
            yardstick_ns: median(&yardsticks),
            yardstick_noise: spread(&yardsticks),
            rows,
        }
    }
}

/// Now, in UTC, to the second.
fn today() -> String {
    humantime::format_rfc3339_seconds(SystemTime::now()).to_string()
}

/// Rays that are counted for the floor.
const COUNTED: usize = 1 << 13;

/// The contenders' rows, from what was built and raced; `builds` and `contenders` go together.
pub fn rows(
    contenders: &[Box<dyn Contender>],
    builds: &[BuildTimes],
    sets: &[RaySet],
    heats: &[Heat],
    probe: &Probe,
    triangles: usize,
) -> Vec<Row> {
    let go_on = || ControlFlow::Continue(());
    rows_while(contenders, builds, sets, heats, probe, triangles, &go_on)
}

/// [`rows`], of which those that come after `go_on` has ended it have rates alone: no work was counted for them.
pub fn rows_while(
    contenders: &[Box<dyn Contender>],
    builds: &[BuildTimes],
    sets: &[RaySet],
    heats: &[Heat],
    probe: &Probe,
    triangles: usize,
    go_on: &dyn Fn() -> ControlFlow<()>,
) -> Vec<Row> {
    let row = |(number, build): (usize, &BuildTimes)| {
        let who = &contenders[number];
        let work: Vec<Option<Work>> = sets
            .iter()
            .map(|set| {
                // Nothing was measured that it would explain.
                let heat = heats.iter().find(|heat| sets[heat.set].name == set.name)?;
                if go_on().is_break() {
                    return None;
                }
                // Whoever is slow to answer is slow to count.
                let lane = |mode| Some(heat.lanes[heat.lane(number, mode)?].rays);
                let rays = lane(Mode::Single).or(lane(Mode::Batch))?.min(COUNTED);
                who.work(set.question, &sample(&set.rays, rays))
            })
            .collect();
        let structure = build.bytes.unwrap_or(0);
        let cells = heats
            .iter()
            .flat_map(|heat| cells(number, heat, sets, &work, structure, probe));
        Row {
            name: who.name().to_owned(),
            build_ms: build.one_thread,
            build_noise: build.noise,
            build_ms_all: build.all_threads,
            bytes: build.bytes,
            bytes_per_triangle: build
                .bytes
                .map(|bytes| bytes as f64 / triangles.max(1) as f64),
            agreement: None,
            cells: cells.collect(),
        }
    };
    builds.iter().enumerate().map(row).collect()
}

/// A contender's cells of one heat.
fn cells(
    contender: usize,
    heat: &Heat,
    sets: &[RaySet],
    work: &[Option<Work>],
    structure: u64,
    probe: &Probe,
) -> Vec<Cell> {
    let (yardstick, yardstick_noise) = heat.yardstick();
    let cell = |mode| {
        let lane = heat.lane(contender, mode)?;
        let (set, work) = (&sets[heat.set], work[heat.set]);
        let how = How {
            mode,
            coherent: set.coherent,
        };
        let mrays = heat.mrays(lane);
        let floor_ns = work.map(|work| floor(&work, structure, how, probe));
        Some(Cell {
            set: set.name.to_owned(),
            mode,
            threads: heat.threads,
            rays: heat.lanes[lane].rays,
            mrays,
            noise: heat.rounds.noise(lane),
            yardstick_ns: yardstick * 1e9,
            yardstick_noise,
            work,
            floor_ns,
            // At best, each thread is as fast as one alone.
            of_floor: floor_ns.map(|floor| floor * mrays * 1e-3 / heat.threads as f64),
        })
    };
    Mode::ALL.into_iter().filter_map(cell).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::{race::Lane, rays::Question, rounds::Rounds};
    use boxwood::{Hit, Ray};
    use std::sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    };

    /// A report of two contenders and two sets, `factor` times as fast as usual.
    pub(crate) fn report(factor: f64) -> Report {
        let cell = |set: &str, mode, mrays: f64| Cell {
            set: set.to_owned(),
            mode,
            threads: 1,
            rays: 4096,
            mrays: mrays * factor,
            noise: 0.01,
            yardstick_ns: 400_000.0,
            yardstick_noise: 0.0,
            work: None,
            floor_ns: Some(100.0),
            of_floor: Some(0.125 * mrays * factor),
        };
        let row = |name: &str, speed: f64| Row {
            name: name.to_owned(),
            build_ms: 20.0,
            build_noise: 0.01,
            build_ms_all: None,
            bytes: Some(5000),
            bytes_per_triangle: Some(50.0),
            agreement: None,
            cells: vec![
                cell("primary", Mode::Single, 3.0 * speed),
                cell("primary", Mode::Batch, 4.0 * speed),
                cell("random", Mode::Single, 1.5 * speed),
            ],
        };
        let scene = SceneInfo {
            name: "builtin:<soup>".to_owned(),
            triangles: 100,
            rays_per_set: 4096,
            sets: vec!["primary".to_owned(), "random".to_owned()],
        };
        let probe = Probe {
            cycle_ns: 0.3,
            l1_ns: 1.0,
            l2_ns: 4.0,
            l3_ns: 15.0,
            dram_ns: 100.0,
            dram_parallel_ns: 12.0,
            gflops: 40.0,
            l2_bytes: 1 << 20,
            l3_bytes: 1 << 23,
            vector_bits: 256,
        };
        let rows = vec![row("bvh2", 1.0), row("grid & co", 0.25)];
        let mut report = Report::new(scene, probe, Machine::seen(), &[], rows);
        report.yardstick_ns = 400_000.0;
        report
    }

    #[test]
    fn a_report_is_the_same_after_writing_and_reading() {
        let report = report(1.0);
        let text = serde_json::to_string(&report).unwrap();
        assert_eq!(serde_json::from_str::<Report>(&text).unwrap(), report);
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(value["schema"], SCHEMA);
        assert_eq!(value["rows"][0]["single"]["random"], 1.5);
        assert_eq!(value["rows"][0]["batch"]["primary"], 4.0);
    }

    /// Says how many rays it was asked to count.
    #[derive(Clone, Default)]
    struct Counting(Arc<AtomicUsize>);

    impl Contender for Counting {
        fn name(&self) -> &str {
            "counting"
        }

        fn has(&self, _: Mode) -> bool {
            true
        }

        fn closest_hits(&self, _: Mode, _: &[Ray], _: &mut [Option<Hit>]) {}

        fn occluded(&self, _: Mode, _: &[Ray], _: &mut [bool]) {}

        fn work(&self, _: Question, rays: &[Ray]) -> Option<Work> {
            self.0.fetch_add(rays.len(), Ordering::Relaxed);
            Some(Work::default())
        }
    }

    #[test]
    fn no_work_is_counted_of_what_was_not_raced_or_after_the_end() {
        let set = |name| RaySet {
            name,
            question: Question::Closest,
            coherent: false,
            rays: vec![Ray::new([0.0; 3], [1.0; 3]); 6400],
        };
        let sets = ["raced", "not raced"].map(set);
        let heat = Heat {
            set: 0,
            threads: 1,
            lanes: vec![Lane {
                contender: 0,
                mode: Mode::Single,
                rays: 128,
            }],
            rounds: Rounds::of(vec![vec![1e-3], vec![1e-3]]),
        };
        let counted = |heats: &[Heat], flow: ControlFlow<()>| {
            let counting = Counting::default();
            let contenders: [Box<dyn Contender>; 1] = [Box::new(counting.clone())];
            let probe = report(1.0).probe;
            let builds = [BuildTimes::default()];
            let go_on = || flow;
            rows_while(&contenders, &builds, &sets, heats, &probe, 100, &go_on);
            counting.0.load(Ordering::Relaxed)
        };
        let heats = [heat];
        assert_eq!(counted(&[], ControlFlow::Continue(())), 0);
        assert_eq!(counted(&heats, ControlFlow::Continue(())), 128);
        assert_eq!(counted(&heats, ControlFlow::Break(())), 0);
    }

    #[test]
    fn the_date_is_a_date() {
        let date = today();
        assert!(
            date.len() == 20 && date.starts_with("20") && date.ends_with('Z'),
            "{date}"
        );
    }
}
