//! Questions, one and many.

use crate::error::{BwError, Failure};
use crate::memory::{Given, Input, Output, Plain};
use crate::threads::on_threads;
use crate::types::{BwHit, BwNearest, BwRay};
use boxwood::{Hit, Ray, Scene};
use rayon::prelude::*;

/// Questions that one task answers: as many as the core has at once.
const CHUNK: usize = 1024;

/// The hit as C has it.
#[inline]
pub(crate) fn located(scene: &Scene, hit: Option<Hit>) -> BwHit {
    hit.map_or(BwHit::MISS, |hit| {
        BwHit::new(hit, scene.normal(&hit).unwrap_or_default())
    })
}

/// The closest hit of each ray.
pub(crate) fn closest_hits(
    scene: &Scene,
    threads: u32,
    rays: &Input<'_, BwRay>,
    hits: Output<'_, BwHit>,
) -> Result<(), Failure> {
    in_pieces(threads, rays.len(), hits, |first, count, output| {
        let rays: Vec<Ray> = gathered(rays, first, count);
        let mut hits = vec![None; count];
        scene.closest_hits(&rays, &mut hits);
        for (index, hit) in hits.into_iter().enumerate() {
            output.set(index, located(scene, hit));
        }
    })
}

/// Whether anything is in the way of each ray.
pub(crate) fn occluded_each(
    scene: &Scene,
    threads: u32,
    rays: &Input<'_, BwRay>,
    occluded: Output<'_, bool>,
) -> Result<(), Failure> {
    in_pieces(threads, rays.len(), occluded, |first, count, output| {
        let rays: Vec<Ray> = gathered(rays, first, count);
        let mut answers = vec![false; count];
        scene.occluded_each(&rays, &mut answers);
        for (index, answer) in answers.into_iter().enumerate() {
            output.set(index, answer);
        }
    })
}

/// The nearest place of the surface for each point.
pub(crate) fn closest_points(
    scene: &Scene,
    threads: u32,
    points: &Input<'_, [f32; 3]>,
    nearest: Output<'_, BwNearest>,
) -> Result<(), Failure> {
    has_distances(scene)?;
    in_pieces(threads, points.len(), nearest, |first, count, output| {
        let points = gathered(points, first, count);
        let mut places = vec![None; count];
        scene.closest_points(&points, &mut places);
        for (index, place) in places.into_iter().enumerate() {
            output.set(index, place.map_or(BwNearest::NOWHERE, BwNearest::from));
        }
    })
}

/// Distances, negative inside.
pub(crate) fn signed_distances(
    scene: &Scene,
    threads: u32,
    points: &Input<'_, [f32; 3]>,
    distances: Output<'_, f32>,
) -> Result<(), Failure> {
    has_distances(scene)?;
    in_pieces(threads, points.len(), distances, |first, count, output| {
        let points = gathered(points, first, count);
        let mut answers = vec![0.0; count];
        scene.signed_distances(&points, &mut answers);
        for (index, answer) in answers.into_iter().enumerate() {
            output.set(index, answer);
        }
    })
}

/// Runs `answer(first, count, places)` for every piece, on so many threads where that is worth it.
fn in_pieces<T: Given>(
    threads: u32,
    count: usize,
    output: Output<'_, T>,
    answer: impl Fn(usize, usize, &mut Output<'_, T>) + Sync,
) -> Result<(), Failure> {
    let piece = |(number, mut places): (usize, Output<'_, T>)| {
        let first = number * CHUNK;
        answer(first, CHUNK.min(count - first), &mut places);
    };
    let pieces = output.pieces(CHUNK)?;
    if threads == 1 || pieces.len() == 1 {
        pieces.into_iter().enumerate().for_each(piece);
        return Ok(());
    }
    on_threads(threads, || {
        pieces.into_par_iter().enumerate().for_each(piece);
    })
}

/// A piece of what C gave, without gaps.
fn gathered<C: Plain, T: From<C>>(input: &Input<'_, C>, first: usize, count: usize) -> Vec<T> {
    (first..first + count)
        .map(|index| input.get(index).into())
        .collect()
}

fn has_distances(scene: &Scene) -> Result<(), Failure> {
    if scene.instances().is_empty() {
        return Ok(());
    }
    let message = "distances are there for scenes of triangles, not of instances";
    Err(Failure::new(BwError::Unsupported, message))
}
