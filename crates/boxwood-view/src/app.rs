//! The viewer without its window: events in, frames, a title and wishes out.

mod act;
mod frame;
mod hear;
mod read;
#[cfg(test)]
mod tests;

use std::{
    collections::VecDeque,
    fmt,
    path::PathBuf,
    sync::Arc,
    time::{Duration, Instant},
};

use boxwood::{BuildOptions, Counts, Structure};
use boxwood_render::{Image, ScaleOptions, Shading};
use boxwood_scene::Camera;

use self::read::Asked;
use crate::{
    Event, ViewError, Wish,
    keys::{Key, SUN},
    pace::Pace,
    picture::{Painted, Shot, no_image},
    state::State,
    subject::{Aim, Built, Open, Subject},
    walk::Picked,
    watch::{self, Watched},
    workshop::{News, Ticket, Wake, Workshop},
};

/// What a viewer is started with.
#[derive(Clone)]
pub struct Options {
    /// The scene, as a user names it.
    pub file: String,
    /// How scenes are read; [`open`](crate::open) for example.
    pub open: Arc<Open>,
    /// From [`boxwood::STRUCTURES`].
    pub structure: Structure,
    /// How all structures are built.
    pub build: BuildOptions,
    /// The camera of this scene.
    pub aim: Aim,
    /// `sun`, or from [`boxwood_render::SHADINGS`].
    pub look: String,
    /// Whether costs are coloured by the logarithm.
    pub log: bool,
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// What an earlier viewer left behind: it stays so as far as no scene is opened.
    pub remembered: State,
    /// Where pictures are saved.
    pub folder: PathBuf,
    /// Prints a camera as arguments of the command line.
    pub camera_flags: fn(&Camera) -> String,
    /// Called, from any thread, when there is something new to draw.
    pub wake: Arc<Wake>,
    /// Asked before each frame, and twice a second between them: if true, the viewer ends as by its key.
    pub stop: fn() -> bool,
}

/// How long whoever runs a viewer may rest before the next frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// Something moves.
    None,
    /// Until an event, a wake, or so much later.
    AtMost(Duration),
}

/// A viewer.
///
/// Whoever runs it hands it every [`Event`], then calls [`App::advance`] and [`App::draw`] for each frame, fulfils
/// its [`Wish`]es, and rests as [`App::rest`] says. Nothing but [`App::draw`] takes long, and that about a thirtieth of a
/// second: files are read, trees built and pictures refined on other threads.
pub struct App {
    options: Options,
    workshop: Workshop,
    started: Instant,
    subject: Option<Arc<Subject>>,
    /// Structures around the subject, the one shown last at the end.
    built: Vec<Arc<Built>>,
    camera: Camera,
    look: &'static str,
    scale: ScaleOptions,
    /// In stops, as measured for this look.
    exposure: Option<f32>,
    shown: Shown,
    hands: Hands,
    picked: Option<Picked>,
    message: Option<Message>,
    jobs: Jobs,
    /// Of the subject.
    watched: Option<Watched>,
    /// What is to be the next subject, once it can be read.
    asked: Option<Asked>,
    /// Why the scene that was asked for last is not shown.
    failure: Option<ViewError>,
    pace: Pace,
    /// What the picture shows has changed since it was painted.
    is_stale: bool,
    /// Something on top of the picture has changed.
    is_dirty: bool,
    painted: Option<Painted>,
    /// Of the window's sides.
    painted_share: f32,
    /// When the picture is to get finer, unless something moves before.
    refine_at: Option<Instant>,
    counted: Option<(Counts, u32)>,
    first_picture: Option<Duration>,
    /// Times of the last frames, the latest last.
    times: VecDeque<Duration>,
    frame: Image,
    wishes: Vec<Wish>,
}

/// What is drawn on top of the picture.
#[derive(Clone, Copy, Debug)]
struct Shown {
    numbers: bool,
    graph: bool,
    /// The page of the cheat sheet, from 1; 0 for none.
    help: usize,
    boxes: bool,
    /// Of the boxes.
    depth: u32,
    split: bool,
}

/// What the user holds.
#[derive(Clone, Debug, Default)]
struct Hands {
    pointer: [f32; 2],
    button: Option<crate::Button>,
    shift: bool,
    /// Keys that move the camera while they are down.
    held: Vec<Key>,
}

/// A line for the user.
#[derive(Clone, Debug)]
struct Message {
    text: String,
    is_error: bool,
    /// Gone then; errors stay until a key is pressed.
    until: Option<Instant>,
}

