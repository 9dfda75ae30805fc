//! A uniform grid seen from above: the walk of a ray from cell to cell, by the library's own [`Grid`].

use boxwood::{
    BuildOptions, Query, Ray, Step,
    prims::Triangles,
    query::CellVisit,
    structure::{Grid, Indexed},
};
use serde::Serialize;

use super::{HALF_HEIGHT, upright};

/// A ray's way through a grid seen from above.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GridAnswer {
    /// Columns and rows.
    pub cells: [u32; 2],
    /// Smallest and largest corner of the grid.
    pub bounds: [[f64; 2]; 2],
    /// Column, row and references of each cell that is not empty.
    pub filled: Vec<[u32; 3]>,
    /// Cell by cell.
    pub steps: Vec<CellStep>,
    /// Ray parameter and number of the wall that is hit.
    pub hit: Option<(f32, u32)>,
    /// Triangle tests; each wall is two triangles, tested once.
    pub tests: u64,
    /// Operations, of cells and triangles.
    pub flops: u64,
}

/// One cell of the walk; `t_next` and `t_delta` are null across a zero direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellStep {
    /// Column and row.
    pub cell: [u32; 2],
    /// Where the ray enters.
    pub enter: f64,
    /// The constant offset between faces.
    pub t_delta: [f64; 2],
    /// The next face of each axis; the smaller is where the ray goes on.
    pub t_next: [f64; 2],
    /// Walls tested here.
    pub tested: Vec<u32>,
    /// The closest hit after the cell.
    pub best_t: Option<f32>,
}

/// Walks the ray through a [`Grid`] of about `columns` cells along the longer side over `walls`, each from `[x, y]` to `[x, y]`.
pub fn grid_walk(
    walls: &[[f32; 4]],
    columns: u32,
    origin: [f32; 2],
    dir: [f32; 2],
) -> Result<GridAnswer, String> {
    let [min, max] = extent(walls).ok_or("without walls there is no grid")?;
    let options = BuildOptions {
        grid_density: density(columns, walls.len(), [max[0] - min[0], max[1] - min[1]]),
        ..BuildOptions::default()
    };
    let triangles = Triangles::new(walls.iter().flat_map(upright).collect());
    let grid = Indexed::<Grid, _>::new(&triangles, &options).map_err(|error| error.to_string())?;
    let [across, down, _] = grid.accel().resolution();
    let (mut filled, mut bounds) = (Vec::new(), [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]]);
    grid.for_each_node(&mut |cell| {
        let place = [cell.node % across, cell.node / across % down];
        let references = cell.prims.unwrap_or(0);
        filled.push([place[0], place[1], references]);
        for axis in 0..2 {
            // Where the whole grid would begin and end, by this cell.
            let ends = [cell.bounds.min[axis], cell.bounds.max[axis]].map(f64::from);
            let size = ends[1] - ends[0];
            let start = ends[0] - f64::from(place[axis]) * size;
            bounds[0][axis] = bounds[0][axis].min(start);
            bounds[1][axis] = bounds[1][axis].max(start + size * f64::from([across, down][axis]));
        }
    });
    let ray = Ray::new([origin[0], origin[1], 0.0], [dir[0], dir[1], 0.0]);
    let walk = grid.explain(&ray);
    Ok(GridAnswer {
        cells: [across, down],
        bounds,
        filled,
        steps: cell_steps(&walk.steps),
        hit: walk.hit.map(|hit| (hit.t, hit.prim / 2)),
        tests: walk.counts.prims,
        flops: walk.counts.flops,
    })
}

fn extent(walls: &[[f32; 4]]) -> Option<[[f32; 2]; 2]> {
    let ends = walls.iter().flat_map(|w| [[w[0], w[1]], [w[2], w[3]]]);
    ends.fold(None, |extent, p| {
        let [min, max] = extent.unwrap_or([p, p]);
        Some([
            [min[0].min(p[0]), min[1].min(p[1])],
            [max[0].max(p[0]), max[1].max(p[1])],
        ])
    })
}

/// The grid's rule turned round: cells are cubes, `density` of them to a triangle.
fn density(columns: u32, walls: usize, [x, y]: [f32; 2]) -> f32 {
    let per_unit = columns as f32 / x.max(y).max(f32::MIN_POSITIVE);
    per_unit.powi(3) * x * y * 2.0 * HALF_HEIGHT / (2 * walls) as f32
}

fn cell_steps(steps: &[Step]) -> Vec<CellStep> {
    let mut cells: Vec<CellStep> = Vec::new();
    for step in steps {
        match step {
            Step::Cell(visit) => cells.push(CellStep::of(visit, cells.last())),
            Step::Primitive(test) => {
                let Some(cell) = cells.last_mut() else {
                    continue;
                };
                if cell.tested.last() != Some(&(test.prim / 2)) {
                    cell.tested.push(test.prim / 2);
                }
                if let Some(found) = test.candidate
                    && cell.best_t.is_none_or(|best| found.t < best)
                {
                    cell.best_t = Some(found.t);
                }
            }
            _ => {}
        }
    }
    cells
}

impl CellStep {
    fn of(visit: &CellVisit, last: Option<&Self>) -> Self {
        let two = |three: [f64; 3]| [three[0], three[1]];
        Self {
            cell: [visit.cell[0], visit.cell[1]],
            enter: visit.enter,
            t_delta: two(visit.t_delta),
            t_next: two(visit.t_next),
            tested: Vec::new(),
            best_t: last.and_then(|last| last.best_t),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_has_one_layer_and_the_offset_between_faces_is_constant() {
        let walls = [
            [0.0, 0.0, 1.5, 0.5],
            [14.0, 8.5, 16.0, 9.0],
            [7.0, 5.0, 9.0, 2.0],
            [3.0, 8.0, 5.0, 7.0],
        ];
        for columns in [2, 5, 8, 16, 24] {
            let found = grid_walk(&walls, columns, [-1.0, 1.25], [1.0, 0.35]).unwrap();
            assert!(found.cells[0].abs_diff(columns) <= 1, "{:?}", found.cells);
            assert_eq!(found.hit.map(|(_, wall)| wall), Some(2));
            let deltas = found.steps.iter().map(|step| step.t_delta);
            assert!(deltas.clone().all(|delta| delta == found.steps[0].t_delta));
            for pair in found.steps.windows(2) {
                assert_eq!(pair[1].enter, pair[0].t_next[0].min(pair[0].t_next[1]));
            }
            for (cells, axis) in found.cells.iter().zip(0..) {
                let side = found.bounds[1][axis] - found.bounds[0][axis];
                let size = side / f64::from(*cells);
                assert!(
                    (found.steps[0].t_delta[axis] * [1.0, f64::from(0.35f32)][axis] - size).abs()
                        < 1e-4
                );
            }
        }
    }
}
