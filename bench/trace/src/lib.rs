//! See `benches/trace.rs`.