/// Work under way.
#[derive(Debug, Default)]
struct Jobs {
    opening: Option<Ticket>,
    building: Option<Ticket>,
    refining: Option<Ticket>,
    timing: Option<Ticket>,
    /// What the first two are at.
    doing: Option<String>,
}

/// A larger picture is not made: at most so many pixels, about 8192 x 8192.
pub const MAX_PIXELS: u64 = 1 << 26;
/// A picture that stands still so long gets finer.
const STILL: Duration = Duration::from_millis(60);
/// Frames whose times are kept.
const TIMES: usize = 240;

impl App {
    /// Begins to read the scene.
    pub fn new(options: Options) -> Self {
        let known = |look: &str| Shading::named(look).map_or(SUN, |shading| shading.name);
        let mut app = Self {
            workshop: Workshop::new(Arc::clone(&options.wake)),
            started: Instant::now(),
            subject: None,
            built: Vec::new(),
            camera: Camera {
                eye: [0.0, 0.0, 1.0],
                target: [0.0; 3],
                up: [0.0, 1.0, 0.0],
                fov: 35.0,
            },
            look: known(&options.look),
            scale: ScaleOptions {
                top: None,
                log: options.log,
            },
            exposure: None,
            shown: Shown {
                numbers: true,
                graph: false,
                help: 0,
                boxes: false,
                depth: 3,
                split: false,
            },
            hands: Hands::default(),
            picked: None,
            message: None,
            jobs: Jobs::default(),
            watched: None,
            asked: None,
            failure: None,
            pace: Pace::default(),
            is_stale: false,
            is_dirty: true,
            painted: None,
            painted_share: 0.0,
            refine_at: None,
            counted: None,
            first_picture: None,
            times: VecDeque::new(),
            frame: no_image(),
            wishes: Vec::new(),
            options,
        };
        app.resize(app.options.size);
        let (file, aim) = (app.options.file.clone(), app.options.aim);
        app.open(&file, aim);
        app
    }

    /// Something happened.
    pub fn handle(&mut self, event: Event) {
        // What these two change, they say themselves.
        self.is_dirty |= !matches!(event, Event::Pointer(_) | Event::Resize(_));
        match event {
            Event::Press(key) => self.press(key),
            Event::Release(key) => self.hands.held.retain(|&held| held != key),
            Event::FocusLost => self.hands = Hands::default(),
            Event::Shift(is_down) => self.hands.shift = is_down,
            Event::ButtonDown(button) => self.hands.button = Some(button),
            Event::ButtonsUp => self.hands.button = None,
            Event::Pointer(place) => self.point(place),
            Event::Wheel(notches) => self.wheel(notches),
            Event::Resize(size) => self.resize(size),
            Event::Drop(path) => match path.to_str() {
                Some(name) => self.open(name, Aim::default()),
                None => self.fail(format!("{}: the name is not Unicode", path.display())),
            },
        }
    }

    /// `time` has passed since the last frame: what is held moves, what was made elsewhere arrives.
    pub fn advance(&mut self, time: Duration) {
        if (self.options.stop)() {
            self.wishes.push(Wish::Quit);
        }
        self.hear_all();
        self.fly(time);
        if self.jobs.opening.is_none() {
            self.look_at_files(time);
        }
        let now = Instant::now();
        if self
            .message
            .as_ref()
            .is_some_and(|m| m.until.is_some_and(|until| until <= now))
        {
            self.message = None;
            self.is_dirty = true;
        }
        if !self.is_stale && self.refine_at.is_some_and(|at| at <= now) {
            self.refine();
        }
    }

    /// How long nothing need be drawn.
    pub fn rest(&self) -> Rest {
        if self.is_stale || self.is_dirty || !self.hands.held.is_empty() {
            return Rest::None;
        }
        let now = Instant::now();
        let until = self.message.as_ref().and_then(|message| message.until);
        let waits = [until, self.refine_at].into_iter().flatten();
        let waits = waits.map(|at| at.saturating_duration_since(now));
        Rest::AtMost(waits.fold(watch::INTERVAL, Duration::min))
    }

    /// What is to be done outside since the last call.
    pub fn wishes(&mut self) -> Vec<Wish> {
        std::mem::take(&mut self.wishes)
    }

    /// For the window's frame: the scene, its structure, and how it goes.
    pub fn title(&self) -> String {
        if let Some(doing) = &self.jobs.doing {
            return format!("{doing} - boxwood");
        }
        match (&self.subject, self.built.last()) {
            (Some(subject), Some(built)) => {
                let rate = self
                    .rate()
                    .map_or(String::new(), |rate| format!(" - {rate:.0} frames/s"));
                format!(
                    "{} - {}{rate} - boxwood",
                    subject.short_name(),
                    built.structure
                )
            }
            _ => "boxwood".to_owned(),
        }
    }

