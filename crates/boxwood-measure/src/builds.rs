//! Building, in turns as well.

use crate::{
    contender::Contender,
    error::MeasureError,
    statistics::{median, spread},
};
use std::{ops::ControlFlow, time::Duration};

/// Who is to be built.
pub struct Entry<'a> {
    /// For tables.
    pub name: String,
    /// Builds with so many threads.
    pub build: Box<dyn Fn(usize) -> Result<Built, MeasureError> + 'a>,
}

/// What building gave.
pub struct Built {
    /// Ready to be asked.
    pub contender: Box<dyn Contender>,
    /// From indexed triangles to the first ray, by [`Clock::of_work_on`](crate::Clock::of_work_on) the threads.
    pub time: Duration,
    /// Memory of the structure, if it is known.
    pub bytes: Option<u64>,
}

/// What building takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BuildTimes {
    /// Milliseconds on one thread, the median.
    pub one_thread: f64,
    /// How far the rounds on one thread lie apart, as a part of that.
    pub noise: f64,
    /// Milliseconds on all threads, if there are several.
    pub all_threads: Option<f64>,
    /// Memory of the structure.
    pub bytes: Option<u64>,
}

/// Builds all entries in `rounds` rounds, on one thread and, if that is more, on `threads`; keeps the last one of each on one
/// thread. `watch` is told of every build before it and may end it all; who was built by then takes part.
///
/// # Errors
/// The first of a build.
#[expect(clippy::type_complexity, reason = "two lists of the same length")]
pub fn build_all(
    entries: &[Entry<'_>],
    rounds: usize,
    threads: usize,
    watch: &mut dyn FnMut(&str) -> ControlFlow<()>,
) -> Result<(Vec<Box<dyn Contender>>, Vec<BuildTimes>), MeasureError> {
    let mut contenders: Vec<Box<dyn Contender>> = Vec::new();
    let mut bytes = Vec::new();
    let mut times = vec![[Vec::new(), Vec::new()]; entries.len()];
    'rounds: for round in 0..rounds.max(1) {
        for (number, entry) in entries.iter().enumerate() {
            if threads > 1 {
                if watch(&entry.name).is_break() {
                    break 'rounds;
                }
                times[number][1].push((entry.build)(threads)?.time.as_secs_f64() * 1e3);
            }
            if watch(&entry.name).is_break() {
                break 'rounds;
            }
            let built = (entry.build)(1)?;
            times[number][0].push(built.time.as_secs_f64() * 1e3);
            if round == 0 {
                contenders.push(built.contender);
                bytes.push(built.bytes);
            }
        }
    }
    let of = |([one, all], bytes): (&[Vec<f64>; 2], &Option<u64>)| BuildTimes {
        one_thread: median(one),
        noise: spread(one),
        all_threads: (!all.is_empty()).then(|| median(all)),
        bytes: *bytes,
    };
    let times = times.iter().zip(&bytes).map(of).collect();
    Ok((contenders, times))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::asked::Asked;
    use boxwood::Scene;

    fn entry(name: &str) -> Entry<'_> {
        let build = move |threads: usize| {
            let scene = Scene::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
            Ok(Built {
                contender: Box::new(Asked::new(name, scene)),
                time: Duration::from_millis(10 / threads as u64),
                bytes: Some(5),
            })
        };
        Entry {
            name: name.to_owned(),
            build: Box::new(build),
        }
    }

    #[test]
    fn builds_are_timed_on_one_thread_and_on_all() {
        let mut told = Vec::new();
        let mut watch = |name: &str| {
            told.push(name.to_owned());
            ControlFlow::Continue(())
        };
        let (contenders, times) = build_all(&[entry("a"), entry("b")], 2, 2, &mut watch).unwrap();
        assert_eq!(told, ["a", "a", "b", "b", "a", "a", "b", "b"]);
        assert_eq!(contenders[1].name(), "b");
        let expected = BuildTimes {
            one_thread: 10.0,
            noise: 0.0,
            all_threads: Some(5.0),
            bytes: Some(5),
        };
        assert_eq!(times, [expected; 2]);
    }

    #[test]
    fn who_was_built_when_it_ended_takes_part() {
        let mut left = 1;
        let mut watch = |_: &str| {
            left -= 1;
            if left >= 0 {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        };
        let (contenders, times) = build_all(&[entry("a"), entry("b")], 2, 1, &mut watch).unwrap();
        assert_eq!((contenders.len(), times.len()), (1, 1));
    }
}
