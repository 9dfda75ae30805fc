//! Whether a scene fits the memory, before the system ends the process for it.

use std::fs;

use crate::output::{Trouble, grouped};

/// Bytes per triangle of the loaded, the flattened and the built scene at their height, as measured on `builtin:soup`.
const BYTES_PER_TRIANGLE: u64 = 256;

/// Refuses a scene called `name` of so many triangles if more memory is needed for it than is there. An estimate; where
/// the system does not say how much there is, everything passes.
pub(crate) fn check(name: &str, triangles: u64) -> anyhow::Result<()> {
    let needed = triangles.saturating_mul(BYTES_PER_TRIANGLE);
    match available() {
        Some(available) if needed > available => {
            let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
            let cause = format!(
                "{name}: {} triangles take about {:.1} GiB of memory, and {:.1} GiB are available",
                grouped(triangles),
                gib(needed),
                gib(available)
            );
            Err(Trouble::input(cause, "take a smaller scene, or end other programs").into())
        }
        _ => Ok(()),
    }
}

/// Bytes that this process may still take: what is free, within its own limit. Known on Linux only.
fn available() -> Option<u64> {
    let free = field("/proc/meminfo", "MemAvailable:")?.saturating_mul(1024);
    // "unlimited" is no number.
    let limit = field("/proc/self/limits", "Max address space").unwrap_or(u64::MAX);
    let taken = field("/proc/self/status", "VmSize:")?.saturating_mul(1024);
    Some(free.min(limit.saturating_sub(taken)))
}

/// The number that follows `name` at the beginning of a line of `file`.
fn field(file: &str, name: &str) -> Option<u64> {
    let text = fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_cannot_fit_is_refused() {
        check("a.ply", 1000).unwrap();
        if available().is_some() {
            let error = check("a.ply", u64::MAX / 2).unwrap_err().to_string();
            assert!(error.starts_with("a.ply: ") && error.contains("GiB are available"));
        }
    }
}
