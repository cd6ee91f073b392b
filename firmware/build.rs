//! Hands the linker the memory map and the scripts of the runtime and of the log.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or(io::ErrorKind::NotFound)?);
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("../memory.x");
    fs::copy(&map, out.join("memory.x"))?;
    println!("cargo:rerun-if-changed={}", map.display());
    println!("cargo:rustc-link-search={}", out.display());
    // --nmagic: the linker must not pad the load addresses to its page size.
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    Ok(())
}
