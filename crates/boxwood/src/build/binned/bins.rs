//! Bins along all axes, and the cheapest border between them.

use super::super::fragment::{Fragment, Lanes, LoadedScale, Scale, center2, extent};
use fearless_simd::{Select, Simd, SimdBase, f32x4, f32x8, mask32x4};

/// How many fragments are in each of `N` bins.
pub(super) trait Counter<const N: usize>: Copy {
    /// None anywhere.
    const ZERO: Self;

    /// One more in a bin.
    fn count(&mut self, bin: usize);

    /// How many are in each bin and those before it.
    fn up_to(&self) -> [u32; N];
}

impl<const N: usize> Counter<N> for [u32; N] {
    const ZERO: Self = [0; N];

    #[inline(always)]
    fn count(&mut self, bin: usize) {
        self[bin] += 1;
    }

    #[inline(always)]
    fn up_to(&self) -> [u32; N] {
        let mut sum = 0;
        self.map(|count| {
            sum += count;
            sum
        })
    }
}

/// Eight counts below 256 in all, a byte each: they stay in a register.
#[derive(Clone, Copy)]
pub(super) struct Packed(u64);

impl Counter<8> for Packed {
    const ZERO: Self = Self(0);

    #[inline(always)]
    fn count(&mut self, bin: usize) {
        self.0 += 1 << (8 * bin);
    }

    /// The product adds each byte to all above it.
    #[inline(always)]
    fn up_to(&self) -> [u32; 8] {
        let sums = self.0.wrapping_mul(0x0101_0101_0101_0101);
        sums.to_le_bytes().map(u32::from)
    }
}

/// Bins of so many fragments are computed before any is filled: a processor that does not know in time where it will store
/// guesses that a later load is from elsewhere, and starts again when it is not.
pub(super) const BLOCK: usize = 32;

/// The boxes of fragments by the bin of their centre, along each axis.
#[repr(C, align(64))]
pub(super) struct Table<const N: usize, C> {
    boxes: [[Lanes; N]; 3],
    counts: [C; 3],
}

/// A set as sorted into bins.
pub(super) struct Binned<const N: usize> {
    pub(super) scale: Scale,
    pub(super) table: Table<N, [u32; N]>,
}

impl<const N: usize> Binned<N> {
    pub(super) fn new() -> Self {
        Self {
            scale: Scale::new(&Lanes::EMPTY, 1),
            table: Table::new(),
        }
    }
}

impl<const N: usize, C: Counter<N>> Table<N, C> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self {
            boxes: [[Lanes::EMPTY; N]; 3],
            counts: [C::ZERO; 3],
        }
    }

    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.boxes = [[Lanes::EMPTY; N]; 3];
        self.counts = [C::ZERO; 3];
    }

    /// Adds a fragment with the bins that [`LoadedScale::bins`] gave.
    #[inline(always)]
    pub(super) fn add<S: Simd>(&mut self, simd: S, fragment: f32x8<S>, bins: [i32; 4]) {
        for axis in 0..3 {
            // `N` is a power of two: no check is left.
            let bin = bins[axis] as usize % N;
            let place = &mut self.boxes[axis][bin];
            place.store(place.load(simd).max(fragment));
            self.counts[axis].count(bin);
        }
    }

    #[inline(always)]
    pub(super) fn add_all<S: Simd>(
        &mut self,
        simd: S,
        fragments: &[Fragment],
        scale: &LoadedScale<S>,
    ) {
        // In registers, where they fit.
        let mut counts = self.counts;
        for block in fragments.chunks(BLOCK) {
            let mut bins = [[0; 4]; BLOCK];
            for (bins, fragment) in bins.iter_mut().zip(block) {
                *bins = scale.bins(center2(fragment.load(simd)));
            }
            for (bins, fragment) in bins.iter().zip(block) {
                let lanes = fragment.load(simd);
                for axis in 0..3 {
                    let bin = bins[axis] as usize % N;
                    let place = &mut self.boxes[axis][bin];
                    place.store(place.load(simd).max(lanes));
                    counts[axis].count(bin);
                }
            }
        }
        self.counts = counts;
    }
}

/// Where a set is best split.
#[derive(Clone, Copy, Debug)]
pub(super) struct Border {
    pub(super) axis: usize,
    /// The first bin of the right side.
    pub(super) bin: usize,
    /// How many are on the left side.
    pub(super) left_count: usize,
    /// The boxes around both sides.
    pub(super) boxes: [Lanes; 2],
    /// The sum over both sides of area times `count + extra`, relative to the area of the set.
    pub(super) cost: f32,
}

