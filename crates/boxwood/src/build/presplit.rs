//! Large slanted primitives are split before the tree is built: their boxes are mostly empty, and overlap those of others.
//!
//! Karras and Aila, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies", HPG 2013, section 4. Each primitive
//! is cut at planes of a grid that halves the scene again and again; those gain most that are large, mostly empty, and meet
//! planes of high rank.
//!
//! A ray that hits a primitive hits it in one of its parts, and the part's box holds the point of the hit up to the rounding
//! that the paddings of [`crate::geom`] allow for: `t` of a hit is that of the exact triangle with vertices moved by at most
//! `6 u A`, and a part's box is never smaller than the part. So splitting changes no answer.

use super::fragment::{Fragment, fragments};
use super::input::room;
use super::{BuildInput, Topology};
use crate::error::BuildError;
use crate::geom::Aabb;
use crate::prims::Parts;

/// Most parts altogether: a tree has up to twice as many nodes, which 32 bits number.
const MAX_PARTS: usize = (1 << 31) - 1;

/// The primitives of an input with up to `budget` times as many parts more.
pub(super) fn split_fragments(
    input: &BuildInput<'_>,
    budget: f32,
) -> Result<Vec<Fragment>, BuildError> {
    let whole = fragments(input)?;
    let Some(parts) = input.parts.filter(|parts| is_worth_it(*parts, &whole)) else {
        return Ok(whole);
    };
    let all = whole
        .iter()
        .fold(Aabb::EMPTY, |all, f| all.union(&f.bounds()));
    let grid = Grid::new(&all);
    let mut priorities = room(whole.len())?;
    priorities.extend(whole.iter().map(|f| grid.priority(parts, f)));
    let extra = (whole.len() as f64 * f64::from(budget.clamp(0.0, 4.0))) as usize;
    let extra = extra.min(MAX_PARTS.saturating_sub(whole.len()));
    let Some(scale) = scale_to(&priorities, extra) else {
        return Ok(whole);
    };
    let mut split = room(whole.len() + extra)?;
    for (fragment, priority) in whole.iter().zip(&priorities) {
        let cutter = Cutter {
            parts,
            grid: &grid,
            number: fragment.number(),
        };
        cutter.cut(fragment.bounds(), cuts(*priority, scale), &mut split);
    }
    Ok(split)
}

/// True if boxes are mostly empty, as those of slivers. Else splitting costs more visits of nodes than it saves, for all its
/// fewer tests: 16 % more work of rays in the kitchen scene and 41 % in the bathroom, 18 % less among slivers (bench/LOG.md).
/// Triangles of flat walls have twice their area, those of scans less than 3 times.
fn is_worth_it(parts: &dyn Parts, whole: &[Fragment]) -> bool {
    let (boxes, least) = whole.iter().fold((0.0, 0.0), |(boxes, least), f| {
        (
            boxes + f.bounds().half_area(),
            least + f64::from(parts.least_area(f.number())),
        )
    });
    boxes > 10.0 * least
}

/// Most cuts of one primitive.
const MAX_CUTS: f32 = 63.0;

fn cuts(priority: f32, scale: f32) -> u32 {
    (priority * scale).min(MAX_CUTS) as u32
}

/// The largest factor of priorities with which there are at most `extra` cuts; `None` if none is worth it.
fn scale_to(priorities: &[f32], extra: usize) -> Option<f32> {
    let sum: f64 = priorities.iter().map(|&p| f64::from(p)).sum();
    if !(sum > 0.0) || extra == 0 {
        return None;
    }
    let needed =
        |scale: f32| -> u64 { priorities.iter().map(|&p| u64::from(cuts(p, scale))).sum() };
    // Cuts are rounded down, so this one is too small and its double or so too large.
    let mut low = (extra as f64 / sum) as f32;
    let mut high = low * 4.0;
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        if needed(middle) <= extra as u64 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(low)
}

