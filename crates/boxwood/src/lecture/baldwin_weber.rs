//! A more efficient routine at the price of memory: everything that depends on the triangle alone is computed once.
//!
//! Baldwin and Weber, "Fast Ray-Triangle Intersections by Coordinate Transformation", JCGT 2016. An affine map takes the
//! triangle to (0,0), (1,0), (0,1) in the plane `w = 0`; of its twelve numbers three can be made 0 or 1 by choosing the axis in
//! which the triangle's normal is largest.

use super::{Barycentric, Exit};
use crate::geom::{Ray, Triangle};
use glam::Vec3;

/// What the code executes up to each [`Exit`]: `w` of origin and direction 5 + 4, quotient 1, two coordinates 4, then the first
/// weight 4, the second weight and the sum 5. All numbers are known at the last weight.
pub const FLOPS: [u32; 3] = [18, 23, 23];

/// A triangle made ready: 9 numbers and an axis, 40 bytes beside the vertices' 36.
#[derive(Clone, Copy, Debug)]
pub struct Precomputed {
    axis: usize,
    /// Factors of the two other coordinates, and the constant, for beta, gamma and w.
    beta: [f32; 3],
    gamma: [f32; 3],
    w: [f32; 3],
}

impl Precomputed {
    /// `None` for a triangle without area.
    pub fn new(triangle: &Triangle) -> Option<Self> {
        let [v0, v1, v2] = triangle.0.map(Vec3::from);
        let (e1, e2) = (v1 - v0, v2 - v0);
        let normal = e1.cross(e2);
        let axis = normal.abs().max_position();
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let n = normal[axis];
        let finite = |row: [f32; 3]| row.into_iter().all(f32::is_finite).then_some(row);
        Some(Self {
            axis,
            beta: finite([e2[j] / n, -e2[i] / n, (e2[i] * v0[j] - e2[j] * v0[i]) / n])?,
            gamma: finite([-e1[j] / n, e1[i] / n, (e1[j] * v0[i] - e1[i] * v0[j]) / n])?,
            w: finite([normal[i] / n, normal[j] / n, -normal.dot(v0) / n])?,
        })
    }

    /// `None` if the line misses the triangle, and where it was decided. `t` may lie outside the ray's range.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> (Option<Barycentric>, Exit) {
        let (k, i, j) = (self.axis, (self.axis + 1) % 3, (self.axis + 2) % 3);
        let (o, d) = (ray.origin, ray.dir);
        let height = o[k] + self.w[0] * o[i] + self.w[1] * o[j] + self.w[2];
        let speed = d[k] + self.w[0] * d[i] + self.w[1] * d[j];
        let t = -height / speed;
        let (x, y) = (o[i] + t * d[i], o[j] + t * d[j]);
        let beta = self.beta[0] * x + self.beta[1] * y + self.beta[2];
        if !(0.0..=1.0).contains(&beta) {
            return (None, Exit::Beta);
        }
        let gamma = self.gamma[0] * x + self.gamma[1] * y + self.gamma[2];
        if !(gamma >= 0.0 && beta + gamma <= 1.0) {
            return (None, Exit::Gamma);
        }
        (Some(Barycentric { beta, gamma, t }), Exit::Full)
    }
}
