//! Keeps the caller's floating-point modes out.
//!
//! Embree tells its users to have the processor take denormals for zero (FTZ and DAZ), and `-ffast-math` does so unasked, for
//! whole programs. Rust's arithmetic means the usual modes, and exact answers need them: so every call from another language works in
//! the usual modes and leaves those of its caller as they were. Threads inherit the modes of the one that starts them.
#![allow(
    unsafe_code,
    reason = "only assembly reads and writes the modes of the processor"
)]

/// The usual modes while it lives, on this thread: rounding to nearest, denormal numbers as they are, no traps. Then those of before.
#[must_use]
#[derive(Debug)]
pub struct FloatModes {
    /// The caller's, if they are others.
    before: Option<Word>,
}

impl FloatModes {
    /// From here on, on this thread.
    #[inline]
    pub fn enter() -> Self {
        let word = read();
        let before = ((word ^ USUAL) & MODES != 0).then_some(word);
        if before.is_some() {
            write(USUAL);
        }
        Self { before }
    }
}

impl Drop for FloatModes {
    #[inline]
    fn drop(&mut self) {
        if let Some(word) = self.before {
            write(word);
        }
    }
}

use arch::{MODES, USUAL, Word, read, write};

/// MXCSR: bit 15 flushes results to zero, 13 and 14 round, 7 to 12 mask exceptions, 6 takes denormals for zero, 0 to 5 are flags.
#[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
mod arch {
    pub(super) type Word = u32;
    /// To the nearest, all exceptions masked.
    pub(super) const USUAL: Word = 0x1F80;
    /// All but the flags.
    pub(super) const MODES: Word = 0xFFC0;

    #[inline]
    pub(super) fn read() -> Word {
        let mut word: Word = 0;
        // SAFETY: stores the 32 bits of MXCSR into `word`, and touches nothing else.
        unsafe {
            std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut word, options(nostack, preserves_flags));
        }
        word
    }

    #[inline]
    pub(super) fn write(word: Word) {
        // SAFETY: `word` is `USUAL`, which is what Rust expects, or what MXCSR had when the host called, on the way back to it: no reserved
        // bit is set.
        unsafe {
            std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const word, options(nostack, preserves_flags));
        }
    }
}

/// FPCR: all bits are modes, and 0 is usual: to the nearest, no flushing, no traps.
#[cfg(target_arch = "aarch64")]
mod arch {
    pub(super) type Word = u64;
    pub(super) const USUAL: Word = 0;
    pub(super) const MODES: Word = Word::MAX;

    #[inline]
    pub(super) fn read() -> Word {
        let word: Word;
        // SAFETY: reads FPCR, which every program may, and touches nothing else.
        unsafe {
            std::arch::asm!("mrs {}, fpcr", out(reg) word, options(nomem, nostack, preserves_flags));
        }
        word
    }

    #[inline]
    pub(super) fn write(word: Word) {
        // SAFETY: `word` is `USUAL`, which is what Rust expects, or what FPCR had when the host called, on the way back to it.
        unsafe {
            std::arch::asm!("msr fpcr, {}", in(reg) word, options(nostack, preserves_flags));
        }
    }
}

/// Elsewhere the modes stay the caller's.
#[cfg(not(any(target_arch = "x86_64", target_arch = "x86", target_arch = "aarch64")))]
mod arch {
    pub(super) type Word = u32;
    pub(super) const USUAL: Word = 0;
    pub(super) const MODES: Word = 0;

    pub(super) fn read() -> Word {
        USUAL
    }

    pub(super) fn write(_: Word) {}
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;
    use std::hint::black_box;

    /// Flush to zero, denormals are zero, round up: and a flag, which must stay.
    const HOST: Word = USUAL | 0x8000 | 0x0040 | 0x4000 | 0x0001;

    #[test]
    fn the_usual_modes_hold_inside_and_those_of_the_host_afterwards() {
        write(HOST);
        let (inside, sum) = {
            let _modes = FloatModes::enter();
            (read(), black_box(1e-40_f32) + black_box(1e-40_f32))
        };
        let after = read();
        write(USUAL);
        assert_eq!(inside & MODES, USUAL);
        assert_eq!(sum.to_bits(), (2.0 * 1e-40_f32).to_bits());
        assert_eq!(after, HOST);
    }

    #[test]
    fn they_come_back_when_the_body_panics_and_new_threads_have_the_usual_ones() {
        write(HOST);
        let mut of_thread = HOST;
        let panic = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            let _modes = FloatModes::enter();
            of_thread = std::thread::spawn(read).join().unwrap();
            panic!("on purpose")
        }));
        let after = read();
        write(USUAL);
        assert!(panic.is_err());
        assert_eq!(of_thread & MODES, USUAL);
        assert_eq!(after & MODES, HOST & MODES);
    }
}
