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

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<T> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: every place below the old `len` was written before `len` went past it.
        Some(unsafe { self.places[self.len].assume_init() })
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
