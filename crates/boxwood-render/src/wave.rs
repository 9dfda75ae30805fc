//! Many paths at once: each is written as if it were alone, and all their rays are traced together.
//!
//! A shading is an `async fn` that follows one camera ray. Where it needs to know what another ray
//! hits, it awaits the answer; there the path rests, its ray in its [`Port`], until all other paths
//! of the wave rest too or are done. Then the wave hands all the rays to the structure in two
//! batches, closest hits and shadow rays, puts the answers into the ports, and wakes the paths. The
//! compiler makes the state of a resting path out of the function's local variables; there is no
//! runtime, no waker and no thread in it.
//!
//! Waves of rays instead of one path after the other: Laine, Karras and Aila, "Megakernels
//! Considered Harmful", HPG 2013.

use std::{
    cell::Cell,
    pin::Pin,
    rc::Rc,
    task::{Context, Poll, Waker},
};

use boxwood::{Hit, Ray};
use glam::Vec3;

use crate::{probe::Probe, sampler::Sampler, stage::Stage};

/// Most paths of a wave: enough to keep a batch busy, few enough for the second-level cache.
pub(crate) const MOST_PATHS: usize = 1024;

/// A shading that follows rays.
pub(crate) trait Shade: 'static {
    /// Linear light along the camera ray `ray`, whose hit in the scene is known already.
    fn shade(probe: Probe<'_>, ray: Ray, hit: Option<Hit>) -> impl Future<Output = Vec3>;
}

/// Where a path begins: its camera ray, what that hits in the scene, and its random numbers.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    pub(crate) ray: Ray,
    pub(crate) hit: Option<Hit>,
    pub(crate) sampler: Sampler,
}

/// Paths of one shading, side by side on the calling thread. Made once per thread and used again.
pub(crate) trait Wave {
    /// Follows a path from each start (at most [`MOST_PATHS`]) to its end. `colors` become their
    /// colours, in the same order; the number of rays comes back. None if `cancelled` says so
    /// between two batches.
    fn run(
        &mut self,
        starts: &[Start],
        colors: &mut Vec<Vec3>,
        cancelled: &dyn Fn() -> bool,
    ) -> Option<u64>;
}

/// How the table of shadings opens a wave.
pub(crate) type Open = for<'s> fn(&'s Stage<'s>) -> Box<dyn Wave + 's>;

/// A wave of the shading `S`.
pub(crate) fn open<'s, S: Shade>(stage: &'s Stage<'s>) -> Box<dyn Wave + 's> {
    Box::new(Paths {
        stage,
        start: S::shade,
        lanes: Vec::new(),
        awake: Vec::new(),
        closest: Batch::default(),
        shadow: Batch::default(),
    })
}

/// What a path and its wave have to say to each other.
#[derive(Clone, Copy, Debug, Default)]
enum Message {
    #[default]
    Nothing,
    Closest(Ray),
    Shadow(Ray),
    Hit(Option<Hit>),
    Occluded(bool),
}

/// Where a path leaves its ray and finds the answer.
#[derive(Debug, Default)]
pub(crate) struct Port(Cell<Message>);

impl Port {
    /// What `ray` hits in the scene.
    pub(crate) async fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let answer = |message| match message {
            Message::Hit(hit) => Poll::Ready(hit),
            _ => Poll::Pending,
        };
        self.ask(Message::Closest(*ray), answer).await
    }

    /// Whether anything in the scene is in the way of `ray`.
    pub(crate) async fn occluded(&self, ray: &Ray) -> bool {
        let answer = |message| match message {
            Message::Occluded(occluded) => Poll::Ready(occluded),
            _ => Poll::Pending,
        };
        self.ask(Message::Shadow(*ray), answer).await
    }

    /// Rests until `answer` finds one in the port.
    async fn ask<T>(&self, question: Message, answer: impl Fn(Message) -> Poll<T>) -> T {
        self.0.set(question);
        std::future::poll_fn(|_| answer(self.0.get())).await
    }
}

/// Paths that end where they begin: a colour from what the camera ray hits, without further rays.
pub(crate) struct Glances<'s> {
    pub(crate) stage: &'s Stage<'s>,
    pub(crate) color: fn(&Stage<'_>, &Ray, Option<Hit>) -> Vec3,
}

