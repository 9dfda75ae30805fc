//! What C points to: checked once, then read and written one value at a time.
//!
//! Values stand `stride` bytes apart, so arrays of rays and of hits may be woven into each other, and no slice is made of what
//! another thread writes between. What a check cannot see - that the memory is there, for so many values, and that nobody writes it
//! meanwhile - is the C caller's promise.
#![allow(
    unsafe_code,
    reason = "the memory is C's: pointers are followed here and nowhere else"
)]

use crate::error::{BwError, Failure};
use crate::types::{BwBounds, BwHit, BwNearest, BwRay, BwStats};
use boxwood::BuildError;
use std::ffi::{CStr, c_char};
use std::marker::PhantomData;
use std::path::PathBuf;

/// Types whose bits C may choose: any of them is a value.
///
/// # Safety
/// Implement it for numbers, and for `repr(C)` structs and arrays of these without padding.
pub(crate) unsafe trait Plain: Copy {}

// SAFETY: arrays of numbers.
unsafe impl Plain for [f32; 3] {}
// SAFETY: arrays of numbers.
unsafe impl Plain for [u32; 3] {}
// SAFETY: arrays of numbers.
unsafe impl Plain for [f32; 12] {}
// SAFETY: eight numbers, 32 bytes.
unsafe impl Plain for BwRay {}

/// Types that C may be given.
pub(crate) trait Given: Copy + Send {}

impl Given for BwHit {}
impl Given for BwNearest {}
impl Given for BwBounds {}
impl Given for BwStats {}
impl Given for f32 {}
impl Given for bool {}
impl Given for usize {}

/// Values to read.
pub(crate) struct Input<'a, T> {
    start: *const T,
    count: usize,
    stride: usize,
    memory: PhantomData<&'a T>,
}

// SAFETY: it only reads, what nobody writes meanwhile.
unsafe impl<T: Plain> Sync for Input<'_, T> {}

impl<T: Plain> Input<'_, T> {
    /// `stride` bytes apart; 0: without gaps. `what` is its name in errors.
    ///
    /// # Safety
    /// If no error comes back, `start` must point to `count` such values for as long as this lives, which nobody writes.
    #[inline]
    pub(crate) unsafe fn new(
        what: &str,
        start: *const T,
        count: usize,
        stride: usize,
    ) -> Result<Self, Failure> {
        Ok(Self {
            start,
            count,
            stride: checked(what, start, count, stride)?,
            memory: PhantomData,
        })
    }

    pub(crate) fn len(&self) -> usize {
        self.count
    }

    #[inline]
    pub(crate) fn get(&self, index: usize) -> T {
        assert!(index < self.count, "value {index} of {}", self.count);
        // SAFETY: one of the values that the caller of `new` promised, aligned as `checked` found, and any bits are a `T`.
        unsafe { self.start.byte_add(index * self.stride).read() }
    }

    /// A copy without gaps.
    pub(crate) fn to_vec(&self) -> Result<Vec<T>, Failure> {
        let mut values = room(self.count)?;
        values.extend((0..self.count).map(|index| self.get(index)));
        Ok(values)
    }
}

/// One value to read.
///
/// # Safety
/// As [`Input::new`], for one value.
#[inline]
pub(crate) unsafe fn read<T: Plain>(what: &str, pointer: *const T) -> Result<T, Failure> {
    // SAFETY: as promised by the caller.
    unsafe { Input::new(what, pointer, 1, 0) }.map(|input| input.get(0))
}

/// A file's name: bytes on Unix, else UTF-8.
///
/// # Safety
/// NULL, or a C string that nobody writes meanwhile.
pub(crate) unsafe fn path(name: *const c_char) -> Result<PathBuf, Failure> {
    if name.is_null() {
        return Err(Failure::new(BwError::NullPointer, "path is NULL"));
    }
    // SAFETY: as promised by the caller.
    let name = unsafe { CStr::from_ptr(name) };
    if name.is_empty() {
        return Err(Failure::new(BwError::InvalidArgument, "path is empty"));
    }
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt;
        Ok(std::ffi::OsStr::from_bytes(name.to_bytes()).into())
    }
    #[cfg(not(unix))]
    {
        let utf8 = name.to_str().map(PathBuf::from);
        utf8.map_err(|_| Failure::new(BwError::InvalidArgument, "path is not UTF-8"))
    }
}

