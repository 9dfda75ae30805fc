//! The rays that pictures are made of, from the scene itself and Boxwood's own exact answers.
//!
//! Five sets of `size * size` rays each. `primary`: through the pixels of a square picture, in tiles of 8 x 8. From where those
//! end, in their order, again and again until there are as many: `shadow` to a point light, `ao` (ambient occlusion) over a
//! tenth of the scene's diagonal, `diffuse` for one bounce. `random`: from anywhere in the scene's box to anywhere.

use crate::error::MeasureError;
use boxwood::{Hit, Ray, Scene};
use boxwood_scene::Camera;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::f32::consts::TAU;

/// What is asked of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Question {
    /// For the closest hit.
    Closest,
    /// Whether anything is in its range.
    Occluded,
}

/// Rays of one kind.
#[derive(Clone, Debug)]
pub struct RaySet {
    /// `primary`, `shadow`, `ao`, `diffuse`, `random`.
    pub name: &'static str,
    /// What is asked of them.
    pub question: Question,
    /// True if neighbours in the list go much the same way through the structure.
    pub coherent: bool,
    /// In the order in which a renderer makes them.
    pub rays: Vec<Ray>,
}

/// Pixels of a tile, along each side.
const TILE: usize = 8;
/// Rays start so far above the surface, as a part of the scene's diagonal.
const OFFSET: f32 = 1e-5;
/// How far ambient occlusion looks, as a part of the scene's diagonal.
const NEARBY: f32 = 0.1;

/// The five sets, `size * size` rays each, seen from `camera` or from [`outside`]. The same scene, camera and size give the same
/// rays, whatever the structure.
///
/// # Errors
/// [`MeasureError::NoTriangles`] if the scene is empty, [`MeasureError::SeesNothing`] if no primary ray hits.
pub fn ray_sets(
    scene: &Scene,
    camera: Option<Camera>,
    size: usize,
) -> Result<Vec<RaySet>, MeasureError> {
    if scene.is_empty() {
        return Err(MeasureError::NoTriangles);
    }
    let size = size.max(1);
    let primary = primary(&camera.unwrap_or_else(|| outside(scene)), size);
    let points = Points::of(scene, &primary)?;
    let mut random = Random(7);
    let mut shadow = Vec::with_capacity(primary.len());
    let mut ao = Vec::with_capacity(primary.len());
    let mut diffuse = Vec::with_capacity(primary.len());
    for (point, normal) in points.0.iter().copied().cycle().take(primary.len()) {
        shadow.push(ray_to(point, light(scene)));
        let nearby = NEARBY * diagonal(scene);
        ao.push(ray(point, around(normal, &mut random)).with_range(0.0, nearby));
        diffuse.push(ray(point, around(normal, &mut random)));
    }
    let anywhere = anywhere(scene, size * size, &mut random);
    let set = |name, question, coherent, rays| RaySet {
        name,
        question,
        coherent,
        rays,
    };
    Ok(vec![
        set("primary", Question::Closest, true, primary),
        set("shadow", Question::Occluded, true, shadow),
        set("ao", Question::Occluded, true, ao),
        set("diffuse", Question::Closest, false, diffuse),
        set("random", Question::Closest, false, anywhere),
    ])
}

/// The whole scene from outside, from the front, the right and above.
pub fn outside(scene: &Scene) -> Camera {
    let center = Vec3::from(scene.bounds().center());
    let away = Vec3::new(0.6, 0.35, 1.0).normalize() * (0.95 * diagonal(scene));
    Camera {
        eye: (center + away).into(),
        target: center.into(),
        up: [0.0, 1.0, 0.0],
        fov: 50.0,
    }
}

/// About `count` of the rays, in whole tiles from everywhere in the list; all if there are no more.
pub fn sample(rays: &[Ray], count: usize) -> Vec<Ray> {
    const RUN: usize = TILE * TILE;
    let runs = rays.len() / RUN;
    let wanted = count.div_ceil(RUN);
    if wanted >= runs {
        return rays.to_vec();
    }
    (0..wanted)
        .flat_map(|i| &rays[i * runs / wanted * RUN..][..RUN])
        .copied()
        .collect()
}

