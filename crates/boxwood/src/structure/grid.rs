//! Uniform space subdivision: cells hold references to the primitives that overlap them, and a ray goes from cell to
//! cell.
//!
//! * Storage: one offset per cell and one number per reference, filled by counting sort (Lagae and Dutré, "Compact, Fast
//!   and Robust Grids for Ray Tracing", EGSR 2008).
//! * Resolution: `n_i = d_i * cbrt(density * N / V)` cells along side `d_i` of a box of volume `V`, so that cells are
//!   nearly cubes and there are `density` of them per primitive; half as many along each side, and again, while long
//!   primitives would need more than 16 references each on average (4096 in all are always allowed).
//! * Walk: a 3D digital differential analyser with the lecture's constant offset between faces (Amanatides and Woo, "A Fast
//!   Voxel Traversal Algorithm for Ray Tracing", Eurographics 1987). A hit beyond the cell is kept, and the walk ends
//!   when a cell begins behind it.
//!
//! Primitives are entered with a margin of a 32nd of a cell. Rays so far away that single precision errs by more than
//! that walk whole layers of cells instead (see [`Grid::sweep`]).

use super::{Accel, Visit};
use crate::build::{BuildOptions, BuildStep, BuildWalk, GridTry};
use crate::error::BuildError;
use crate::geom::{Aabb, Interval, PreparedRay, SlabRay, filter_pad};
use crate::prims::Primitives;
use crate::query::{CellVisit, NodeInfo, Observer, VolumeTest, VolumeVerdict};
use crate::volume::BoundingVolume;
use std::ops::{ControlFlow, Range};

/// A uniform grid.
#[derive(Clone, Debug)]
pub struct Grid {
    shape: Shape,
    /// References of cell `i`: `starts[i]..starts[i + 1]`.
    starts: Vec<u32>,
    references: Vec<u32>,
    /// Slot to primitive; references count in slots.
    order: Vec<u32>,
}

/// Average number of references per primitive above which the resolution is halved.
const MAX_REFERENCES: usize = 16;
/// Operations per cell of a sweep, those of its layer shared out: faces 6, corners of the beam 8 and 4 comparisons.
const SWEEP_FLOPS: u32 = 18;
/// Cells along one axis.
const MAX_CELLS: f64 = 1024.0;

impl Accel for Grid {
    fn build<P: Primitives>(
        _: &P,
        boxes: &[Aabb],
        options: &BuildOptions,
    ) -> Result<Self, BuildError> {
        let (order, kept) = kept(boxes);
        let shape = Shape::fitting(&kept, options, |_| {});
        let (starts, references) = shape.counting_sort(&kept)?;
        Ok(Self {
            shape,
            starts,
            references,
            order,
        })
    }

    fn order(&self) -> &[u32] {
        &self.order
    }

    #[inline]
    fn traverse<V: Visit>(&self, ray: &PreparedRay, visit: &mut V) {
        if self.order.is_empty() {
            return;
        }
        let bounds = &self.shape.bounds;
        let interval = SlabRay::new(ray, bounds).interval(bounds);
        let Interval { near, far } = interval;
        let is_met = interval.meets(ray.t_min, ray.t_max);
        visit.observer().volume(VolumeTest {
            node: 0,
            near,
            far,
            verdict: if is_met {
                VolumeVerdict::Enter
            } else {
                VolumeVerdict::Miss
            },
            flops: Aabb::FLOPS,
            bytes: size_of::<Aabb>() as u32,
        });
        if !is_met {
            return;
        }
        let (start, end) = (near.max(ray.t_min), far.min(ray.t_max));
        let mut mailbox = Mailbox::default();
        // A break ends the traversal, and so does the end.
        let _ = if filter_pad(bounds.reach(ray.origin), ray) <= self.shape.margin {
            self.step(ray, f64::from(start), f64::from(end), &mut mailbox, visit)
        } else {
            self.sweep(ray, f64::from(start), f64::from(end), &mut mailbox, visit)
        };
    }

