//! A fixed piece of work that has nothing to do with rays. It is timed in every race, so that two reports can be compared
//! though the machine was faster on one day than on the other.

use std::hint::black_box;

/// Steps: some milliseconds, as long as a turn, so that who shares the processor with us shows in it too.
const STEPS: usize = 1 << 21;
/// Words of the table, as much as a small cache holds.
const WORDS: usize = 1 << 13;

/// A table that is walked at random, deciding at each step.
pub(crate) struct Yardstick(Vec<u32>);

impl Yardstick {
    pub(crate) fn new() -> Self {
        let word = |i: u32| i.wrapping_mul(0x9E37_79B9).rotate_left(13) ^ 0x5BD1_E995;
        Self((0..WORDS as u32).map(word).collect())
    }

    /// Walks: integer arithmetic, loads that wait for each other, branches that cannot be foreseen, a few products.
    pub(crate) fn walk(&self) {
        let (mut at, mut sum) = (black_box(1_u32), 1.0_f32);
        for _ in 0..STEPS {
            let word = self.0[at as usize % WORDS];
            at = at.wrapping_mul(0x0019_660D).wrapping_add(word);
            sum = if word & 64 == 0 {
                black_box(sum * 0.5 + 1.0)
            } else {
                black_box(sum * 0.25 + 3.0)
            };
        }
        black_box((at, sum));
    }
}