fn diagonal(scene: &Scene) -> f32 {
    (scene.bounds().diagonal() as f32).max(f32::MIN_POSITIVE)
}

/// Behind the scene's left shoulder.
fn light(scene: &Scene) -> Vec3 {
    let towards = Vec3::new(-0.5, 1.0, 0.4).normalize();
    Vec3::from(scene.bounds().center()) + towards * diagonal(scene)
}

fn ray(origin: Vec3, dir: Vec3) -> Ray {
    Ray::new(origin.into(), dir.into())
}

/// Of unit direction.
fn ray_to(from: Vec3, to: Vec3) -> Ray {
    let length = from.distance(to);
    ray(from, (to - from) / length).with_range(0.0, length)
}

/// Tile by tile, in each row by row.
fn primary(camera: &Camera, size: usize) -> Vec<Ray> {
    let eye = Vec3::from(camera.eye);
    let forward = (Vec3::from(camera.target) - eye).normalize_or(Vec3::NEG_Z);
    let up = Vec3::from(camera.up).normalize_or(Vec3::Y);
    let right = forward.cross(up).try_normalize();
    let right = right.unwrap_or_else(|| forward.any_orthonormal_vector());
    let down = forward.cross(right);
    let half = (camera.fov.to_radians() * 0.5).tan();
    let at = |pixel: usize| ((pixel as f32 + 0.5) / size as f32 * 2.0 - 1.0) * half;
    let pixel_ray = |x, y| ray(eye, (forward + right * at(x) + down * at(y)).normalize());
    let tiles = size.div_ceil(TILE);
    let mut rays = Vec::with_capacity(size * size);
    for tile in 0..tiles * tiles {
        let (left, top) = (tile % tiles * TILE, tile / tiles * TILE);
        for y in top..(top + TILE).min(size) {
            rays.extend((left..(left + TILE).min(size)).map(|x| pixel_ray(x, y)));
        }
    }
    rays
}

/// Where rays end, lifted off the surface, and the unit normal there towards where they come from.
struct Points(Vec<(Vec3, Vec3)>);

impl Points {
    fn of(scene: &Scene, rays: &[Ray]) -> Result<Self, MeasureError> {
        let mut hits = vec![None; rays.len()];
        scene.closest_hits(rays, &mut hits);
        let lift = OFFSET * diagonal(scene);
        let point = |(ray, hit): (&Ray, &Option<Hit>)| {
            let hit = hit.as_ref()?;
            let normal = Vec3::from(scene.normal(hit)?).try_normalize()?;
            let normal = if normal.dot(ray.dir.into()) > 0.0 {
                -normal
            } else {
                normal
            };
            Some((Vec3::from(ray.at(hit.t)) + normal * lift, normal))
        };
        let points: Vec<_> = rays.iter().zip(&hits).filter_map(point).collect();
        if points.is_empty() {
            return Err(MeasureError::SeesNothing);
        }
        Ok(Self(points))
    }
}

/// A direction about the unit `normal`, the likelier the closer (by the cosine).
fn around(normal: Vec3, random: &mut Random) -> Vec3 {
    let (a, b) = (random.unit(), random.unit());
    let (radius, angle) = (a.sqrt(), b * TAU);
    let (x, y) = normal.any_orthonormal_pair();
    let height = (1.0 - a).max(0.0).sqrt().max(1e-3);
    (normal * height + x * radius * angle.cos() + y * radius * angle.sin()).normalize()
}

/// From uniform points of the scene's box in uniform directions.
fn anywhere(scene: &Scene, count: usize, random: &mut Random) -> Vec<Ray> {
    let bounds = scene.bounds();
    let (min, extent) = (Vec3::from(bounds.min), Vec3::from(bounds.extent()));
    let mut one = || {
        let origin = min + extent * Vec3::new(random.unit(), random.unit(), random.unit());
        let (z, angle) = (random.unit() * 2.0 - 1.0, random.unit() * TAU);
        let across = (1.0 - z * z).max(0.0).sqrt();
        ray(
            origin,
            Vec3::new(across * angle.cos(), across * angle.sin(), z),
        )
    };
    (0..count).map(|_| one()).collect()
}

