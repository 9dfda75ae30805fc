//! *Ray tracing is expensive. How expensive?* The slides' multiplication.

use super::cramer;

/// One frame by brute force: every pixel against every triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Price {
    /// In pixels.
    pub width: u64,
    /// In pixels.
    pub height: u64,
    /// In the scene.
    pub triangles: u64,
    /// Per ray and triangle.
    pub flops_per_test: u64,
}

impl Price {
    /// The slides' frame, 1280 x 720 at 27 operations a test.
    pub const fn of_720p(triangles: u64) -> Self {
        Self {
            width: 1280,
            height: 720,
            triangles,
            flops_per_test: cramer::SLIDE_FLOPS as u64,
        }
    }

    /// Rays of a frame.
    pub const fn pixels(&self) -> u64 {
        self.width.saturating_mul(self.height)
    }

    /// Operations of a frame; saturates.
    pub const fn flops(&self) -> u64 {
        self.pixels()
            .saturating_mul(self.triangles)
            .saturating_mul(self.flops_per_test)
    }

    /// Seconds per frame on a machine of `gigaflops` (10^9 operations a second).
    pub fn seconds_at(&self, gigaflops: f64) -> f64 {
        self.flops() as f64 / (gigaflops * 1e9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slides_numbers() {
        assert_eq!(Price::of_720p(114).pixels(), 921_600);
        assert_eq!(Price::of_720p(114).flops(), 2_836_684_800);
        assert_eq!(Price::of_720p(40_000).flops(), 995_328_000_000);
        assert!((Price::of_720p(40_000).seconds_at(100.0) - 9.953_28).abs() < 1e-9);
    }

    #[test]
    fn absurd_sizes_saturate() {
        let price = Price {
            width: u64::MAX,
            height: 2,
            triangles: 3,
            flops_per_test: 27,
        };
        assert_eq!(price.flops(), u64::MAX);
    }
}
