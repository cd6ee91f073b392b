//! `cargo xtask site`: the studio as one file, and its tests in a browser.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, bail};

use crate::child;
use crate::steps::Done;
use crate::wasm;
use crate::workspace;

/// The page's folder.
const PAGE: &str = "apps/studio/page";
/// The engine, and the profile that it is built with.
const ENGINE: &str = "studio-engine";
const PROFILE: &str = "studio";

/// Folder of real flights, which the page offers (`offered.json`); it is never in the project itself.
const REAL_LOGS: &str = "../shared/flights/real";

/// The resulting file.
pub fn file() -> PathBuf {
    workspace::target_folder().join("studio").join("studio.html")
}

/// Builds the engine and the page into one file; returns a description with its size.
pub fn build(echo: bool) -> anyhow::Result<String> {
    let mut engine = workspace::cargo(["build", "--package", ENGINE, "--lib"]);
    child::run(engine.args(["--profile", PROFILE, "--target", wasm::TARGET]), echo)?;
    let module = workspace::target_folder().join(wasm::TARGET).join(PROFILE).join("studio_engine.wasm");
    packages(echo)?;
    let file = file();
    fs::create_dir_all(file.parent().context("the file has no folder")?)?;
    let made = child::run(node("site.mjs").args([&module, &file, &workspace::root().join(REAL_LOGS)]), echo)?;
    Ok(made.stdout.trim().replace(&file.display().to_string(), &workspace::shown(&file)))
}

/// Builds the site and checks the page's types.
pub fn check(echo: bool) -> anyhow::Result<Done> {
    let made = build(echo)?;
    child::run(npm(&["run", "--silent", "check"]).current_dir(folder()), echo)?;
    Ok(Done::all(made))
}

/// The command that opens the page in a browser and compares it with the command line; needs [`check`] and
/// the built tests.
pub fn browser_tests() -> anyhow::Result<Command> {
    if fs::read_dir(folder().join("e2e")).map_or(0, Iterator::count) == 0 {
        bail!("{PAGE}/e2e has no test");
    }
    if !file().is_file() {
        bail!("{} is missing: `cargo xtask site` makes it", workspace::shown(&file()));
    }
    let mut tests = npm(&["run", "--silent", "e2e"]);
    tests.current_dir(folder()).env("PYLON_STUDIO", file()).env("PYLON_BIN", workspace::tested("pylon"));
    Ok(tests)
}

/// Fetches the page's packages, once for each lock file.
fn packages(echo: bool) -> anyhow::Result<()> {
    let lock = fs::read(folder().join("package-lock.json"))?;
    let stamp = folder().join("node_modules/.pylon-lock");
    if fs::read(&stamp).is_ok_and(|found| found == lock) {
        return Ok(());
    }
    let fetch = ["ci", "--no-audit", "--no-fund", "--loglevel=error"];
    child::run(npm(&fetch).current_dir(folder()), echo)?;
    Ok(fs::write(stamp, lock)?)
}

fn folder() -> PathBuf {
    workspace::root().join(PAGE)
}

fn npm(arguments: &[&str]) -> Command {
    let mut npm = workspace::program("npm");
    npm.args(arguments);
    npm
}

fn node(script: &str) -> Command {
    let mut node = workspace::program("node");
    node.current_dir(folder()).arg(script);
    node
}
