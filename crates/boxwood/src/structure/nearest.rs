//! The nearest place known while a structure is asked for the nearest of all.

use crate::geom::{Foot, MAX_COORDINATE, Nearest, Triangle};
use crate::prims::Primitives;

/// The nearest triangle known.
#[derive(Clone, Copy)]
pub(crate) struct NearestPlace {
    foot: Foot,
    prim: u32,
    triangle: Triangle,
}

impl NearestPlace {
    pub(crate) const NONE: Self = Self {
        foot: Foot {
            squared: f64::INFINITY,
            u: 0.0,
            v: 0.0,
        },
        prim: u32::MAX,
        triangle: Triangle([[0.0; 3]; 3]),
    };

    /// Looks at one triangle: of equally near ones the first counts.
    pub(crate) fn look(&mut self, triangle: &Triangle, prim: u32, point: &[f32; 3]) {
        self.take(triangle, prim, triangle.nearest(point));
    }

    /// The same where the nearest place of the triangle is known. True if it is the nearest of all now.
    #[inline(always)]
    pub(crate) fn take(&mut self, triangle: &Triangle, prim: u32, foot: Foot) -> bool {
        let is_nearer = foot.squared < self.foot.squared
            || foot.squared == self.foot.squared && prim < self.prim;
        if is_nearer {
            *self = Self {
                foot,
                prim,
                triangle: *triangle,
            };
        }
        is_nearer
    }

    /// Nothing farther than this matters; a little more than it is, for comparisons in single precision.
    pub(crate) fn reach(&self) -> f32 {
        const SLACK: f64 = 1.0 + 1.0 / (1 << 20) as f64;
        ((self.foot.squared.sqrt() * SLACK) as f32).min(f32::MAX)
    }

    pub(crate) fn answer(&self) -> Option<Nearest> {
        (self.prim != u32::MAX).then(|| Nearest {
            point: self
                .triangle
                .place(self.foot.u, self.foot.v)
                .map(|x| x as f32),
            distance: self.foot.squared.sqrt() as f32,
            u: self.foot.u as f32,
            v: self.foot.v as f32,
            prim: self.prim,
            geom: 0,
        })
    }
}

/// True for what may be asked: a point that is finite, and not beyond [`MAX_COORDINATE`].
pub(crate) fn is_in_domain(point: &[f32; 3]) -> bool {
    point.iter().all(|x| x.abs() <= MAX_COORDINATE)
}

/// Asks every triangle; `ids` gives places in `prims` and their numbers.
pub(crate) fn nearest_of_all<P: Primitives>(
    prims: &P,
    ids: impl Iterator<Item = (usize, u32)>,
    point: &[f32; 3],
) -> Option<Nearest> {
    let mut known = NearestPlace::NONE;
    for (place, prim) in ids {
        if let Some(triangle) = prims.triangle(place) {
            known.look(triangle, prim, point);
        }
    }
    known.answer()
}
