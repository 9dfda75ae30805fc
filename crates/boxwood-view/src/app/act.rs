//! What the user's hands do.

use std::{
    path::PathBuf,
    sync::Arc,
    time::{Duration, Instant},
};

use boxwood::STRUCTURES;
use boxwood_render::{View, save_atomically, write_png};
use boxwood_scene::Camera;

use super::App;
use crate::{
    Button, Wish,
    canvas::Canvas,
    keys::{Action, Key, action_of},
    navigate, overlay,
    picture::no_image,
    subject::Built,
    walk::Picked,
    workshop::{Desk, News},
};

/// Degrees round the scene for a drag over the height of the window.
const ORBIT: f32 = 200.0;
/// Of the distance, for a notch of the wheel.
const ZOOM: f32 = 0.9;
/// Of the scene's diagonal, in a second.
const SPEED: f32 = 0.3;
/// Degrees in a second.
const TURN: f64 = 60.0;
/// Frames of a benchmark.
const FRAMES: u32 = 16;

impl App {
    pub(super) fn press(&mut self, key: Key) {
        if self
            .message
            .as_ref()
            .is_some_and(|message| message.is_error)
        {
            self.message = None;
        }
        let Some((action, place)) = action_of(key) else {
            return;
        };
        match action {
            Action::Look(looks) => self.look(looks),
            Action::Benchmark => self.benchmark(),
            Action::Brightness => self.brightness(place),
            Action::Logarithm => {
                self.scale.log = !self.scale.log;
                self.changed();
            }
            Action::Fly | Action::Turn => {
                if !self.hands.held.contains(&key) {
                    self.hands.held.push(key);
                }
            }
            Action::Structure => self.structure(place),
            Action::Split => self.split(),
            Action::Boxes => self.shown.boxes = !self.shown.boxes,
            Action::Depth => self.deepen(place),
            Action::Pick => self.pick(),
            Action::Step => self.step(place),
            Action::Camera => self
                .wishes
                .push(Wish::Print((self.options.camera_flags)(&self.camera))),
            Action::Screenshot => self.screenshot(),
            Action::Reset => self.reset(),
            Action::Numbers => self.shown.numbers = !self.shown.numbers,
            Action::Graph => self.shown.graph = !self.shown.graph,
            Action::Help => {
                let pages = overlay::pages(&Canvas::new(&mut self.frame));
                self.shown.help = (self.shown.help + 1) % (pages + 1);
            }
            Action::FullScreen => self.wishes.push(Wish::ToggleFullScreen),
            Action::Quit => self.wishes.push(Wish::Quit),
        }
    }

