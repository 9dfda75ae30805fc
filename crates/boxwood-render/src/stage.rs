//! The scene made ready for the camera: geometry, looks, lights, sky, floor, exposure.

use boxwood::{Hit, Ray, Scene};
use glam::Vec3;

use crate::{
    RenderOptions, Surface, Surfaces, View,
    floor::Floor,
    light::{Lights, PointLight, Shadows, Sky, Sun, offset_point},
    sampler::Sampler,
    sampling::cosine_hemisphere,
    tone::luminance,
};

/// Everything that the shadings ask of a scene. Made once per picture, shared by all threads.
#[derive(Clone, Debug)]
pub(crate) struct Stage<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) surfaces: Surfaces<'a>,
    pub(crate) sky: Sky,
    pub(crate) lights: Lights,
    pub(crate) floor: Option<Floor>,
    /// Length of the diagonal of the bounds.
    pub(crate) diagonal: f32,
    /// Most bounces of a path.
    pub(crate) max_depth: u32,
    /// Factor from scene light to picture light.
    pub(crate) exposure: f32,
    /// An interior, or lit by lamps of unknown brightness: the exposure is to be measured.
    pub(crate) adapts: bool,
    /// What stands for light that bounces indoors, in shadings where light does not bounce:
    /// radiance, even.
    pub(crate) ambient: Vec3,
    /// See [`offset_point`].
    extent: f32,
}

/// Below this share of sky, seen from the surfaces, a scene counts as an interior: the file's own
/// lights do without a sky, and the exposure adapts.
const OPEN: f32 = 0.25;
/// Below this share no daylight to speak of comes in: a lamp is hung up.
const CLOSED: f32 = 0.03;
/// From this mean radiance of white surfaces on, lamps light a scene well enough without daylight;
/// it is about 1 in the sun.
const LAMPS_SUFFICE: f32 = 0.02;
/// The same where no daylight competes, and the exposure does the rest.
const LAMPS_SUFFICE_INDOORS: f32 = 0.001;

impl<'a> Stage<'a> {
    /// Decides what lights the scene.
    ///
    /// - Lights of the file or the options are kept. Where they are bright enough for what the
    ///   camera sees, they are the only ones, and the background is black.
    /// - Else sun and sky, the sun to the left of the camera and behind it, about 45 degrees high.
    /// - In an interior that daylight does not reach, a lamp that hangs from the ceiling.
    ///
    /// Whether the scene is an interior is found out by a few hundred rays from what the camera
    /// sees, always the same.
    pub(crate) fn new(
        scene: &'a Scene,
        surfaces: Surfaces<'a>,
        view: &View,
        options: &RenderOptions,
    ) -> Self {
        let light_from = options.light_from.as_ref().unwrap_or(view);
        let bounds = scene.bounds();
        let (min, max) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
        let size = (max - min).length();
        let mut stage = Self {
            scene,
            surfaces,
            sky: Sky {
                up: Vec3::from(light_from.camera().up).normalize(),
                strength: 1.0,
            },
            lights: Lights::of(surfaces, options.lights.clone()),
            floor: None,
            diagonal: if size.is_finite() {
                size.max(f32::MIN_POSITIVE)
            } else {
                1.0
            },
            max_depth: options.max_depth,
            exposure: 1.0,
            adapts: false,
            ambient: Vec3::ZERO,
            extent: min
                .abs()
                .max(max.abs())
                .max_element()
                .clamp(f32::MIN_POSITIVE, 1.0),
        };
        stage.light_up(light_from, view, options);
        stage
    }

    /// As it looks from `from`; the floor is for who looks from `view`.
    fn light_up(&mut self, from: &View, view: &View, options: &RenderOptions) {
        let seen = self.surfaces_in_view(from);
        let open = self.open_share(&seen);
        let lamplight = self.mean_light(&seen);
        let interior = open < OPEN;
        let by_lamps = luminance(lamplight)
            > if interior {
                LAMPS_SUFFICE_INDOORS
            } else {
                LAMPS_SUFFICE
            };
        self.sky.strength = options.sky.unwrap_or(if by_lamps { 0.0 } else { 1.0 });
        let daylight = self.sky.strength > 0.0 && open >= CLOSED;
        if daylight && !(by_lamps && options.sky.is_none()) {
            self.lights.sun = Some(key_light(from, self.sky, if interior { 2.2 } else { 1.05 }));
        }
        if open < CLOSED && !by_lamps {
            self.lights.points.extend(self.ceiling_lamp(from));
        }
        if options.floor && !interior && !by_lamps {
            self.floor = Floor::under(self.scene, self.sky.up, view);
        }
        self.adapts = interior || by_lamps;
        if self.adapts {
            self.ambient = if daylight {
                lamplight
            } else {
                self.mean_light(&seen)
            } * 0.3;
        }
    }

