//! Primitives in the order of a space-filling curve.
//!
//! Morton, "A computer oriented geodetic data base", IBM 1966; Lauterbach et al., "Fast BVH Construction on GPUs", 2009.

use super::super::fragment::{Fragment, Scale, center2, range_of_centers};
use super::super::input::{filled, room};
use crate::error::BuildError;
use fearless_simd::Simd;

/// Bits of a digit of the sort, and of a cell's number along each axis.
const DIGIT: u32 = 11;
const RADIX: usize = 1 << DIGIT;
/// Numbers of primitives are below 2^31; the rest of a key is its code.
const NUMBER: u32 = 31;

/// Places of fragments along a Morton curve through a grid of 2048^3 cells; those of one cell in their own order. Linear;
/// holds 16 bytes per fragment.
pub(super) fn places_along_curve<S: Simd>(
    simd: S,
    fragments: &[Fragment],
) -> Result<Vec<u64>, BuildError> {
    let mut keys = room(fragments.len())?;
    simd.vectorize(
        #[inline(always)]
        || {
            let range = range_of_centers(simd, fragments);
            let scale = Scale::new(&range, RADIX).load(simd);
            for (fragment, place) in fragments.iter().zip(0u64..) {
                let [x, y, z, _] = scale.bins(center2(fragment.load(simd)));
                keys.push(code([x, y, z]) << NUMBER | place);
            }
        },
    );
    sort(&mut keys)?;
    for key in &mut keys {
        *key &= (1 << NUMBER) - 1;
    }
    Ok(keys)
}

/// The code of each fragment's cell, for explaining.
pub(super) fn codes<S: Simd>(simd: S, fragments: &[Fragment]) -> Result<Vec<u64>, BuildError> {
    let range = range_of_centers(simd, fragments);
    let scale = Scale::new(&range, RADIX).load(simd);
    let mut codes = room(fragments.len())?;
    codes.extend(fragments.iter().map(|fragment| {
        let [x, y, z, _] = scale.bins(center2(fragment.load(simd)));
        code([x, y, z])
    }));
    Ok(codes)
}

/// The bits of three numbers in turn.
#[inline(always)]
fn code(cell: [i32; 3]) -> u64 {
    let [x, y, z] = cell.map(|number| spread(number as u64));
    x << 2 | y << 1 | z
}

/// Moves bit `i` of 11 to place `3 i`, by halves.
#[inline(always)]
fn spread(number: u64) -> u64 {
    let mut bits = number;
    bits = (bits | bits << 16) & 0xFF00_00FF;
    bits = (bits | bits << 8) & 0x00F0_0F00_F00F;
    bits = (bits | bits << 4) & 0x0C30_C30C_30C3;
    (bits | bits << 2) & 0x2492_4924_9249
}

/// Sorts by the bits of the code, the last digit first.
fn sort(keys: &mut Vec<u64>) -> Result<(), BuildError> {
    let digit = |key: u64, pass: u32| (key >> (NUMBER + pass * DIGIT)) as usize % RADIX;
    let mut counts = filled([0u32; RADIX], 3)?;
    for &key in keys.iter() {
        for pass in 0..3 {
            counts[pass as usize][digit(key, pass)] += 1;
        }
    }
    let mut sorted = filled(0, keys.len())?;
    for pass in 0..3 {
        let next = &mut counts[pass as usize];
        let mut sum = 0;
        for count in next.iter_mut() {
            sum += std::mem::replace(count, sum);
        }
        for &key in keys.iter() {
            let place = &mut next[digit(key, pass)];
            sorted[*place as usize] = key;
            *place += 1;
        }
        std::mem::swap(keys, &mut sorted);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_hold_the_bits_of_all_axes_in_turn() {
        for bit in 0..11 {
            assert_eq!(code([1 << bit, 0, 0]), 4 << (3 * bit));
            assert_eq!(code([0, 1 << bit, 0]), 2 << (3 * bit));
            assert_eq!(code([0, 0, 1 << bit]), 1 << (3 * bit));
        }
        assert_eq!(code([2047; 3]), (1 << 33) - 1);
    }

    #[test]
    fn keys_are_sorted_by_code_and_then_as_they_were() {
        let mut keys: Vec<u64> = (0..5000u64)
            .map(|i| (((i * 7919 % 1000) * 8_000_000) << NUMBER) | i)
            .collect();
        let mut expected = keys.clone();
        expected.sort_unstable();
        sort(&mut keys).unwrap();
        assert_eq!(keys, expected);
    }
}
