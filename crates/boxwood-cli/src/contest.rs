//! Structures side by side: which ones, and the rays that all of them are asked about.

use std::time::Duration;

use boxwood::{BUILDERS, BuildOptions, Builder, Ray, STRUCTURES, Scene, Structure, check::Variant};
use boxwood_render::View;
use boxwood_scene::FlatMesh;
use glam::Vec3;

use crate::args;

/// A structure with its options.
#[derive(Clone, Debug)]
pub(crate) struct Contender {
    structure: Structure,
    options: BuildOptions,
}

/// A [`Contender`] with a scene built.
#[derive(Debug)]
pub(crate) struct Built {
    /// As [`Contender::name`].
    pub(crate) name: String,
    /// Ready to be asked.
    pub(crate) scene: Scene,
    /// What building took.
    pub(crate) time: Duration,
}

impl Contender {
    /// `bvh2 binned aabb`, `grid`.
    pub(crate) fn name(&self) -> String {
        Variant::of(self.structure, self.options.clone()).name
    }

    /// True for brute force.
    pub(crate) fn is_list(&self) -> bool {
        self.structure.name == "list"
    }

    /// Builds it over `mesh`.
    pub(crate) fn build(&self, mesh: &FlatMesh) -> anyhow::Result<Built> {
        let (scene, time) = args::build(mesh, self.structure.name, self.options.clone())?;
        Ok(Built {
            name: self.name(),
            scene,
            time,
        })
    }
}

/// Brute force first, then the structures of the tables. Of the trees a choice: nested objects by the lecture's median;
/// the flat tree by every builder over boxes, and by the default builder over every volume. With `all`, each of each.
pub(crate) fn contenders(all: bool) -> Vec<Contender> {
    let usual = BuildOptions::default();
    let is_chosen = |structure: &Structure, builder: &Builder, volume: &str| {
        let (usual_builder, usual_volume) = (*builder == usual.builder, volume == usual.volume);
        match structure.name {
            "bounded" => usual_volume && *builder == Builder::MEDIAN,
            _ => usual_builder || usual_volume,
        }
    };
    let mut contenders = Vec::new();
    for structure in STRUCTURES.iter().copied() {
        if !structure.is_tree {
            contenders.push(Contender {
                structure,
                options: usual.clone(),
            });
            continue;
        }
        for builder in BUILDERS {
            for volume in structure.volumes() {
                if all || is_chosen(&structure, builder, volume.name) {
                    let options = BuildOptions {
                        volume: volume.name,
                        ..BuildOptions::with(*builder)
                    };
                    contenders.push(Contender { structure, options });
                }
            }
        }
    }
    contenders.sort_by_key(|contender| !contender.is_list());
    contenders
}

/// Every structure with the default options.
pub(crate) fn usual_contenders() -> Vec<Contender> {
    let usual = |structure: &Structure| Contender {
        structure: *structure,
        options: BuildOptions::default(),
    };
    STRUCTURES.iter().map(usual).collect()
}

/// The rays through the centres of pixels: an even choice of about `count`, or all, in blocks of 8 x 8 as a renderer
/// asks for them.
pub(crate) fn camera_rays(view: &View, count: usize) -> Vec<Ray> {
    let (width, height) = (u64::from(view.width()), u64::from(view.height()));
    let pixels = width * height;
    let count = (count as u64).clamp(1, pixels);
    if count == pixels {
        return all_camera_rays(view);
    }
    (0..count)
        .map(|i| scattered(i) % pixels)
        .map(|p| view.pixel_ray((p % width) as u32, (p / width) as u32))
        .collect()
}

/// Block by block, row by row in each.
fn all_camera_rays(view: &View) -> Vec<Ray> {
    const SIDE: u32 = 8;
    let starts = |length: u32| (0..length).step_by(SIDE as usize);
    let block = |start: u32, length: u32| start..length.min(start + SIDE);
    let (width, height) = (view.width(), view.height());
    let corners = starts(height).flat_map(|y| starts(width).map(move |x| [x, y]));
    corners
        .flat_map(|[x, y]| {
            block(y, height).flat_map(move |y| block(x, width).map(move |x| view.pixel_ray(x, y)))
        })
        .collect()
}

