//! All hits of many rays: what becomes of a leaf's candidates if every hit counts, and not the closest alone.
//!
//! Nothing shortens a ray, so children wait in any order, and rays are independent of what they hit. Candidates of which the fast test is
//! sure are told to who asks (`lists`); all others are decided exactly at once.

use super::Wide;
use super::batch::Answers;
use super::form::Form;
use super::lanes::LeafTest;
use super::layout::Ref;
use super::pending::exact;
use super::prepare::Record;
use super::ray::EdgeLanes;
use crate::geom::{PreparedRay, Ray};
use fearless_simd::{f32x8, prelude::*};

/// A leaf with triangles that a ray hits for certain.
pub(super) struct Certain<'a, M> {
    pub(super) wide: &'a Wide<M>,
    pub(super) rays: &'a [Ray],
    pub(super) record: &'a Record,
    pub(super) ray: usize,
    pub(super) leaf: Ref,
    /// The triangles, as bits.
    pub(super) lanes: u32,
}

/// Tells `answers` of all hits among the candidates of a leaf.
#[inline(always)]
pub(super) fn take_all<S: Simd, M: Form, A: Answers>(
    simd: S,
    test: &LeafTest<f32x8<S>>,
    edges: &EdgeLanes<S>,
    mut found: Certain<'_, M>,
    answers: &mut A,
) {
    let depths = test.depths(simd, edges);
    let t_max = f32x8::splat(simd, found.record.t_max);
    let before = depths.upper.simd_le(t_max).to_bitmask() as u32;
    let beyond = depths.lower.simd_gt(t_max).to_bitmask() as u32;
    found.lanes = depths.sure & before;
    let unsure = depths.open & !found.lanes & !beyond;
    if unsure != 0 {
        decide_now(&found, unsure, answers);
    }
    if found.lanes != 0 {
        answers.certain(simd, &found);
    }
}

#[cold]
fn decide_now<M: Form, A: Answers>(found: &Certain<'_, M>, mut lanes: u32, answers: &mut A) {
    let Some(ray) = PreparedRay::new(&found.rays[found.ray]) else {
        return;
    };
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize & 7;
        lanes &= lanes - 1;
        if let (Some(candidate), prim) = exact(&found.wide.store, found.leaf, lane, &ray) {
            answers.decided(found.ray, candidate, prim);
        }
    }
}
