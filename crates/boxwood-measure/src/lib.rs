//! **How fast?** - asked fairly, so that the answer can be repeated and compared.
//!
//! * [`ray_sets`]: five kinds of rays that pictures are made of, from the scene itself.
//! * [`Contender`], [`race`]: structures, or other libraries, take turns on the same rays; medians count, and so does how far
//!   the rounds lie apart ([`Rounds`]).
//! * [`Machine`], [`Probe`], [`floor`]: what the machine is, what it can do at best by estimate, and which part of that is reached.
//! * [`Report`]: all of it as one JSON object with a version, as one HTML page ([`html::page`]), and compared with an earlier
//!   one ([`baseline::compare`]).
//!
//! The library times and looks at the machine, but prints nothing and writes no files.
//!
//! ```
//! use boxwood_measure::{Asked, Contender, Plan, race, ray_sets};
//! let mesh = boxwood_scene::open("builtin:terrain?n=2000")?.flatten()?;
//! let scene = boxwood::Scene::new(&mesh.positions, &mesh.indices)?;
//! let sets = ray_sets(&scene, None, 16)?;
//! let plan = Plan { rounds: 3, ..Plan::default() };
//! let contenders: Vec<Box<dyn Contender>> = vec![Box::new(Asked::new("mine", scene))];
//! let heats = race(&contenders, &sets, &plan, &mut |_| std::ops::ControlFlow::Continue(()))?;
//! assert!(heats.iter().all(|heat| heat.mrays(0) > 0.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod asked;
mod builds;
mod clock;
mod contender;
mod error;
mod machine;
mod probe;
mod race;
mod rays;
mod report;
mod rounds;
mod statistics;
mod summary;
mod yardstick;

pub mod agree;
pub mod baseline;
pub mod floor;
pub mod html;
pub mod plot;

pub use asked::Asked;
pub use builds::{BuildTimes, Built, Entry, build_all};
pub use clock::Clock;
pub use contender::{Contender, Mode, with_threads};
pub use error::MeasureError;
pub use machine::{Machine, short_size};
pub use probe::{Peak, Probe};
pub use race::{Heat, Lane, Plan, Step, race};
pub use rays::{Question, RaySet, outside, ray_sets, sample};
pub use report::{Cell, Report, Row, SCHEMA, SceneInfo, rows, rows_while};
pub use rounds::{Rounds, Task, interleaved};
pub use statistics::{geometric_mean, median, spread};
