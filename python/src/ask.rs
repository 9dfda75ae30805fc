//! Questions with one answer for each ray or point: in pieces, on all threads, each piece from question to arrays in one go, so
//! that nothing travels to memory and back in between.

use crate::arrays::{column, table, zeroed};
use crate::pool::interruptible;
use crate::rays::keep;
use boxwood::{Hit, Nearest, Ray, Scene};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// What does not exist: Open3D's number for it.
pub(crate) const NOTHING: u32 = u32::MAX;

/// Rays that one task answers, as in the core.
pub(crate) const PIECE: usize = 1024;
/// Points that one task answers: the core sorts them along a curve, and the more, the closer are neighbours.
const POINTS: usize = 1 << 16;

type Column<'py, T> = Bound<'py, PyArray1<T>>;
type Table<'py, T> = Bound<'py, PyArray2<T>>;

/// The answers to closest hits: t, geometry, primitive, weights, normal, whether there is one.
pub(crate) type Cast<'py> = (
    Column<'py, f32>,
    Column<'py, u32>,
    Column<'py, u32>,
    Table<'py, f32>,
    Table<'py, f32>,
    Column<'py, bool>,
);

/// Nearest places: point, distance, geometry, primitive, weights, normal.
pub(crate) type Closest<'py> = (
    Table<'py, f32>,
    Column<'py, f32>,
    Column<'py, u32>,
    Column<'py, u32>,
    Table<'py, f32>,
    Table<'py, f32>,
);

/// The closest hit of each ray.
pub(crate) fn closest_hits<'py>(
    py: Python<'py>,
    scene: &Scene,
    rays: Vec<Ray>,
    threads: usize,
) -> PyResult<Cast<'py>> {
    let n = rays.len();
    let (mut t, mut hit) = (zeroed(n)?, zeroed(n)?);
    let (mut geoms, mut prims) = (zeroed(n)?, zeroed(n)?);
    let (mut uvs, mut normals) = (zeroed(n)?, zeroed(n)?);
    interruptible(py, threads, |cancel| {
        (
            rays.par_chunks(PIECE),
            t.par_chunks_mut(PIECE),
            geoms.par_chunks_mut(PIECE),
            prims.par_chunks_mut(PIECE),
            uvs.par_chunks_mut(PIECE),
            normals.par_chunks_mut(PIECE),
            hit.par_chunks_mut(PIECE),
        )
            .into_par_iter()
            .for_each_init(
                || vec![None; PIECE],
                |hits, (rays, t, geoms, prims, uvs, normals, hit)| {
                    if cancel.load(Ordering::Relaxed) {
                        return;
                    }
                    let hits = &mut hits[..rays.len()];
                    scene.closest_hits_fetching(rays, hits);
                    for (i, found) in hits.iter().enumerate() {
                        let Hit {
                            t: at,
                            u,
                            v,
                            prim,
                            geom,
                            ..
                        } = found.unwrap_or(MISS);
                        (t[i], geoms[i], prims[i], uvs[i]) = (at, geom, prim, [u, v]);
                        hit[i] = found.is_some();
                    }
                    scene.unit_normals(geoms, prims, normals);
                },
            );
    })?;
    keep(rays);
    Ok((
        column(py, t),
        column(py, geoms),
        column(py, prims),
        table(py, uvs)?,
        table(py, normals)?,
        column(py, hit),
    ))
}

/// As arrays say it.
const MISS: Hit = Hit {
    t: f32::INFINITY,
    u: 0.0,
    v: 0.0,
    prim: NOTHING,
    geom: NOTHING,
    inst: Hit::NO_INSTANCE,
};

