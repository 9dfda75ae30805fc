//! One block of memory for a whole tree: nodes and leaves, addressed by 16-byte granules.

use super::kept::Keeper;
use std::alloc::{Layout, alloc, dealloc};
use std::marker::PhantomData;
use std::ptr::NonNull;

/// Eight lanes of 32 bits, as they lie in the arena.
pub(crate) type Row = [f32; 8];

/// Zeroed memory on huge pages where the system has them, or a part of what someone else keeps, which is only read.
///
/// Every access is checked against the length, so no content of the arena can lead outside it: a wrong reference gives a
/// wrong answer, never a wrong read.
pub(crate) struct Arena {
    start: NonNull<u8>,
    bytes: usize,
    /// Whose memory it is, if not the arena's own.
    keeper: Option<Keeper>,
}

// SAFETY: the arena owns its memory or has its keeper, and shared references only read it.
unsafe impl Send for Arena {}
// SAFETY: as above.
unsafe impl Sync for Arena {}

/// Unit of references.
pub(crate) const GRANULE: usize = 16;
/// Pages that the address cache likes.
const HUGE: usize = 2 << 20;

impl Arena {
    /// `None` if there is no such memory.
    pub(crate) fn new(bytes: usize) -> Option<Self> {
        let layout = Self::layout(bytes)?;
        // SAFETY: the layout is not empty.
        let start = NonNull::new(unsafe { alloc(layout) })?;
        let bytes = layout.size();
        ask_for_huge_pages(start, bytes);
        // SAFETY: just allocated with this length.
        unsafe { start.as_ptr().write_bytes(0, bytes) };
        Some(Self {
            start,
            bytes,
            keeper: None,
        })
    }

    /// Memory that the keeper keeps.
    #[cfg(feature = "file")]
    pub(super) fn kept(start: NonNull<u8>, bytes: usize, keeper: Keeper) -> Self {
        Self {
            start,
            bytes,
            keeper: Some(keeper),
        }
    }

    /// How long the arena is that has room for `bytes`.
    #[cfg(feature = "file")]
    pub(crate) fn len_for(bytes: usize) -> Option<usize> {
        Some(Self::layout(bytes)?.size())
    }

    fn layout(bytes: usize) -> Option<Layout> {
        let align = if bytes >= HUGE { HUGE } else { 64 };
        Layout::from_size_align(bytes.max(1024).checked_next_multiple_of(64)?, align).ok()
    }

    /// Everything.
    #[cfg(feature = "file")]
    pub(crate) fn bytes(&self) -> &[u8] {
        // SAFETY: all of the memory, which has been written.
        unsafe { std::slice::from_raw_parts(self.start.as_ptr(), self.bytes) }
    }

    /// Everything, to be written.
    #[cfg(feature = "file")]
    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        assert!(self.keeper.is_none(), "what others keep is not written");
        // SAFETY: all of our own memory; `self` is borrowed as long.
        unsafe { std::slice::from_raw_parts_mut(self.start.as_ptr(), self.bytes) }
    }

    /// Length in bytes.
    pub(crate) fn len(&self) -> usize {
        self.bytes
    }

    /// Where a granule lies, or would lie.
    #[inline(always)]
    pub(crate) fn address(&self, granule: u32) -> *const u8 {
        self.start.as_ptr().wrapping_add(granule as usize * GRANULE)
    }

    /// True if there are `bytes` bytes at `at`. On 64 bits the sum is far from wrapping, and its check would be one more instruction.
    #[inline(always)]
    fn has(&self, at: usize, bytes: usize) -> bool {
        #[cfg(target_pointer_width = "64")]
        let end = at + bytes;
        #[cfg(not(target_pointer_width = "64"))]
        let end = at.saturating_add(bytes);
        end <= self.bytes
    }

    /// A node: eight rows.
    #[inline(always)]
    pub(crate) fn node(&self, granule: u32) -> NodeRows<'_> {
        let at = granule as usize * GRANULE;
        assert!(self.has(at, 8 * size_of::<Row>()));
        // SAFETY: inside the memory.
        let start = unsafe { self.start.as_ptr().add(at) };
        NodeRows {
            start,
            arena: PhantomData,
        }
    }

    /// A leaf of `count` triangles: rows of `count` numbers.
    #[inline(always)]
    pub(crate) fn leaf(&self, granule: u32, count: usize) -> LeafRows<'_> {
        let at = granule as usize * GRANULE;
        // The last row begins after eight others and is read eight lanes wide.
        assert!(count <= 8 && self.has(at, (8 * count + 8) * 4));
        // SAFETY: inside the memory.
        let start = unsafe { self.start.as_ptr().add(at).cast() };
        LeafRows {
            start,
            stride: count,
            arena: PhantomData,
        }
    }

    /// The numbers from a granule on.
    #[inline(always)]
    pub(crate) fn floats(&self, granule: u32, count: usize) -> &[f32] {
        let at = granule as usize * GRANULE;
        assert!(self.has(at, count * 4));
        // SAFETY: as above.
        unsafe { std::slice::from_raw_parts(self.start.as_ptr().add(at).cast(), count) }
    }

    /// The same to be written.
    pub(crate) fn floats_mut(&mut self, granule: u32, count: usize) -> &mut [f32] {
        let at = granule as usize * GRANULE;
        assert!(self.has(at, count * 4) && self.keeper.is_none());
        // SAFETY: as above, our own; `self` is borrowed as long.
        unsafe { std::slice::from_raw_parts_mut(self.start.as_ptr().add(at).cast(), count) }
    }
}

/// The rows of a node: two planes for each axis, then references.
#[derive(Clone, Copy)]
pub(crate) struct NodeRows<'a> {
    start: *const u8,
    arena: PhantomData<&'a Arena>,
}

