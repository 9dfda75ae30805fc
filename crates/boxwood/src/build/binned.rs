//! The surface area heuristic, tried only at the borders of bins.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", IEEE RT 2007.

use super::top_down::{Reference, Set, Split, top_down};
use super::{BuildOptions, Topology};
use crate::geom::Aabb;

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

#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: u32,
}

const EMPTY_BIN: Bin = Bin {
    bounds: Aabb::EMPTY,
    count: 0,
};

/// How centres are sorted into bins along one axis.
#[derive(Clone, Copy)]
struct Scale {
    lo: f32,
    per_unit: f32,
    last: usize,
}

impl Scale {
    fn new(centers: &Aabb, axis: usize, bins: usize) -> Self {
        let per_unit = bins as f32 * 0.9999 / (centers.max[axis] - centers.min[axis]);
        Self {
            lo: centers.min[axis],
            per_unit,
            last: bins - 1,
        }
    }

    /// The bin of a doubled centre. Total: the cast saturates, and NaN goes to bin 0.
    #[inline]
    fn bin(&self, center2: f32) -> usize {
        (((center2 - self.lo) * self.per_unit) as usize).min(self.last)
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
        let bins = self.bins.min(4 + count / 2);
        let best = (0..3)
            .filter(|&axis| centers.max[axis] > centers.min[axis])
            .filter_map(|axis| best_border(set.refs, Scale::new(&centers, axis, bins), axis, bins))
            .min_by(|a, b| a.cost.total_cmp(&b.cost));
        let best = best?;
        let split_cost = 1.0 + best.cost * self.primitive_cost / area;
        // Not `>=`: a NaN of two areas of 0 makes a leaf.
        if count <= self.leaf_limit && !(split_cost < leaf_cost) {
            return None;
        }
        let scale = Scale::new(&centers, best.axis, bins);
        Some(set.partition(|r| scale.bin(r.center2(best.axis)) < best.border))
    }
}

/// The cheapest border along one axis: `area * count` of both sides. `None` if all centres share a bin.
fn best_border(refs: &[Reference], scale: Scale, axis: usize, bins: usize) -> Option<BestSplit> {
    let mut table = [EMPTY_BIN; MAX_BINS];
    for r in refs {
        let bin = &mut table[scale.bin(r.center2(axis))];
        bin.bounds = bin.bounds.union(&r.bounds);
        bin.count += 1;
    }
    let table = &table[..bins];
    let mut right_costs = [0.0; MAX_BINS];
    let (mut bounds, mut count) = (Aabb::EMPTY, 0);
    for (i, bin) in table.iter().enumerate().skip(1).rev() {
        bounds = bounds.union(&bin.bounds);
        count += bin.count;
        right_costs[i] = bounds.half_area() * f64::from(count);
    }
    let (mut bounds, mut count) = (Aabb::EMPTY, 0);
    let mut best: Option<BestSplit> = None;
    for border in 1..bins {
        bounds = bounds.union(&table[border - 1].bounds);
        count += table[border - 1].count;
        let cost = bounds.half_area() * f64::from(count) + right_costs[border];
        let real = count > 0 && (count as usize) < refs.len();
        if real && best.as_ref().is_none_or(|b| cost < b.cost) {
            best = Some(BestSplit { cost, axis, border });
        }
    }
    best
}
