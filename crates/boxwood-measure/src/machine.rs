//! What a figure was measured on: without it a figure says nothing.

use serde::{Deserialize, Serialize};
use std::fs;

/// The machine and the program, in the words of the JSON object.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// As the processor calls itself.
    pub cpu: Option<String>,
    /// Processor cores, each counted once however many threads it runs; what the system offers where that is not known.
    pub cores: usize,
    /// Threads that the system offers.
    pub threads: usize,
    /// The first core's caches in bytes, of level 1 (data), 2 and 3. A virtual machine may share the last with strangers.
    pub caches: [Option<u64>; 3],
    /// SIMD instruction sets that the processor has, least first.
    pub simd: Vec<String>,
    /// Those that this program's own code was compiled for; libraries that choose at run time use more.
    pub compiled_for: Vec<String>,
    /// In bytes.
    pub memory: Option<u64>,
    /// Name and kernel.
    pub system: String,
    /// Linux's transparent huge pages: `always`, `madvise`, `never`.
    pub huge_pages: Option<String>,
    /// The compiler.
    pub rustc: String,
    /// Of Boxwood.
    pub version: String,
    /// Of Boxwood's repository, `-dirty` if files were changed; none if it was not built in it.
    pub commit: Option<String>,
    /// False for a debug build, whose figures are worthless.
    pub optimised: bool,
}

impl Machine {
    /// Looks at this machine. What a system does not tell is left out; Linux tells most.
    pub fn seen() -> Self {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        Self {
            cpu: value_of("/proc/cpuinfo", "model name"),
            cores: cores().unwrap_or(threads),
            threads,
            caches: [1, 2, 3].map(cache),
            simd: owned(&simd()),
            compiled_for: owned(&compiled_for()),
            memory: value_of("/proc/meminfo", "MemTotal").and_then(|text| size(&text)),
            system: system(),
            huge_pages: huge_pages(),
            rustc: env!("BOXWOOD_RUSTC").to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: Some(env!("BOXWOOD_COMMIT").to_owned()).filter(|commit| !commit.is_empty()),
            optimised: !cfg!(debug_assertions),
        }
    }

    /// Bits of a vector that the widest kernels of this machine work on. Nodes and leaves hold eight lanes of 32 bits, so that
    /// more than 256 do not help them.
    pub fn vector_bits(&self) -> u32 {
        let has = |name: &str| self.simd.iter().any(|simd| simd == name);
        if has("AVX2") { 256 } else { 128 }
    }

    /// One line for people.
    pub fn line(&self) -> String {
        let cpu = self.cpu.as_deref().unwrap_or(std::env::consts::ARCH);
        let caches: Vec<String> = (self.caches.iter().zip(1..))
            .filter_map(|(bytes, level)| Some(format!("L{level} {}", short_size((*bytes)?))))
            .collect();
        let parts = [
            format!("{cpu}, {} cores, {} threads", self.cores, self.threads),
            caches.join(" "),
            self.simd.join(" "),
            self.memory.map(short_size).unwrap_or_default(),
            self.system.clone(),
            self.rustc.clone(),
            self.commit
                .as_ref()
                .map_or(String::new(), |commit| format!("commit {commit}")),
        ];
        parts
            .into_iter()
            .filter(|part| !part.is_empty())
            .collect::<Vec<_>>()
            .join(", ")
    }
}

fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

/// A size for people: `32 KiB`, `1.5 MiB`, `16 GiB`.
pub fn short_size(bytes: u64) -> String {
    let (unit, name) = match bytes {
        0..0x10_0000 => (1 << 10, "KiB"),
        0x10_0000..0x4000_0000 => (1 << 20, "MiB"),
        _ => (1_u64 << 30, "GiB"),
    };
    let number = bytes as f64 / unit as f64;
    let digits = usize::from(number.fract() > 0.05 && number < 100.0);
    format!("{number:.digits$} {name}")
}

/// The first value of `key` in a Linux file of lines `key : value`.
fn value_of(path: &str, key: &str) -> Option<String> {
    let text = fs::read_to_string(path).ok()?;
    let pairs = text.lines().filter_map(|line| line.split_once(':'));
    let value = pairs
        .filter(|(name, _)| name.trim() == key)
        .map(|(_, value)| value.trim().to_owned());
    value.into_iter().next()
}

