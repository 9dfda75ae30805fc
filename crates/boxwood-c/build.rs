//! Tells the linker what the shared library is called once it is installed.
#![allow(missing_docs, reason = "a build script has no API")]

use std::env::var;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if var("CARGO_CFG_TARGET_OS").as_deref() != Ok("linux") {
        return;
    }
    let part = |name: &str| var(format!("CARGO_PKG_VERSION_{name}")).unwrap_or_default();
    // Before 1.0 every minor version may change the interface.
    let name = format!("libboxwood.so.{}.{}", part("MAJOR"), part("MINOR"));
    println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,{name}");
    // Threads of the pool may sleep in it, so it stays when a program closes it.
    println!("cargo::rustc-cdylib-link-arg=-Wl,-z,nodelete");
}