/// The row of a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct PlaneRow(u8);

impl PlaneRow {
    /// The smaller side of an axis, or the larger.
    #[inline(always)]
    pub(crate) fn new(axis: Third, larger: bool) -> Self {
        Self(((2 * axis as usize + usize::from(larger)) * size_of::<Row>()) as u8)
    }

    /// From where it begins in the node, in bytes.
    #[inline(always)]
    pub(crate) const fn at(byte: u8) -> Self {
        Self(byte & 0xe0)
    }

    /// The other side of the axis.
    #[inline(always)]
    pub(crate) fn opposite(self) -> Self {
        Self(self.0 ^ size_of::<Row>() as u8)
    }
}

impl<'a> NodeRows<'a> {
    /// Rows that are not in an arena.
    #[cfg(feature = "compact")]
    #[inline(always)]
    pub(crate) fn of(rows: &'a [Row; 8]) -> Self {
        Self {
            start: rows.as_ptr().cast(),
            arena: PhantomData,
        }
    }

    /// A plane of all children.
    #[inline(always)]
    pub(crate) fn plane(self, row: PlaneRow) -> &'a Row {
        // SAFETY: one of eight rows, checked by `Arena::node` or given by `of`.
        unsafe { &*self.start.add(usize::from(row.0)).cast() }
    }

    /// Smallest and largest corner of the box of a child.
    pub(crate) fn bounds(self, lane: usize) -> [[f32; 3]; 2] {
        let axes = [Third::A, Third::B, Third::C];
        let side = |larger| axes.map(|axis| self.plane(PlaneRow::new(axis, larger))[lane]);
        [side(false), side(true)]
    }

    /// One reference, loaded whether it is used or not: so that a choice between it and another stays a selection.
    #[inline(always)]
    pub(crate) fn child(self, lane: usize) -> u32 {
        // SAFETY: row 6 of eight, one of eight lanes.
        unsafe {
            std::ptr::read_volatile(self.start.add(6 * size_of::<Row>() + 4 * (lane & 7)).cast())
        }
    }

    /// The references of all children.
    #[inline(always)]
    pub(crate) fn refs(self) -> &'a [u32; 8] {
        // SAFETY: row 6 of eight.
        unsafe { &*self.start.add(6 * size_of::<Row>()).cast() }
    }
}

/// Nine rows of coordinates, `stride` apart.
#[derive(Clone, Copy)]
pub(crate) struct LeafRows<'a> {
    start: *const f32,
    stride: usize,
    arena: PhantomData<&'a Arena>,
}

/// One of three: an axis or a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub(crate) enum Third {
    A = 0,
    B = 1,
    C = 2,
}

/// The rows of one axis.
#[derive(Clone, Copy)]
pub(crate) struct AxisRows<'a> {
    start: *const f32,
    step: usize,
    arena: PhantomData<&'a Arena>,
}

impl<'a> LeafRows<'a> {
    /// Rows that are not in an arena.
    #[cfg(feature = "compact")]
    #[inline(always)]
    pub(crate) fn of(rows: &'a [Row; 9]) -> Self {
        Self {
            start: rows.as_ptr().cast(),
            stride: 8,
            arena: PhantomData,
        }
    }

    /// The rows of one axis.
    #[inline(always)]
    pub(crate) fn axis(self, axis: Third) -> AxisRows<'a> {
        // SAFETY: row 0 to 2, checked by `Arena::leaf` or given by `of`.
        let start = unsafe { self.start.add(axis as usize * self.stride) };
        AxisRows {
            start,
            step: 3 * self.stride,
            arena: PhantomData,
        }
    }
}

impl<'a> AxisRows<'a> {
    /// Eight lanes of a coordinate of a corner; those after the leaf's last are meaningless.
    #[inline(always)]
    pub(crate) fn corner(self, corner: Third) -> &'a Row {
        // SAFETY: row 0 to 8, checked by `Arena::leaf` or given by `of`.
        unsafe { &*self.start.add(corner as usize * self.step).cast() }
    }
}

/// Must come before the memory is first touched. A refusal does no harm. Nothing is asked for less than a huge page.
pub(super) fn ask_for_huge_pages(start: NonNull<u8>, bytes: usize) {
    #[cfg(all(target_os = "linux", not(miri)))]
    if bytes >= HUGE {
        // SAFETY: advice about our own memory, which changes none of it.
        unsafe { libc::madvise(start.as_ptr().cast(), bytes, libc::MADV_HUGEPAGE) };
    }
    #[cfg(not(all(target_os = "linux", not(miri))))]
    let _ = (start, bytes);
}

impl Drop for Arena {
    fn drop(&mut self) {
        if self.keeper.is_some() {
            return;
        }
        if let Some(layout) = Self::layout(self.bytes) {
            // SAFETY: allocated with the same layout: its size is a fixed point of `layout`.
            unsafe { dealloc(self.start.as_ptr(), layout) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    /// On 32 bits the last granules of all lie so high that what is read there would begin at 0 again.
    #[test]
    fn no_granule_leads_outside() {
        let arena = Arena::new(1024).unwrap();
        let inside = |granule: u32| {
            let node = catch_unwind(AssertUnwindSafe(|| _ = arena.node(granule))).is_ok();
            let leaf = catch_unwind(AssertUnwindSafe(|| _ = arena.leaf(granule, 8))).is_ok();
            let floats = catch_unwind(AssertUnwindSafe(|| arena.floats(granule, 72).len())).is_ok();
            (node, leaf, floats)
        };
        assert_eq!(inside(46), (true, true, true));
        assert_eq!(inside(49), (false, false, false));
        for last in 1..20 {
            assert_eq!(inside((1 << 28) - last), (false, false, false));
        }
    }
}
