//! Questions with one answer for each ray or point: in pieces, on all threads, each piece from question to arrays in one go, so
//! that nothing travels to memory and back in between.

use crate::arrays::{Answers, Array};
use crate::pool::interruptible;
use crate::rays::keep;
use boxwood::{Hit, Nearest, Ray, Scene};
use numpy::Element;
use pyo3::prelude::*;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// What does not exist: Open3D's number for it.
pub(crate) const NOTHING: u32 = u32::MAX;

/// Rays that one task answers, as in the core.
pub(crate) const PIECE: usize = 1024;
/// Most pieces that a thread takes at a time, by their size: else a quarter of all rays is one task, and who is done first waits
/// for the other.
pub(crate) fn pieces_at_a_time(piece: usize) -> usize {
    (16 * PIECE / piece).max(1)
}

/// Most and least points that one task answers: the core sorts them along a curve, and the more, the closer are neighbours.
const POINTS: [usize; 2] = [1 << 12, 1 << 16];

/// Points that one task answers of so many: some tasks for each thread, so that all are done at about the same time.
fn points_at_a_time(points: usize) -> usize {
    let [least, most] = POINTS;
    match rayon::current_num_threads() {
        1 => most,
        threads => points.div_ceil(4 * threads).clamp(least, most),
    }
}

/// The answers to closest hits: t, geometry, primitive, weights, normal, whether there is one.
pub(crate) type Cast<'py> = (
    Array<'py, f32>,
    Array<'py, u32>,
    Array<'py, u32>,
    Array<'py, f32>,
    Array<'py, f32>,
    Array<'py, bool>,
);

/// Nearest places: point, distance, geometry, primitive, weights, normal.
pub(crate) type Closest<'py> = (
    Array<'py, f32>,
    Array<'py, f32>,
    Array<'py, u32>,
    Array<'py, u32>,
    Array<'py, f32>,
    Array<'py, f32>,
);

/// The closest hit of each ray.
pub(crate) fn closest_hits<'py>(
    py: Python<'py>,
    scene: &Scene,
    rays: Vec<Ray>,
    threads: usize,
) -> PyResult<Cast<'py>> {
    let n = rays.len();
    let (mut ts, mut is_hit) = (Answers::column(py, n)?, Answers::column(py, n)?);
    let (mut geoms, mut prims) = (Answers::column(py, n)?, Answers::column(py, n)?);
    let (mut uvs, mut normals) = (Answers::table(py, n, 2)?, Answers::table(py, n, 3)?);
    let (t, hit) = (ts.numbers()?, is_hit.numbers()?);
    let (geom, prim) = (geoms.numbers()?, prims.numbers()?);
    let (uv, normal) = (uvs.rows()?, normals.rows()?);
    interruptible(py, threads, |cancel| {
        (
            rays.par_chunks(PIECE),
            t.par_chunks_mut(PIECE),
            geom.par_chunks_mut(PIECE),
            prim.par_chunks_mut(PIECE),
            uv.par_chunks_mut(PIECE),
            normal.par_chunks_mut(PIECE),
            hit.par_chunks_mut(PIECE),
        )
            .into_par_iter()
            .with_max_len(pieces_at_a_time(PIECE))
            .for_each(|(rays, t, geoms, prims, uvs, normals, hit)| {
                if cancel.load(Ordering::Relaxed) {
                    return;
                }
                let hits = &mut [None; PIECE][..rays.len()];
                scene.closest_hits_fetching(rays, hits);
                t.fill(f32::INFINITY);
                geoms.fill(NOTHING);
                prims.fill(NOTHING);
                for (i, found) in found(hits, hit) {
                    (t[i], uvs[i]) = (found.t, [found.u, found.v]);
                    (geoms[i], prims[i]) = (found.geom, found.prim);
                }
                scene.unit_normals(geoms, prims, normals);
            });
    })?;
    keep(rays);
    Ok((
        ts.array(),
        geoms.array(),
        prims.array(),
        uvs.array(),
        normals.array(),
        is_hit.array(),
    ))
}

