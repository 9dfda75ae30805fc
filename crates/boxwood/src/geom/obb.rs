//! The oriented bounding box.

/// A box turned any way: the points `center + x axes[0] + y axes[1] + z axes[2]` with `|x| <= half[0]` and so on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obb {
    /// Middle.
    pub center: [f32; 3],
    /// Orthonormal to rounding, right-handed.
    pub axes: [[f32; 3]; 3],
    /// Half side lengths along the axes; negative for the empty box.
    pub half: [f32; 3],
}

impl Obb {
    /// All eight corners.
    pub fn corners(&self) -> [[f32; 3]; 8] {
        std::array::from_fn(|i| {
            let along = |axis: usize| {
                if i >> axis & 1 == 0 {
                    -self.half[axis]
                } else {
                    self.half[axis]
                }
            };
            std::array::from_fn(|k| {
                let offset: f64 = (0..3)
                    .map(|axis| f64::from(along(axis)) * f64::from(self.axes[axis][k]))
                    .sum();
                (f64::from(self.center[k]) + offset) as f32
            })
        })
    }

    /// A point in the box's own frame: coordinates along its axes from its centre. 9 products, 9 additions.
    #[inline]
    pub fn in_frame(&self, point: [f64; 3]) -> [f64; 3] {
        let d: [f64; 3] = std::array::from_fn(|k| point[k] - f64::from(self.center[k]));
        self.turn(d)
    }

    /// A direction in the box's own frame.
    #[inline]
    pub fn turn(&self, dir: [f64; 3]) -> [f64; 3] {
        self.axes
            .map(|axis| (0..3).map(|k| f64::from(axis[k]) * dir[k]).sum())
    }
}
