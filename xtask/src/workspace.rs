//! Paths in the checkout.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::registry_paths;

/// The flight computer's target.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// The checkout's folder.
pub fn root() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here)
}

/// Cargo's target folder.
pub fn target_folder() -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), |folder| root().join(folder))
}

/// The workbench's program; needs [`build_workbench`] first.
pub fn workbench() -> PathBuf {
    target_folder().join("release").join(format!("pylon{}", env::consts::EXE_SUFFIX))
}

/// A path relative to the checkout's folder, where possible.
pub fn shown(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}

/// A program, to be run in the checkout's folder.
pub fn program(name: impl Into<OsString>) -> Command {
    let mut command = Command::new(name.into());
    command.current_dir(root());
    command
}

/// The cargo that runs this program, with these arguments.
pub fn cargo<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Command {
    let mut command = program(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments);
    command
}

/// The crate without tests of its own; it builds only for the target.
pub const UNTESTED: &str = "firmware";

/// Arguments that run every test except that crate's. The packages are always the same, or cargo would build
/// them again with other features.
const TESTED: [&str; 4] = ["test", "--workspace", "--exclude", UNTESTED];

/// Cargo with the arguments that run these tests.
pub fn test<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Command {
    let mut test = cargo(TESTED);
    test.args(arguments);
    test
}

/// A program as built for the tests; needs `test(["--no-run"])` first. It has the same bits as the release's,
/// and the test command builds it anyway.
pub fn tested(name: &str) -> PathBuf {
    target_folder().join("debug").join(format!("{name}{}", env::consts::EXE_SUFFIX))
}

/// Builds the workbench.
pub fn build_workbench() -> Command {
    cargo(["build", "--release", "--package", "pylon"])
}

/// Builds an image of the firmware, in the folder where the workbench builds it.
pub fn firmware_build(binary: &str, features: &str) -> Command {
    let mut build = cargo(["build", "--package", "firmware", "--bin", binary, "--features", features]);
    build.args(["--profile", "firmware", "--target", TARGET, "--target-dir", "target/flight-computer"]);
    build.env("CARGO_ENCODED_RUSTFLAGS", registry_paths::compiler_flags());
    build
}
