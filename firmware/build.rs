//! Passes the memory map and the scripts of the runtime and of the log to the linker.
//!
//! `PYLON_TELEMETRY_BAUD` is the baud rate of the telemetry line (default: 921600). `PYLON_MUTATE` (one of
//! [`MUTATIONS`]) plants an error or a load (`src/mutation.rs`).

use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// Default rate of the telemetry line, baud.
const TELEMETRY_BAUD: u32 = 921_600;

/// The errors and loads that can be planted.
const MUTATIONS: [&str; 8] =
    ["ulp", "panic", "fault", "starve", "strike", "slow_line", "full_line", "silent_line"];

fn main() -> Result<(), Box<dyn Error>> {
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("OUT_DIR is not set")?);
    write_telemetry(&out)?;

    println!("cargo:rerun-if-env-changed=PYLON_MUTATE");
    println!(
        "cargo:rustc-check-cfg=cfg(pylon_mutate, values({}))",
        MUTATIONS.map(|name| format!("{name:?}")).join(", ")
    );
    match env::var("PYLON_MUTATE") {
        Ok(mutation) if MUTATIONS.contains(&mutation.as_str()) => {
            println!("cargo:rustc-cfg=pylon_mutate={mutation:?}");
        }
        Ok(other) => {
            return Err(format!("PYLON_MUTATE is {other:?}: expected one of {}", MUTATIONS.join(", ")).into());
        }
        Err(_) => {}
    }

    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("../memory.x");
    println!("cargo:rerun-if-changed={}", map.display());
    fs::copy(&map, out.join("memory.x"))?;
    println!("cargo:rustc-link-search={}", out.display());
    // --nmagic: the linker must not pad the load addresses to its page size.
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    println!("cargo:rerun-if-changed=build.rs");
    Ok(())
}

/// Writes the rate of the telemetry line as a constant.
fn write_telemetry(out: &Path) -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-env-changed=PYLON_TELEMETRY_BAUD");
    let baud = match env::var("PYLON_TELEMETRY_BAUD") {
        Ok(text) => {
            text.parse().map_err(|_| format!("PYLON_TELEMETRY_BAUD is {text:?}: expected a whole number"))?
        }
        Err(_) => TELEMETRY_BAUD,
    };
    let source = format!("/// The rate of the telemetry's line, baud.\npub const BAUD: u32 = {baud};\n");
    fs::write(out.join("telemetry.rs"), source)?;
    Ok(())
}
