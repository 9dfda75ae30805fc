//! The processor's floating point mode, which is the host's to change and ours to be independent of.
//!
//! One library built with `-ffast-math` sets flush-to-zero for the whole thread that loads it, and new threads inherit it. Rust's
//! arithmetic is defined for the usual mode only, so Boxwood works in that.
#![expect(
    unsafe_code,
    reason = "the mode is a register that only assembly reaches"
)]

/// The usual mode, until it is dropped: rounding to nearest, denormal numbers as they are, no traps.
#[must_use]
pub(crate) struct Usual {
    before: Word,
}

impl Usual {
    /// From here on, on this thread.
    pub(crate) fn enter() -> Self {
        let before = read();
        if before != USUAL {
            write(USUAL);
        }
        Self { before }
    }
}

impl Drop for Usual {
    fn drop(&mut self) {
        if self.before != USUAL {
            write(self.before);
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod register {
    use std::arch::asm;

    pub(super) type Word = u32;

    /// All exceptions masked, nothing else.
    pub(super) const USUAL: Word = 0x1f80;

    /// Without the flags of what has happened, which are no mode.
    pub(super) fn read() -> Word {
        let mut word: Word = 0;
        // SAFETY: stores four bytes at `word`.
        unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut word, options(nostack, preserves_flags)) };
        word & !0x3f
    }

    pub(super) fn write(word: Word) {
        // SAFETY: loads four bytes at `word`, none of them reserved: they came from `read` or are the usual ones.
        unsafe {
            asm!("ldmxcsr [{}]", in(reg) &raw const word, options(nostack, preserves_flags, readonly))
        };
    }
}

#[cfg(target_arch = "aarch64")]
mod register {
    use std::arch::asm;

    pub(super) type Word = u64;

    pub(super) const USUAL: Word = 0;

    pub(super) fn read() -> Word {
        let word: Word;
        // SAFETY: reads a register.
        unsafe { asm!("mrs {}, fpcr", out(reg) word, options(nomem, nostack, preserves_flags)) };
        word
    }

    pub(super) fn write(word: Word) {
        // SAFETY: writes a register with what came from `read`, or the usual mode.
        unsafe { asm!("msr fpcr, {}", in(reg) word, options(nomem, nostack, preserves_flags)) };
    }
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
mod register {
    pub(super) type Word = ();

    pub(super) const USUAL: Word = ();

    pub(super) fn read() -> Word {}

    pub(super) fn write((): Word) {}
}

use register::{USUAL, Word, read, write};