/// Places to write to.
pub(crate) struct Output<'a, T> {
    start: *mut T,
    count: usize,
    stride: usize,
    memory: PhantomData<&'a mut T>,
}

// SAFETY: the only one to write to its places, from whatever thread.
unsafe impl<T: Given> Send for Output<'_, T> {}

impl<T: Given> Output<'_, T> {
    /// `stride` bytes apart; 0: without gaps. `what` is its name in errors. What stands there may be uninitialised.
    ///
    /// # Safety
    /// If no error comes back, `start` must point to `count` such places for as long as this lives, which nobody else reads or
    /// writes.
    #[inline]
    pub(crate) unsafe fn new(
        what: &str,
        start: *mut T,
        count: usize,
        stride: usize,
    ) -> Result<Self, Failure> {
        Ok(Self {
            start,
            count,
            stride: checked(what, start, count, stride)?,
            memory: PhantomData,
        })
    }

    #[inline]
    pub(crate) fn set(&mut self, index: usize, value: T) {
        assert!(index < self.count, "place {index} of {}", self.count);
        // SAFETY: one of the places that the caller of `new` promised, aligned as `checked` found; what was there needs no drop.
        unsafe {
            self.start.byte_add(index * self.stride).write(value);
        }
    }

    /// The places in pieces of `size`, the last one perhaps smaller.
    pub(crate) fn pieces(self, size: usize) -> Result<Vec<Self>, Failure> {
        let piece = |first: usize| Self {
            // Not `byte_add`: behind a piece there may be nothing, but before each there is one.
            start: self.start.wrapping_byte_add(first * self.stride),
            count: size.min(self.count - first),
            ..self
        };
        let mut pieces = room(self.count.div_ceil(size))?;
        pieces.extend((0..self.count).step_by(size).map(piece));
        Ok(pieces)
    }
}

/// One place to write to.
///
/// # Safety
/// As [`Output::new`], for one place.
#[inline]
pub(crate) unsafe fn write<T: Given>(
    what: &str,
    pointer: *mut T,
    value: impl FnOnce() -> Result<T, Failure>,
) -> Result<(), Failure> {
    // SAFETY: as promised by the caller.
    let mut output = unsafe { Output::new(what, pointer, 1, 0)? };
    output.set(0, value()?);
    Ok(())
}

/// What a handle points to.
///
/// # Safety
/// `pointer` must be NULL or a handle that lives as long as the answer is used.
#[inline]
pub(crate) unsafe fn handle<'a, T>(what: &str, pointer: *const T) -> Result<&'a T, Failure> {
    // SAFETY: as promised by the caller.
    unsafe { pointer.as_ref() }.ok_or_else(|| null(what))
}

/// Memory for so many, if the system grants it.
fn room<T>(count: usize) -> Result<Vec<T>, Failure> {
    let mut values = Vec::new();
    match values.try_reserve_exact(count) {
        Ok(()) => Ok(values),
        Err(_) => {
            let bytes = count.saturating_mul(size_of::<T>());
            Err(BuildError::OutOfMemory { bytes }.into())
        }
    }
}

/// The stride in bytes, or what is wrong.
#[inline]
fn checked<T>(what: &str, start: *const T, count: usize, stride: usize) -> Result<usize, Failure> {
    let (size, align) = (size_of::<T>(), align_of::<T>());
    let stride = if stride == 0 { size } else { stride };
    if stride < size || !stride.is_multiple_of(align) {
        return Err(bad_stride(what, stride, size, align));
    }
    if count == 0 {
        return Ok(stride);
    }
    if start.is_null() {
        return Err(null(what));
    }
    if !start.is_aligned() {
        return Err(misaligned(what, start.addr(), align));
    }
    let span = (count - 1)
        .checked_mul(stride)
        .and_then(|gaps| gaps.checked_add(size));
    match span
        .filter(|&span| span <= isize::MAX as usize && start.addr().checked_add(span).is_some())
    {
        Some(_) => Ok(stride),
        None => Err(too_large(what, count, stride)),
    }
}

