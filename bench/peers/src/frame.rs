//! Frames per second of a small renderer that is the same for all: primary rays, a shadow ray each, shading.

use crate::{
    entries::entries,
    input::{self, Input},
    measure::{Bench, Settings},
};
use anyhow::Result;
use boxwood::{Hit, Ray, Scene};
use boxwood_measure::{Clock, Contender, Mode, Rounds, Task, outside, with_threads};
use boxwood_scene::{Camera, FlatMesh};
use rayon::prelude::*;
use std::{ops::ControlFlow, path::Path};

/// Frames of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Frames {
    /// Its name.
    pub(crate) scene: String,
    /// Who, asked how, and frames per second.
    pub(crate) rates: Vec<(String, Mode, f64)>,
}

const WIDTH: usize = 1280;
const HEIGHT: usize = 720;
/// Pixels along each side of a tile, which is one call: enough to be coherent, few enough for many threads.
const TILE: usize = 16;
/// Who renders.
const WHO: [&str; 2] = ["boxwood", "embree"];
/// The scene of the list that is rendered besides `builtin:bush`.
const LISTED: &str = "beetle";
const ROUNDS: usize = 15;

/// `builtin:bush`, and the beetle if the list has it.
pub(crate) fn of_list(list: &Path, settings: &Settings, bench: &Bench) -> Result<Vec<Frames>> {
    let bush = Input {
        name: "builtin:bush".to_owned(),
        file: "builtin:bush".to_owned(),
        camera: None,
    };
    let listed = input::list(list)?
        .into_iter()
        .filter(|input| input.name == LISTED);
    let folder = list.parent().unwrap_or(Path::new(""));
    let scenes = std::iter::once(bush).chain(listed);
    scenes
        .map(|input| frames(&input.name, &input.load(folder)?, settings, bench))
        .collect()
}

fn frames(name: &str, mesh: &FlatMesh, settings: &Settings, bench: &Bench) -> Result<Frames> {
    let scene = Scene::new(&mesh.positions, &mesh.indices)?;
    let stage = Stage::new(&scene, mesh);
    let entries = entries(mesh, bench.embree, &WHO.map(str::to_owned))?;
    let mut contenders = Vec::new();
    for entry in &entries {
        contenders.push((entry.build)(1)?.contender);
    }
    let lanes: Vec<(&dyn Contender, Mode)> = contenders
        .iter()
        .flat_map(|who| Mode::ALL.map(|mode| (&**who, mode)))
        .collect();
    let rounds = with_threads(settings.threads, || {
        let mut tasks: Vec<Task<'_>> = Vec::new();
        for &(who, mode) in &lanes {
            let mut picture = vec![0; WIDTH * HEIGHT];
            let stage = &stage;
            tasks.push(Box::new(move |_| stage.render(who, mode, &mut picture)));
        }
        // Once to warm up.
        Rounds::run(
            Clock::Wall,
            1,
            &mut tasks,
            &mut || ControlFlow::Continue(()),
        );
        Rounds::run(Clock::Wall, ROUNDS, &mut tasks, &mut || {
            ControlFlow::Continue(())
        })
    })?;
    let rate = |(number, (who, mode)): (usize, &(&dyn Contender, Mode))| {
        (who.name().to_owned(), *mode, 1.0 / rounds.median(number))
    };
    Ok(Frames {
        scene: name.to_owned(),
        rates: lanes.iter().enumerate().map(rate).collect(),
    })
}

/// A scene to be shown.
struct Stage<'a> {
    mesh: &'a FlatMesh,
    camera: Camera,
    light: [f32; 3],
    lift: f32,
}

/// What a tile works on, made once per thread.
#[derive(Default)]
struct Buffers {
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    shadows: Vec<Ray>,
    dark: Vec<bool>,
    /// Pixel of the tile and brightness of each shadow ray.
    lit: Vec<(usize, f32)>,
}

impl<'a> Stage<'a> {
    fn new(scene: &Scene, mesh: &'a FlatMesh) -> Self {
        let (center, size) = (scene.bounds().center(), scene.bounds().diagonal() as f32);
        let towards = [-0.5, 1.0, 0.4].map(|x: f32| x / 1.41_f32.sqrt());
        Self {
            mesh,
            camera: outside(scene),
            light: std::array::from_fn(|k| center[k] + size * towards[k]),
            lift: 1e-5 * size,
        }
    }

