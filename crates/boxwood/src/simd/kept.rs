//! Lists that nobody changes any more: of their own, or a part of what someone else keeps, such as a file in memory.

use super::arena::Arena;
use crate::geom::Triangle;
use std::any::Any;
use std::ops::{Deref, Range};
use std::ptr::NonNull;
use std::sync::Arc;

/// A list that is read and never written. A copy of it is the same memory.
pub(crate) struct Kept<T> {
    start: NonNull<T>,
    len: usize,
    keeper: Keeper,
}

/// Whoever the memory belongs to: it lives as long as anyone has this.
pub(crate) type Keeper = Arc<dyn Any + Send + Sync>;

// SAFETY: shared references to the elements are all that a list gives away, and its keeper may go anywhere.
unsafe impl<T: Send + Sync> Send for Kept<T> {}
// SAFETY: as above.
unsafe impl<T: Send + Sync> Sync for Kept<T> {}

/// Types that are numbers of 32 bits in a row and nothing else: any bytes are one.
///
/// # Safety
/// No padding, no value that must not be, aligned to four bytes or less.
pub(crate) unsafe trait Plain: Copy + Send + Sync + 'static {}

// SAFETY: a number.
unsafe impl Plain for u8 {}
// SAFETY: a number.
unsafe impl Plain for u32 {}
// SAFETY: nine numbers of 32 bits.
unsafe impl Plain for Triangle {}

/// The memory of plain elements.
#[cfg(feature = "file")]
pub(crate) fn bytes_of<T: Plain>(list: &[T]) -> &[u8] {
    // SAFETY: `Plain` has no padding, so that every byte has a value.
    unsafe { std::slice::from_raw_parts(list.as_ptr().cast(), size_of_val(list)) }
}

impl<T: Send + Sync + 'static> From<Vec<T>> for Kept<T> {
    fn from(list: Vec<T>) -> Self {
        let list = Arc::new(list);
        Self {
            start: NonNull::from(list.as_slice()).cast(),
            len: list.len(),
            keeper: list,
        }
    }
}

#[cfg(feature = "file")]
impl Kept<u8> {
    /// The bytes of whoever has some. They are asked for once.
    pub(crate) fn new<O: AsRef<[u8]> + Send + Sync + 'static>(owner: O) -> Self {
        // In its place first: bytes may lie in the owner itself.
        let owner = Arc::new(owner);
        let bytes: &[u8] = (*owner).as_ref();
        Self {
            start: NonNull::from(bytes).cast(),
            len: bytes.len(),
            keeper: owner,
        }
    }

    /// True if rows of the wide tree may be read in place.
    pub(crate) fn is_aligned(&self) -> bool {
        (self.start.as_ptr() as usize).is_multiple_of(ALIGNMENT)
    }

    /// A part of the bytes.
    pub(crate) fn part(&self, range: Range<usize>) -> Option<Self> {
        let part = self.get(range)?;
        Some(Self {
            start: NonNull::from(part).cast(),
            len: part.len(),
            keeper: Arc::clone(&self.keeper),
        })
    }

    /// The same memory as elements; `None` if it is not aligned, or no whole number of them.
    pub(crate) fn elements<T: Plain>(&self) -> Option<Kept<T>> {
        let start = self.start.cast::<T>();
        let is_whole = self.len.is_multiple_of(size_of::<T>()) && start.is_aligned();
        is_whole.then(|| Kept {
            start,
            len: self.len / size_of::<T>(),
            keeper: Arc::clone(&self.keeper),
        })
    }

    /// The same memory as the arena of a tree; `None` if it is not aligned.
    pub(crate) fn arena(&self) -> Option<Arena> {
        self.is_aligned()
            .then(|| Arena::kept(self.start, self.len, Arc::clone(&self.keeper)))
    }
}

/// Of what is read as an arena: a cache line.
#[cfg(feature = "file")]
pub(crate) const ALIGNMENT: usize = 64;

impl<T> Deref for Kept<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        // SAFETY: from a slice that the keeper keeps, or checked by `elements`.
        unsafe { std::slice::from_raw_parts(self.start.as_ptr(), self.len) }
    }
}

impl<T> Clone for Kept<T> {
    fn clone(&self) -> Self {
        Self {
            start: self.start,
            len: self.len,
            keeper: Arc::clone(&self.keeper),
        }
    }
}

impl<T: std::fmt::Debug> std::fmt::Debug for Kept<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

#[cfg(all(test, feature = "file"))]
mod tests {
    use super::*;

    #[test]
    fn parts_and_elements_outlive_whoever_gave_the_bytes() {
        let numbers: Vec<u32> = (0..100).collect();
        let all = Kept::new(bytes_of(&numbers).to_vec());
        let part = all.part(40..80).unwrap();
        drop(all);
        // A vector of bytes may begin anywhere.
        if let Some(elements) = part.elements::<u32>() {
            assert_eq!(*elements, numbers[10..20]);
        }
        assert_eq!(*part, *bytes_of(&numbers[10..20]));
        assert!(part.part(39..41).is_none());
        assert!(part.part(1..4).unwrap().elements::<u32>().is_none());
    }

    #[test]
    fn bytes_that_lie_in_their_owner_are_found_where_the_owner_stays() {
        let kept = Kept::new([7_u8; 64]);
        let moved = (kept.clone(), 1);
        drop(kept);
        assert_eq!(*moved.0, [7_u8; 64]);
    }
}
