//! The workspace's packages, from cargo's metadata.

use std::path::PathBuf;

use serde::Deserialize;

use crate::child;
use crate::workspace;

/// The part of `cargo metadata` that is used.
#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

/// A package of the workspace.
#[derive(Deserialize)]
pub struct Package {
    /// Its name.
    pub name: String,
    /// Its `Cargo.toml`.
    pub manifest_path: PathBuf,
    /// Its dependencies, including those of the build and the tests.
    #[cfg_attr(not(test), expect(dead_code, reason = "only a test asks for them"))]
    pub dependencies: Vec<Dependency>,
    /// Its targets.
    pub targets: Vec<Target>,
}

/// A dependency of any kind.
#[derive(Deserialize)]
pub struct Dependency {
    /// The package's name.
    #[cfg_attr(not(test), expect(dead_code, reason = "only a test asks for it"))]
    pub name: String,
}

/// A library, a program or a test program.
#[derive(Deserialize)]
pub struct Target {
    /// Its name.
    pub name: String,
    /// `lib`, `bin`, `test` and others.
    pub kind: Vec<String>,
    /// Its first file.
    pub src_path: PathBuf,
    /// Whether it has tests that `cargo test` runs.
    pub test: bool,
}

/// Every package of the workspace.
///
/// # Errors
/// Cargo cannot read a manifest.
pub fn all() -> anyhow::Result<Vec<Package>> {
    let mut metadata = workspace::cargo(["metadata", "--format-version", "1", "--no-deps", "--offline"]);
    let Metadata { packages } = serde_json::from_str(&child::run(&mut metadata, false)?.stdout)?;
    Ok(packages)
}
