//! The studio's page: one file, built if it is missing.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::cli::failure::Failure;
use crate::cli::progress::while_busy;

/// Environment variable that names a page already built.
const VARIABLE: &str = "PYLON_STUDIO";

/// The page's text.
pub fn page() -> Result<String, Failure> {
    if let Some(file) = env::var_os(VARIABLE) {
        return read(&PathBuf::from(file));
    }
    let checkout = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let target = env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| checkout.join("target"), |folder| checkout.join(folder));
    let file = target.join("studio/studio.html");
    if !file.exists() {
        build(&checkout)?;
    }
    read(&file)
}

fn read(file: &Path) -> Result<String, Failure> {
    fs::read_to_string(file).map_err(|error| {
        Failure::input(format!(
            "{}: the studio's page cannot be read: {error}; build it with `cargo xtask site` in the checkout, or set {VARIABLE} to a built page",
            file.display()
        ))
    })
}

/// Builds the page, once; takes some minutes.
fn build(checkout: &Path) -> Result<(), Failure> {
    if !checkout.join("xtask").is_dir() {
        return Err(Failure::input(format!(
            "the studio's page is built by `cargo xtask site` in the checkout, which is no longer at {}; set {VARIABLE} to a \
             page that is already built",
            checkout.display()
        )));
    }
    let mut cargo = Command::new("cargo");
    cargo.args(["xtask", "site"]).current_dir(checkout).stdin(Stdio::null());
    let output = while_busy("building the studio's page, once (takes some minutes)", || cargo.output());
    let output = output.map_err(|error| {
        Failure::input(format!(
            "cargo could not be started to build the studio's page ({error}): run `cargo xtask site`"
        ))
    })?;
    if output.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let last = said.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("");
    Err(Failure::input(format!("the studio's page could not be built (`cargo xtask site`): {last}")))
}