/// Random lines: uniform over all lines that meet a sphere twice as large as the one around the box of the scene, and
/// beginning on it. (A line between two independent uniform points of a sphere is that.)
pub(crate) fn random_rays(scene: &Scene, count: usize) -> Vec<Ray> {
    let bounds = scene.bounds();
    let center = Vec3::from(bounds.center());
    let radius = (bounds.diagonal() as f32).max(f32::MIN_POSITIVE);
    let center = if center.is_finite() {
        center
    } else {
        Vec3::ZERO
    };
    let on_sphere = |i: usize| center + radius * on_unit_sphere(i as u64);
    (0..count)
        .map(|i| {
            Ray::new(
                on_sphere(2 * i).into(),
                (on_sphere(2 * i + 1) - on_sphere(2 * i)).into(),
            )
        })
        .collect()
}

/// From where the given rays end, in random directions: what shadows and bounces ask.
pub(crate) fn bounced_rays(scene: &Scene, rays: &[Ray]) -> Vec<Ray> {
    let mut hits = vec![None; rays.len()];
    scene.closest_hits(rays, &mut hits);
    let size = scene.bounds().diagonal() as f32;
    let bounce = |(i, (ray, hit)): (usize, (&Ray, &Option<boxwood::Hit>))| {
        let hit = hit.as_ref()?;
        let normal = Vec3::from(scene.normal(hit)?).normalize_or_zero();
        let towards = if normal.dot(ray.dir.into()) > 0.0 {
            -normal
        } else {
            normal
        };
        let point = Vec3::from(ray.at(hit.t)) + towards * (1e-4 * size);
        Some(Ray::new(
            point.into(),
            (towards + on_unit_sphere(i as u64) * 0.999).into(),
        ))
    };
    rays.iter()
        .zip(&hits)
        .enumerate()
        .filter_map(bounce)
        .collect()
}

/// Uniform (Marsaglia, "Choosing a Point from the Surface of a Sphere", 1972), the same for the same number.
fn on_unit_sphere(number: u64) -> Vec3 {
    for attempt in 0.. {
        let bits = scattered(number.wrapping_mul(1 << 20).wrapping_add(attempt));
        let signed = |bits: u64| (bits & 0xFF_FFFF) as f32 / (1 << 23) as f32 - 1.0;
        let (x, y) = (signed(bits), signed(bits >> 24));
        let square = x * x + y * y;
        if square < 1.0 {
            let across = 2.0 * (1.0 - square).sqrt();
            return Vec3::new(x * across, y * across, 1.0 - 2.0 * square);
        }
    }
    Vec3::X
}

/// The finaliser of SplitMix64.
fn scattered(number: u64) -> u64 {
    let x = number.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_choice_has_every_structure_builder_and_volume() {
        let names: Vec<String> = contenders(false).iter().map(Contender::name).collect();
        assert_eq!(names[0], "list");
        for word in STRUCTURES
            .iter()
            .map(|s| s.name)
            .chain(BUILDERS.iter().map(|b| b.name))
        {
            assert!(
                names.iter().any(|name| name.contains(word)),
                "{word} of {names:?}"
            );
        }
        let of = |s: &Structure| match s.is_tree {
            true => BUILDERS.len() * s.volumes().len(),
            false => 1,
        };
        let all = STRUCTURES.iter().map(of).sum::<usize>();
        assert_eq!(contenders(true).len(), all);
        assert!(names.len() < all / 2);
    }

    #[test]
    fn all_pixels_come_in_blocks_each_once() {
        let camera = boxwood_scene::Camera {
            eye: [0.0, 0.0, 5.0],
            target: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            fov: 40.0,
        };
        let view = View::new(camera, 19, 11).unwrap();
        let rays = camera_rays(&view, usize::MAX);
        assert_eq!(rays[9], view.pixel_ray(1, 1));
        assert_eq!(rays[64], view.pixel_ray(8, 0));
        let place = |ray: &Ray| ray.dir.map(f32::to_bits);
        let mut found: Vec<_> = rays.iter().map(place).collect();
        let pixels = (0..19 * 11).map(|i| view.pixel_ray(i % 19, i / 19));
        let mut expected: Vec<_> = pixels.map(|ray| place(&ray)).collect();
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!(found, expected);
    }

    #[test]
    fn points_of_the_sphere_are_spread_evenly() {
        let mean = (0..10_000).map(on_unit_sphere).sum::<Vec3>() / 10_000.0;
        assert!(mean.length() < 0.03, "{mean}");
        assert!((0..100).all(|i| (on_unit_sphere(i).length() - 1.0).abs() < 1e-5));
        let upper = (0..10_000).filter(|i| on_unit_sphere(*i).z > 0.5).count();
        assert!(
            (2300..2700).contains(&upper),
            "a quarter of the area: {upper}"
        );
    }
}
