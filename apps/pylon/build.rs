//! Copies uPlot, which draws the page of `pylon report`, to where `src/report/page.rs` includes it.
//!
//! npm fetches the version that `npm/package-lock.json` pins, once, and checks it against the checksum there.
//! The package is kept in cargo's target folder. `PYLON_UPLOT` names a folder that already has it.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs, process};

/// Files taken from the package, and their names in the output folder.
const FILES: [(&str, &str); 3] = [
    ("dist/uPlot.iife.min.js", "uplot.js"),
    ("dist/uPlot.min.css", "uplot.css"),
    ("LICENSE", "uplot-license.txt"),
];
/// Files that pin the version.
const PINS: [&str; 2] = ["package.json", "package-lock.json"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=PYLON_UPLOT");
    for pin in PINS {
        println!("cargo::rerun-if-changed=npm/{pin}");
    }
    if let Err(error) = provide() {
        eprintln!("pylon is built with uPlot, which draws its reports, and uPlot could not be had: {error}");
        eprintln!(
            "`cargo xtask setup` installs npm, which fetches it; without a network, unpack npm's package"
        );
        eprintln!("`uplot` (version in apps/pylon/npm/package.json) and set PYLON_UPLOT to its folder.");
        process::exit(1);
    }
}

fn provide() -> Result<(), Box<dyn Error>> {
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo named no folder to build in")?);
    let package = match env::var_os("PYLON_UPLOT") {
        Some(folder) => PathBuf::from(folder),
        None => fetched(&out)?,
    };
    for (from, to) in FILES {
        let from = package.join(from);
        fs::copy(&from, out.join(to)).map_err(|error| format!("{}: {error}", from.display()))?;
        println!("cargo::rerun-if-changed={}", from.display());
    }
    Ok(())
}

/// The package's folder, fetched if it is missing. All builds in one target folder share it.
fn fetched(out: &Path) -> Result<PathBuf, Box<dyn Error>> {
    // target/PROFILE/build/pylon-HASH/out
    let target = out.ancestors().nth(4).ok_or("cargo's folder is not as deep as it used to be")?;
    let lock = fs::read("npm/package-lock.json")?;
    let folder = target.join("npm/report");
    let is_there = fs::read(folder.join("package-lock.json")).is_ok_and(|found| found == lock);
    if !is_there {
        // Complete or not at all: another build may be doing the same.
        let making = out.join("npm");
        let _ = fs::remove_dir_all(&making);
        fs::create_dir_all(&making)?;
        for pin in PINS {
            fs::copy(Path::new("npm").join(pin), making.join(pin))?;
        }
        install(&making)?;
        fs::create_dir_all(target.join("npm"))?;
        let _ = fs::remove_dir_all(&folder);
        if let Err(error) = fs::rename(&making, &folder)
            && !folder.join("package-lock.json").exists()
        {
            return Err(error.into());
        }
    }
    Ok(folder.join("node_modules/uplot"))
}

fn install(folder: &Path) -> Result<(), Box<dyn Error>> {
    let output = Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" })
        .args(["ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"])
        .current_dir(folder)
        .output()
        .map_err(|error| format!("npm could not be started ({error})"))?;
    if output.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    Err(format!("`npm ci` ended with {}: {}", output.status, said.trim()).into())
}
