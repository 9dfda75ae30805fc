//! How a surface throws light back: glTF's metallic-roughness model.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use crate::{
    Surface,
    sampler::Sampler,
    sampling,
    sampling::{cosine_density, cosine_hemisphere},
};

/// Narrowest highlight: `alpha` is the roughness squared, and a perfect mirror has no density.
const MIN_ALPHA: f32 = 0.003;
/// What a dielectric reflects at right angles (refractive index 1.5).
const DIELECTRIC: f32 = 0.04;

/// A surface as seen from the unit direction `out`: a matte part and a rough mirror.
///
/// Lambert below, above it GGX microfacets with height-correlated Smith shadowing and Schlick's
/// Fresnel term. Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR
/// 2007; Heitz, JCGT 2014. Light that bounces twice between microfacets is lost, up to some tenths
/// for rough metal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bsdf {
    face_normal: Vec3,
    normal: Vec3,
    tangent: Vec3,
    bitangent: Vec3,
    /// In the frame of the normal.
    out: Vec3,
    diffuse: Vec3,
    /// Reflection at right angles.
    f0: Vec3,
    alpha: f32,
    /// Probability of sampling the mirror part.
    choose_specular: f32,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounce {
    /// Where the light comes from, unit.
    pub(crate) dir: Vec3,
    /// BSDF times cosine, divided by the density.
    pub(crate) weight: Vec3,
    /// Density over solid angle.
    pub(crate) pdf: f32,
}

impl Bsdf {
    /// `out` points from the surface to the viewer. `blur` is the least width of the highlight, 0
    /// to 1 in terms of [`Bsdf::alpha`].
    pub(crate) fn new(surface: &Surface, out: Vec3, blur: f32) -> Self {
        // A shading normal that faces away from the viewer would be black: there the flat one takes
        // over.
        let normal = if surface.normal.dot(out) > 1e-3 {
            surface.normal
        } else {
            surface.face_normal
        };
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let f0 = Vec3::splat(DIELECTRIC).lerp(surface.base_color, surface.metallic);
        let local_out = Vec3::new(
            tangent.dot(out),
            bitangent.dot(out),
            normal.dot(out).max(1e-4),
        );
        let diffuse = surface.base_color * (1.0 - surface.metallic);
        let mirror = fresnel(f0, local_out.z).max_element();
        let matte = diffuse.max_element() * (1.0 - mirror);
        let choose_specular = if matte <= 0.0 {
            1.0
        } else {
            (mirror / (mirror + matte)).clamp(0.1, 0.9)
        };
        Self {
            face_normal: surface.face_normal,
            normal,
            tangent,
            bitangent,
            out: local_out,
            diffuse,
            f0,
            alpha: (surface.roughness * surface.roughness)
                .max(blur)
                .max(MIN_ALPHA),
            choose_specular,
        }
    }

    /// BSDF times cosine, and the density with which [`Bsdf::sample`] gives `dir`.
    pub(crate) fn eval(&self, dir: Vec3) -> (Vec3, f32) {
        let incoming = Vec3::new(
            self.tangent.dot(dir),
            self.bitangent.dot(dir),
            self.normal.dot(dir),
        );
        if incoming.z <= 0.0 || self.face_normal.dot(dir) <= 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        let half = (incoming + self.out).normalize();
        let reflected = fresnel(self.f0, half.dot(self.out).clamp(0.0, 1.0));
        let density = self.normal_density(half);
        let (lambda_in, lambda_out) = (self.lambda(incoming), self.lambda(self.out));
        // The cosine of the incoming light cancels against the microfacet model's.
        let mirror = reflected * (density / (4.0 * self.out.z * (1.0 + lambda_in + lambda_out)));
        // Light enters the body and leaves it again through the boundary.
        let enters = (1.0 - self.kept_out(incoming.z)) * (1.0 - self.kept_out(self.out.z));
        let matte = self.diffuse * enters * (incoming.z / PI);
        let mirror_pdf = density / (4.0 * self.out.z * (1.0 + lambda_out));
        let pdf = self.choose_specular * mirror_pdf
            + (1.0 - self.choose_specular) * cosine_density(incoming.z);
        (mirror + matte, pdf)
    }

    /// A direction for the next ray; none where the sample falls below the surface.
    pub(crate) fn sample(&self, sampler: &mut Sampler) -> Option<Bounce> {
        let choice = sampler.next();
        let pair = sampler.next_pair();
        let dir = if choice < self.choose_specular {
            let half = self.visible_normal(pair);
            let local = half * (2.0 * half.dot(self.out)) - self.out;
            self.tangent * local.x + self.bitangent * local.y + self.normal * local.z
        } else {
            cosine_hemisphere(self.normal, pair)
        }
        .normalize();
        let (value, pdf) = self.eval(dir);
        let weight = value / pdf;
        (pdf > 0.0 && weight.is_finite()).then_some(Bounce { dir, weight, pdf })
    }