/// Distinct pairs of package and core.
fn cores() -> Option<usize> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let field = |block: &str, key: &str| {
        let mut pairs = block.lines().filter_map(|line| line.split_once(':'));
        pairs
            .find(|(name, _)| name.trim() == key)
            .map(|(_, value)| value.trim().to_owned())
    };
    let mut found: Vec<_> = text
        .split("\n\n")
        .filter_map(|block| Some((field(block, "physical id")?, field(block, "core id")?)))
        .collect();
    found.sort_unstable();
    found.dedup();
    (!found.is_empty()).then_some(found.len())
}

/// Bytes of the first core's data cache of a level.
fn cache(level: u32) -> Option<u64> {
    (0..8).find_map(|index| {
        let folder = format!("/sys/devices/system/cpu/cpu0/cache/index{index}");
        let read = |name: &str| fs::read_to_string(format!("{folder}/{name}")).ok();
        let is_it =
            read("level")?.trim() == level.to_string() && read("type")?.trim() != "Instruction";
        is_it.then(|| size(read("size")?.trim()))?
    })
}

/// Bytes of `32K`, `1024 kB`, `8M`.
fn size(text: &str) -> Option<u64> {
    let digits = text.trim_end_matches(|c: char| !c.is_ascii_digit());
    let unit = match text[digits.len()..].trim().chars().next() {
        None => 0,
        Some('k' | 'K') => 10,
        Some('m' | 'M') => 20,
        Some(_) => return None,
    };
    Some(digits.parse::<u64>().ok()? << unit)
}

/// `Debian GNU/Linux 12 (bookworm), 6.1.0`, else the name of the kind.
fn system() -> String {
    let release = fs::read_to_string("/etc/os-release").unwrap_or_default();
    let name = release
        .lines()
        .find_map(|line| line.strip_prefix("PRETTY_NAME="));
    let name = name.map_or(std::env::consts::OS, |name| name.trim_matches('"'));
    match fs::read_to_string("/proc/sys/kernel/osrelease") {
        Ok(kernel) => format!("{name}, {}", kernel.trim()),
        Err(_) => name.to_owned(),
    }
}

/// The choice in brackets.
fn huge_pages() -> Option<String> {
    let text = fs::read_to_string("/sys/kernel/mm/transparent_hugepage/enabled").ok()?;
    let (_, rest) = text.split_once('[')?;
    Some(rest.split_once(']')?.0.to_owned())
}

/// The SIMD instruction sets of the processor, least first.
fn simd() -> Vec<&'static str> {
    #[cfg(target_arch = "x86_64")]
    let sets = [
        ("SSE2", true),
        ("SSE4.2", std::is_x86_feature_detected!("sse4.2")),
        (
            "AVX2",
            std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma"),
        ),
        (
            "AVX-512",
            std::is_x86_feature_detected!("avx512f") && std::is_x86_feature_detected!("avx512vl"),
        ),
    ];
    #[cfg(not(target_arch = "x86_64"))]
    let sets = [
        ("NEON", cfg!(target_arch = "aarch64")),
        ("simd128", cfg!(target_feature = "simd128")),
    ];
    sets.into_iter()
        .filter(|(_, is_there)| *is_there)
        .map(|(name, _)| name)
        .collect()
}

fn compiled_for() -> Vec<&'static str> {
    let sets = [
        ("SSE2", cfg!(target_feature = "sse2")),
        ("SSE4.2", cfg!(target_feature = "sse4.2")),
        ("AVX2", cfg!(target_feature = "avx2")),
        ("AVX-512", cfg!(target_feature = "avx512f")),
        ("NEON", cfg!(target_feature = "neon")),
        ("simd128", cfg!(target_feature = "simd128")),
    ];
    sets.into_iter()
        .filter(|(_, is_there)| *is_there)
        .map(|(name, _)| name)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_and_written() {
        assert_eq!(size("32K"), Some(32 << 10));
        assert_eq!(size("16384 kB"), Some(16 << 20));
        assert_eq!(size("8M"), Some(8 << 20));
        assert_eq!(size("512"), Some(512));
        assert_eq!((size("many"), size("3 parsecs")), (None, None));
        assert_eq!(short_size(32 << 10), "32 KiB");
        assert_eq!(short_size(3 << 19), "1.5 MiB");
        assert_eq!(short_size(16 << 30), "16 GiB");
    }

    #[test]
    fn this_machine_has_cores_and_says_so_in_one_line() {
        let machine = Machine::seen();
        assert!(machine.cores >= 1 && machine.threads >= 1 && machine.vector_bits() >= 128);
        assert!(machine.rustc.starts_with("rustc"), "{}", machine.rustc);
        let line = machine.line();
        assert!(line.contains("cores") && !line.contains('\n'), "{line}");
    }
}