/// Planes that halve a cube around the scene, its halves, and so on.
struct Grid {
    origin: [f32; 3],
    per_unit: f32,
    unit: f32,
}

/// Halvings along each axis.
const LEVELS: u32 = 20;

/// The plane of the highest rank that cuts a box.
struct Plane {
    axis: usize,
    at: f32,
    /// 1 for the planes through the middle of the scene, 2 for those of its halves.
    level: u32,
}

impl Grid {
    fn new(all: &Aabb) -> Self {
        let [x, y, z] = all.extent();
        let unit = x.max(y).max(z) / (1 << LEVELS) as f32;
        Self {
            origin: all.min,
            per_unit: if unit > 0.0 { 1.0 / unit } else { 0.0 },
            unit,
        }
    }

    fn plane(&self, bounds: &Aabb) -> Option<Plane> {
        let along = |axis: usize| {
            let cell = |x: f32| ((x - self.origin[axis]) * self.per_unit) as u32;
            let (lo, hi) = (cell(bounds.min[axis]), cell(bounds.max[axis]));
            let highest = (lo ^ hi).checked_ilog2()?;
            let at = self.origin[axis] + (hi >> highest << highest) as f32 * self.unit;
            let is_inside = bounds.min[axis] < at && at < bounds.max[axis];
            is_inside.then_some(Plane {
                axis,
                at,
                level: LEVELS - highest.min(LEVELS),
            })
        };
        let extent = bounds.extent();
        // Of planes of one rank the one across the longest side.
        (0..3).filter_map(along).min_by(|a, b| {
            a.level
                .cmp(&b.level)
                .then(extent[b.axis].total_cmp(&extent[a.axis]))
        })
    }

    /// What splitting is worth: the third root makes up for that each further cut gains less.
    fn priority(&self, parts: &dyn Parts, fragment: &Fragment) -> f32 {
        let bounds = fragment.bounds();
        let Some(plane) = self.plane(&bounds) else {
            return 0.0;
        };
        let empty = bounds.half_area() - f64::from(parts.least_area(fragment.number()));
        let rank = f64::from(plane.level.min(LEVELS)).exp2().recip();
        let worth = (rank * empty.max(0.0)).cbrt() as f32;
        if worth.is_finite() { worth } else { 0.0 }
    }
}

/// Cuts one primitive.
struct Cutter<'a> {
    parts: &'a dyn Parts,
    grid: &'a Grid,
    number: u32,
}

impl Cutter<'_> {
    /// Adds the part of the primitive in a box, cut up to `cuts` times.
    fn cut(&self, bounds: Aabb, cuts: u32, split: &mut Vec<Fragment>) {
        let plane = self.grid.plane(&bounds).filter(|_| cuts > 0);
        let Some(Plane { axis, at, .. }) = plane else {
            split.push(Fragment::fragment(&bounds, self.number));
            return;
        };
        let (mut left, mut right) = (bounds, bounds);
        left.max[axis] = at;
        right.min[axis] = at;
        let [left, right] = [left, right].map(|cell| self.parts.clip(self.number, &cell));
        match (left.is_empty(), right.is_empty()) {
            (true, true) => split.push(Fragment::fragment(&bounds, self.number)),
            (true, false) => self.cut(right, cuts - 1, split),
            (false, true) => self.cut(left, cuts - 1, split),
            (false, false) => {
                // The other cuts by size.
                let size = |b: &Aabb| b.extent().into_iter().fold(0.0, f32::max);
                let share = size(&left) / (size(&left) + size(&right));
                let for_left = ((cuts - 1) as f32 * share + 0.5) as u32;
                let for_left = for_left.min(cuts - 1);
                self.cut(left, for_left, split);
                self.cut(right, cuts - 1 - for_left, split);
            }
        }
    }
}