impl Wave for Glances<'_> {
    fn run(
        &mut self,
        starts: &[Start],
        colors: &mut Vec<Vec3>,
        cancelled: &dyn Fn() -> bool,
    ) -> Option<u64> {
        let color = |start: &Start| (self.color)(self.stage, &start.ray, start.hit);
        colors.clear();
        colors.extend(starts.iter().map(color));
        (!cancelled()).then_some(0)
    }
}

/// Paths of a shading that follows rays.
struct Paths<'s, F> {
    stage: &'s Stage<'s>,
    start: fn(Probe<'s>, Ray, Option<Hit>) -> F,
    lanes: Vec<Lane<F>>,
    /// Numbers of the lanes that have their answers.
    awake: Vec<usize>,
    closest: Batch<Option<Hit>>,
    shadow: Batch<bool>,
}

/// The place of a path; the next one uses its memory again.
struct Lane<F> {
    port: Rc<Port>,
    path: Pin<Box<Option<F>>>,
}

/// The rays of one kind that paths wait for.
#[derive(Default)]
struct Batch<A> {
    lanes: Vec<usize>,
    rays: Vec<Ray>,
    answers: Vec<A>,
}

impl<F: Future<Output = Vec3>> Wave for Paths<'_, F> {
    fn run(
        &mut self,
        starts: &[Start],
        colors: &mut Vec<Vec3>,
        cancelled: &dyn Fn() -> bool,
    ) -> Option<u64> {
        self.start_all(starts);
        colors.clear();
        colors.resize(starts.len(), Vec3::ZERO);
        let mut rays = 0;
        while !self.awake.is_empty() {
            if cancelled() {
                return None;
            }
            self.wake(colors);
            rays += self.closest.rays.len() + self.shadow.rays.len();
            self.answer();
        }
        Some(rays as u64)
    }
}

impl<F: Future<Output = Vec3>> Paths<'_, F> {
    fn start_all(&mut self, starts: &[Start]) {
        while self.lanes.len() < starts.len() {
            self.lanes.push(Lane {
                port: Rc::default(),
                path: Box::pin(None),
            });
        }
        for (lane, start) in self.lanes.iter_mut().zip(starts) {
            let probe = Probe::new(self.stage, start.sampler.clone(), Rc::clone(&lane.port));
            lane.path
                .set(Some((self.start)(probe, start.ray, start.hit)));
        }
        self.awake.clear();
        self.awake.extend(0..starts.len());
    }

    /// Follows each path that is awake to its end, or to its next ray.
    fn wake(&mut self, colors: &mut [Vec3]) {
        let mut context = Context::from_waker(Waker::noop());
        for number in self.awake.drain(..) {
            let lane = &mut self.lanes[number];
            let Some(path) = lane.path.as_mut().as_pin_mut() else {
                continue;
            };
            match path.poll(&mut context) {
                Poll::Ready(color) => colors[number] = color,
                Poll::Pending => match lane.port.0.get() {
                    Message::Closest(ray) => self.closest.push(number, ray),
                    Message::Shadow(ray) => self.shadow.push(number, ray),
                    _ => unreachable!("a path rests only at its port"),
                },
            }
        }
    }

    /// Traces what the paths wait for, and lets them wake in the order of the lanes: neighbours in
    /// the picture stay neighbours.
    fn answer(&mut self) {
        let query = self.stage.scene.query();
        let Self {
            closest, shadow, ..
        } = self;
        closest.answers.resize(closest.rays.len(), None);
        query.closest_hits(&closest.rays, &mut closest.answers);
        closest.deliver(&self.lanes, Message::Hit);
        shadow.answers.resize(shadow.rays.len(), false);
        query.occluded_each(&shadow.rays, &mut shadow.answers);
        shadow.deliver(&self.lanes, Message::Occluded);
        self.awake.append(&mut closest.lanes);
        self.awake.append(&mut shadow.lanes);
        self.awake.sort_unstable();
    }
}

impl<A: Copy> Batch<A> {
    fn push(&mut self, lane: usize, ray: Ray) {
        self.lanes.push(lane);
        self.rays.push(ray);
    }

