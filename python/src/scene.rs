//! A scene and its questions.

use crate::arrays::{column, rows, table};
use crate::pool::on_threads;
use boxwood::build::PRESETS;
use boxwood::{Hit, Nearest, Ray, Scene};
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// What does not exist: Open3D's number for it.
const NOTHING: u32 = u32::MAX;

/// Built once; every question leaves it as it is.
#[pyclass(frozen, name = "NativeScene", module = "boxwood._native")]
pub(crate) struct NativeScene(pub(crate) Scene);

type Column<'py, T> = Bound<'py, PyArray1<T>>;
type Table<'py, T> = Bound<'py, PyArray2<T>>;

/// The answers to closest hits: t, geometry, primitive, weights, normal.
type Cast<'py> = (
    Column<'py, f32>,
    Column<'py, u32>,
    Column<'py, u32>,
    Table<'py, f32>,
    Table<'py, f32>,
);

/// All hits: offsets, rays, t, geometry, primitive, weights.
type Listed<'py> = (
    Column<'py, i64>,
    Column<'py, i64>,
    Column<'py, f32>,
    Column<'py, u32>,
    Column<'py, u32>,
    Table<'py, f32>,
);

/// Nearest places: point, distance, geometry, primitive, weights, normal.
type Closest<'py> = (
    Table<'py, f32>,
    Column<'py, f32>,
    Column<'py, u32>,
    Column<'py, u32>,
    Table<'py, f32>,
    Table<'py, f32>,
);