#[cold]
fn null(what: &str) -> Failure {
    Failure::new(BwError::NullPointer, format!("{what} is NULL"))
}

#[cold]
fn misaligned(what: &str, address: usize, align: usize) -> Failure {
    let message = format!("{what} is at {address:#x}, which is not a multiple of {align}");
    Failure::new(BwError::Misaligned, message)
}

#[cold]
fn bad_stride(what: &str, stride: usize, size: usize, align: usize) -> Failure {
    let message = format!(
        "{what}: {stride} bytes from one to the next, where at least {size} and a multiple of {align} are needed, or 0 for no gaps"
    );
    Failure::new(BwError::BadStride, message)
}

#[cold]
fn too_large(what: &str, count: usize, stride: usize) -> Failure {
    let message =
        format!("{what}: {count} values, {stride} bytes apart, are more than memory can hold");
    Failure::new(BwError::TooLarge, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error<T>(result: Result<T, Failure>) -> BwError {
        result.map(|_| ()).unwrap_err().code
    }

    #[test]
    fn pointers_and_strides_are_checked_before_they_are_followed() {
        let numbers = [[1.0_f32, 2.0, 3.0]; 4];
        let start = numbers.as_ptr();
        let null = std::ptr::null::<[f32; 3]>();
        let input = |start, count, stride| {
            // SAFETY: everything that passes the checks is in `numbers`.
            unsafe { Input::<[f32; 3]>::new("numbers", start, count, stride) }
        };
        assert_eq!(error(input(null, 4, 12)), BwError::NullPointer);
        assert_eq!(input(null, 0, 12).unwrap().len(), 0);
        assert_eq!(
            error(input(start.wrapping_byte_add(1), 1, 12)),
            BwError::Misaligned
        );
        for stride in [1, 8, 11, 13, 14, 15] {
            assert_eq!(error(input(start, 4, stride)), BwError::BadStride);
            assert_eq!(error(input(start, 0, stride)), BwError::BadStride);
        }
        for (count, stride) in [(usize::MAX, 12), (usize::MAX / 8, 0), (2, usize::MAX & !3)] {
            assert_eq!(error(input(start, count, stride)), BwError::TooLarge);
        }
        assert_eq!(input(start, 4, 0).unwrap().to_vec().unwrap(), numbers);
    }

    #[test]
    fn woven_arrays_are_read_and_written_beside_each_other() {
        let mut cells: Vec<u32> = (0..35).collect();
        let start = cells.as_mut_ptr();
        // SAFETY: five places of three numbers, seven apart, and behind each five values that end before the next.
        let (input, output) = unsafe {
            (
                Input::<[u32; 3]>::new("in", start.cast(), 5, 28).unwrap(),
                Output::<f32>::new("out", start.add(3).cast(), 5, 28).unwrap(),
            )
        };
        let pieces = output.pieces(2).unwrap();
        assert_eq!(
            pieces.iter().map(|piece| piece.count).collect::<Vec<_>>(),
            [2, 2, 1]
        );
        for (number, mut piece) in pieces.into_iter().enumerate() {
            for index in 0..piece.count {
                piece.set(index, input.get(2 * number + index)[2] as f32);
            }
        }
        for row in 0..5 {
            let cell = 7 * row + 2;
            assert_eq!(cells[cell as usize + 1], (cell as f32).to_bits());
            assert_eq!(cells[cell as usize + 2], cell + 2, "what is between stays");
        }
    }

    #[test]
    #[should_panic(expected = "value 3 of 3")]
    fn nothing_is_read_behind_the_last_value() {
        let numbers = [[0_u32; 3]; 3];
        // SAFETY: three values.
        let input = unsafe { Input::new("numbers", numbers.as_ptr(), 3, 0) }.unwrap();
        input.get(3);
    }
}
