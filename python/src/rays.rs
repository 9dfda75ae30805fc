//! Rays and points from arrays.

use crate::arrays::room;
use boxwood::Ray;
use boxwood_host::FloatModes;
use numpy::{PyReadonlyArray1, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Rows of numbers in one of two precisions, contiguous; all axes but the last count rows.
#[derive(FromPyObject)]
pub(crate) enum Table<'py> {
    Single(PyReadonlyArrayDyn<'py, f32>),
    Double(PyReadonlyArrayDyn<'py, f64>),
}

/// One number for all rays, or one for each.
#[derive(FromPyObject)]
pub(crate) enum Limit<'py> {
    All(f32),
    Each(PyReadonlyArray1<'py, f32>),
}

/// Rays: rows of origin and direction, least and greatest distance.
#[derive(FromPyObject)]
pub(crate) struct Asked<'py>(Table<'py>, Limit<'py>, Limit<'py>);

/// Origins and directions in arrays of their own, as many of each.
#[derive(FromPyObject)]
pub(crate) struct Lines<'py>(Table<'py>, Table<'py>);

/// What to subtract from coordinates before they become single precision.
pub(crate) type Origin = [f64; 3];

impl Table<'_> {
    fn shape(&self) -> &[usize] {
        match self {
            Self::Single(array) => array.shape(),
            Self::Double(array) => array.shape(),
        }
    }

    fn rows(&self) -> usize {
        self.shape().iter().rev().skip(1).product()
    }

    /// Copies of the rows as `row` makes them of `N` numbers, in the place of what is spare.
    fn copied<const N: usize, T>(
        &self,
        what: &str,
        origin: Origin,
        spare: Vec<T>,
        mut row: impl FnMut(usize, [f32; N]) -> T,
    ) -> PyResult<Vec<T>> {
        let broken = |why: &str| PyValueError::new_err(format!("{what} {why}"));
        if self.shape().last() != Some(&N) {
            return Err(broken(&format!("must have {N} columns")));
        }
        let scattered = |_| broken("must be contiguous");
        let mut rows = room(spare, self.rows())?;
        let _modes = FloatModes::enter();
        match self {
            Self::Single(array) if origin == [0.0; 3] => {
                let numbers = array.as_slice().map_err(scattered)?.as_chunks::<N>().0;
                rows.extend(numbers.iter().enumerate().map(|(i, x)| row(i, *x)));
            }
            Self::Single(array) => {
                let numbers = array.as_slice().map_err(scattered)?.as_chunks::<N>().0;
                let near = numbers.iter().map(|x| moved(x.map(f64::from), origin));
                rows.extend(near.enumerate().map(|(i, x)| row(i, x)));
            }
            Self::Double(array) => {
                let numbers = array.as_slice().map_err(scattered)?.as_chunks::<N>().0;
                let near = numbers.iter().map(|x| moved(*x, origin));
                rows.extend(near.enumerate().map(|(i, x)| row(i, x)));
            }
        }
        Ok(rows)
    }

    /// The rows where they lie.
    fn numbers(&self) -> PyResult<Numbers<'_>> {
        Ok(match self {
            Self::Single(array) => Numbers::Single(array.as_slice()?.as_chunks().0),
            Self::Double(array) => Numbers::Double(array.as_slice()?.as_chunks().0),
        })
    }

    /// Points or vertices from rows.
    pub(crate) fn points(&self, what: &str, origin: Origin) -> PyResult<Vec<[f32; 3]>> {
        self.copied(what, origin, Vec::new(), |_, point| point)
    }
}

impl Asked<'_> {
    /// As the core takes them.
    pub(crate) fn at(&self, origin: Origin) -> PyResult<Vec<Ray>> {
        let Self(table, near, far) = self;
        let rays = table.rows();
        let (near, far) = (near.read(rays, "tnear")?, far.read(rays, "tfar")?);
        table.copied("rays", origin, spare(), |i, [ox, oy, oz, dx, dy, dz]| Ray {
            origin: [ox, oy, oz],
            t_min: near(i),
            dir: [dx, dy, dz],
            t_max: far(i),
        })
    }
}

impl Lines<'_> {
    /// As the core takes them, without limits.
    pub(crate) fn at(&self, origin: Origin) -> PyResult<Vec<Ray>> {
        let Self(origins, directions) = self;
        let start = |_, place| Ray::new(place, [0.0; 3]);
        let mut rays = origins.copied("origins", origin, spare(), start)?;
        if directions.rows() != rays.len() {
            let (origins, directions) = (rays.len(), directions.rows());
            let error = format!("{origins} origins for {directions} directions");
            return Err(PyValueError::new_err(error));
        }
        directions.copied("directions", [0.0; 3], Vec::new(), |i, dir| {
            rays[i].dir = dir;
        })?;
        Ok(rays)
    }

    /// Where hits at a distance are, in the precision of the arrays. What another thread took away meanwhile is NaN.
    pub(crate) fn places(
        &self,
        hits: impl Iterator<Item = (usize, f32)>,
        places: &mut [[f64; 3]],
    ) -> PyResult<()> {
        let (origins, directions) = (self.0.numbers()?, self.1.numbers()?);
        for (place, (ray, t)) in places.iter_mut().zip(hits) {
            let (origin, dir) = (origins.get(ray), directions.get(ray));
            *place = std::array::from_fn(|axis| origin[axis] + f64::from(t) * dir[axis]);
        }
        Ok(())
    }
}

/// The rows of a table of three columns.
enum Numbers<'a> {
    Single(&'a [[f32; 3]]),
    Double(&'a [[f64; 3]]),
}

impl Numbers<'_> {
    fn get(&self, row: usize) -> [f64; 3] {
        let found = match self {
            Self::Single(rows) => rows.get(row).map(|row| row.map(f64::from)),
            Self::Double(rows) => rows.get(row).copied(),
        };
        found.unwrap_or([f64::NAN; 3])
    }
}

/// Memory of rays that were answered, for the next ones: the system lays out new memory page by page, which took a tenth of
/// the time of a million rays.
static SPARE: Mutex<Vec<Ray>> = Mutex::new(Vec::new());

/// Most rays to keep memory for: 32 MiB.
const MOST_SPARE: usize = 1 << 20;

fn spare() -> Vec<Ray> {
    std::mem::take(&mut *SPARE.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Keeps the memory of rays for the next ones.
pub(crate) fn keep(mut rays: Vec<Ray>) {
    if rays.capacity() <= MOST_SPARE {
        rays.clear();
        *SPARE.lock().unwrap_or_else(PoisonError::into_inner) = rays;
    }
}

/// In the three first columns.
fn moved<const N: usize>(numbers: [f64; N], origin: Origin) -> [f32; N] {
    let by = |column: usize| origin.get(column).copied().unwrap_or(0.0);
    std::array::from_fn(|column| (numbers[column] - by(column)) as f32)
}

impl Limit<'_> {
    fn read(&self, rays: usize, what: &str) -> PyResult<impl Fn(usize) -> f32> {
        let (all, each) = match self {
            Self::All(number) => (*number, None),
            Self::Each(array) => (0.0, array.as_slice().ok()),
        };
        match each {
            Some(each) if each.len() != rays => Err(PyValueError::new_err(format!(
                "{what} has {} numbers for {rays} rays",
                each.len()
            ))),
            _ => Ok(move |i: usize| each.map_or(all, |each| each[i])),
        }
    }
}
