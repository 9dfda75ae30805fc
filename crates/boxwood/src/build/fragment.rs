//! Primitives on their way into the tree, and how their centres are told apart.

use super::BuildInput;
use super::input::room;
use crate::error::BuildError;
use crate::geom::Aabb;
use fearless_simd::{Simd, SimdBase, SimdFloat, SimdInto, SimdSplit, f32x4, f32x8, i32x4};

/// A box as one vector: `-min`, a lane to spare, `max`, another one. So one `max` is a union.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(super) struct Lanes(pub(super) [f32; 8]);

/// A primitive: its box, and its number in the first lane to spare. Moved rather than pointed to.
pub(super) type Fragment = Lanes;

impl Lanes {
    /// Contains nothing.
    pub(super) const EMPTY: Self = Self([f32::NEG_INFINITY; 8]);

    pub(super) fn fragment(bounds: &Aabb, number: u32) -> Self {
        let ([a, b, c], [x, y, z]) = (bounds.min, bounds.max);
        // The 1 keeps the unused lane of the centre an ordinary number.
        Self([-a, -b, -c, f32::from_bits(number), x, y, z, 1.0])
    }

    /// The number of a fragment.
    #[inline(always)]
    pub(super) fn number(&self) -> u32 {
        self.0[3].to_bits()
    }

    #[inline(always)]
    pub(super) fn bounds(&self) -> Aabb {
        let [a, b, c, _, x, y, z, _] = self.0;
        Aabb {
            min: [-a, -b, -c],
            max: [x, y, z],
        }
    }

    /// Twice the centre along an axis.
    #[inline(always)]
    pub(super) fn center2_along(&self, axis: usize) -> f32 {
        self.0[4 + axis] - self.0[axis]
    }

    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S) -> f32x8<S> {
        f32x8::load_array_ref(simd, &self.0)
    }

    #[inline(always)]
    pub(super) fn store<S: Simd>(&mut self, value: f32x8<S>) {
        value.store_array(&mut self.0);
    }
}

/// The primitives of an input that can be hit.
pub(super) fn fragments(input: &BuildInput<'_>) -> Result<Vec<Fragment>, BuildError> {
    let mut fragments = room(input.boxes.len())?;
    let kept = |(bounds, _): &(&Aabb, u32)| bounds.is_in_domain();
    fragments.extend(
        input
            .boxes
            .iter()
            .zip(0..)
            .filter(kept)
            .map(|(bounds, prim)| Fragment::fragment(bounds, prim)),
    );
    Ok(fragments)
}

/// Twice the centre of a box.
#[inline(always)]
pub(super) fn center2<S: Simd>(lanes: f32x8<S>) -> f32x4<S> {
    let (negated_min, max) = lanes.split();
    max - negated_min
}

/// Sides of a box.
#[inline(always)]
pub(super) fn extent<S: Simd>(lanes: f32x8<S>) -> f32x4<S> {
    let (negated_min, max) = lanes.split();
    max + negated_min
}

/// The range of doubled centres, in the form of a box.
#[inline(always)]
pub(super) fn range_of_centers<S: Simd>(simd: S, fragments: &[Fragment]) -> Lanes {
    let (mut lo, mut hi) = (
        f32x4::splat(simd, f32::INFINITY),
        f32x4::splat(simd, f32::NEG_INFINITY),
    );
    for fragment in fragments {
        let center = center2(fragment.load(simd));
        (lo, hi) = (lo.min(center), hi.max(center));
    }
    let mut range = Lanes::EMPTY;
    range.store(simd.combine_f32x4(-lo, hi));
    range
}

/// The box around all.
#[inline(always)]
pub(super) fn box_around<S: Simd>(simd: S, fragments: &[Fragment]) -> Lanes {
    let all = fragments
        .iter()
        .fold(Lanes::EMPTY.load(simd), |all, f| all.max(f.load(simd)));
    let mut answer = Lanes::EMPTY;
    answer.store(all);
    answer
}

/// How doubled centres are sorted into bins along all axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    range: Lanes,
    lo: [f32; 4],
    per_unit: [f32; 4],
    bins: f32,
}

impl Scale {
    /// Equal bins over a range of doubled centres. An axis without extent has one bin.
    pub(super) fn new(range: &Lanes, bins: usize) -> Self {
        let [a, b, c, _, x, y, z, _] = range.0;
        let bins = bins as f32;
        let per_unit = |extent: f32| {
            let per_unit = bins / extent;
            if per_unit < f32::INFINITY {
                per_unit
            } else {
                0.0
            }
        };
        Self {
            range: *range,
            lo: [-a, -b, -c, 0.0],
            per_unit: [per_unit(x + a), per_unit(y + b), per_unit(z + c), 0.0],
            bins,
        }
    }

    /// The range on one side of a border, cut down to what centres of boxes in `bounds` can be.
    pub(super) fn range_beside(
        &self,
        axis: usize,
        border: usize,
        is_left: bool,
        bounds: &Lanes,
    ) -> Lanes {
        let mut side = self.range;
        let at = self.border(axis, border);
        if is_left {
            side.0[4 + axis] = at;
        } else {
            side.0[axis] = -at;
        }
        for (lane, bound) in side.0.iter_mut().zip(bounds.0) {
            *lane = lane.min(2.0 * bound);
        }
        side
    }

    /// The doubled coordinate of the face before a bin.
    #[inline]
    pub(super) fn border(&self, axis: usize, bin: usize) -> f32 {
        self.lo[axis] + bin as f32 / self.per_unit[axis]
    }

    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S) -> LoadedScale<S> {
        LoadedScale {
            lo: f32x4::load_array_ref(simd, &self.lo),
            per_unit: f32x4::load_array_ref(simd, &self.per_unit),
            last: f32x4::splat(simd, self.bins - 1.0),
        }
    }
}

/// A [`Scale`] in registers.
#[derive(Clone, Copy)]
pub(super) struct LoadedScale<S: Simd> {
    lo: f32x4<S>,
    per_unit: f32x4<S>,
    last: f32x4<S>,
}

impl<S: Simd> LoadedScale<S> {
    /// Places along the axes in units of bins, before they are cut to whole ones.
    #[inline(always)]
    pub(super) fn places(&self, center2: f32x4<S>) -> f32x4<S> {
        (center2 - self.lo) * self.per_unit
    }

    /// The bins of a doubled centre, and something.
    #[inline(always)]
    pub(super) fn bins(&self, center2: f32x4<S>) -> [i32; 4] {
        let zero: f32x4<S> = 0.0.simd_into(self.lo.simd);
        let inside = self.places(center2).max(zero).min(self.last);
        inside.to_int::<i32x4<S>>().to_array()
    }
}