    fn for_each_node(&self, visit: &mut dyn FnMut(NodeInfo)) {
        for z in 0..self.shape.cells[2] {
            for y in 0..self.shape.cells[1] {
                for x in 0..self.shape.cells[0] {
                    let index = self.shape.index([x, y, z]);
                    let count = self.range(index).len() as u32;
                    if count > 0 {
                        let bounds = self.shape.cell_bounds([x, y, z]);
                        visit(NodeInfo {
                            node: index as u32,
                            depth: 0,
                            bounds,
                            prims: Some(count),
                        });
                    }
                }
            }
        }
    }

    fn bytes(&self) -> usize {
        4 * (self.starts.len() + self.references.len() + self.order.len())
    }
}

/// The primitives that can be hit, and their boxes.
fn kept(boxes: &[Aabb]) -> (Vec<u32>, Vec<Aabb>) {
    boxes
        .iter()
        .zip(0..)
        .filter(|(b, _)| !b.is_empty())
        .map(|(b, prim)| (prim, *b))
        .unzip()
}

impl Grid {
    /// The resolutions that [`Grid::build`](Accel::build) tries, the last of which it takes; as many as are wanted.
    pub fn explain(boxes: &[Aabb], options: &BuildOptions, limit: usize) -> BuildWalk {
        let (order, kept) = kept(boxes);
        let mut steps = Vec::new();
        Shape::fitting(&kept, options, |grid| steps.push(BuildStep::Grid(grid)));
        let step_count = steps.len();
        steps.truncate(limit);
        BuildWalk {
            steps,
            step_count,
            order,
            ..BuildWalk::default()
        }
    }

    /// Cells along each axis.
    pub fn resolution(&self) -> [u32; 3] {
        self.shape.cells
    }

    /// The walk of the slides. Each step goes through the nearest of the three next faces.
    #[inline]
    fn step<V: Visit>(
        &self,
        ray: &PreparedRay,
        start: f64,
        end: f64,
        mailbox: &mut Mailbox,
        visit: &mut V,
    ) -> ControlFlow<()> {
        let mut walk = CellWalk::new(&self.shape, ray, start);
        loop {
            let index = self.shape.index(walk.cell);
            let range = self.range(index);
            visit.observer().cell(CellVisit {
                cell: walk.cell,
                enter: walk.enter,
                t_delta: walk.t_delta,
                t_next: walk.t_next,
                prims: range.len() as u32,
                flops: CellWalk::FLOPS,
                bytes: 8 + 4 * range.len() as u32,
            });
            self.visit_cell(range, mailbox, visit)?;
            if !walk.advance(&self.shape.cells) || walk.enter > end.min(f64::from(visit.t_max())) {
                return ControlFlow::Continue(());
            }
        }
    }