/// Names each primitive once per leaf, however many of its parts are there.
pub(super) fn drop_copies(tree: &mut Topology) {
    tree.is_split = true;
    let mut to = 0;
    // Depth first, which is the order of slots. A tree is at most 96 deep.
    let mut waiting = vec![0; usize::from(!tree.nodes.is_empty())];
    while let Some(index) = waiting.pop() {
        let node = &mut tree.nodes[index];
        if !node.is_leaf() {
            waiting.extend([node.first as usize + 1, node.first as usize]);
            continue;
        }
        let first = to;
        for slot in node.slots() {
            let prim = tree.order[slot as usize];
            if !tree.order[first..to].contains(&prim) {
                tree.order[to] = prim;
                to += 1;
            }
        }
        (node.first, node.count) = (first as u32, (to - first) as u32);
    }
    tree.order.truncate(to);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Triangle;
    use crate::prims::{Primitives, Triangles};
    use crate::testing::Random;

    /// Thin and slanted, some of them large.
    fn slanted(count: usize) -> Triangles {
        let mut random = Random::new(8);
        let mut point = |size: f32, at: [f32; 3]| at.map(|x| x + size * random.signed());
        let triangles = (0..count).map(|i| {
            let size = if i % 10 == 0 { 5.0 } else { 0.1 };
            let at = point(10.0, [0.0; 3]);
            let (a, b) = (point(size, at), point(size, at));
            Triangle([a, b, point(0.01, b)])
        });
        Triangles::new(triangles.collect())
    }

    #[test]
    fn parts_stay_in_the_budget_and_make_boxes_smaller() {
        let triangles = slanted(3000);
        let boxes = crate::prims::boxes(&triangles);
        let input = BuildInput::new(&triangles, &boxes);
        let area = |all: &[Fragment]| all.iter().map(|f| f.bounds().half_area()).sum::<f64>();
        let whole = fragments(&input).unwrap();
        let split = split_fragments(&input, 0.3).unwrap();
        assert!(split.len() > 3300 && split.len() <= 3900, "{}", split.len());
        assert!(area(&split) < 0.7 * area(&whole));
        assert_eq!(split_fragments(&input, 0.0).unwrap(), whole);
    }

    #[test]
    fn every_point_of_a_primitive_is_in_the_box_of_one_of_its_parts() {
        let triangles = slanted(1000);
        let boxes = crate::prims::boxes(&triangles);
        let split = split_fragments(&BuildInput::new(&triangles, &boxes), 1.0).unwrap();
        let mut parts = vec![Vec::new(); triangles.len()];
        for fragment in &split {
            let bounds = fragment.bounds();
            let number = fragment.number() as usize;
            assert!(boxes[number].contains_box(&bounds));
            parts[number].push(bounds);
        }
        let mut random = Random::new(9);
        for (triangle, parts) in triangles.as_slice().iter().zip(&parts) {
            for _ in 0..200 {
                let (a, b) = (random.unit(), random.unit());
                let (u, v) = if a + b > 1.0 {
                    (1.0 - a, 1.0 - b)
                } else {
                    (a, b)
                };
                let [p, q, r] = triangle.0.map(|v| v.map(f64::from));
                let (u, v) = (f64::from(u), f64::from(v));
                let point: [f64; 3] =
                    std::array::from_fn(|k| p[k] + u * (q[k] - p[k]) + v * (r[k] - p[k]));
                let holds = |b: &Aabb| {
                    (0..3)
                        .all(|k| f64::from(b.min[k]) <= point[k] && point[k] <= f64::from(b.max[k]))
                };
                assert!(
                    parts.iter().any(holds),
                    "{point:?} of {triangle:?}: {parts:?}"
                );
            }
        }
    }

    #[test]
    fn primitives_without_parts_stay_whole() {
        let boxes = crate::prims::boxes(&slanted(50));
        let split = split_fragments(&BuildInput::of_boxes(&boxes), 0.5).unwrap();
        assert_eq!(split.len(), 50);
    }
}