/// The hits that there are, each with the number of its ray in the piece; and whether each ray has one.
fn found(hits: &[Option<Hit>], is_hit: &mut [bool]) -> impl Iterator<Item = (usize, Hit)> {
    for (is_hit, hit) in is_hit.iter_mut().zip(hits) {
        *is_hit = hit.is_some();
    }
    those_that_hit(hits)
}

/// The hits that there are, each with the number of its ray in the piece. Which ray hits cannot be guessed, so the numbers are
/// gathered without a branch.
pub(crate) fn those_that_hit(hits: &[Option<Hit>]) -> impl Iterator<Item = (usize, Hit)> {
    let (mut numbers, mut count) = ([0; PIECE], 0);
    for (number, hit) in hits.iter().enumerate() {
        numbers[count] = number;
        count += usize::from(hit.is_some());
    }
    let numbers = numbers.into_iter().take(count);
    numbers.filter_map(|number| hits[number].map(|hit| (number, hit)))
}

/// The nearest place of the surface for each point.
pub(crate) fn closest_points<'py>(
    py: Python<'py>,
    scene: &Scene,
    points: Vec<[f32; 3]>,
    threads: usize,
) -> PyResult<Closest<'py>> {
    let n = points.len();
    let (mut places, mut distances) = (Answers::table(py, n, 3)?, Answers::column(py, n)?);
    let (mut geoms, mut prims) = (Answers::column(py, n)?, Answers::column(py, n)?);
    let (mut uvs, mut normals) = (Answers::table(py, n, 2)?, Answers::table(py, n, 3)?);
    let (at, distance) = (places.rows()?, distances.numbers()?);
    let (geom, prim) = (geoms.numbers()?, prims.numbers()?);
    let (uv, normal) = (uvs.rows()?, normals.rows()?);
    interruptible(py, threads, |cancel| {
        let piece = points_at_a_time(n);
        (
            points.par_chunks(piece),
            at.par_chunks_mut(piece),
            distance.par_chunks_mut(piece),
            geom.par_chunks_mut(piece),
            prim.par_chunks_mut(piece),
            uv.par_chunks_mut(piece),
            normal.par_chunks_mut(piece),
        )
            .into_par_iter()
            .with_max_len(pieces_at_a_time(piece))
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
        places.array(),
        distances.array(),
        geoms.array(),
        prims.array(),
        uvs.array(),
        normals.array(),
    ))
}

/// One plain number for each ray, by a question that takes slices.
pub(crate) fn each<'py, T>(
    py: Python<'py>,
    rays: Vec<Ray>,
    threads: usize,
    ask: impl Fn(&[Ray], &mut [T]) + Sync,
) -> PyResult<Array<'py, T>>
where
    T: Element + Send,
{
    let answers = each_in(|_| PIECE, py, &rays, threads, ask)?;
    keep(rays);
    Ok(answers)
}

/// [`each`] for points.
pub(crate) fn each_point<'py, T>(
    py: Python<'py>,
    points: Vec<[f32; 3]>,
    threads: usize,
    ask: impl Fn(&[[f32; 3]], &mut [T]) + Sync,
) -> PyResult<Array<'py, T>>
where
    T: Element + Send,
{
    each_in(points_at_a_time, py, &points, threads, ask)
}

fn each_in<'py, Q, T>(
    piece: impl Fn(usize) -> usize + Sync,
    py: Python<'py>,
    questions: &[Q],
    threads: usize,
    ask: impl Fn(&[Q], &mut [T]) + Sync,
) -> PyResult<Array<'py, T>>
where
    Q: Sync,
    T: Element + Send,
{
    let mut answers = Answers::column(py, questions.len())?;
    let numbers = answers.numbers()?;
    let in_pieces = |cancel: &AtomicBool| {
        let piece = piece(questions.len());
        let pieces = (questions.par_chunks(piece), numbers.par_chunks_mut(piece));
        let pieces = pieces.into_par_iter().with_max_len(pieces_at_a_time(piece));
        pieces.for_each(|(questions, answers)| {
            if !cancel.load(Ordering::Relaxed) {
                ask(questions, answers);
            }
        });
    };
    interruptible(py, threads, in_pieces)?;
    Ok(answers.array())
}
