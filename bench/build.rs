//! Passes the flight computer's memory map and the runtime's script to the linker.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("OUT_DIR is not set")?);
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("../memory.x");
    println!("cargo:rerun-if-changed={}", map.display());
    println!("cargo:rerun-if-changed=build.rs");
    fs::copy(&map, out.join("memory.x"))?;
    println!("cargo:rustc-link-search={}", out.display());
    // --nmagic: the linker must not pad the load addresses to its page size. The peers need more stack than
    // the flight computer has; it lies between the image's variables and the retained memory.
    let stack = ["--defsym=_stack_end=__sheap", "--defsym=_stack_start=_retained_start"];
    for argument in ["--nmagic", "-Tlink.x"].into_iter().chain(stack) {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    Ok(())
}
