//! The test programs: those that cargo builds for every crate except the firmware, the documentation's
//! examples, and the studio in a browser.
//!
//! They run in parallel: while one links an image, or waits for a browser or the emulator, another can use
//! the processors.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::Context;
use serde::Deserialize;

use crate::child::{self, ChildOutput};
use crate::packages::{self, Target};
use crate::site;
use crate::test_report::Kind;
use crate::workspace;

/// Number of programs that run at a time. Each has a thread for every processor, so two of them leave a
/// processor idle only while both wait.
const SIDE_BY_SIDE: usize = 2;

/// The documentation's examples, which `cargo test --doc` compiles and runs.
const EXAMPLES: &str = "documentation examples";

/// A test program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TestProgram {
    /// Its name: that of its file, or of the crate whose units it tests.
    pub name: String,
    /// What it tests.
    pub kind: Kind,
    /// Where cargo builds it from; none if it is not one of cargo's.
    source: Option<Source>,
}

/// Source of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Source {
    /// Its first file, which identifies it: a crate's library and its program may have the same name.
    file: PathBuf,
    /// The crate's folder, in which it is run.
    folder: PathBuf,
}

/// Result of a test program.
#[derive(Debug)]
pub struct Ended {
    /// The program.
    pub program: TestProgram,
    /// Its output, or why it failed or was not run.
    pub outcome: anyhow::Result<ChildOutput>,
    /// How long it ran.
    pub took: Duration,
}

/// A line of cargo's output that reports a built artifact.
#[derive(Deserialize)]
struct Artifact {
    target: Target,
    profile: Profile,
    executable: Option<PathBuf>,
}

#[derive(Deserialize)]
struct Profile {
    test: bool,
}

/// The program with the tests of a target.
fn program(target: Target, manifest: &Path) -> anyhow::Result<TestProgram> {
    let folder = manifest.parent().context("a manifest has no folder")?;
    let is_integration = target.kind.iter().any(|kind| kind == "test");
    let kind = match target.name.as_str() {
        _ if !is_integration => Kind::Unit,
        "budgets" => Kind::Budgets,
        name if name.starts_with("qemu") => Kind::Emulated,
        _ => Kind::Integration,
    };
    let source = Some(Source { file: target.src_path, folder: folder.to_owned() });
    Ok(TestProgram { name: target.name.replace('-', "_"), kind, source })
}

/// Every program, in starting order, without building any. Those that use few processors for long come first,
/// so that none of them is left running alone at the end.
pub fn all() -> anyhow::Result<Vec<TestProgram>> {
    let mut programs = Vec::new();
    for package in packages::all()?.into_iter().filter(|package| package.name != workspace::UNTESTED) {
        for target in package.targets.into_iter().filter(|target| target.test) {
            programs.push(program(target, &package.manifest_path)?);
        }
    }
    programs.push(TestProgram { name: "studio".into(), kind: Kind::Browser, source: None });
    programs.push(TestProgram { name: EXAMPLES.into(), kind: Kind::Documentation, source: None });
    programs.sort_by_key(|program| program.kind.rank());
    Ok(programs)
}

