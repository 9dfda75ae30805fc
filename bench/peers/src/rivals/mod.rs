//! The rivals, each as its own documentation uses it.

pub(crate) mod embree;
mod embree_abi;
pub(crate) mod library;
pub(crate) mod obvhs;
pub(crate) mod parry;
pub(crate) mod svenstaro;
