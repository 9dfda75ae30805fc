//! A scene and its questions.

use crate::arrays::{Array, column, rows, table};
use crate::ask;
use crate::first;
use crate::pool::interruptible;
use crate::rays::{Asked, Lines, Origin, Table as Rows};
use boxwood::build::PRESETS;
use boxwood::{HitLists, Ray, Scene, SceneBuilder};
use boxwood_host::FloatModes;
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Built once; every question leaves it as it is.
#[pyclass(frozen, name = "NativeScene", module = "boxwood._native")]
pub(crate) struct NativeScene(pub(crate) Scene);

type Column<'py, T> = Bound<'py, PyArray1<T>>;
/// Of positions and triangles.
type Copy = (Vec<[f32; 3]>, Vec<[u32; 3]>);
type Table<'py, T> = Bound<'py, PyArray2<T>>;

/// All hits: offsets, rays, t, geometry, primitive, weights.
type Listed<'py> = (
    Column<'py, i64>,
    Column<'py, i64>,
    Column<'py, f32>,
    Column<'py, u32>,
    Column<'py, u32>,
    Table<'py, f32>,
);

#[pymethods]
impl NativeScene {
    /// Builds over meshes of `(V, 3)` positions and `(F, 3)` triangles, with notes for its file.
    #[new]
    fn new(
        py: Python<'_>,
        meshes: Vec<(Rows<'_>, PyReadonlyArray2<'_, u32>)>,
        origin: Origin,
        preset: &str,
        threads: usize,
        notes: Vec<(String, Vec<u8>)>,
    ) -> PyResult<Self> {
        let options = PRESETS
            .iter()
            .find(|known| known.name == preset)
            .map(|known| (known.options)())
            .ok_or_else(|| {
                let names: Vec<_> = PRESETS.iter().map(|known| known.name).collect();
                PyValueError::new_err(format!(
                    "there is no quality {preset:?}: {}",
                    names.join(", ")
                ))
            })?;
        let copies = meshes
            .iter()
            .map(|(positions, indices)| {
                Ok((
                    positions.points("vertices", origin)?,
                    rows::<_, 3>(indices, "triangles")?,
                ))
            })
            .collect::<PyResult<Vec<_>>>()?;
        drop(meshes);
        let built = interruptible(py, threads, |_| {
            let mesh = |builder: SceneBuilder, (positions, indices): &Copy| {
                builder.mesh(positions, indices)
            };
            let builder = copies.iter().fold(Scene::builder(), mesh);
            builder.options(options).build()
        })?;
        let scene = built.map_err(|error| PyValueError::new_err(error.to_string()))?;
        let noted = notes.into_iter().fold(scene, |scene, (name, content)| {
            scene.with_note(&name, content)
        });
        Ok(Self(noted))
    }