/// SplitMix64 (Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014).
struct Random(u64);

impl Random {
    /// In 0..1.
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((x ^ (x >> 31)) >> 40) as f32 / (1u32 << 24) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn terrain() -> Scene {
        let mesh = boxwood_scene::open("builtin:terrain?n=2000")
            .unwrap()
            .flatten()
            .unwrap();
        Scene::new(&mesh.positions, &mesh.indices).unwrap()
    }

    #[test]
    fn there_are_five_sets_of_equal_size_and_all_rays_are_rays() {
        let scene = terrain();
        let sets = ray_sets(&scene, None, 20).unwrap();
        let names: Vec<_> = sets.iter().map(|set| set.name).collect();
        assert_eq!(names, ["primary", "shadow", "ao", "diffuse", "random"]);
        for set in &sets {
            assert_eq!(set.rays.len(), 400, "{}", set.name);
            assert!(set.rays.iter().all(Ray::is_valid), "{}", set.name);
        }
        let lengths = sets[2].rays.iter().map(|ray| ray.t_max);
        let expected = 0.1 * scene.bounds().diagonal() as f32;
        assert!(lengths.clone().all(|length| length == expected));
    }

    #[test]
    fn primary_rays_go_tile_by_tile_through_every_pixel_once() {
        let camera = Camera {
            eye: [0.0; 3],
            target: [0.0, 0.0, -1.0],
            up: [0.0, 1.0, 0.0],
            fov: 90.0,
        };
        let rays = primary(&camera, 20);
        let pixel = |ray: &Ray| {
            let at = |x: f32| ((x / -ray.dir[2] + 1.0) * 10.0).floor() as i32;
            (at(ray.dir[0]), at(-ray.dir[1]))
        };
        let pixels: Vec<_> = rays.iter().map(pixel).collect();
        assert_eq!(
            pixels[..9],
            [
                (0, 0),
                (1, 0),
                (2, 0),
                (3, 0),
                (4, 0),
                (5, 0),
                (6, 0),
                (7, 0),
                (0, 1)
            ]
        );
        assert_eq!(pixels[64], (8, 0));
        let mut sorted = pixels;
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), 400);
    }

    #[test]
    fn bounces_leave_the_side_that_the_ray_came_from() {
        let scene = terrain();
        let sets = ray_sets(&scene, None, 16).unwrap();
        // A terrain seen from above: whatever bounces goes up or sideways, hardly ever down.
        let up = sets[3].rays.iter().filter(|ray| ray.dir[1] > 0.0).count();
        assert!(up > 200, "{up} of 256");
    }

    #[test]
    fn a_sample_is_of_whole_tiles_from_everywhere() {
        let rays: Vec<Ray> = (0..6400)
            .map(|i| Ray::new([i as f32, 0.0, 0.0], [0.0, 0.0, 1.0]))
            .collect();
        let some = sample(&rays, 200);
        assert_eq!(some.len(), 256);
        let starts: Vec<f32> = some.chunks(64).map(|run| run[0].origin[0]).collect();
        assert_eq!(starts, [0.0, 1600.0, 3200.0, 4800.0]);
        assert_eq!(sample(&rays, 6400).len(), 6400);
        assert_eq!(sample(&rays[..50], 10).len(), 50);
    }

    #[test]
    fn a_camera_that_looks_away_is_an_error() {
        let scene = terrain();
        let mut away = outside(&scene);
        away.target = std::array::from_fn(|k| 2.0 * away.eye[k] - away.target[k]);
        let error = ray_sets(&scene, Some(away), 8).unwrap_err();
        assert!(matches!(error, MeasureError::SeesNothing), "{error}");
    }
}
