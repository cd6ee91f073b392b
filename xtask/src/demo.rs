//! `cargo xtask demo`: flies the paper's simulated flight in the emulator and compares it. Then a flight that
//! fails, what its model lacks, and the next flight, which succeeds with the improved model.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use anyhow::{Context, anyhow, bail};
use serde::de::DeserializeOwned;

use crate::child;
use crate::improvement::{Addition, Diagnosis, Improvement};
use crate::setup::{self, Need, Provided};
use crate::stages::Stages;
use crate::steps::Done;
use crate::story::{Comparison, Flown, Story};
use crate::workspace;

/// Scenario of the paper's flight.
const SCENARIO: &str = "flights/paper-reconstruction.toml";
/// Its model.
const MODEL: &str = "paper";
/// A flight with a hidden effect that raises a flag.
const HIDDEN: &str = "flights/hidden-static-port.toml";
/// Another plan with the same effect.
const SECOND: &str = "flights/hidden-static-port-second.toml";

/// Sets up what is missing, flies, and prints the results to standard output.
pub fn run(echo: bool) -> anyhow::Result<()> {
    for need in [Need::Npm, Need::Target, Need::Qemu] {
        match setup::provide(need, echo)? {
            Provided::Found(what) => eprintln!("{}: found, {what}", need.name()),
            Provided::Installed(what) => eprintln!("{}: installed, {what}", need.name()),
        }
    }
    let mut stages = Stages::new(1 + STAGES);
    stages.run("building the workbench, and what every image of the flight computer needs", |news| {
        // Building one crate uses only one processor, so they are built in parallel.
        thread::scope(|scope| {
            let image = scope.spawn(|| {
                child::run_heard(&mut workspace::firmware_build("flight", "board-qemu"), echo, &|_| ())
            });
            child::run_heard(&mut workspace::build_workbench(), echo, &|line| news.hear(line))?;
            // A panic of the thread is ignored here: flying the image will report why it was not built.
            if let Ok(built) = image.join() {
                built?;
            }
            Ok(())
        })
    })?;
    let mut demo = Demo { workbench: workspace::workbench(), echo, stages };
    let (story, improvement) = demo.tell()?;
    demo.stages.finish();
    print!("{story}{improvement}");
    Ok(())
}

/// The picture in the README, and the demo's picture that it is a copy of.
const SHOWN: &str = "docs/figure-4-reconstruction.svg";
const DRAWN: &str = "figure-4-free-flight.svg";

/// The demo as a test: it must finish and draw its pictures, and the README must show the current version of
/// one of them. Uses the workbench that the tests have built.
pub fn test(echo: bool) -> anyhow::Result<Done> {
    child::run(&mut workspace::test(["--no-run"]), echo)?;
    let mut demo = Demo { workbench: workspace::tested("pylon"), echo, stages: Stages::new(STAGES) };
    let (story, improvement) = demo.tell()?;
    demo.stages.finish();
    let drawn = story.pictures.iter().find(|picture| picture.ends_with(DRAWN));
    let drawn = drawn.with_context(|| format!("the demo draws no {DRAWN}"))?;
    if fs::read(drawn)? != fs::read(workspace::root().join(SHOWN))? {
        bail!("{SHOWN} is not what the demo draws: check {} and copy it there", workspace::shown(drawn));
    }
    Ok(Done::all(format!(
        "{} and {} ticks bit for bit, {} pictures, {} found and added, a report",
        story.flown.ticks,
        improvement.ticks,
        story.pictures.len(),
        improvement.effect
    )))
}

/// The steps of [`Demo::tell`].
const STAGES: usize = 8;

/// State of the demo.
struct Demo {
    /// The workbench's program.
    workbench: PathBuf,
    echo: bool,
    stages: Stages,
}