    /// The closest hit of each ray.
    fn cast<'py>(
        &self,
        py: Python<'py>,
        rays: Asked<'py>,
        origin: Origin,
        threads: usize,
    ) -> PyResult<ask::Cast<'py>> {
        let rays = rays.at(origin)?;
        ask::closest_hits(py, &self.0, rays, threads)
    }

    /// Whether anything is in the way of each ray.
    fn occluded<'py>(
        &self,
        py: Python<'py>,
        rays: Asked<'py>,
        origin: Origin,
        threads: usize,
    ) -> PyResult<Array<'py, bool>> {
        let rays = rays.at(origin)?;
        ask::each(py, rays, threads, |rays, occluded| {
            self.0.occluded_each(rays, occluded);
        })
    }

    /// The number of the first triangle in its mesh, -1 if none.
    fn first<'py>(
        &self,
        py: Python<'py>,
        lines: Lines<'py>,
        origin: Origin,
        threads: usize,
    ) -> PyResult<Array<'py, i64>> {
        first::numbers(py, &self.0, &lines, origin, threads)
    }

    /// Triangle, ray and place of the first hit of each ray that has one.
    fn first_places<'py>(
        &self,
        py: Python<'py>,
        lines: Lines<'py>,
        origin: Origin,
        threads: usize,
    ) -> PyResult<first::Firsts<'py>> {
        first::places(py, &self.0, &lines, origin, threads)
    }

    /// All hits of each ray, nearest first.
    fn list<'py>(
        &self,
        py: Python<'py>,
        rays: Asked<'py>,
        origin: Origin,
        threads: usize,
    ) -> PyResult<Listed<'py>> {
        let rays = rays.at(origin)?;
        let HitLists { splits, hits } = interruptible(py, threads, |_| self.0.list_hits(&rays))?;
        let lengths = splits.windows(2).map(|ends| ends[1] - ends[0]);
        let mut ids = Vec::with_capacity(hits.len());
        for (length, ray) in lengths.zip(0_i64..) {
            ids.resize(ids.len() + length, ray);
        }
        Ok((
            column(py, splits.iter().map(|&split| split as i64).collect()),
            column(py, ids),
            column(py, hits.iter().map(|hit| hit.t).collect()),
            column(py, hits.iter().map(|hit| hit.geom).collect()),
            column(py, hits.iter().map(|hit| hit.prim).collect()),
            table(py, hits.iter().map(|hit| [hit.u, hit.v]).collect())?,
        ))
    }

    /// How many hits each ray has.
    fn count<'py>(
        &self,
        py: Python<'py>,
        rays: Asked<'py>,
        origin: Origin,
        threads: usize,
    ) -> PyResult<Array<'py, i64>> {
        let rays = rays.at(origin)?;
        ask::each(py, rays, threads, |rays, counts: &mut [i64]| {
            let numbers = &mut [0; ask::PIECE][..rays.len()];
            self.0.count_hits(rays, numbers);
            for (count, number) in counts.iter_mut().zip(numbers) {
                *count = i64::from(*number);
            }
        })
    }

    /// The nearest place of the surface for each point.
    fn nearest<'py>(
        &self,
        py: Python<'py>,
        points: Rows<'py>,
        origin: Origin,
        threads: usize,
    ) -> PyResult<ask::Closest<'py>> {
        ask::closest_points(py, &self.0, points.points("points", origin)?, threads)
    }

    /// Distances, negative inside.
    fn signed<'py>(
        &self,
        py: Python<'py>,
        points: Rows<'py>,
        origin: Origin,
        threads: usize,
    ) -> PyResult<Array<'py, f32>> {
        ask::each_point(
            py,
            points.points("points", origin)?,
            threads,
            |points, distances| {
                self.0.signed_distances(points, distances);
            },
        )
    }

    /// Whether each point is inside.
    fn inside<'py>(
        &self,
        py: Python<'py>,
        points: Rows<'py>,
        origin: Origin,
        threads: usize,
    ) -> PyResult<Array<'py, bool>> {
        ask::each_point(
            py,
            points.points("points", origin)?,
            threads,
            |points, inside| {
                self.0.is_inside_each(points, inside);
            },
        )
    }

    /// How one ray finds its answer, as text.
    fn explain(&self, ray: [f32; 6]) -> String {
        let [ox, oy, oz, dx, dy, dz] = ray;
        let _modes = FloatModes::enter();
        let walk = boxwood_trace::walk(&self.0, &Ray::new([ox, oy, oz], [dx, dy, dz]));
        walk.text(usize::MAX)
    }

    /// Triangles, skipped ones, nodes, leaves, depth, bytes, SAH cost.
    fn stats(&self) -> (usize, usize, usize, usize, u32, usize, f64) {
        let stats = self.0.stats();
        (
            self.0.len(),
            self.0.skipped(),
            stats.nodes,
            stats.leaves,
            stats.max_depth,
            stats.bytes,
            stats.sah_cost,
        )
    }

    /// Smallest and largest corner.
    fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        let bounds = self.0.bounds();
        (bounds.min, bounds.max)
    }
}
