//! Vectors that are filled once: their memory is asked for beforehand, on huge pages where they are long.

use super::arena::ask_for_huge_pages;
use std::collections::TryReserveError;
use std::ptr::NonNull;

/// Vectors shorter than this lie among others, and advice about their pages would be advice about those, too.
const ALONE: usize = 4 << 20;

/// An empty vector with room for `count` elements. The first touch of a page costs as much as sorting its content into
/// bins: huge pages are touched 512 times less often.
pub(crate) fn room<T>(count: usize) -> Result<Vec<T>, TryReserveError> {
    let mut room: Vec<T> = Vec::new();
    room.try_reserve_exact(count)?;
    let bytes = room.capacity().saturating_mul(size_of::<T>());
    if bytes >= ALONE {
        let start = room.as_mut_ptr() as usize;
        // Advice is for whole pages.
        let aligned = start.next_multiple_of(PAGE);
        if let Some(first) = NonNull::new(aligned as *mut u8) {
            ask_for_huge_pages(first, bytes - (aligned - start));
        }
    }
    Ok(room)
}

/// Of every system that knows huge pages, or a multiple of it.
const PAGE: usize = 64 << 10;
