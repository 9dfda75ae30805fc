//! Scripted sessions: moves and keys from a file, and how many frames a second that gave.

use std::{
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use boxwood_render::{save_atomically, write_png};
use boxwood_scene::Camera;
use serde::Serialize;

use crate::{App, Event, Key, Matter, ViewError, Wish, navigate};

/// What is to be done, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Script {
    steps: Vec<Step>,
}

#[derive(Clone, Debug, PartialEq)]
enum Step {
    /// So many frames of a move.
    Frames(u32, Move),
    /// Until the picture is as fine as it gets, or for so many seconds.
    Wait(f64),
    Key(Key),
    /// Where the pointer is, in shares of the window.
    Point([f32; 2]),
    Shot(PathBuf),
}

/// As it is when all its frames are done.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Move {
    /// Degrees to the right.
    Orbit(f64),
    /// Degrees up.
    Rise(f64),
    /// Factor on the distance.
    Zoom(f64),
    /// Shares of the distance ahead.
    Fly(f64),
    /// Degrees to the right.
    Turn(f64),
    /// As it stands.
    Still,
}

/// What a script may say.
const LANGUAGE: &str = "orbit FRAMES [DEGREES], rise FRAMES DEGREES, zoom FRAMES FACTOR, fly FRAMES SHARE, \
    turn FRAMES DEGREES, still FRAMES, wait [SECONDS], key NAME, point X Y (shares of the window), shot FILE";

/// How long `wait` waits at most.
const PATIENCE: f64 = 60.0;

impl Default for Script {
    /// Once round the scene, and once more nearer.
    fn default() -> Self {
        Self {
            steps: vec![
                Step::Frames(120, Move::Orbit(360.0)),
                Step::Frames(30, Move::Zoom(0.5)),
                Step::Frames(120, Move::Orbit(-360.0)),
            ],
        }
    }
}

impl Script {
    /// Reads a script: a step per line, `#` begins a remark. `name` is for errors.
    ///
    /// # Errors
    /// For a line that says nothing of the language, with its number.
    pub fn parse(name: &str, text: &str) -> Result<Self, ViewError> {
        let mut steps = Vec::new();
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.is_empty() {
                continue;
            }
            let step = step_of(line).ok_or_else(|| {
                let cause = format!("{name}:{number}: '{line}' is no step (there are {LANGUAGE})");
                ViewError::new(Matter::Script, cause).with_remedy("correct the script")
            })?;
            steps.push(step);
        }
        Ok(Self { steps })
    }
}

fn step_of(line: &str) -> Option<Step> {
    let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let rest = rest.trim();
    let numbers: Option<Vec<f64>> = rest
        .split_whitespace()
        .map(|word| word.parse().ok())
        .collect();
    let numbers = numbers.filter(|numbers| numbers.iter().all(|x: &f64| x.is_finite()));
    let frames = |number: f64| (number >= 1.0 && number <= 1e6).then_some(number as u32);
    Some(match (word, numbers.as_deref()) {
        ("orbit", Some(&[n])) => Step::Frames(frames(n)?, Move::Orbit(360.0)),
        ("orbit", Some(&[n, degrees])) => Step::Frames(frames(n)?, Move::Orbit(degrees)),
        ("rise", Some(&[n, degrees])) => Step::Frames(frames(n)?, Move::Rise(degrees)),
        ("zoom", Some(&[n, factor])) if factor > 0.0 => {
            Step::Frames(frames(n)?, Move::Zoom(factor))
        }
        ("fly", Some(&[n, share])) => Step::Frames(frames(n)?, Move::Fly(share)),
        ("turn", Some(&[n, degrees])) => Step::Frames(frames(n)?, Move::Turn(degrees)),
        ("still", Some(&[n])) => Step::Frames(frames(n)?, Move::Still),
        ("wait", Some(&[])) => Step::Wait(PATIENCE),
        ("wait", Some(&[seconds])) if seconds >= 0.0 => Step::Wait(seconds),
        ("point", Some(&[x, y])) => Step::Point([x as f32, y as f32]),
        ("key", _) => Step::Key(Key::named(rest)?),
        ("shot", _) if !rest.is_empty() => Step::Shot(rest.into()),
        _ => return None,
    })
}

