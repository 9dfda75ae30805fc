//! Where a new ray starts on a surface.

use glam::Vec3;

/// Moves `point` off its surface to the side of the unit vector `normal`, just beyond the rounding
/// error of a hit point.
///
/// The step is 256 representable numbers per axis (times the normal), so that it suits every scale.
/// Nearer to zero than `extent / 32`, where the numbers stand too close, it is `extent / 65536`;
/// `extent` is the largest coordinate of the scene, at most 1. This keeps a surface from shadowing
/// itself.
///
/// Waechter and Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing
/// Gems, 2019.
pub(crate) fn offset_point(point: Vec3, normal: Vec3, extent: f32) -> Vec3 {
    let step = |p: f32, n: f32| {
        if p.abs() < extent / 32.0 {
            return p + n * (extent / 65_536.0);
        }
        let ulps = (256.0 * n) as i32;
        let towards = if p < 0.0 { -ulps } else { ulps };
        f32::from_bits(p.to_bits().wrapping_add_signed(towards))
    };
    Vec3::new(
        step(point.x, normal.x),
        step(point.y, normal.y),
        step(point.z, normal.z),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_goes_along_the_normal_at_every_scale() {
        for extent in [1e-4, 0.3, 1.0] {
            for scale in [0.0, 1e-3, 1.5, 3e4, 1e9] {
                for sign in [-1.0, 1.0] {
                    let point = Vec3::splat(scale * sign);
                    let normal = Vec3::new(0.6, -0.64, 0.48);
                    let moved = offset_point(point, normal, extent) - point;
                    assert!(moved.dot(normal) > 0.0, "{point} moved by {moved}");
                    assert!(
                        moved.length() <= 1e-4 * scale.max(extent),
                        "{point} moved by {moved}"
                    );
                }
            }
        }
    }
}
