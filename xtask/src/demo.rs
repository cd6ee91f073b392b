//! `cargo xtask demo`: the paper's flight, simulated, flown in the emulator and compared; then a flight that
//! fails, what its model lacks, and the next flight, which holds.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, bail};
use serde::de::DeserializeOwned;

use crate::child;
use crate::improvement::{Addition, Diagnosis, Improvement};
use crate::setup::{self, Need, Provided};
use crate::steps::Done;
use crate::story::{Comparison, Flown, Story};
use crate::workspace;

/// The flight.
const SCENARIO: &str = "flights/paper-reconstruction.toml";
/// The model.
const MODEL: &str = "paper";
/// A flight with a hidden effect that raises a flag.
const HIDDEN: &str = "flights/hidden-static-port.toml";
/// Another plan with the same effect.
const SECOND: &str = "flights/hidden-static-port-second.toml";

/// Sets up what is missing, flies and tells the story on standard output.
pub fn run(echo: bool) -> anyhow::Result<()> {
    for need in [Need::Npm, Need::Target, Need::Qemu] {
        match setup::provide(need, echo)? {
            Provided::Found(what) => eprintln!("{}: found, {what}", need.name()),
            Provided::Installed(what) => eprintln!("{}: installed, {what}", need.name()),
        }
    }
    eprintln!("building the workbench");
    child::run(&mut workspace::build_workbench(), echo)?;
    let workbench = workspace::workbench();
    print!("{}", fly(&workbench, echo)?);
    print!("{}", improve(&workbench, echo)?);
    Ok(())
}

/// The demo as a test: that it comes to its end, with pictures; with the workbench that the tests have built.
pub fn test(echo: bool) -> anyhow::Result<Done> {
    child::run(&mut workspace::test(["--no-run"]), echo)?;
    let workbench = workspace::tested("pylon");
    let story = fly(&workbench, echo)?;
    let improvement = improve(&workbench, echo)?;
    Ok(Done::all(format!(
        "{} and {} ticks bit for bit, {} pictures, {} found and added, a report",
        story.flown.ticks,
        improvement.ticks,
        story.pictures.len(),
        improvement.effect
    )))
}

/// Does all there is to tell about.
fn fly(workbench: &Path, echo: bool) -> anyhow::Result<Story> {
    let folder = workspace::target_folder().join("demo");
    let (flight, pictures) = (folder.join("paper-reconstruction.csv"), folder.join("pictures"));
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("{} can not be emptied", folder.display()))?;
    }
    fs::create_dir_all(&folder).with_context(|| format!("{} can not be made", folder.display()))?;

    let pylon = |command: &str| pylon(workbench, command);
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

/// A flight with a hidden effect, the diagnosis, the improved model and a flight that was held out.
fn improve(workbench: &Path, echo: bool) -> anyhow::Result<Improvement> {
    let pylon = |command: &str| pylon(workbench, command);
    let folder = workspace::target_folder().join("demo");
    let simulated = |scenario: &str, file: &str| -> anyhow::Result<PathBuf> {
        let flight = folder.join(file);
        eprintln!("simulating {scenario}");
        child::run(pylon("simulate").arg(scenario).arg("-o").arg(&flight), echo)?;
        Ok(flight)
    };
    let first = simulated(HIDDEN, "first.csv")?;
    let second = simulated(SECOND, "second.csv")?;
    eprintln!("diagnosing the first flight");
    let diagnosis: Diagnosis = json(pylon("diagnose").arg(&first).arg("--json"), echo)?;
    let missing = diagnosis.missing();
    let [effect] = missing.as_slice() else {
        bail!("the diagnosis says {}: {}", diagnosis.verdict, missing.join(", "));
    };
    let model = folder.join("improved.toml");
    let (sensor, _) = effect.split_once('.').context("an effect's id is SENSOR.EFFECT")?;
    eprintln!("adding {effect} and flying the second flight with it, in QEMU");
    let mut add = pylon("add");
    add.arg(effect).args(["--model", "default", "--from"]).arg(&first);
    add.arg("--hold-out").arg(&second).arg("-o").arg(&model).arg("--json");
    let addition: Addition = json(&mut add, echo)?;
    let flown: Flown = json(pylon("fly").arg(&second).arg("--model").arg(&model).arg("--json"), echo)?;
    eprintln!("writing a report of both flights with the improved model");
    let report = folder.join("report.html");
    let mut write = pylon("report");
    write.args([&first, &second]).arg("--model").arg(&model).arg("-o").arg(&report);
    child::run(&mut write, echo)?;
    let page =
        fs::read_to_string(&report).with_context(|| format!("{} can not be read", report.display()))?;
    if !page.contains("data-chart=\"ladder-2\"") || !page.contains(*effect) {
        bail!("{} does not show how the error fell on the second flight", report.display());
    }
    let (effect, sensor) = ((*effect).to_owned(), sensor.to_owned());
    Ok(Improvement { effect, sensor, addition, ticks: flown.ticks, model, report })
}

/// The workbench with a command of its.
fn pylon(workbench: &Path, command: &str) -> Command {
    let mut pylon = workspace::program(workbench);
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