    /// What the camera sees of the scene on an even grid, the same for any crop.
    fn surfaces_in_view(&self, view: &View) -> Vec<Surface> {
        const GRID: u32 = 24;
        let cell = |i, side: u32| (i as f32 + 0.5) * (side as f32 / GRID as f32);
        (0..GRID * GRID)
            .filter_map(|i| {
                let ray = view.ray(cell(i % GRID, view.width()), cell(i / GRID, view.height()));
                self.scene
                    .closest_hit(&ray)
                    .map(|hit| self.surfaces.at(&ray, &hit))
            })
            .collect()
    }

    /// The share of the hemisphere above the surfaces, weighted by the cosine, that is sky. 1 where
    /// nothing is seen.
    fn open_share(&self, seen: &[Surface]) -> f32 {
        let open = |(number, surface): (u32, &Surface)| {
            let mut sampler = Sampler::new(0, number, 0, 0);
            let free = |_: &u32| {
                let dir = cosine_hemisphere(surface.face_normal, sampler.next_pair());
                !self
                    .scene
                    .occluded(&self.spawn(surface, dir, f32::INFINITY))
            };
            (0..4).filter(free).count()
        };
        if seen.is_empty() {
            return 1.0;
        }
        (0..).zip(seen).map(open).sum::<usize>() as f32 / (4 * seen.len()) as f32
    }

    /// The radiance that white surfaces would have on average, lit by the lamps alone.
    fn mean_light(&self, seen: &[Surface]) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for (number, surface) in (0..).zip(seen) {
            let mut sampler = Sampler::new(1, number, 0, 0);
            for index in 0..self.lights.count() {
                let pair = sampler.next_pair();
                let Some(light) = self
                    .lights
                    .sample(index, surface.position, pair, Shadows::Soft)
                else {
                    continue;
                };
                let cosine = light.dir.dot(surface.face_normal);
                let shadow_ray = self.spawn(surface, light.dir, light.distance * (1.0 - 1e-3));
                if cosine > 0.0 && !self.scene.occluded(&shadow_ray) {
                    sum += light.light * (cosine * std::f32::consts::FRAC_1_PI);
                }
            }
        }
        sum / seen.len().max(1) as f32
    }

    /// A lamp that hangs from the ceiling, between the camera and what it looks at.
    fn ceiling_lamp(&self, view: &View) -> Option<PointLight> {
        let middle = view.ray(view.width() as f32 * 0.5, view.height() as f32 * 0.5);
        let ahead = self
            .scene
            .closest_hit(&middle)
            .map_or(0.3 * self.diagonal, |hit| hit.t);
        let below = Vec3::from(middle.origin) + Vec3::from(middle.dir) * (0.45 * ahead);
        let rise = self
            .scene
            .closest_hit(&Ray::new(below.into(), self.sky.up.into()));
        let rise = rise.map_or(0.2 * self.diagonal, |hit| hit.t).min(ahead);
        let intensity = ahead * ahead;
        Some(PointLight {
            position: (below + self.sky.up * (0.5 * rise)).into(),
            intensity: (Vec3::new(1.0, 0.94, 0.84) * intensity).into(),
            radius: 0.06 * rise,
        })
    }

    /// The surface that `ray` sees, given what it hits in the scene: that, or the floor in front of
    /// it.
    pub(crate) fn surface(&self, ray: &Ray, hit: Option<Hit>) -> Option<Surface> {
        let t_max = hit.map_or(ray.t_max, |hit| hit.t);
        let floor = self
            .floor
            .as_ref()
            .and_then(|floor| floor.surface(ray, t_max));
        floor.or_else(|| hit.map(|hit| self.surfaces.at(ray, &hit)))
    }

    /// A ray that leaves `surface` along the unit vector `dir`, on the side of the face normal, up
    /// to `t_max`.
    pub(crate) fn spawn(&self, surface: &Surface, dir: Vec3, t_max: f32) -> Ray {
        let origin = offset_point(surface.position, surface.face_normal, self.extent);
        Ray::new(origin.into(), dir.into()).with_range(0.0, t_max)
    }
}

/// The sun over the photographer's left shoulder; `height` is the tangent of its elevation, roughly.
/// It stands high above courtyards, so that some of it gets in.
pub(crate) fn key_light(view: &View, sky: Sky, height: f32) -> Sun {
    let camera = view.camera();
    let ahead = Vec3::from(camera.target) - Vec3::from(camera.eye);
    let ahead = ahead.reject_from(sky.up).normalize_or_zero();
    let left = sky.up.cross(ahead);
    Sun {
        dir: (sky.up * height + left * 0.8 - ahead * 0.55).normalize(),
        irradiance: Vec3::new(1.0, 0.94, 0.86) * (2.6 * sky.strength),
    }
}
