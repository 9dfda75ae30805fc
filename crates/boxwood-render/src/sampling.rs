//! Random points on spheres, disks and hemispheres from pairs of random numbers in `0..1`.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use glam::Vec3;

/// Sine and cosine by pure Rust, the same on every machine.
pub(crate) fn sin_cos(angle: f32) -> (f32, f32) {
    libm::sincosf(angle)
}

/// Uniform on the unit disk (Shirley and Chiu, "A Low Distortion Map", 1997).
pub(crate) fn disk([a, b]: [f32; 2]) -> (f32, f32) {
    let (x, y) = (2.0 * a - 1.0, 2.0 * b - 1.0);
    if x == 0.0 && y == 0.0 {
        return (0.0, 0.0);
    }
    let (radius, angle) = if x.abs() > y.abs() {
        (x, FRAC_PI_4 * (y / x))
    } else {
        (y, FRAC_PI_2 - FRAC_PI_4 * (x / y))
    };
    let (sin, cos) = sin_cos(angle);
    (radius * cos, radius * sin)
}

/// Uniform on the unit sphere.
pub(crate) fn sphere([a, b]: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * a;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = sin_cos(TAU * b);
    Vec3::new(radius * cos, radius * sin, z)
}

/// Around the unit vector `normal`, dense as the cosine to it; density `cosine / PI` (Malley's
/// method).
pub(crate) fn cosine_hemisphere(normal: Vec3, pair: [f32; 2]) -> Vec3 {
    let (x, y) = disk(pair);
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    (tangent * x + bitangent * y + normal * (1.0 - x * x - y * y).max(0.0).sqrt()).normalize()
}

/// The density of [`cosine_hemisphere`] over solid angle.
pub(crate) fn cosine_density(cosine: f32) -> f32 {
    cosine.max(0.0) / PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Sampler;

    #[test]
    fn directions_stand_around_the_normal_with_a_mean_cosine_of_two_thirds() {
        let normal = Vec3::new(0.48, -0.64, 0.6);
        let n = 1024;
        let cosines: Vec<f32> = (0..n)
            .map(|i| cosine_hemisphere(normal, Sampler::new(3, 0, 0, i).next_pair()).dot(normal))
            .collect();
        assert!(cosines.iter().all(|&c| (0.0..=1.0001).contains(&c)));
        assert!((cosines.iter().sum::<f32>() / n as f32 - 2.0 / 3.0).abs() < 0.005);
    }

    #[test]
    fn points_of_disk_and_sphere_are_spread_evenly() {
        let n = 1024;
        let pairs = || (0..n).map(|i| Sampler::new(5, 0, 0, i).next_pair());
        let inner = pairs()
            .map(disk)
            .filter(|(x, y)| x * x + y * y < 0.25)
            .count();
        assert!((inner as f32 / n as f32 - 0.25).abs() < 0.01);
        let mean = pairs().map(sphere).sum::<Vec3>() / n as f32;
        assert!(mean.length() < 0.01, "{mean}");
    }
}