impl Move {
    /// The camera when `share` of the move is done.
    fn at(self, camera: &Camera, share: f64) -> Camera {
        match self {
            Self::Orbit(degrees) => navigate::orbit(camera, degrees * share, 0.0),
            Self::Rise(degrees) => navigate::orbit(camera, 0.0, degrees * share),
            Self::Zoom(factor) => navigate::zoom(camera, factor.powf(share)),
            Self::Turn(degrees) => navigate::turn(camera, degrees * share, 0.0),
            Self::Fly(shares) => {
                let [a, b] = [camera.eye, camera.target].map(glam::Vec3::from);
                navigate::fly(camera, f64::from(a.distance(b)) * shares * share, 0.0)
            }
            Self::Still => *camera,
        }
    }

    fn name(self) -> String {
        match self {
            Self::Orbit(degrees) => format!("orbit {degrees}"),
            Self::Rise(degrees) => format!("rise {degrees}"),
            Self::Zoom(factor) => format!("zoom {factor}"),
            Self::Turn(degrees) => format!("turn {degrees}"),
            Self::Fly(share) => format!("fly {share}"),
            Self::Still => "still".to_owned(),
        }
    }
}

/// How a script went.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// From the start of the viewer to the first picture of the scene, in milliseconds.
    pub first_picture_ms: f64,
    /// A row for each move.
    pub rows: Vec<Row>,
}

/// The frames of one move.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// As in the script.
    pub what: String,
    /// Their number.
    pub frames: usize,
    /// Of all frames together.
    pub mean_per_second: f64,
    /// At the pace of the slowest of each hundred.
    pub worst_per_second: f64,
    /// The mean share of the window's pixels that had a ray of their own, 0 to 1.
    pub pixels: f64,
}

/// A script being followed.
#[derive(Debug)]
pub(crate) struct Runner {
    script: Script,
    /// Of the next step.
    at: usize,
    /// Of the present step.
    frame: u32,
    /// When it began.
    began: Option<(Instant, Camera)>,
    times: Vec<Duration>,
    pixels: f64,
    report: Report,
}

impl Runner {
    pub(crate) fn new(script: Script) -> Self {
        Self {
            script,
            at: 0,
            frame: 0,
            began: None,
            times: Vec::new(),
            pixels: 0.0,
            report: Report::default(),
        }
    }

    /// Does what comes before the next frame; none when the script is over.
    pub(crate) fn before(&mut self, app: &mut App) -> Result<Option<()>, ViewError> {
        let Some(first) = app.first_picture() else {
            return match app.failure() {
                Some(failure) if app.is_settled() => Err(failure.clone()),
                _ => Ok(Some(())),
            };
        };
        self.report.first_picture_ms = first.as_secs_f64() * 1e3;
        loop {
            let Some(step) = self.script.steps.get(self.at) else {
                return Ok(None);
            };
            let (began, camera) = *self
                .began
                .get_or_insert_with(|| (Instant::now(), app.camera()));
            match step {
                Step::Frames(frames, path) if self.frame < *frames => {
                    self.frame += 1;
                    app.go(path.at(&camera, f64::from(self.frame) / f64::from(*frames)));
                    return Ok(Some(()));
                }
                Step::Frames(_, path) => {
                    let row = row(path.name(), &self.times, self.pixels);
                    self.report.rows.push(row);
                }
                Step::Wait(seconds) => {
                    if !app.is_settled() && began.elapsed().as_secs_f64() < *seconds {
                        return Ok(Some(()));
                    }
                }
                Step::Key(key) => {
                    app.handle(Event::Press(*key));
                    app.handle(Event::Release(*key));
                }
                Step::Point(share) => app.point_at(*share),
                Step::Shot(path) => shoot(app, path)?,
            }
            self.at += 1;
            self.frame = 0;
            self.began = None;
            self.times.clear();
            self.pixels = 0.0;
        }
    }

    /// The frame took `time`.
    pub(crate) fn after(&mut self, app: &App, time: Duration) {
        if self.frame > 0 {
            self.times.push(time);
            self.pixels += f64::from(app.share()).powi(2);
        }
    }

