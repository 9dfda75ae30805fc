//! A stack that costs nothing until it is used.

use std::mem::MaybeUninit;

/// A stack in memory that nobody has cleared: clearing as much as a traversal may need takes longer than many a ray.
///
/// The memory is apart from the stack so that its length can live in a register.
pub(crate) struct Stack<'a, T> {
    places: &'a mut [MaybeUninit<T>],
    len: usize,
}

impl<'a, T: Copy> Stack<'a, T> {
    /// Memory for `N` elements.
    #[inline(always)]
    pub(crate) const fn memory<const N: usize>() -> [MaybeUninit<T>; N] {
        [MaybeUninit::uninit(); N]
    }

    #[inline(always)]
    pub(crate) fn new(places: &'a mut [MaybeUninit<T>]) -> Self {
        Self { places, len: 0 }
    }

    /// Panics if the memory is full.
    #[inline(always)]
    pub(crate) fn push(&mut self, element: T) {
        self.push_if(true, element);
    }

    /// Pushes if `real`, without a branch. Panics if the memory is full, whether `real` or not.
    #[inline(always)]
    pub(crate) fn push_if(&mut self, real: bool, element: T) {
        self.places[self.len] = MaybeUninit::new(element);
        self.len += usize::from(real);
    }

    /// How many.
    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<T> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: every place below the old `len` was written before `len` went past it.
        Some(unsafe { self.places[self.len].assume_init() })
    }
}

impl Stack<'_, u64> {
    /// Pushes into place: from `base` up, largest first.
    #[inline(always)]
    pub(crate) fn insert_descending(&mut self, base: usize, element: u64) {
        self.push(element);
        let mut i = self.len - 1;
        while i > base {
            // SAFETY: every place below `len` was written.
            let before = unsafe { self.places[i - 1].assume_init() };
            if before >= element {
                break;
            }
            self.places[i] = MaybeUninit::new(before);
            i -= 1;
        }
        self.places[i] = MaybeUninit::new(element);
    }
}

/// A stack of references and where they begin, pushed eight at a time.
pub(crate) struct RowStack<const CAP: usize> {
    refs: [MaybeUninit<u32>; CAP],
    near: [MaybeUninit<f32>; CAP],
    len: usize,
}

impl<const CAP: usize> RowStack<CAP> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self {
            refs: [MaybeUninit::uninit(); CAP],
            near: [MaybeUninit::uninit(); CAP],
            len: 0,
        }
    }

    /// Pushes the first `count` of eight. Panics if there is no room for eight.
    #[inline(always)]
    pub(crate) fn push(&mut self, refs: [u32; 8], near: [f32; 8], count: usize) {
        let place = self.len..self.len + 8;
        self.refs[place.clone()].copy_from_slice(&refs.map(MaybeUninit::new));
        self.near[place].copy_from_slice(&near.map(MaybeUninit::new));
        self.len += count & 7;
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<(u32, f32)> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: every place below the old `len` was written before `len` went past it.
        Some(unsafe {
            (
                self.refs[self.len].assume_init(),
                self.near[self.len].assume_init(),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Stack;

    #[test]
    fn the_last_one_in_is_the_first_one_out() {
        let mut memory = Stack::memory::<3>();
        let mut stack = Stack::new(&mut memory);
        assert_eq!(stack.pop(), None);
        stack.push(7);
        stack.push(11);
        assert_eq!(stack.pop(), Some(11));
        stack.push_if(false, 13);
        stack.push_if(true, 17);
        let rest = [stack.pop(), stack.pop(), stack.pop()];
        assert_eq!(rest, [Some(17), Some(7), None]);
    }

    #[test]
    #[should_panic(expected = "index out of bounds")]
    fn more_than_fit_is_a_panic() {
        let mut memory = Stack::memory::<1>();
        let mut stack = Stack::new(&mut memory);
        stack.push(1);
        stack.push(2);
    }
}
