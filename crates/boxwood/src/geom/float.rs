//! Minimum and maximum as processors have them: one instruction, and a NaN in the second place is ignored.
//! (`f32::min` ignores it in either place, which takes four.)

/// `b` if it is smaller, else `a`.
#[inline(always)]
pub(crate) fn min(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// `b` if it is larger, else `a`.
#[inline(always)]
pub(crate) fn max(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}