    /// The first of `looks`, or the one after the present one.
    fn look(&mut self, looks: &'static [&'static str]) {
        let at = looks.iter().position(|look| *look == self.look);
        let next = looks[at.map_or(0, |at| (at + 1) % looks.len())];
        self.scale.top = None;
        self.shown.split &= next.starts_with("heat");
        self.set_look(next);
    }

    fn set_look(&mut self, look: &'static str) {
        self.look = look;
        self.changed_look();
    }

    /// The heat map of all tests; if costs are shown already, darker or brighter.
    fn brightness(&mut self, place: usize) {
        if !self.look.starts_with("heat") {
            self.scale.top = None;
            self.set_look("heat-tests");
            return;
        }
        let factor = [2.0, 0.5][place];
        self.scale.top = self.scale.top.map(|top| (top * factor).max(1.0));
        self.changed();
    }

    fn benchmark(&mut self) {
        let Some(shot) = self.shot() else { return };
        self.say("benchmark ...");
        self.jobs.timing = Some(self.workshop.start(move |desk| {
            let Ok(view) = View::new(shot.camera, shot.size[0], shot.size[1]) else {
                return;
            };
            let (mut image, mut start) = (no_image(), Instant::now());
            // The first one warms up.
            for frame in 0..=FRAMES {
                if desk.stop() {
                    return;
                }
                if frame == 1 {
                    start = Instant::now();
                }
                shot.subject.frames.draw(&shot.built.scene, &view, &mut image);
            }
            let each = start.elapsed().as_secs_f64() / f64::from(FRAMES);
            let [width, height] = shot.size;
            desk.tell(News::Said(format!(
                "{FRAMES} frames of {width} x {height}, sun and shadow, in {}: {:.2} ms each, {:.1} frames per second",
                shot.built.structure,
                each * 1e3,
                1.0 / each
            )));
        }));
    }

    fn deepen(&mut self, place: usize) {
        let deepest = || {
            self.built
                .last()?
                .nodes()
                .iter()
                .map(|node| node.depth)
                .max()
        };
        self.shown.depth = match place {
            0 => self.shown.depth.saturating_sub(1),
            _ => (self.shown.depth + 1).min(deepest().unwrap_or(0)),
        };
        self.shown.boxes = true;
    }

    fn pick(&mut self) {
        if self.picked.take().is_some() {
            return;
        }
        let (Some(built), [width, height]) = (self.built.last(), self.options.size) else {
            return;
        };
        let Ok(view) = View::new(self.camera, width, height) else {
            return;
        };
        let [x, y] = self.hands.pointer.map(|place| place.max(0.0) as u32);
        let ray = view.pixel_ray(x.min(width - 1), y.min(height - 1));
        self.picked = Some(Picked::new(built, ray));
        self.say("orbit to see the ray from the side; , and . step along its walk");
    }

    fn step(&mut self, place: usize) {
        let far = if self.hands.shift { 10 } else { 1 };
        match &mut self.picked {
            Some(picked) => picked.step([-far, far][place]),
            None => self.say("p picks the ray under the pointer first"),
        }
    }

    fn reset(&mut self) {
        if let Some(subject) = &self.subject {
            self.camera = subject.camera;
            self.changed();
        }
    }

    fn screenshot(&mut self) {
        self.draw();
        match self.save_picture() {
            Ok(path) => self.say(format!("saved {}", path.display())),
            Err(error) => self.fail(format!("the picture is not saved: {error}")),
        }
    }

    /// Under the first number that is free.
    fn save_picture(&self) -> Result<PathBuf, String> {
        for number in 1..10_000 {
            let path = self
                .options
                .folder
                .join(format!("boxwood-view-{number}.png"));
            if path.exists() {
                continue;
            }
            let camera = (self.options.camera_flags)(&self.camera);
            let texts = [("Camera", &*camera), ("Shading", self.look)];
            save_atomically(&path, |out| write_png(&self.frame, &texts, out))
                .map_err(|error| error.to_string())?;
            return Ok(path);
        }
        Err("too many pictures of that name; remove some".to_owned())
    }

    pub(super) fn point(&mut self, place: [f32; 2]) {
        let [dx, dy] =
            [0, 1].map(|k| (place[k] - self.hands.pointer[k]) / self.options.size[1] as f32);
        self.hands.pointer = place;
        let (dx, dy) = (f64::from(dx), f64::from(dy));
        let moved = match self.hands.button {
            None => return,
            Some(Button::Left) if !self.hands.shift => {
                navigate::orbit(&self.camera, -dx * f64::from(ORBIT), dy * f64::from(ORBIT))
            }
            Some(_) => navigate::pan(&self.camera, -dx, dy),
        };
        self.go(moved);
    }

    pub(super) fn wheel(&mut self, notches: f32) {
        let factor = ZOOM.powf(notches.clamp(-20.0, 20.0));
        self.go(navigate::zoom(&self.camera, factor.into()));
    }

    /// Moves as the held keys say.
    pub(super) fn fly(&mut self, time: Duration) {
        let Some(subject) = self
            .subject
            .as_ref()
            .filter(|_| !self.hands.held.is_empty())
        else {
            return;
        };
        let seconds = time.as_secs_f64().min(0.1);
        let hurry = if self.hands.shift { 4.0 } else { 1.0 };
        let way = f64::from(subject.diagonal * SPEED) * seconds * hurry;
        let angle = TURN * seconds;
        let mut camera = self.camera;
        for &key in &self.hands.held {
            camera = match action_of(key) {
                Some((Action::Fly, place)) => {
                    let [ahead, right] = [[way, 0.0], [0.0, -way], [-way, 0.0], [0.0, way]][place];
                    navigate::fly(&camera, ahead, right)
                }
                Some((Action::Turn, place)) => {
                    let [right, up] =
                        [[-angle, 0.0], [angle, 0.0], [0.0, angle], [0.0, -angle]][place];
                    navigate::turn(&camera, right, up)
                }
                _ => camera,
            };
        }
        self.go(camera);
    }

    /// To another camera, if it is a possible one.
    pub(crate) fn go(&mut self, camera: Camera) {
        if camera != self.camera && View::new(camera, 2, 2).is_ok() {
            self.camera = camera;
            self.changed();
        }
    }

    pub(crate) fn camera(&self) -> Camera {
        self.camera
    }

    /// Puts the pointer there, in shares of the window.
    pub(crate) fn point_at(&mut self, share: [f32; 2]) {
        let place = [0, 1].map(|k| share[k] * self.options.size[k] as f32);
        self.point(place);
    }

    /// The structure with that place in the table.
    fn structure(&mut self, place: usize) {
        let Some(structure) = STRUCTURES.get(place) else {
            return;
        };
        self.counted = None;
        match self
            .built
            .iter()
            .position(|built| built.structure == structure.name)
        {
            Some(at) => {
                let built = self.built.remove(at);
                self.built.push(built);
                self.built_changed();
            }
            None => self.build(structure.name, false),
        }
    }

    /// Costs in two structures side by side, or no longer.
    fn split(&mut self) {
        self.shown.split = !self.shown.split;
        if self.shown.split && !self.look.starts_with("heat") {
            self.scale.top = None;
            self.look = "heat-tests";
        }
        self.changed_look();
        if let (true, [only]) = (self.shown.split, &*self.built) {
            let other = if only.structure == "grid" {
                "bvh2"
            } else {
                "grid"
            };
            self.build(other, true);
        }
    }

    /// Builds in the background; to be shown, or, `beside`, in the right half.
    fn build(&mut self, structure: &'static str, beside: bool) {
        let Some(subject) = self.subject.clone() else {
            return;
        };
        let options = self.options.build.clone();
        // A finer picture of the old structure would only keep the threads busy.
        self.jobs.refining = None;
        self.jobs.doing = Some(format!("building {structure}"));
        self.jobs.building = Some(self.workshop.start(move |desk| {
            let report = reporter(desk, structure);
            let built = Built::new(subject.mesh(), structure, &options, desk.cancel(), report);
            let built = built
                .map(Arc::new)
                .map_err(|error| format!("{structure}: {error}"));
            desk.tell(News::Built(built, beside));
        }));
    }

    /// The structure that is shown is another one.
    pub(super) fn built_changed(&mut self) {
        if let (Some(picked), Some(built)) = (&self.picked, self.built.last()) {
            self.picked = Some(Picked::new(built, picked.ray));
        }
        self.changed_look();
    }
}

/// Tells how far a build is, in whole percents.
pub(super) fn reporter(
    desk: &Desk,
    structure: &'static str,
) -> impl Fn(f32) + Send + Sync + 'static {
    let tell = desk.teller();
    let last = std::sync::atomic::AtomicU32::new(u32::MAX);
    move |share| {
        let percent = (share * 100.0) as u32;
        if last.swap(percent, std::sync::atomic::Ordering::Relaxed) != percent {
            tell(News::Doing(format!("building {structure}: {percent} %")));
        }
    }
}
