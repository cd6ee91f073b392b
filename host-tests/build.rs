//! Generates the firmware's source for some models, as the firmware's own build does.
//!
//! `tests/generated_models.rs` compiles it and compares it with the host's models.

use std::error::Error;
use std::path::PathBuf;
use std::{env, fs};

use model::{Model, codegen};

#[path = "tests/sources/mod.rs"]
mod sources;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(env::var_os("OUT_DIR").ok_or("OUT_DIR is not set")?);
    let models = [
        ("default", sources::DEFAULT),
        ("paper", sources::PAPER),
        ("estimated", sources::ESTIMATED),
        ("constant", sources::CONSTANT),
    ];
    for (name, text) in models {
        fs::write(folder.join(format!("{name}.rs")), codegen(&Model::parse(text)?)?)?;
    }
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=tests/sources/mod.rs");
    println!("cargo::rerun-if-changed=../flights/models/paper.toml");
    Ok(())
}
