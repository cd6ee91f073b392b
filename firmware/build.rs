//! Turns the model into source, and hands the linker the memory map and the scripts of the runtime and
//! of the log.
//!
//! `PYLON_MODEL` is a preset's name or a model file (default: the preset `default`); the workbench gives
//! `PYLON_MODEL_SOURCE` instead, a file of source that it has generated from the model it flies.
//! `PYLON_MUTATE` (`ulp`, `panic`, `fault`, `starve`) plants an error (`src/mutation.rs`).

use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs};

use model::Model;

fn main() -> Result<(), Box<dyn Error>> {
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("OUT_DIR is not set")?);
    write_model(&out)?;

    println!("cargo:rerun-if-env-changed=PYLON_MUTATE");
    println!("cargo:rustc-check-cfg=cfg(pylon_mutate, values(\"ulp\", \"panic\", \"fault\", \"starve\"))");
    match env::var("PYLON_MUTATE") {
        Ok(error) if ["ulp", "panic", "fault", "starve"].contains(&error.as_str()) => {
            println!("cargo:rustc-cfg=pylon_mutate={error:?}");
        }
        Ok(other) => {
            return Err(format!("PYLON_MUTATE is {other:?}: expected ulp, panic, fault or starve").into());
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

/// Writes the model's source and says where it comes from.
fn write_model(out: &Path) -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-env-changed=PYLON_MODEL");
    println!("cargo:rerun-if-env-changed=PYLON_MODEL_SOURCE");
    let (name, source) = match env::var("PYLON_MODEL_SOURCE") {
        Ok(file) => {
            println!("cargo:rerun-if-changed={file}");
            (
                "of the workbench".to_owned(),
                fs::read_to_string(&file).map_err(|error| format!("{file}: {error}"))?,
            )
        }
        Err(_) => {
            let name = env::var("PYLON_MODEL").unwrap_or_else(|_| "default".to_owned());
            if Model::preset(&name).is_none() {
                println!("cargo:rerun-if-changed={name}");
            }
            let source = model::codegen(&Model::load(&name)?)?;
            (name, source)
        }
    };
    fs::write(out.join("model.rs"), &source)?;
    println!("cargo:rustc-env=PYLON_MODEL_NAME={name}");
    Ok(())
}
