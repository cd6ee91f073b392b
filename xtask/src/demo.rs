//! `cargo xtask demo`: the paper's flight, simulated, flown in the emulator and compared.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, bail};
use serde::de::DeserializeOwned;

use crate::child;
use crate::setup::{self, Need, Provided};
use crate::steps::Done;
use crate::story::{Comparison, Flown, Story};
use crate::workspace;

/// The flight.
const SCENARIO: &str = "flights/paper-reconstruction.toml";
/// The model.
const MODEL: &str = "paper";

/// Sets up what is missing, flies and tells the story on standard output.
pub fn run(echo: bool) -> anyhow::Result<()> {
    for need in [Need::Npm, Need::Target, Need::Qemu] {
        match setup::provide(need, echo)? {
            Provided::Found(what) => eprintln!("{}: found, {what}", need.name()),
            Provided::Installed(what) => eprintln!("{}: installed, {what}", need.name()),
        }
    }
    print!("{}", fly(echo)?);
    Ok(())
}

/// The demo as a test: that it comes to its end, with pictures.
pub fn test(echo: bool) -> anyhow::Result<Done> {
    let story = fly(echo)?;
    Ok(Done::all(format!("{} ticks bit for bit, {} pictures", story.flown.ticks, story.pictures.len())))
}

/// Does all there is to tell about.
fn fly(echo: bool) -> anyhow::Result<Story> {
    let folder = workspace::target_folder().join("demo");
    let (flight, pictures) = (folder.join("paper-reconstruction.csv"), folder.join("pictures"));
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("{} can not be emptied", folder.display()))?;
    }
    fs::create_dir_all(&folder).with_context(|| format!("{} can not be made", folder.display()))?;

    eprintln!("building the workbench");
    child::run(&mut workspace::build_workbench(), echo)?;
    eprintln!("simulating {SCENARIO}");
    child::run(pylon("simulate").arg(SCENARIO).arg("-o").arg(&flight), echo)?;
    eprintln!("building the flight computer's image and flying it in QEMU, bit for bit");
    let flown: Flown = json(pylon("fly").arg(&flight).args(["--model", MODEL, "--json"]), echo)?;
    eprintln!("comparing the flight with the paper's model");
    let mut compare = pylon("compare");
    compare.arg(&flight).args(["--model", MODEL, "--json", "--plots"]).arg(&pictures);
    let comparison: Comparison = json(&mut compare, echo)?;
    Ok(Story { flown, comparison, flight, pictures: drawn(&pictures)? })
}

/// The workbench, which must have been built, with a command of its.
fn pylon(command: &str) -> Command {
    let mut pylon = workspace::program(workspace::workbench());
    pylon.arg(command);
    pylon
}

fn json<T: DeserializeOwned>(command: &mut Command, echo: bool) -> anyhow::Result<T> {
    let said = child::run(command, echo)?;
    serde_json::from_str(&said.stdout)
        .with_context(|| format!("`{}` said something unexpected", child::shown(command)))
}

/// The pictures in a folder, by name.
fn drawn(folder: &PathBuf) -> anyhow::Result<Vec<PathBuf>> {
    let files = fs::read_dir(folder).with_context(|| format!("{} can not be read", folder.display()))?;
    let mut pictures: Vec<_> = files.flatten().map(|file| file.path()).collect();
    pictures.retain(|path| path.extension().is_some_and(|extension| extension == "svg"));
    pictures.sort();
    if pictures.is_empty() {
        bail!("no picture was drawn in {}", folder.display());
    }
    Ok(pictures)
}
