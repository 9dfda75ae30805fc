//! What builders compare boxes by.

use super::fragment::extent;
use crate::geom::Aabb;
use fearless_simd::{Simd, SimdBase, f32x8};

/// The area of boxes, relative to the largest extent of all, so that single precision is enough for any scene.
#[derive(Clone, Copy)]
pub(super) struct Measure(f32);

/// Padding of each side.
const PAD: f32 = 1.0 / (1 << 20) as f32;

impl Measure {
    pub(super) fn new(all: &Aabb) -> Self {
        let [x, y, z] = all.extent();
        let scale = 1.0 / x.max(y).max(z);
        // All in one point: only the padding counts.
        Self(if scale < f32::INFINITY { scale } else { 0.0 })
    }

    /// Half of the surface, of a box that is padded as rays see it: so that points and lines have an area too.
    #[inline]
    pub(super) fn area(self, bounds: &Aabb) -> f32 {
        let [x, y, z] = bounds.extent().map(|e| e * self.0 + PAD);
        x * (y + z) + y * z
    }

    /// The same of a box as lanes.
    #[inline(always)]
    pub(super) fn area_of<S: Simd>(self, lanes: f32x8<S>) -> f32 {
        let scaled = extent(lanes) * self.0 + PAD;
        let [x, y, z, _] = scaled.to_array();
        x * (y + z) + y * z
    }
}
