//! What the interfaces to other languages need, because a host program is not Rust: its thread may have other floating-point
//! modes ([`FloatModes`]), and its process may be a fork of one whose threads are not there any more ([`pool`]).

mod float_modes;
mod pool;

pub use float_modes::FloatModes;
pub use pool::pool;
