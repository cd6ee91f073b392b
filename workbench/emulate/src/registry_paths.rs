//! Keeps the path of cargo's dependency sources out of an image. A panic's message names its file, and every
//! such name would put the builder's home directory into the flash.
//!
//! `xtask`, which depends on none of our crates, includes this file by path.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::PathBuf;

/// The compiler flags for this, in the form of `CARGO_ENCODED_RUSTFLAGS`.
pub fn compiler_flags() -> OsString {
    let home = env::var_os("CARGO_HOME")
        .map(PathBuf::from)
        .or_else(|| env::var_os("HOME").map(|home| PathBuf::from(home).join(".cargo")));
    let entries = home.and_then(|home| fs::read_dir(home.join("registry/src")).ok());
    let mut registries: Vec<PathBuf> =
        entries.into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    registries.sort();
    let mut flags = OsString::new();
    for registry in registries {
        if !flags.is_empty() {
            flags.push("\x1f");
        }
        flags.push("--remap-path-prefix=");
        flags.push(registry);
        flags.push("=");
    }
    flags
}
