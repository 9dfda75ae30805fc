//! Structures side by side: which ones, and the rays that all of them are asked about.

use std::time::Duration;

use boxwood::{
    BUILDERS, BuildOptions, Builder, Ray, STRUCTURES, Scene, Structure, VOLUMES, check::Variant,
};
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
            for volume in VOLUMES {
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

/// The rays through the centres of pixels, all or an even choice of about `count`.
pub(crate) fn camera_rays(view: &View, count: usize) -> Vec<Ray> {
    let (width, height) = (u64::from(view.width()), u64::from(view.height()));
    let pixels = width * height;
    let count = (count as u64).clamp(1, pixels);
    // Steps of the golden ratio visit the picture evenly.
    let pixel = |i: u64| {
        if count == pixels {
            i
        } else {
            scattered(i) % pixels
        }
    };
    (0..count)
        .map(pixel)
        .map(|p| view.pixel_ray((p % width) as u32, (p / width) as u32))
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
        let trees = STRUCTURES.iter().filter(|s| s.is_tree).count();
        let all = trees * BUILDERS.len() * VOLUMES.len() + STRUCTURES.len() - trees;
        assert_eq!(contenders(true).len(), all);
        assert!(names.len() < all / 2);
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
