//! Checks that the workbench's crates build for a browser and give the same results there as here.

use crate::child;
use crate::packages;
use crate::steps::Done;
use crate::workspace;

/// A browser's target, which has no file, terminal, process or thread.
pub const TARGET: &str = "wasm32-unknown-unknown";

/// The folder of the workbench's crates.
const WORKBENCH: &str = "workbench";
/// The one of them that need not build for a browser: it runs programs and talks to boards.
const NATIVE: &str = "emulate";

/// The crates that must build for a browser.
fn portable() -> anyhow::Result<Vec<String>> {
    let folder = workspace::root().join(WORKBENCH);
    let ours = packages::all()?.into_iter().filter(|package| package.manifest_path.starts_with(&folder));
    Ok(ours.map(|package| package.name).filter(|name| name != NATIVE).collect())
}

/// Builds them. What they may call there is checked separately, by `workbench/clippy.toml`.
pub fn check(echo: bool) -> anyhow::Result<Done> {
    let portable = portable()?;
    let mut check = workspace::cargo(["check", "--target", TARGET]);
    check.args(portable.iter().flat_map(|name| ["--package", name]));
    child::run(&mut check, echo)?;
    Ok(Done::all(format!("{} crates: {}", portable.len(), portable.join(", "))))
}

#[test]
fn every_crate_of_the_workbench_but_the_one_with_programs_is_portable() {
    let portable = portable().unwrap();
    assert!(portable.iter().any(|name| name == "flight-data"), "{portable:?}");
    assert!(!portable.iter().any(|name| name == NATIVE || name == "pylon"), "{portable:?}");
}
