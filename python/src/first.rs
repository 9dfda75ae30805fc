//! First hits in the shapes of trimesh: numbers of triangles for all rays, or rays and places of those that hit.

use crate::arrays::{Answers, Array, room};
use crate::ask::{PIECE, each, pieces_at_a_time, those_that_hit};
use crate::pool::interruptible;
use crate::rays::{Lines, Origin, keep};
use boxwood::Scene;
use pyo3::prelude::*;
use rayon::prelude::*;
use std::sync::atomic::Ordering;

/// Of each hit: triangle, ray, place.
pub(crate) type Firsts<'py> = (Array<'py, i64>, Array<'py, i64>, Array<'py, f64>);

/// A hit of a ray.
#[derive(Clone, Copy, Default)]
struct First {
    ray: usize,
    prim: u32,
    t: f32,
}

/// The number in its mesh of the first primitive that each ray hits, -1 if none.
pub(crate) fn numbers<'py>(
    py: Python<'py>,
    scene: &Scene,
    lines: &Lines<'py>,
    origin: Origin,
    threads: usize,
) -> PyResult<Array<'py, i64>> {
    each(py, lines.at(origin)?, threads, |rays, prims| {
        let hits = &mut [None; PIECE][..rays.len()];
        scene.closest_hits(rays, hits);
        for (prim, hit) in prims.iter_mut().zip(hits) {
            *prim = hit.map_or(-1, |hit| i64::from(hit.prim));
        }
    })
}

/// The first hit of each ray that has one, in the order of the rays.
pub(crate) fn places<'py>(
    py: Python<'py>,
    scene: &Scene,
    lines: &Lines<'py>,
    origin: Origin,
    threads: usize,
) -> PyResult<Firsts<'py>> {
    let rays = lines.at(origin)?;
    let mut firsts = room(Vec::new(), rays.len())?;
    firsts.resize(rays.len(), First::default());
    // Each piece keeps its own hits at the beginning of its part.
    let mut counts = room(Vec::new(), rays.len().div_ceil(PIECE))?;
    counts.resize(counts.capacity(), 0);
    interruptible(py, threads, |cancel| {
        let parts = (
            rays.par_chunks(PIECE),
            firsts.par_chunks_mut(PIECE),
            &mut counts,
        );
        let numbered = parts
            .into_par_iter()
            .enumerate()
            .with_max_len(pieces_at_a_time(PIECE));
        numbered.for_each(|(piece, (rays, firsts, count))| {
            if cancel.load(Ordering::Relaxed) {
                return;
            }
            let hits = &mut [None; PIECE][..rays.len()];
            scene.closest_hits(rays, hits);
            for (number, hit) in those_that_hit(hits) {
                let (ray, prim, t) = (piece * PIECE + number, hit.prim, hit.t);
                firsts[*count] = First { ray, prim, t };
                *count += 1;
            }
        });
    })?;
    keep(rays);
    let parts = firsts.chunks(PIECE).zip(&counts);
    let found = || parts.clone().flat_map(|(firsts, &count)| &firsts[..count]);
    let n = counts.iter().sum();
    let (mut prims, mut ids) = (Answers::column(py, n)?, Answers::column(py, n)?);
    let mut places = Answers::table(py, n, 3)?;
    for ((prim, id), first) in prims.numbers()?.iter_mut().zip(ids.numbers()?).zip(found()) {
        (*prim, *id) = (i64::from(first.prim), first.ray as i64);
    }
    lines.places(found().map(|first| (first.ray, first.t)), places.rows()?)?;
    Ok((prims.array(), ids.array(), places.array()))
}
