//! The surface area heuristic, tried only at the borders of bins.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", IEEE RT 2007.

use super::top_down::{Reference, Set, Split, top_down};
use super::{BuildOptions, Topology};
use crate::geom::Aabb;
use glam::Vec3A;

pub(super) fn build(boxes: &[Aabb], options: &BuildOptions) -> Topology {
    let split = Binned {
        leaf_limit: options.leaf_limit(),
        bins: (options.bins as usize).clamp(2, MAX_BINS),
        primitive_cost: f64::from(options.primitive_cost),
    };
    top_down(boxes, options, &split)
}

const MAX_BINS: usize = 64;

struct Binned {
    leaf_limit: usize,
    bins: usize,
    primitive_cost: f64,
}

/// The boxes whose centres fall into one bin.
#[derive(Clone, Copy)]
struct Bin {
    min: Vec3A,
    max: Vec3A,
    count: u32,
}

impl Bin {
    const EMPTY: Self = Self {
        min: Vec3A::INFINITY,
        max: Vec3A::NEG_INFINITY,
        count: 0,
    };

    #[inline]
    fn add(&mut self, other: &Self) {
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
        self.count += other.count;
    }

    /// Area times count, by which a side of a split is judged.
    #[inline]
    fn cost(&self) -> f64 {
        let (min, max) = (self.min.to_array(), self.max.to_array());
        Aabb { min, max }.half_area() * f64::from(self.count)
    }
}

/// How centres are sorted into bins along all axes.
#[derive(Clone, Copy)]
struct Scale {
    lo: Vec3A,
    per_unit: Vec3A,
    last: f32,
}

/// Added to a number from 0 to 255 it rounds it and leaves it in the last byte: there are no digits for a fraction.
const ROUNDER: f32 = (1 << 23) as f32;

impl Scale {
    fn new(centers: &Aabb, bins: usize) -> Self {
        let (lo, hi) = (Vec3A::from(centers.min), Vec3A::from(centers.max));
        Self {
            lo,
            per_unit: bins as f32 / (hi - lo),
            last: (bins - 1) as f32,
        }
    }

    /// The bins of a doubled centre, plus [`ROUNDER`]. NaN goes to bin 0.
    #[inline]
    fn rounded(&self, center2: Vec3A) -> Vec3A {
        let place = (center2 - self.lo) * self.per_unit - 0.5;
        place.max(Vec3A::ZERO).min(Vec3A::splat(self.last)) + ROUNDER
    }

    /// The bins of a doubled centre.
    #[inline]
    fn bins(&self, center2: Vec3A) -> [usize; 3] {
        let [x, y, z] = self.rounded(center2).to_array();
        [x, y, z].map(|rounded| usize::from(rounded.to_bits() as u8))
    }

    /// True if the bin along `axis` is before `border`.
    #[inline]
    fn is_before(&self, center2: Vec3A, axis: usize, border: usize) -> bool {
        let border = Vec3A::splat(ROUNDER + border as f32);
        self.rounded(center2).cmplt(border).bitmask() >> axis & 1 == 1
    }
}

struct BestSplit {
    cost: f64,
    axis: usize,
    border: usize,
}

impl Split for Binned {
    fn split(&self, set: &mut Set<'_>) -> Option<usize> {
        let (all, centers) = set.bounds();
        let count = set.refs.len();
        let area = all.half_area();
        let leaf_cost = count as f64 * self.primitive_cost;
        // Few primitives do not fill many bins.
        let bins = self.bins.min(4 + count / 8);
        let scale = Scale::new(&centers, bins);
        // Most sets are small, and clearing many bins would take longer than filling few.
        let best = match bins {
            ..=8 => best_split::<8>(set.refs, &centers, scale, bins),
            9..=16 => best_split::<16>(set.refs, &centers, scale, bins),
            17..=32 => best_split::<32>(set.refs, &centers, scale, bins),
            _ => best_split::<MAX_BINS>(set.refs, &centers, scale, bins),
        }?;
        let split_cost = 1.0 + best.cost * self.primitive_cost / area;
        // Not `>=`: a NaN of two areas of 0 makes a leaf.
        if count <= self.leaf_limit && !(split_cost < leaf_cost) {
            return None;
        }
        Some(set.partition(|r| scale.is_before(r.center2(), best.axis, best.border)))
    }
}

/// The cheapest border along any axis. `None` if all centres share a bin.
fn best_split<const N: usize>(
    refs: &[Reference],
    centers: &Aabb,
    scale: Scale,
    bins: usize,
) -> Option<BestSplit> {
    let mut tables = [[Bin::EMPTY; N]; 3];
    for r in refs {
        let (min, max) = (Vec3A::from(r.bounds.min), Vec3A::from(r.bounds.max));
        let one = Bin { min, max, count: 1 };
        for (table, bin) in tables.iter_mut().zip(scale.bins(r.center2())) {
            table[bin].add(&one);
        }
    }
    (0..3)
        .filter(|&axis| centers.max[axis] > centers.min[axis])
        .filter_map(|axis| best_border::<N>(&tables[axis][..bins], axis))
        .min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// The cheapest border along one axis: [`Bin::cost`] of both sides.
fn best_border<const N: usize>(table: &[Bin], axis: usize) -> Option<BestSplit> {
    let mut right_costs = [0.0; N];
    let mut right = Bin::EMPTY;
    for (i, bin) in table.iter().enumerate().skip(1).rev() {
        right.add(bin);
        right_costs[i] = right.cost();
    }
    let count = right.count + table[0].count;
    let mut left = Bin::EMPTY;
    let mut best: Option<BestSplit> = None;
    for border in 1..table.len() {
        left.add(&table[border - 1]);
        let cost = left.cost() + right_costs[border];
        let real = left.count > 0 && left.count < count;
        if real && best.as_ref().is_none_or(|b| cost < b.cost) {
            best = Some(BestSplit { cost, axis, border });
        }
    }
    best
}