/// Builds cargo's programs; returns the path of each by its first file.
fn build(echo: bool) -> anyhow::Result<HashMap<PathBuf, PathBuf>> {
    let mut cargo = workspace::test(["--no-run", "--message-format", "json-render-diagnostics"]);
    let built = child::run(&mut cargo, echo)?.stdout;
    let mut executables = HashMap::new();
    for line in built.lines().filter(|line| line.starts_with(r#"{"reason":"compiler-artifact""#)) {
        let Artifact { target, profile, executable } =
            serde_json::from_str(line).with_context(|| format!("cargo printed unexpected output: {line}"))?;
        if profile.test {
            executables.extend(executable.map(|executable| (target.src_path, executable)));
        }
    }
    Ok(executables)
}

/// The command that runs a program; for cargo's, as cargo would run it.
fn command(program: &TestProgram, executables: &HashMap<PathBuf, PathBuf>) -> anyhow::Result<Command> {
    let Some(Source { file, folder }) = &program.source else {
        return match program.kind {
            Kind::Browser => site::browser_tests(),
            _ => Ok(workspace::test(["--doc"])),
        };
    };
    let executable =
        executables.get(file).with_context(|| format!("cargo has not built {}", program.name))?;
    let mut command = workspace::program(executable);
    command.arg("--show-output").current_dir(folder).env("CARGO_MANIFEST_DIR", folder);
    Ok(command)
}

/// Builds and runs these programs, some at a time; `ended` gets each as it ends. Returns how long they took
/// together, without the building.
///
/// # Errors
/// The programs cannot be built. One that fails or cannot be run does not stop the others.
pub fn run(
    programs: Vec<TestProgram>,
    echo: bool,
    ended: &mut (dyn FnMut(Ended) + Send),
) -> anyhow::Result<Duration> {
    let executables = build(echo)?;
    let run = |program: TestProgram| {
        let start = Instant::now();
        let outcome = command(&program, &executables)
            .and_then(|mut command| Ok(child::run_in_order(&mut command, echo, &mut |_| ())?));
        Ended { program, outcome, took: start.elapsed() }
    };
    let start = Instant::now();
    side_by_side(programs, SIDE_BY_SIDE, run, ended);
    Ok(start.elapsed())
}

/// Runs these jobs in order, this many at a time; `ended` gets each result as it arrives.
fn side_by_side<J: Send, R>(
    jobs: Vec<J>,
    lanes: usize,
    work: impl Fn(J) -> R + Sync,
    ended: &mut (dyn FnMut(R) + Send),
) {
    let jobs: Vec<_> = jobs.into_iter().map(|job| Mutex::new(Some(job))).collect();
    let next = AtomicUsize::new(0);
    let ended = Mutex::new(ended);
    thread::scope(|scope| {
        for _ in 0..lanes {
            scope.spawn(|| {
                while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let job = job.lock().unwrap_or_else(PoisonError::into_inner).take();
                    if let Some(result) = job.map(&work) {
                        ended.lock().unwrap_or_else(PoisonError::into_inner)(result);
                    }
                }
            });
        }
    });
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;

    use super::*;

    #[test]
    fn every_kind_is_found_and_what_leaves_processors_idle_is_started_first() {
        let programs = all().unwrap();
        let found =
            |name: &str, kind| programs.iter().position(|one| one.name == name && one.kind == kind).unwrap();
        let budgets = found("budgets", Kind::Budgets);
        let emulated = found("qemu_chips", Kind::Emulated);
        let browser = found("studio", Kind::Browser);
        let integration = found("golden", Kind::Integration);
        let unit = found("xtask", Kind::Unit);
        assert!([budgets, emulated, browser, integration, unit].is_sorted(), "{programs:#?}");
        found(EXAMPLES, Kind::Documentation);
        assert!(programs.iter().all(|program| program.name != workspace::UNTESTED), "{programs:#?}");
    }

    #[test]
    fn a_library_and_a_program_that_are_called_alike_are_two() {
        let programs = all().unwrap();
        let alike: Vec<_> = programs.iter().filter(|program| program.name == "pylon").collect();
        assert_eq!(alike.len(), 2, "{alike:#?}");
        assert_ne!(alike[0], alike[1]);
    }

    /// If they ran one after the other, the first two would wait for each other for ever.
    #[test]
    fn jobs_run_side_by_side_and_each_ends_once() {
        let meet = Barrier::new(2);
        let mut squares = Vec::new();
        let work = |job: usize| {
            if job < 2 {
                meet.wait();
            }
            job * job
        };
        side_by_side((0..7).collect(), 2, work, &mut |square| squares.push(square));
        squares.sort_unstable();
        assert_eq!(squares, [0, 1, 4, 9, 16, 25, 36]);
    }
}