#[pymethods]
impl NativeScene {
    /// Builds over meshes of `(V, 3)` positions and `(F, 3)` triangles.
    #[new]
    fn new(
        py: Python<'_>,
        meshes: Vec<(PyReadonlyArray2<'_, f32>, PyReadonlyArray2<'_, u32>)>,
        preset: &str,
        threads: usize,
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
                    rows::<_, 3>(positions, "vertices")?,
                    rows::<_, 3>(indices, "triangles")?,
                ))
            })
            .collect::<PyResult<Vec<_>>>()?;
        drop(meshes);
        let built = py.detach(|| {
            on_threads(threads, || {
                copies
                    .iter()
                    .fold(Scene::builder(), |builder, (positions, indices)| {
                        builder.mesh(positions, indices)
                    })
                    .options(options)
                    .build()
            })
        })?;
        built
            .map(Self)
            .map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// The closest hit of each ray.
    fn cast<'py>(
        &self,
        py: Python<'py>,
        rays: PyReadonlyArray2<'py, f32>,
        near: f32,
        far: f32,
        threads: usize,
    ) -> PyResult<Cast<'py>> {
        let rays = rays_of(&rays, near, far)?;
        let (hits, normals) = py.detach(|| {
            on_threads(threads, || {
                let mut hits = vec![None; rays.len()];
                self.0.closest_hits(&rays, &mut hits);
                let normal = |hit: &Hit| self.unit_normal(hit.geom, hit.prim);
                let normals = each(&hits, [0.0; 3], normal);
                (hits, normals)
            })
        })?;
        Ok((
            column(py, each(&hits, f32::INFINITY, |hit| hit.t)),
            column(py, each(&hits, NOTHING, |hit| hit.geom)),
            column(py, each(&hits, NOTHING, |hit| hit.prim)),
            table(py, each(&hits, [0.0; 2], |hit| [hit.u, hit.v]))?,
            table(py, normals)?,
        ))
    }

    /// Whether anything is in the way of each ray.
    fn occluded<'py>(
        &self,
        py: Python<'py>,
        rays: PyReadonlyArray2<'py, f32>,
        near: f32,
        far: f32,
        threads: usize,
    ) -> PyResult<Column<'py, bool>> {
        let rays = rays_of(&rays, near, far)?;
        let occluded = py.detach(|| {
            on_threads(threads, || {
                let mut occluded = vec![false; rays.len()];
                self.0.occluded_each(&rays, &mut occluded);
                occluded
            })
        })?;
        Ok(column(py, occluded))
    }

    /// All hits of each ray, nearest first.
    fn list<'py>(
        &self,
        py: Python<'py>,
        rays: PyReadonlyArray2<'py, f32>,
        near: f32,
        far: f32,
        threads: usize,
    ) -> PyResult<Listed<'py>> {
        let rays = rays_of(&rays, near, far)?;
        let hits = py.detach(|| on_threads(threads, || self.0.all_hits_each(&rays)))?;
        let mut splits = vec![0_i64];
        splits.extend(hits.iter().scan(0, |sum, hits| {
            *sum += hits.len() as i64;
            Some(*sum)
        }));
        let numbers = hits.iter().zip(0_i64..);
        let ids = numbers.flat_map(|(hits, ray)| std::iter::repeat_n(ray, hits.len()));
        let all = || hits.iter().flatten();
        Ok((
            column(py, splits),
            column(py, ids.collect()),
            column(py, all().map(|hit| hit.t).collect()),
            column(py, all().map(|hit| hit.geom).collect()),
            column(py, all().map(|hit| hit.prim).collect()),
            table(py, all().map(|hit| [hit.u, hit.v]).collect())?,
        ))
    }

    /// How many hits each ray has.
    fn count<'py>(
        &self,
        py: Python<'py>,
        rays: PyReadonlyArray2<'py, f32>,
        near: f32,
        far: f32,
        threads: usize,
    ) -> PyResult<Column<'py, i64>> {
        let rays = rays_of(&rays, near, far)?;
        let hits = py.detach(|| on_threads(threads, || self.0.all_hits_each(&rays)))?;
        Ok(column(
            py,
            hits.iter().map(|hits| hits.len() as i64).collect(),
        ))
    }

    /// The nearest place of the surface for each point.
    fn nearest<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f32>,
        threads: usize,
    ) -> PyResult<Closest<'py>> {
        let points = rows::<f32, 3>(&points, "points")?;
        let (places, normals) = py.detach(|| {
            on_threads(threads, || {
                let mut places = vec![None; points.len()];
                self.0.closest_points(&points, &mut places);
                let normal = |place: &Nearest| self.unit_normal(place.geom, place.prim);
                let normals = each(&places, [0.0; 3], normal);
                (places, normals)
            })
        })?;
        Ok((
            table(py, each(&places, [f32::NAN; 3], |place| place.point))?,
            column(py, each(&places, f32::NAN, |place| place.distance)),
            column(py, each(&places, NOTHING, |place| place.geom)),
            column(py, each(&places, NOTHING, |place| place.prim)),
            table(py, each(&places, [0.0; 2], |place| [place.u, place.v]))?,
            table(py, normals)?,
        ))
    }

    /// Distances, negative inside.
    fn signed<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f32>,
        threads: usize,
    ) -> PyResult<Column<'py, f32>> {
        let points = rows::<f32, 3>(&points, "points")?;
        let distances = py.detach(|| {
            on_threads(threads, || {
                let mut distances = vec![0.0; points.len()];
                self.0.signed_distances(&points, &mut distances);
                distances
            })
        })?;
        Ok(column(py, distances))
    }

    /// Whether each point is inside.
    fn inside<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f32>,
        threads: usize,
    ) -> PyResult<Column<'py, bool>> {
        let points = rows::<f32, 3>(&points, "points")?;
        let inside = py.detach(|| {
            on_threads(threads, || {
                let mut inside = vec![false; points.len()];
                self.0.is_inside_each(&points, &mut inside);
                inside
            })
        })?;
        Ok(column(py, inside))
    }

    /// How one ray finds its answer, as text.
    fn explain(&self, ray: [f32; 6]) -> String {
        let [ox, oy, oz, dx, dy, dz] = ray;
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

impl NativeScene {
    /// In double precision, since squares of lengths may be beyond single precision.
    fn unit_normal(&self, geom: u32, prim: u32) -> [f32; 3] {
        let normal = self
            .0
            .triangle(geom, prim)
            .map_or([0.0; 3], |triangle| triangle.normal())
            .map(f64::from);
        let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length > 0.0 {
            normal.map(|x| (x / length) as f32)
        } else {
            [0.0; 3]
        }
    }
}

/// One number of each answer, `missing` where there is none.
fn each<T, U: Copy>(answers: &[Option<T>], missing: U, of: impl Fn(&T) -> U) -> Vec<U> {
    let number = |answer: &Option<T>| answer.as_ref().map_or(missing, &of);
    answers.iter().map(number).collect()
}

/// Rays from rows of origin and direction.
fn rays_of(array: &PyReadonlyArray2<'_, f32>, near: f32, far: f32) -> PyResult<Vec<Ray>> {
    let rows = rows::<f32, 6>(array, "rays")?;
    let ray = |[ox, oy, oz, dx, dy, dz]: [f32; 6]| Ray {
        origin: [ox, oy, oz],
        t_min: near,
        dir: [dx, dy, dz],
        t_max: far,
    };
    Ok(rows.into_iter().map(ray).collect())
}
