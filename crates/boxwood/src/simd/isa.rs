//! Instruction sets: which the machine has, and how one of them is asked for.

use fearless_simd::Level;

/// An instruction set that this machine has. Kernels are compiled for each and chosen at run time; the answers are the
/// same bits in all.
#[derive(Clone, Copy, Debug)]
pub struct InstructionSet(pub(crate) Level);

impl InstructionSet {
    /// The widest of this machine.
    pub fn best() -> Self {
        Self(Level::new())
    }

    /// All of this machine, widest first.
    pub fn available() -> Vec<Self> {
        let best = Level::new();
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        let narrower = [
            best.as_avx2().map(Level::Avx2),
            best.as_sse4_2().map(Level::Sse4_2),
            best.as_sse2().map(Level::Sse2),
        ];
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        let narrower: [Option<Level>; 0] = [];
        let mut all = vec![Self(best)];
        all.extend(narrower.into_iter().flatten().map(Self));
        all.dedup_by_key(|set| set.name());
        all
    }

    /// Looks one up by name. `None` if there is no such set, or this machine has it not.
    pub fn named(name: &str) -> Option<Self> {
        Self::available().into_iter().find(|set| set.name() == name)
    }

    /// True if eight numbers are one register.
    pub(crate) fn has_eight_lanes(self) -> bool {
        matches!(self.name(), "avx512" | "avx2")
    }

    /// `avx512`, `avx2`, `sse4.2`, `sse2`, `neon`, `simd128`, or `scalar`.
    pub fn name(self) -> &'static str {
        match self.0 {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx512(_) => "avx512",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx2(_) => "avx2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Sse4_2(_) => "sse4.2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Sse2(_) => "sse2",
            #[cfg(target_arch = "aarch64")]
            Level::Neon(_) => "neon",
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Level::WasmSimd128(_) => "simd128",
            _ => "scalar",
        }
    }
}

impl Default for InstructionSet {
    fn default() -> Self {
        Self::best()
    }
}

impl PartialEq for InstructionSet {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

#[cfg(test)]
mod tests {
    use super::InstructionSet;

    #[test]
    fn the_best_comes_first_and_each_is_found_by_its_name() {
        let all = InstructionSet::available();
        assert_eq!(all[0], InstructionSet::best());
        for set in &all {
            assert_eq!(InstructionSet::named(set.name()), Some(*set));
        }
        assert_eq!(InstructionSet::named("mmx"), None);
        #[cfg(target_arch = "x86_64")]
        assert_eq!(all.last().map(|set| set.name()), Some("sse2"));
    }
}