    /// The share of light that does not reach the matte body: what a dielectric's boundary
    /// reflects, less towards grazing angles where it is rough (Lagarde, "Adopting a physically
    /// based shading model", 2011).
    fn kept_out(&self, cosine: f32) -> f32 {
        let most = (1.0 - self.alpha.sqrt()).max(DIELECTRIC);
        let x = 1.0 - cosine.clamp(0.0, 1.0);
        DIELECTRIC + (most - DIELECTRIC) * (x * x * x * x * x)
    }

    /// GGX distribution of microfacet normals.
    fn normal_density(&self, half: Vec3) -> f32 {
        let a2 = self.alpha * self.alpha;
        let stretched = half.x * half.x + half.y * half.y + half.z * half.z * a2;
        a2 / (PI * stretched * stretched)
    }

    /// Smith's auxiliary function: shadowing is `1 / (1 + lambda)`.
    fn lambda(&self, dir: Vec3) -> f32 {
        let tan2 = (dir.x * dir.x + dir.y * dir.y) / (dir.z * dir.z);
        0.5 * ((1.0 + self.alpha * self.alpha * tan2).sqrt() - 1.0)
    }

    /// A microfacet normal as the viewer sees them (Dupuy and Benyoub, "Sampling Visible GGX
    /// Normals with Spherical Caps", HPG 2023).
    fn visible_normal(&self, [a, b]: [f32; 2]) -> Vec3 {
        let stretched =
            Vec3::new(self.out.x * self.alpha, self.out.y * self.alpha, self.out.z).normalize();
        let z = (1.0 - a) * (1.0 + stretched.z) - stretched.z;
        let radius = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
        let (sin, cos) = sampling::sin_cos(TAU * b);
        let half = Vec3::new(radius * cos, radius * sin, z) + stretched;
        Vec3::new(half.x * self.alpha, half.y * self.alpha, half.z.max(1e-6)).normalize()
    }
}

/// The share of light that a boundary reflects (Schlick, 1994).
pub(crate) fn fresnel(f0: Vec3, cosine: f32) -> Vec3 {
    let x = 1.0 - cosine.clamp(0.0, 1.0);
    f0 + (Vec3::ONE - f0) * (x * x * x * x * x)
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;

    fn surface(metallic: f32, roughness: f32) -> Surface {
        Surface {
            position: Vec3::ZERO,
            face_normal: Vec3::Z,
            normal: Vec3::Z,
            back: false,
            uv: Vec2::ZERO,
            base_color: Vec3::ONE,
            emission: Vec3::ZERO,
            metallic,
            roughness,
            fade: 0.0,
        }
    }

    #[test]
    fn a_white_surface_gives_back_no_more_light_than_it_gets() {
        for metallic in [0.0, 0.5, 1.0] {
            for roughness in [0.0, 0.2, 0.6, 1.0] {
                for slant in [0.1f32, 0.7, 1.4] {
                    let out = Vec3::new(slant.sin(), 0.0, slant.cos());
                    let bsdf = Bsdf::new(&surface(metallic, roughness), out, 0.0);
                    let n = 1024;
                    let total: f32 = (0..n)
                        .filter_map(|i| bsdf.sample(&mut Sampler::new(0, 9, 4, i)))
                        .map(|bounce| bounce.weight.x)
                        .sum();
                    let albedo = total / n as f32;
                    assert!(
                        (0.3..1.02).contains(&albedo),
                        "{metallic} {roughness} {slant}: {albedo}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_roughest_metal_keeps_as_much_as_the_integral_says() {
        let bsdf = Bsdf::new(&surface(1.0, 1.0), Vec3::Z, 0.0);
        let n = 4096;
        let bounces = (0..n).filter_map(|i| bsdf.sample(&mut Sampler::new(0, 2, 7, i)));
        let albedo = bounces.map(|bounce| bounce.weight.x).sum::<f32>() / n as f32;
        // For alpha = 1 and a white metal seen along the normal: the integral of c / (1 + c) over
        // 0..1.
        assert!((albedo - (1.0 - 2f32.ln())).abs() < 0.005, "{albedo}");
    }

    #[test]
    fn the_density_integrates_to_one_where_nothing_falls_below_the_surface() {
        let bsdf = Bsdf::new(
            &surface(0.0, 0.5),
            Vec3::new(0.3, 0.1, 0.9).normalize(),
            0.0,
        );
        let n = 1 << 14;
        let sum: f32 = (0..n)
            .map(|i| {
                let dir = cosine_hemisphere(Vec3::Z, Sampler::new(1, 1, 1, i).next_pair());
                bsdf.eval(dir).1 / cosine_density(dir.z)
            })
            .sum();
        assert!((sum / n as f32 - 1.0).abs() < 0.02, "{}", sum / n as f32);
    }

    #[test]
    fn a_smooth_metal_reflects_along_the_mirror_direction() {
        let out = Vec3::new(0.6, 0.0, 0.8);
        let bounce = Bsdf::new(&surface(1.0, 0.0), out, 0.0)
            .sample(&mut Sampler::new(0, 0, 0, 0))
            .unwrap();
        assert!(
            (bounce.dir - Vec3::new(-0.6, 0.0, 0.8)).length() < 0.05,
            "{}",
            bounce.dir
        );
    }
}