    /// For rays from far away: layer by layer along the ray's main axis, every cell that the padded ray may touch.
    fn sweep<V: Visit>(
        &self,
        ray: &PreparedRay,
        start: f64,
        end: f64,
        mailbox: &mut Mailbox,
        visit: &mut V,
    ) -> ControlFlow<()> {
        let shape = &self.shape;
        let pad = f64::from(2.0 * filter_pad(shape.bounds.reach(ray.origin), ray));
        let (origin, dir) = (ray.origin.map(f64::from), ray.dir.map(f64::from));
        let [kx, ky, kz] = ray.axes;
        let across = |axis: usize, t: [f64; 2]| {
            let at = t.map(|t| origin[axis] + t * dir[axis]);
            shape.columns(axis, at[0].min(at[1]) - pad, at[0].max(at[1]) + pad)
        };
        for layer in 0..shape.cells[kz] {
            let layer = if dir[kz] > 0.0 {
                layer
            } else {
                shape.cells[kz] - 1 - layer
            };
            let face = |i: u32, pad: f64| (shape.face(kz, i) + pad - origin[kz]) * ray.t_per_depth;
            let (a, b) = (face(layer, -pad), face(layer + 1, pad));
            let t = [a.min(b).max(start), a.max(b).min(end)];
            if t[0] > end.min(f64::from(visit.t_max())) {
                return ControlFlow::Continue(());
            }
            if t[0] > t[1] {
                continue;
            }
            for x in across(kx, t) {
                for y in across(ky, t) {
                    let mut cell = [0; 3];
                    (cell[kx], cell[ky], cell[kz]) = (x, y, layer);
                    let range = self.range(shape.index(cell));
                    visit.observer().cell(CellVisit {
                        cell,
                        enter: t[0],
                        t_delta: [f64::NAN; 3],
                        t_next: [f64::NAN; 3],
                        prims: range.len() as u32,
                        flops: SWEEP_FLOPS,
                        bytes: 8 + 4 * range.len() as u32,
                    });
                    self.visit_cell(range, mailbox, visit)?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    #[inline]
    fn visit_cell<V: Visit>(
        &self,
        range: Range<usize>,
        mailbox: &mut Mailbox,
        visit: &mut V,
    ) -> ControlFlow<()> {
        visit.leaf(
            self.references[range]
                .iter()
                .copied()
                .filter(|&slot| mailbox.is_new(slot)),
        )
    }

    #[inline]
    fn range(&self, cell: usize) -> Range<usize> {
        self.starts[cell] as usize..self.starts[cell + 1] as usize
    }
}

/// Remembers the primitives tested last, so that one which overlaps many cells is not tested in each.
struct Mailbox([u32; 16]);

impl Default for Mailbox {
    fn default() -> Self {
        Self([u32::MAX; 16])
    }
}

impl Mailbox {
    #[inline]
    fn is_new(&mut self, slot: u32) -> bool {
        std::mem::replace(&mut self.0[slot as usize % 16], slot) != slot
    }
}

/// A whole number of cells; one where there is no saying (NaN, of infinite boxes).
fn cells_along(wanted: f64) -> u32 {
    if wanted > 1.0 {
        wanted.ceil().min(MAX_CELLS) as u32
    } else {
        1
    }
}

/// Where the cells are.
#[derive(Clone, Debug)]
struct Shape {
    /// Around everything, with a margin.
    bounds: Aabb,
    cells: [u32; 3],
    /// Side lengths of a cell.
    size: [f64; 3],
    /// How much larger than its box a primitive is entered.
    margin: f32,
}

impl Shape {
    /// As fine as the options have it, but with no more references than are bearable.
    fn fitting(boxes: &[Aabb], options: &BuildOptions, mut tell: impl FnMut(GridTry)) -> Self {
        let mut density = options.cells_per_primitive();
        let limit = (MAX_REFERENCES * boxes.len()).clamp(4096, u32::MAX as usize);
        loop {
            let shape = Self::new(boxes, density);
            let references = shape.count_references(boxes, limit);
            tell(GridTry {
                density,
                cells: shape.cells,
                bounds: shape.bounds,
                references,
                limit,
            });
            if references.is_some() || shape.cells == [1; 3] {
                return shape;
            }
            density /= 8.0;
        }
    }

    fn new(boxes: &[Aabb], density: f64) -> Self {
        let tight = Aabb::of_boxes(boxes);
        if boxes.is_empty() {
            return Self {
                bounds: tight,
                cells: [1; 3],
                size: [1.0; 3],
                margin: 0.0,
            };
        }
        // A flat scene gets a little thickness, so that its volume is not 0.
        let thickness = (tight.diagonal() * 1e-3).max(1e-30);
        let sides = tight.extent().map(|side| f64::from(side).max(thickness));
        let per_unit = (density * boxes.len() as f64 / (sides[0] * sides[1] * sides[2])).cbrt();
        let cells = sides.map(|side| cells_along(side * per_unit));
        let smallest = (0..3)
            .map(|k| sides[k] / f64::from(cells[k]))
            .fold(f64::INFINITY, f64::min);
        let margin = (smallest / 32.0) as f32;
        let outer = |k: usize| 2.0 * margin + (sides[k] as f32 - tight.extent()[k]) * 0.5;
        let bounds = Aabb {
            min: std::array::from_fn(|k| (tight.min[k] - outer(k)).next_down()),
            max: std::array::from_fn(|k| (tight.max[k] + outer(k)).next_up()),
        };
        let size = std::array::from_fn(|k| {
            (f64::from(bounds.max[k]) - f64::from(bounds.min[k])) / f64::from(cells[k])
        });
        Self {
            bounds,
            cells,
            size,
            margin,
        }
    }

    #[inline]
    fn index(&self, [x, y, z]: [u32; 3]) -> usize {
        (z as usize * self.cells[1] as usize + y as usize) * self.cells[0] as usize + x as usize
    }

    /// Coordinate of the face before cell `i`.
    #[inline]
    fn face(&self, axis: usize, i: u32) -> f64 {
        f64::from(self.bounds.min[axis]) + f64::from(i) * self.size[axis]
    }

    /// The cell along one axis, clamped to the grid.
    #[inline]
    fn column(&self, axis: usize, at: f64) -> u32 {
        // The cast saturates: below 0 is 0.
        (((at - f64::from(self.bounds.min[axis])) / self.size[axis]) as u32)
            .min(self.cells[axis] - 1)
    }

    fn columns(&self, axis: usize, from: f64, to: f64) -> std::ops::RangeInclusive<u32> {
        self.column(axis, from)..=self.column(axis, to)
    }

    fn cell_bounds(&self, cell: [u32; 3]) -> Aabb {
        Aabb {
            min: std::array::from_fn(|k| self.face(k, cell[k]) as f32),
            max: std::array::from_fn(|k| self.face(k, cell[k] + 1) as f32),
        }
    }

    /// Calls `f` with every cell that the box overlaps, margin included.
    fn overlapped(&self, bounds: &Aabb, mut f: impl FnMut(usize)) {
        let margin = f64::from(self.margin);
        let [xs, ys, zs] = std::array::from_fn(|k| {
            self.columns(
                k,
                f64::from(bounds.min[k]) - margin,
                f64::from(bounds.max[k]) + margin,
            )
        });
        for z in zs {
            for y in ys.clone() {
                let row = self.index([0, y, z]);
                for x in xs.clone() {
                    f(row + x as usize);
                }
            }
        }
    }

    /// How many references there would be; `None` above the limit.
    fn count_references(&self, boxes: &[Aabb], limit: usize) -> Option<usize> {
        let margin = f64::from(self.margin);
        boxes.iter().try_fold(0usize, |sum, b| {
            let cells: usize = (0..3)
                .map(|k| {
                    self.columns(
                        k,
                        f64::from(b.min[k]) - margin,
                        f64::from(b.max[k]) + margin,
                    )
                })
                .map(|columns| columns.count())
                .product();
            Some(sum + cells).filter(|&sum| sum <= limit)
        })
    }

    /// Two passes: count the references of each cell, then put each in its place.
    fn counting_sort(&self, boxes: &[Aabb]) -> Result<(Vec<u32>, Vec<u32>), BuildError> {
        let cells = self.cells.iter().map(|&n| n as usize).product::<usize>();
        let mut starts = filled(cells + 1)?;
        for b in boxes {
            self.overlapped(b, |cell| starts[cell + 1] += 1);
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let mut references = filled(sum as usize)?;
        // Filling from the back leaves each cell's references in ascending order and its start in place.
        let mut ends = starts[1..].to_vec();
        for (slot, b) in boxes.iter().enumerate().rev() {
            self.overlapped(b, |cell| {
                ends[cell] -= 1;
                references[ends[cell] as usize] = slot as u32;
            });
        }
        Ok((starts, references))
    }
}

fn filled(len: usize) -> Result<Vec<u32>, BuildError> {
    let mut values = Vec::new();
    values
        .try_reserve_exact(len)
        .map_err(|_| BuildError::OutOfMemory { bytes: 4 * len })?;
    values.resize(len, 0);
    Ok(values)
}

/// The ray on its way from cell to cell, in double precision.
struct CellWalk {
    cell: [u32; 3],
    /// -1 or 1.
    direction: [i32; 3],
    enter: f64,
    t_next: [f64; 3],
    t_delta: [f64; 3],
}

impl CellWalk {
    /// Two comparisons to find the next face, one addition to find the one after.
    const FLOPS: u32 = 3;

    fn new(shape: &Shape, ray: &PreparedRay, start: f64) -> Self {
        let mut walk = Self {
            cell: [0; 3],
            direction: [1; 3],
            enter: start,
            t_next: [f64::INFINITY; 3],
            t_delta: [f64::INFINITY; 3],
        };
        for k in 0..3 {
            let (origin, dir) = (f64::from(ray.origin[k]), f64::from(ray.dir[k]));
            walk.cell[k] = shape.column(k, origin + start * dir);
            let forward = dir > 0.0;
            walk.direction[k] = if forward { 1 } else { -1 };
            if dir != 0.0 {
                let face = shape.face(k, walk.cell[k] + u32::from(forward));
                walk.t_next[k] = (face - origin) / dir;
                walk.t_delta[k] = (shape.size[k] / dir).abs();
            }
        }
        walk
    }

    /// Goes through the nearest face; false if that leads out of the grid.
    #[inline]
    fn advance(&mut self, cells: &[u32; 3]) -> bool {
        let [x, y, z] = self.t_next;
        let axis = if x < y {
            if x < z { 0 } else { 2 }
        } else if y < z {
            1
        } else {
            2
        };
        self.enter = self.t_next[axis];
        self.t_next[axis] += self.t_delta[axis];
        let next = self.cell[axis].wrapping_add_signed(self.direction[axis]);
        self.cell[axis] = next;
        next < cells[axis] && self.enter < f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Ray, Triangle};
    use crate::prims::{Triangles, boxes};

    fn grid_of(triangles: &[[[f32; 3]; 3]]) -> Grid {
        let prims = Triangles::new(triangles.iter().copied().map(Triangle).collect());
        Grid::build(&prims, &boxes(&prims), &BuildOptions::default()).unwrap()
    }

    #[test]
    fn the_offset_between_faces_is_constant_and_the_walk_crosses_the_whole_grid() {
        let shape = Shape::new(
            &vec![
                Aabb {
                    min: [0.0; 3],
                    max: [4.0, 2.0, 1.0]
                };
                512
            ],
            1.0,
        );
        let ray = PreparedRay::new(&Ray::new([0.01, 0.02, 0.03], [4.0, 2.0, 0.9])).unwrap();
        let mut walk = CellWalk::new(&shape, &ray, 0.0);
        let delta = walk.t_delta;
        let mut steps = 0;
        let mut before = walk.enter;
        while walk.advance(&shape.cells) {
            steps += 1;
            assert!(walk.enter >= before);
            assert_eq!(walk.t_delta, delta);
            before = walk.enter;
        }
        assert!(
            steps as u32 >= shape.cells[0].max(shape.cells[1]),
            "{steps} of {:?}",
            shape.cells
        );
    }

    #[test]
    fn a_primitive_is_referenced_by_every_cell_that_it_overlaps() {
        let grid = grid_of(&[
            [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]],
            [[0.0, 0.0, 9.0], [0.1, 0.0, 9.0], [0.0, 0.1, 9.0]],
        ]);
        let count = |slot| grid.references.iter().filter(|&&s| s == slot).count();
        assert!(count(0) > 1 && count(1) >= 1);
        assert_eq!(*grid.starts.last().unwrap() as usize, grid.references.len());
    }

    #[test]
    fn long_primitives_do_not_flood_the_memory() {
        let diagonal = |i: usize| {
            let x = i as f32 * 1e-3;
            [[x, 0.0, 0.0], [x + 1.0, 1.0, 1.0], [x, 0.001, 0.0]]
        };
        let grid = grid_of(&(0..20_000).map(diagonal).collect::<Vec<_>>());
        assert!(
            grid.references.len() <= MAX_REFERENCES * 20_000,
            "{}",
            grid.references.len()
        );
    }
}
