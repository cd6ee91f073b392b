//! Generates source code from the model.
//!
//! `PYLON_MODEL` is a preset's name or a model file (default: the preset `default`). The workbench sets
//! `PYLON_MODEL_SOURCE` instead, a source file that it generated from the model that it flies.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs};

use model::{Board, Model};

fn main() -> Result<(), Box<dyn Error>> {
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("OUT_DIR is not set")?);
    println!("cargo:rerun-if-changed=build.rs");
    write_model(&out)
}

/// Writes the model's source and its origin.
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
            let model = Model::load(&name)?;
            let board =
                if env::var_os("CARGO_FEATURE_BOARD_F405").is_some() { Board::F405 } else { Board::Recorded };
            model.check_signals(board)?;
            if !model.definitions().is_empty() && env::var_os("CARGO_FEATURE_FORMULAS").is_none() {
                return Err(format!("{name} has effects by formula: build with --features formulas").into());
            }
            let source = model::codegen(&model)?;
            (name, source)
        }
    };
    fs::write(out.join("model.rs"), &source)?;
    println!("cargo:rustc-env=PYLON_MODEL_NAME={name}");
    Ok(())
}