impl Demo {
    /// Runs all parts: the paper's flight; one with a hidden effect, its diagnosis and the improved model;
    /// and a held-out flight.
    fn tell(&mut self) -> anyhow::Result<(Story, Improvement)> {
        let folder = folder();
        if folder.exists() {
            fs::remove_dir_all(&folder).with_context(|| format!("{} cannot be emptied", folder.display()))?;
        }
        fs::create_dir_all(&folder).with_context(|| format!("{} cannot be made", folder.display()))?;
        let flight = folder.join("paper-reconstruction.csv");
        let (first, second) = (folder.join("first.csv"), folder.join("second.csv"));
        for (scenario, flight) in [(SCENARIO, &flight), (HIDDEN, &first), (SECOND, &second)] {
            self.simulate(scenario, flight)?;
        }

        let mut diagnose = self.pylon("diagnose");
        diagnose.arg(&first).arg("--json");
        let diagnosis: Diagnosis = self.json("diagnosing the flight with a hidden effect", diagnose)?;
        let missing = diagnosis.missing();
        let [effect] = missing.as_slice() else {
            bail!("the diagnosis concludes {}: {}", diagnosis.verdict, missing.join(", "));
        };
        let model = folder.join("improved.toml");
        let mut add = self.pylon("add");
        add.arg(effect).args(["--model", "default", "--from"]).arg(&first);
        add.arg("--hold-out").arg(&second).arg("-o").arg(&model).arg("--json");
        let addition: Addition = self.json(&format!("adding {effect} to the model"), add)?;

        let [flown, flown_second] = self.fly([(&flight, Path::new(MODEL)), (&second, &model)])?;

        let pictures = folder.join("pictures");
        let mut compare = self.pylon("compare");
        compare.arg(&flight).args(["--model", MODEL, "--json", "--plots"]).arg(&pictures);
        let comparison: Comparison = self.json("comparing the paper's flight with its model", compare)?;
        let report = folder.join("report.html");
        let mut write = self.pylon("report");
        write.args([&first, &second]).arg("--model").arg(&model).arg("-o").arg(&report);
        self.run("writing a report of the other two with the improved model", write)?;
        let page =
            fs::read_to_string(&report).with_context(|| format!("{} cannot be read", report.display()))?;
        if !page.contains("data-chart=\"ladder-2\"") || !page.contains(*effect) {
            bail!("{} does not show how the error fell on the second flight", report.display());
        }

        let (sensor, _) = effect.split_once('.').context("an effect's id is SENSOR.EFFECT")?;
        let (effect, sensor) = ((*effect).to_owned(), sensor.to_owned());
        Ok((
            Story { flown, comparison, flight, pictures: drawn(&pictures)? },
            Improvement { effect, sensor, addition, ticks: flown_second.ticks, model, report },
        ))
    }

    /// Builds the images with these models and flies the flights in QEMU, in parallel: while one image is
    /// linked, the other flies.
    fn fly(&mut self, flights: [(&Path, &Path); 2]) -> anyhow::Result<[Flown; 2]> {
        let commands = flights.map(|(flight, model)| {
            let mut fly = self.pylon("fly");
            fly.arg(flight).arg("--model").arg(model).arg("--json");
            fly
        });
        let echo = self.echo;
        let name =
            "building the flight computer's image with each model and flying both in QEMU, bit for bit";
        self.stages.run(name, |news| {
            let hear = |line: &str| news.hear(line);
            let [mut paper, mut improved] = commands;
            thread::scope(|scope| {
                let paper = scope.spawn(|| json(&mut paper, echo, &hear));
                let improved = json(&mut improved, echo, &hear);
                let paper =
                    paper.join().map_err(|_| anyhow!("the thread that flies the paper's flight panicked"))?;
                Ok([paper?, improved?])
            })
        })
    }

    /// A command of the workbench.
    fn pylon(&self, command: &str) -> Command {
        let mut pylon = workspace::program(&self.workbench);
        pylon.arg(command);
        pylon
    }

    fn simulate(&mut self, scenario: &str, flight: &Path) -> anyhow::Result<()> {
        let mut simulate = self.pylon("simulate");
        simulate.arg(scenario).arg("-o").arg(flight);
        self.run(&format!("simulating {scenario}"), simulate)?;
        Ok(())
    }

    /// Runs a command as a step.
    fn run(&mut self, name: &str, mut command: Command) -> anyhow::Result<child::ChildOutput> {
        let echo = self.echo;
        self.stages.run(name, |news| Ok(child::run_heard(&mut command, echo, &|line| news.hear(line))?))
    }

    /// Runs a command as a step, and parses its output.
    fn json<T: DeserializeOwned + Send>(&mut self, name: &str, mut command: Command) -> anyhow::Result<T> {
        let echo = self.echo;
        self.stages.run(name, |news| json(&mut command, echo, &|line| news.hear(line)))
    }
}

/// Runs a command, and parses its output.
fn json<T: DeserializeOwned>(
    command: &mut Command,
    echo: bool,
    hear: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<T> {
    let said = child::run_heard(command, echo, hear)?;
    serde_json::from_str(&said.stdout)
        .with_context(|| format!("`{}` printed unexpected output", child::shown(command)))
}

/// Folder of the demo's files.
fn folder() -> PathBuf {
    workspace::target_folder().join("demo")
}

/// The pictures in a folder, by name.
fn drawn(folder: &PathBuf) -> anyhow::Result<Vec<PathBuf>> {
    let files = fs::read_dir(folder).with_context(|| format!("{} cannot be read", folder.display()))?;
    let mut pictures: Vec<_> = files.flatten().map(|file| file.path()).collect();
    pictures.retain(|path| path.extension().is_some_and(|extension| extension == "svg"));
    pictures.sort();
    if pictures.is_empty() {
        bail!("no picture was drawn in {}", folder.display());
    }
    Ok(pictures)
}
