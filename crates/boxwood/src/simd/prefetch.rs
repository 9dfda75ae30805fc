//! A hint that memory will be read soon.

/// Where `slice[index]` lies, or would lie.
#[inline(always)]
pub(crate) fn address<T>(slice: &[T], index: usize) -> *const u8 {
    slice.as_ptr().wrapping_add(index).cast()
}

/// Asks the processor to bring the line at `address` into its cache. Any address is harmless; nothing happens where there
/// is no such instruction.
#[inline(always)]
pub(crate) fn prefetch(address: *const u8) {
    #[cfg(all(target_arch = "x86_64", not(miri)))]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a prefetch neither reads nor faults, whatever the address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(address.cast()) };
    }
    #[cfg(not(all(target_arch = "x86_64", not(miri))))]
    let _ = address;
}

/// The lines of a value that may be on two.
#[inline(always)]
pub(crate) fn fetch_ends<T>(value: &T) {
    let first: *const u8 = std::ptr::from_ref(value).cast();
    prefetch(first);
    prefetch(first.wrapping_add(size_of::<T>().saturating_sub(1)));
}