    /// From the start to the first picture of the scene, once there is one.
    pub fn first_picture(&self) -> Option<Duration> {
        self.first_picture
    }

    /// True if nothing moves, nothing is being made, and the picture is as fine as it gets.
    pub fn is_settled(&self) -> bool {
        let Jobs {
            opening,
            building,
            refining,
            timing,
            ..
        } = &self.jobs;
        let is_waiting = self.is_stale || self.refine_at.is_some() || !self.hands.held.is_empty();
        !is_waiting
            && [opening, building, refining, timing]
                .iter()
                .all(|job| job.is_none())
    }

    /// The line of text at the bottom, if there is one.
    pub fn message(&self) -> Option<&str> {
        self.message.as_ref().map(|message| &*message.text)
    }

    /// Why the scene that was asked for last is not shown, if it is not.
    pub fn failure(&self) -> Option<&ViewError> {
        self.failure.as_ref()
    }

    /// What is to be remembered.
    pub fn state(&self) -> State {
        let mut state = State {
            look: Some(self.look.to_owned()),
            size: Some(self.options.size),
            log: self.scale.log,
            ..self.options.remembered.clone()
        };
        if let (Some(subject), Some(built)) = (&self.subject, self.built.last()) {
            state.file = Some(subject.name.clone());
            state.structure = Some(built.structure.to_owned());
            state.set_camera(&self.camera);
        }
        state
    }

    /// Frames per second as the last of them took.
    fn rate(&self) -> Option<f64> {
        let latest: Duration = self.times.iter().rev().take(30).sum();
        let count = self.times.len().min(30);
        (count > 4).then(|| count as f64 / latest.as_secs_f64().max(1e-9))
    }

    /// What the picture is to show; none before there is a scene.
    fn shot(&self) -> Option<Shot> {
        let beside = || {
            self.built
                .len()
                .checked_sub(2)
                .map(|i| Arc::clone(&self.built[i]))
        };
        Some(Shot {
            subject: Arc::clone(self.subject.as_ref()?),
            built: Arc::clone(self.built.last()?),
            beside: self.shown.split.then(beside).flatten(),
            camera: self.camera,
            size: self.options.size,
            look: self.look,
            scale: self.scale,
            exposure: self.exposure,
        })
    }

    /// What the picture shows has changed.
    fn changed(&mut self) {
        self.is_stale = true;
        self.jobs.refining = None;
        self.jobs.timing = None;
        self.refine_at = None;
    }

    /// The picture is of another kind, and may take another time.
    fn changed_look(&mut self) {
        self.exposure = None;
        self.pace = Pace::default();
        self.changed();
    }

    fn resize(&mut self, size: [u32; 2]) {
        // Nothing is seen of a window without pixels.
        let [width, height] = size.map(|side| side.clamp(1, boxwood_render::MAX_SIDE));
        let highest = (MAX_PIXELS / u64::from(width)) as u32;
        let size = [width, height.min(highest)];
        let is_new = size != self.options.size || self.frame.rgb.is_empty();
        if !is_new {
            return;
        }
        self.options.size = size;
        [self.frame.width, self.frame.height] = size;
        self.frame.rgb.clear();
        self.frame
            .rgb
            .resize(size[0] as usize * size[1] as usize, [0; 3]);
        self.changed();
    }

    fn say(&mut self, text: impl Into<String>) {
        self.message = Some(Message {
            text: text.into(),
            is_error: false,
            until: Some(Instant::now() + Duration::from_secs(6)),
        });
        self.is_dirty = true;
    }

    fn fail(&mut self, text: String) {
        self.wishes.push(Wish::Warn(text.clone()));
        self.message = Some(Message {
            text,
            is_error: true,
            until: None,
        });
        self.is_dirty = true;
    }

    /// Makes the picture finer, in the background.
    fn refine(&mut self) {
        self.refine_at = None;
        let Some(shot) = self.shot() else { return };
        let share = self.painted_share;
        self.jobs.refining = Some(self.workshop.start(move |desk| {
            let stop = || desk.stop();
            shot.refine(share, &stop, |painted| desk.tell(News::Painted(painted)));
            if let Some((counts, rays)) = crate::picture::tests_per_ray(&shot, &stop) {
                desk.tell(News::Counted(counts, rays));
            }
        }));
    }
}

impl fmt::Debug for App {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("App")
            .field("file", &self.options.file)
            .field("camera", &self.camera)
            .field("look", &self.look)
            .finish_non_exhaustive()
    }
}
