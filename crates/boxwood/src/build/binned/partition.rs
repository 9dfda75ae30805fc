//! Moving fragments to their side, and into bins of that side on the way.

use super::super::fragment::{Fragment, Scale, center2};
use super::bins::{BLOCK, Binned, Border};
use fearless_simd::{Simd, SimdBase, SimdMask, f32x4};
use std::hint::select_unpredictable;

/// Copies fragments to their side of a border, each side in the order that it had: left ones from `starts[0]` of `to` on,
/// right ones from `starts[1]`.
#[inline(always)]
pub(super) fn partition<S: Simd>(
    simd: S,
    from: &[Fragment],
    to: &mut [Fragment],
    scale: &Scale,
    border: &Border,
) {
    let parent = scale.load(simd);
    let limit = f32x4::splat(simd, border.bin as f32);
    let (mut left, mut right) = (0, border.left_count);
    for fragment in from {
        let lanes = fragment.load(simd);
        let before = parent.places(center2(lanes)).simd_lt(limit).to_bitmask();
        let is_right = before >> border.axis & 1 == 0;
        let at = select_unpredictable(is_right, right, left);
        to[at].store(lanes);
        right += usize::from(is_right);
        left += usize::from(!is_right);
    }
}

/// [`partition`], and each side is sorted into the bins of its own scale.
#[inline(always)]
pub(super) fn partition_and_bin<S: Simd, const N: usize>(
    simd: S,
    from: &[Fragment],
    to: &mut [Fragment],
    scale: &Scale,
    border: &Border,
    sides: &mut [Binned<N>; 2],
) {
    let parent = scale.load(simd);
    let limit = f32x4::splat(simd, border.bin as f32);
    let (mut left, mut right) = (0, border.left_count);
    for block in from.chunks(BLOCK) {
        let mut bins = [[0; 4]; BLOCK];
        for (bins, fragment) in bins.iter_mut().zip(block) {
            let lanes = fragment.load(simd);
            let center = center2(lanes);
            let before = parent.places(center).simd_lt(limit).to_bitmask();
            let is_right = before >> border.axis & 1 == 0;
            // Selections: which side it is cannot be guessed.
            let at = select_unpredictable(is_right, right, left);
            to[at].store(lanes);
            right += usize::from(is_right);
            left += usize::from(!is_right);
            *bins = sides[usize::from(is_right)].scale.load(simd).bins(center);
            bins[3] = is_right as i32;
        }
        for (bins, fragment) in bins.iter().zip(block) {
            let side = bins[3] as usize % 2;
            sides[side].table.add(simd, fragment.load(simd), *bins);
        }
    }
}