/// The nearest place of the surface for each point.
pub(crate) fn closest_points<'py>(
    py: Python<'py>,
    scene: &Scene,
    points: Vec<[f32; 3]>,
    threads: usize,
) -> PyResult<Closest<'py>> {
    let n = points.len();
    let (mut at, mut distances) = (zeroed(n)?, zeroed(n)?);
    let (mut geoms, mut prims) = (zeroed(n)?, zeroed(n)?);
    let (mut uvs, mut normals) = (zeroed(n)?, zeroed(n)?);
    interruptible(py, threads, |cancel| {
        (
            points.par_chunks(POINTS),
            at.par_chunks_mut(POINTS),
            distances.par_chunks_mut(POINTS),
            geoms.par_chunks_mut(POINTS),
            prims.par_chunks_mut(POINTS),
            uvs.par_chunks_mut(POINTS),
            normals.par_chunks_mut(POINTS),
        )
            .into_par_iter()
            .for_each(|(points, at, distances, geoms, prims, uvs, normals)| {
                if cancel.load(Ordering::Relaxed) {
                    return;
                }
                let mut places: Vec<Option<Nearest>> = vec![None; points.len()];
                scene.closest_points(points, &mut places);
                for (i, place) in places.iter().enumerate() {
                    let Some(place) = place else {
                        (at[i], distances[i]) = ([f32::NAN; 3], f32::NAN);
                        (geoms[i], prims[i]) = (NOTHING, NOTHING);
                        continue;
                    };
                    (at[i], distances[i]) = (place.point, place.distance);
                    (geoms[i], prims[i]) = (place.geom, place.prim);
                    uvs[i] = [place.u, place.v];
                }
                scene.unit_normals(geoms, prims, normals);
            });
    })?;
    Ok((
        table(py, at)?,
        column(py, distances),
        column(py, geoms),
        column(py, prims),
        table(py, uvs)?,
        table(py, normals)?,
    ))
}

/// One plain number for each ray, by a question that takes slices.
pub(crate) fn each<'py, T>(
    py: Python<'py>,
    rays: Vec<Ray>,
    threads: usize,
    ask: impl Fn(&[Ray], &mut [T]) + Sync,
) -> PyResult<Column<'py, T>>
where
    T: numpy::Element + bytemuck::Zeroable + Send,
{
    let answers = each_in(PIECE, py, &rays, threads, ask)?;
    keep(rays);
    Ok(answers)
}

/// The number in its mesh of the first primitive that each ray hits, -1 if none.
pub(crate) fn first<'py>(
    py: Python<'py>,
    scene: &Scene,
    rays: Vec<Ray>,
    threads: usize,
) -> PyResult<Column<'py, i64>> {
    each(py, rays, threads, |rays, prims| {
        let hits = &mut [None; PIECE][..rays.len()];
        scene.closest_hits(rays, hits);
        for (prim, hit) in prims.iter_mut().zip(hits) {
            *prim = hit.map_or(-1, |hit| i64::from(hit.prim));
        }
    })
}

/// [`each`] for points.
pub(crate) fn each_point<'py, T>(
    py: Python<'py>,
    points: Vec<[f32; 3]>,
    threads: usize,
    ask: impl Fn(&[[f32; 3]], &mut [T]) + Sync,
) -> PyResult<Column<'py, T>>
where
    T: numpy::Element + bytemuck::Zeroable + Send,
{
    each_in(POINTS, py, &points, threads, ask)
}

fn each_in<'py, Q, T>(
    piece: usize,
    py: Python<'py>,
    questions: &[Q],
    threads: usize,
    ask: impl Fn(&[Q], &mut [T]) + Sync,
) -> PyResult<Column<'py, T>>
where
    Q: Sync,
    T: numpy::Element + bytemuck::Zeroable + Send,
{
    let mut answers = zeroed(questions.len())?;
    let in_pieces = |cancel: &AtomicBool| {
        let pieces = (questions.par_chunks(piece), answers.par_chunks_mut(piece));
        pieces.into_par_iter().for_each(|(questions, answers)| {
            if !cancel.load(Ordering::Relaxed) {
                ask(questions, answers);
            }
        });
    };
    interruptible(py, threads, in_pieces)?;
    Ok(column(py, answers))
}
