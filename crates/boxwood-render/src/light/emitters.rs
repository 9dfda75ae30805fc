//! Glowing triangles as lamps.

use glam::Vec3;

use super::LightSample;
use crate::{Surfaces, tone::luminance};

/// The triangles whose material glows, each chosen with a probability proportional to its area
/// times its luminance.
#[derive(Clone, Debug, Default)]
pub(crate) struct Emitters {
    triangles: Vec<Emitter>,
    /// Sum of area times luminance up to and including each triangle.
    power_up_to: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
struct Emitter {
    corners: [Vec3; 3],
    emission: Vec3,
}

impl Emitters {
    /// `O(n)` over all triangles; those without an area are left out.
    pub(crate) fn of(surfaces: Surfaces<'_>) -> Self {
        let mut all = Self::default();
        let mut sum = 0.0;
        if !surfaces.has_lights() {
            return all;
        }
        for (inst, prim, corners) in surfaces.shown() {
            let Some(material) = surfaces.material(inst, prim) else {
                continue;
            };
            let emission = Vec3::from(material.emission);
            let power =
                f64::from(luminance(emission)) * f64::from(scaled_normal(corners).length() * 0.5);
            if power > 0.0 && power.is_finite() {
                sum += power;
                all.triangles.push(Emitter { corners, emission });
                all.power_up_to.push(sum);
            }
        }
        all
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// A point on a glowing triangle as seen from `position`.
    pub(crate) fn sample(&self, position: Vec3, [pick, spread]: [f32; 2]) -> Option<LightSample> {
        let total = *self.power_up_to.last()?;
        let target = f64::from(pick) * total;
        let index = self
            .power_up_to
            .partition_point(|&sum| sum <= target)
            .min(self.triangles.len() - 1);
        let below = if index == 0 {
            0.0
        } else {
            self.power_up_to[index - 1]
        };
        // The rest of `pick` within its triangle is a fresh random number.
        let rest = ((target - below) / (self.power_up_to[index] - below)) as f32;

        let Emitter {
            corners: [a, b, c],
            emission,
        } = self.triangles[index];
        let root = rest.clamp(0.0, 1.0).sqrt();
        let point = a * (1.0 - root) + b * (root * (1.0 - spread)) + c * (root * spread);
        let way = point - position;
        let distance = way.length();
        let dir = way / distance;
        let cosine = scaled_normal([a, b, c]).normalize_or_zero().dot(dir).abs();
        let pdf = self.density(emission, distance, cosine);
        (distance > 0.0 && pdf > 0.0 && pdf.is_finite()).then(|| LightSample {
            dir,
            distance,
            light: emission / pdf,
            pdf,
        })
    }

    /// The density over solid angle with which [`Emitters::sample`] chooses a point at `distance`
    /// on a surface with this `emission`, seen under the absolute `cosine` to its normal.
    pub(crate) fn density(&self, emission: Vec3, distance: f32, cosine: f32) -> f32 {
        let Some(&total) = self.power_up_to.last() else {
            return 0.0;
        };
        if cosine <= 0.0 {
            return 0.0;
        }
        (f64::from(luminance(emission)) / total) as f32 * (distance * distance / cosine)
    }
}

/// Along the face normal, twice the area long.
fn scaled_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests {
    use boxwood_scene::{FlatMesh, Material, Model};

    use super::*;
    use crate::sampler::Sampler;

    #[test]
    fn a_glowing_square_lights_a_point_as_the_form_factor_says() {
        let mesh = FlatMesh {
            positions: vec![
                [-1.0, 2.0, -1.0],
                [1.0, 2.0, -1.0],
                [1.0, 2.0, 1.0],
                [-1.0, 2.0, 1.0],
            ],
            indices: vec![[0, 1, 2], [0, 2, 3]],
            material_of: vec![0, 0],
            ..FlatMesh::default()
        };
        let glow = Material {
            emission: [3.0; 3],
            ..Material::default()
        };
        let model = Model {
            materials: vec![glow],
            ..Model::default()
        };
        let emitters = Emitters::of(Surfaces::new(&mesh, &model));
        let samples = 4096;
        let mut sum = 0.0;
        for sample in 0..samples {
            let light = emitters
                .sample(Vec3::ZERO, Sampler::new(0, 1, 2, sample).next_pair())
                .unwrap();
            sum += light.light.x * light.dir.y;
        }
        // Form factor from a patch to a parallel rectangle above its corner (a = b = 1, c = 2),
        // four times.
        let x = 0.5f32;
        let quarter = 2.0 / (2.0 * std::f32::consts::PI)
            * (x / (1.0 + x * x).sqrt() * (x / (1.0 + x * x).sqrt()).atan());
        let expected = 3.0 * std::f32::consts::PI * 4.0 * quarter;
        let got = sum / samples as f32;
        assert!(
            (got / expected - 1.0).abs() < 0.01,
            "{got} instead of {expected}"
        );
    }
}