    /// True if the error that the script ends with says what `wish` says.
    pub(crate) fn will_say(app: &App, wish: &Wish) -> bool {
        let is_over = app.first_picture().is_none();
        let failure = app.failure().filter(|_| is_over);
        failure.is_some_and(|failure| *wish == Wish::Warn(failure.to_string()))
    }

    pub(crate) fn report(self) -> Report {
        self.report
    }
}

fn row(what: String, times: &[Duration], pixels: f64) -> Row {
    let mut sorted = times.to_vec();
    sorted.sort_unstable();
    let all: Duration = times.iter().sum();
    let worst = sorted.get(sorted.len().saturating_sub(1 + sorted.len() / 100));
    let per_second = |count: f64, time: Duration| count / time.as_secs_f64().max(1e-9);
    Row {
        what,
        frames: times.len(),
        mean_per_second: per_second(times.len() as f64, all),
        worst_per_second: worst.map_or(0.0, |&worst| per_second(1.0, worst)),
        pixels: pixels / times.len().max(1) as f64,
    }
}

fn shoot(app: &mut App, path: &Path) -> Result<(), ViewError> {
    let image = app.draw();
    save_atomically(path, |out| write_png(image, &[], out))
        .map_err(|error| ViewError::output(path, error))
}

/// Follows `script` without a window; `heed` gets the viewer's wishes. Ends early when the viewer is to quit.
///
/// # Errors
/// If the scene cannot be read, or a picture not be written.
pub fn run_headless(
    app: &mut App,
    script: Script,
    heed: &mut dyn FnMut(Wish),
) -> Result<Report, ViewError> {
    let mut runner = Runner::new(script);
    let mut last = Instant::now();
    loop {
        let start = Instant::now();
        app.advance(start - std::mem::replace(&mut last, start));
        let goes_on = runner.before(app)?;
        let wishes = app.wishes();
        let quits = wishes.contains(&Wish::Quit);
        let news = wishes.into_iter();
        news.filter(|wish| !Runner::will_say(app, wish))
            .for_each(&mut *heed);
        if goes_on.is_none() || quits {
            return Ok(runner.report());
        }
        if app.rest() == crate::Rest::None {
            app.draw();
        } else {
            // Other threads are at work.
            std::thread::sleep(Duration::from_millis(1));
        }
        runner.after(app, start.elapsed());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_of_the_language_is_read() {
        let text = "# remark\norbit 12\norbit 12 -90 # left\nrise 3 10\nzoom 4 0.5\nfly 5 0.2\nturn 6 45\nstill 7\n\
            wait\nwait 2.5\nkey F11\nkey ,\npoint 0.5 0.25\nshot a picture.png\n";
        let steps = Script::parse("path.txt", text).unwrap().steps;
        assert_eq!(steps.len(), 13);
        assert_eq!(steps[1], Step::Frames(12, Move::Orbit(-90.0)));
        assert_eq!(steps[10], Step::Key(Key::Char(',')));
        assert_eq!(steps[12], Step::Shot("a picture.png".into()));
    }

    #[test]
    fn other_lines_are_refused_with_their_numbers_and_the_language() {
        for line in [
            "orbit",
            "orbit 0",
            "zoom 3 -1",
            "key F99",
            "dance",
            "shot",
            "wait soon",
        ] {
            let message = Script::parse("path.txt", &format!("wait\n{line}"))
                .unwrap_err()
                .to_string();
            assert!(
                message.starts_with("path.txt:2: ") && message.contains("orbit FRAMES"),
                "{message}"
            );
        }
    }

    #[test]
    fn rates_are_of_the_mean_and_of_the_slowest_in_a_hundred() {
        let mut times = vec![Duration::from_millis(10); 199];
        times.push(Duration::from_millis(40));
        let one_slow = row("orbit".to_owned(), &times, 200.0);
        assert!((one_slow.mean_per_second - 200.0 / 2.03).abs() < 1e-6 && one_slow.pixels == 1.0);
        // Two of two hundred may be slow, and only one is.
        assert!((one_slow.worst_per_second - 100.0).abs() < 1e-6);
        times[0] = Duration::from_millis(50);
        times[1] = Duration::from_millis(50);
        assert!((row(String::new(), &times, 0.0).worst_per_second - 25.0).abs() < 1e-6);
    }
}