    /// Tile rows are the pieces of work.
    fn render(&self, who: &dyn Contender, mode: Mode, picture: &mut [u8]) {
        let rows = picture.par_chunks_mut(TILE * WIDTH).enumerate();
        rows.for_each_init(Buffers::default, |buffers, (row, pixels)| {
            for column in 0..WIDTH / TILE {
                self.tile(who, mode, [column * TILE, row * TILE], pixels, buffers);
            }
        });
    }

    fn tile(
        &self,
        who: &dyn Contender,
        mode: Mode,
        corner: [usize; 2],
        pixels: &mut [u8],
        b: &mut Buffers,
    ) {
        let height = pixels.len() / WIDTH;
        b.rays.clear();
        let places =
            (0..height).flat_map(|y| (0..TILE).map(move |x| [corner[0] + x, corner[1] + y]));
        b.rays.extend(places.map(|place| self.primary(place)));
        b.hits.resize(b.rays.len(), None);
        who.closest_hits(mode, &b.rays, &mut b.hits);
        b.shadows.clear();
        b.lit.clear();
        for (pixel, (ray, hit)) in b.rays.iter().zip(&b.hits).enumerate() {
            if let Some(hit) = hit {
                let (shadow, brightness) = self.shade(ray, hit);
                b.shadows.push(shadow);
                b.lit.push((pixel, brightness));
            }
        }
        b.dark.resize(b.shadows.len(), false);
        who.occluded(mode, &b.shadows, &mut b.dark);
        let at = |pixel: usize| pixel / TILE * WIDTH + corner[0] + pixel % TILE;
        (0..b.rays.len()).for_each(|pixel| pixels[at(pixel)] = 0);
        for ((pixel, brightness), dark) in b.lit.iter().zip(&b.dark) {
            let light = if *dark { 0.2 } else { 0.2 + 0.8 * brightness };
            pixels[at(*pixel)] = (255.0 * light) as u8;
        }
    }

    fn primary(&self, place: [usize; 2]) -> Ray {
        let Camera {
            eye, target, fov, ..
        } = self.camera;
        let forward = unit(minus(target, eye));
        let right = unit(cross(forward, [0.0, 1.0, 0.0]));
        let up = cross(right, forward);
        let half = (fov.to_radians() * 0.5).tan();
        let x = ((place[0] as f32 + 0.5) * 2.0 - WIDTH as f32) / HEIGHT as f32 * half;
        let y = (1.0 - (place[1] as f32 + 0.5) * 2.0 / HEIGHT as f32) * half;
        Ray::new(
            eye,
            std::array::from_fn(|k| forward[k] + x * right[k] + y * up[k]),
        )
    }

    /// The way to the light from a hit, and how bright it is if that is free.
    fn shade(&self, ray: &Ray, hit: &Hit) -> (Ray, f32) {
        let corners = self.mesh.indices[hit.prim as usize].map(|i| self.mesh.positions[i as usize]);
        let normal = unit(cross(
            minus(corners[1], corners[0]),
            minus(corners[2], corners[0]),
        ));
        let side = if dot(normal, ray.dir) > 0.0 {
            -1.0
        } else {
            1.0
        };
        let at = ray.at(hit.t);
        let from = std::array::from_fn(|k| at[k] + side * self.lift * normal[k]);
        let shadow = Ray::between(from, self.light);
        (shadow, (side * dot(normal, unit(shadow.dir))).max(0.0))
    }
}

fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [[1, 2], [2, 0], [0, 1]].map(|[i, j]| a[i] * b[j] - a[j] * b[i])
}

fn unit(a: [f32; 3]) -> [f32; 3] {
    let length = dot(a, a).sqrt().max(f32::MIN_POSITIVE);
    a.map(|x| x / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use boxwood_measure::Asked;

    #[test]
    fn single_rays_and_batches_give_the_same_picture_with_light_and_shadow() {
        let mesh = boxwood_scene::open("builtin:bush")
            .unwrap()
            .flatten()
            .unwrap();
        let scene = Scene::new(&mesh.positions, &mesh.indices).unwrap();
        let stage = Stage::new(&scene, &mesh);
        let who = Asked::new("boxwood", scene);
        let [single, batch] = Mode::ALL.map(|mode| {
            let mut picture = vec![7; WIDTH * HEIGHT];
            stage.render(&who, mode, &mut picture);
            picture
        });
        assert!(single == batch);
        let count = |wanted: fn(u8) -> bool| single.iter().filter(|x| wanted(**x)).count();
        assert!(
            count(|x| x == 0) > 10_000 && count(|x| x == 51) > 1000 && count(|x| x > 100) > 1000
        );
    }
}