impl<const N: usize, C: Counter<N>> Table<N, C> {
    /// The cheapest border along any axis; the first of equals. `None` if all centres share a bin along each.
    ///
    /// `extra` is what a side costs beyond its primitives, in primitives.
    #[inline(always)]
    pub(super) fn best_border<S: Simd>(
        &self,
        simd: S,
        bounds: &Lanes,
        count: usize,
        extra: f32,
    ) -> Option<Border> {
        let measure = Measure::new(simd, bounds);
        let everywhere = f32x4::splat(simd, f32::INFINITY);
        let (mut least, mut place) = (everywhere, f32x4::splat(simd, 0.0));
        for axis in 0..3 {
            let (left, right) = self.sides(simd, axis, &measure);
            let below = self.counts[axis].up_to().map(|count| count as f32);
            for block in 0..N / 4 {
                let at = 4 * block;
                let counted = f32x4::from_slice(simd, &below[at..at + 4]);
                let others = f32x4::splat(simd, count as f32) - counted;
                let extra = f32x4::splat(simd, extra);
                let zero = f32x4::splat(simd, 0.0);
                let cost = areas(simd, &left, block) * (counted + extra)
                    + areas(simd, &right, block) * (others + extra);
                let is_real: mask32x4<S> = counted.simd_gt(zero) & others.simd_gt(zero);
                let cost = is_real.select(cost, everywhere);
                let is_less = cost.simd_lt(least);
                let here = f32x4::splat(simd, (axis * N + at) as f32);
                least = is_less.select(cost, least);
                place = is_less.select(here, place);
            }
        }
        let (least, place) = (least.to_array(), place.to_array());
        let number = |lane: usize| place[lane] as usize + lane;
        let best = (0..4).fold(0, |best, lane| {
            let is_less = least[lane] < least[best]
                || (least[lane] == least[best] && number(lane) < number(best));
            if is_less { lane } else { best }
        });
        if least[best] == f32::INFINITY {
            return None;
        }
        let (axis, bin) = (number(best) / N, number(best) % N + 1);
        Some(Border {
            axis,
            bin,
            left_count: self.counts[axis].up_to()[bin - 1] as usize,
            boxes: self.boxes_beside(simd, axis, bin),
            cost: least[best] / measure.area_of_all(),
        })
    }

    /// Every border with something on both sides, as [`Table::best_border`] weighs it: for explaining.
    pub(super) fn borders<S: Simd>(
        &self,
        simd: S,
        bounds: &Lanes,
        count: usize,
        extra: f32,
    ) -> Vec<Border> {
        let measure = Measure::new(simd, bounds);
        let half_area = |[x, y, z, _]: [f32; 4]| x * (y + z) + y * z;
        let mut borders = Vec::new();
        for axis in 0..3 {
            let (left, right) = self.sides(simd, axis, &measure);
            for (bin, below) in (1..N).zip(self.counts[axis].up_to()) {
                let others = count as u32 - below;
                if below > 0 && others > 0 {
                    let cost = half_area(left.0[bin - 1]) * (below as f32 + extra)
                        + half_area(right.0[bin - 1]) * (others as f32 + extra);
                    borders.push(Border {
                        axis,
                        bin,
                        left_count: below as usize,
                        boxes: self.boxes_beside(simd, axis, bin),
                        cost: cost / measure.area_of_all(),
                    });
                }
            }
        }
        borders
    }

    /// Extents of what is before and after each border; entry `i` is for the border after bin `i`.
    #[inline(always)]
    fn sides<S: Simd>(&self, simd: S, axis: usize, measure: &Measure<S>) -> (Rows<N>, Rows<N>) {
        let (mut left, mut right) = (Rows::ZERO, Rows::ZERO);
        let boxes = &self.boxes[axis];
        let mut all = Lanes::EMPTY.load(simd);
        for bin in 0..N - 1 {
            all = all.max(boxes[bin].load(simd));
            left.0[bin] = measure.padded_extent(all);
        }
        all = Lanes::EMPTY.load(simd);
        for bin in (0..N - 1).rev() {
            all = all.max(boxes[bin + 1].load(simd));
            right.0[bin] = measure.padded_extent(all);
        }
        (left, right)
    }

    #[inline(always)]
    fn boxes_beside<S: Simd>(&self, simd: S, axis: usize, border: usize) -> [Lanes; 2] {
        let around = |boxes: &[Lanes]| {
            let all = boxes
                .iter()
                .fold(Lanes::EMPTY.load(simd), |all, b| all.max(b.load(simd)));
            let mut lanes = Lanes::EMPTY;
            lanes.store(all);
            lanes
        };
        let (left, right) = self.boxes[axis].split_at(border);
        [around(left), around(right)]
    }
}

/// Extents, four numbers each.
#[repr(C, align(64))]
struct Rows<const N: usize>([[f32; 4]; N]);

impl<const N: usize> Rows<N> {
    const ZERO: Self = Self([[0.0; 4]; N]);
}

/// Half the areas of four boxes.
#[inline(always)]
fn areas<S: Simd, const N: usize>(simd: S, rows: &Rows<N>, block: usize) -> f32x4<S> {
    let four = rows.0[4 * block..4 * block + 4].as_flattened();
    let four: &[f32; 16] = four.try_into().unwrap_or(&[0.0; 16]);
    let [x, y, z, _] = simd.load_four_interleaved_f32x4(four);
    x * (y + z) + y * z
}

/// The extent of boxes relative to the largest of the set, so that single precision is enough at any scale; padded as
/// rays see them, so that points and lines have an area too.
struct Measure<S: Simd> {
    per_unit: f32x4<S>,
    pad: f32x4<S>,
    all: [f32; 4],
}

impl<S: Simd> Measure<S> {
    #[inline(always)]
    fn new(simd: S, bounds: &Lanes) -> Self {
        let [x, y, z, _] = extent(bounds.load(simd)).to_array();
        let per_unit = 1.0 / x.max(y).max(z);
        let per_unit = if per_unit < f32::INFINITY {
            per_unit
        } else {
            0.0
        };
        let mut measure = Self {
            per_unit: f32x4::splat(simd, per_unit),
            pad: f32x4::splat(simd, 1.0 / (1 << 20) as f32),
            all: [0.0; 4],
        };
        measure.all = measure.padded_extent(bounds.load(simd));
        measure
    }

    #[inline(always)]
    fn padded_extent(&self, lanes: f32x8<S>) -> [f32; 4] {
        (extent(lanes) * self.per_unit + self.pad).to_array()
    }

    #[inline(always)]
    fn area_of_all(&self) -> f32 {
        let [x, y, z, _] = self.all;
        x * (y + z) + y * z
    }
}