    fn deliver<F>(&mut self, lanes: &[Lane<F>], message: fn(A) -> Message) {
        for (&lane, &answer) in self.lanes.iter().zip(&self.answers) {
            lanes[lane].port.0.set(message(answer));
        }
        self.rays.clear();
    }
}

#[cfg(test)]
mod tests {
    use boxwood::Scene;
    use boxwood_scene::{Camera, FlatMesh, Model};

    use super::*;
    use crate::{RenderOptions, SHADINGS, Surfaces, View};

    /// A triangle at `z = 0`, as large as life.
    fn mesh() -> FlatMesh {
        FlatMesh {
            positions: vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]],
            indices: vec![[0, 1, 2]],
            ..FlatMesh::default()
        }
    }

    /// Hands `work` a stage of that triangle.
    fn on_stage(work: impl FnOnce(&Stage<'_>)) {
        let (mesh, model) = (mesh(), Model::default());
        let scene = Scene::new(&mesh.positions, &mesh.indices).unwrap();
        let camera = Camera {
            eye: [1.0, 1.5, 5.0],
            target: [1.0, 1.0, 0.0],
            up: [0.0, 1.0, 0.0],
            fov: 40.0,
        };
        let view = View::new(camera, 8, 8).unwrap();
        let options = RenderOptions::new(&SHADINGS[0]);
        let surfaces = Surfaces::new(&mesh, &model);
        work(&Stage::new(&scene, surfaces, &view, &options));
    }

    /// Asks along x up to the first miss; the colour is the number of hits, and of the shadow rays
    /// in between that were not free.
    struct Steps;

    impl Shade for Steps {
        async fn shade(probe: Probe<'_>, ray: Ray, _: Option<Hit>) -> Vec3 {
            let (mut ray, mut hits, mut blocked) = (ray, 0.0, 0.0);
            while probe.trace(&ray).await.is_some() {
                hits += 1.0;
                let behind = Ray::new(ray.origin, [0.0, 0.0, if hits == 2.0 { -1.0 } else { 1.0 }]);
                blocked += f32::from(u8::from(probe.occluded(&behind).await));
                ray.origin[0] += 1.0;
            }
            Vec3::new(hits, blocked, 0.0)
        }
    }

    fn starts(from: &[f32]) -> Vec<Start> {
        let start = |&x: &f32| Start {
            ray: Ray::new([x, 0.5, 1.0], [0.0, 0.0, -1.0]),
            hit: None,
            sampler: Sampler::new(0, 0, 0, 0),
        };
        from.iter().map(start).collect()
    }

    #[test]
    fn paths_of_all_lengths_end_in_their_own_places() {
        on_stage(|stage| {
            let mut wave = open::<Steps>(stage);
            let mut colors = Vec::new();
            // The second wave is shorter, and finds the lanes of the first.
            for from in [&[2.25, 0.25, 9.0, 1.75, -1.0][..], &[3.25, 0.75]] {
                let rays = wave.run(&starts(from), &mut colors, &|| false).unwrap();
                let hits = |x: f32| {
                    (0..9)
                        .take_while(|i| (0.0..=3.5).contains(&(x + *i as f32)))
                        .count()
                };
                let expected: Vec<Vec3> = from
                    .iter()
                    .map(|&x| Vec3::new(hits(x) as f32, f32::from(u8::from(hits(x) > 1)), 0.0))
                    .collect();
                assert_eq!(colors, expected);
                let asked: usize = from.iter().map(|&x| 2 * hits(x) + 1).sum();
                assert_eq!(rays, asked as u64);
            }
        });
    }

    #[test]
    fn a_cancelled_wave_can_be_used_again() {
        on_stage(|stage| {
            let mut wave = open::<Steps>(stage);
            let mut colors = Vec::new();
            let rounds = Cell::new(0);
            let cancelled = || rounds.replace(rounds.get() + 1) == 2;
            assert_eq!(wave.run(&starts(&[0.5; 7]), &mut colors, &cancelled), None);
            let rays = wave.run(&starts(&[3.25]), &mut colors, &|| false);
            assert_eq!((rays, &*colors), (Some(3), &[Vec3::X][..]));
        });
    }
}
