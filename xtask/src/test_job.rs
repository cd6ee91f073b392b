//! `cargo xtask test`: every test of every kind.

use std::mem;

use anyhow::{anyhow, bail};

use crate::campaign;
use crate::child::{self, Failure};
use crate::demo;
use crate::setup::{self, Need, Provided};
use crate::site;
use crate::steps::{Done, Parts, Steps};
use crate::test_programs::{self, Ended, TestProgram};
use crate::test_report::TestReport;
use crate::wasm;
use crate::workspace::{self, TARGET};

/// A step, and what the machine must have for it.
struct Step {
    name: &'static str,
    needs: &'static [Need],
    run: Run,
}

/// How a step is done.
enum Run {
    /// By a function.
    Alone(fn(echo: bool) -> anyhow::Result<Done>),
    /// By running these test programs, or all.
    Programs,
}

/// The step that runs the test programs.
const TESTS: &str = "tests";

const STEPS: &[Step] = &[
    Step { name: "formatting", needs: &[Need::Rustfmt], run: Run::Alone(formatting) },
    Step { name: "clippy, host", needs: &[Need::Clippy, Need::Npm], run: Run::Alone(clippy_host) },
    Step { name: "formats, one by one", needs: &[], run: Run::Alone(formats_one_by_one) },
    Step { name: "clippy, board-qemu", needs: &[Need::Clippy, Need::Target], run: Run::Alone(clippy_qemu) },
    Step { name: "clippy, board-hil", needs: &[Need::Clippy, Need::Target], run: Run::Alone(clippy_hil) },
    Step { name: "clippy, board-f405", needs: &[Need::Clippy, Need::Target], run: Run::Alone(clippy_f405) },
    Step { name: "workbench, wasm32", needs: &[Need::Wasm], run: Run::Alone(wasm::check) },
    Step { name: "studio", needs: &[Need::Wasm, Need::Npm], run: Run::Alone(site::check) },
    Step { name: "documentation, host", needs: &[Need::Npm], run: Run::Alone(documentation_host) },
    Step { name: "documentation, firmware", needs: &[Need::Target], run: Run::Alone(documentation_firmware) },
    Step { name: "image, board-qemu", needs: &[Need::Target], run: Run::Alone(image_qemu) },
    Step { name: "image, board-hil", needs: &[Need::Target], run: Run::Alone(image_hil) },
    Step { name: "image, board-f405", needs: &[Need::Target], run: Run::Alone(image_f405) },
    Step {
        name: TESTS,
        needs: &[Need::Target, Need::Wasm, Need::Qemu, Need::Npm, Need::Chromium, Need::Pymavlink],
        run: Run::Programs,
    },
    Step { name: "fault campaign", needs: &[Need::Npm], run: Run::Alone(campaign::test) },
    Step { name: "demo", needs: &[Need::Target, Need::Qemu, Need::Npm], run: Run::Alone(demo::test) },
];

/// Runs the steps and test programs whose names contain one of the words, or all; returns whether none
/// failed.
pub fn run(words: &[String], list: bool, echo: bool) -> anyhow::Result<bool> {
    let is_meant = |name: &str| words.is_empty() || words.iter().any(|word| name.contains(word.as_str()));
    let mut programs = test_programs::all()?;
    if !is_meant(TESTS) {
        programs.retain(|program| is_meant(&program.name));
    }
    let chosen: Vec<_> = STEPS
        .iter()
        .filter(|step| match step.run {
            Run::Alone(_) => is_meant(step.name),
            Run::Programs => !programs.is_empty(),
        })
        .collect();
    if chosen.is_empty() {
        let words = words.join(" or ");
        bail!("no step or test program is called {words}; `cargo xtask test --list` names them");
    }
    if list {
        for step in chosen {
            println!("{}", step.name);
            if matches!(step.run, Run::Programs) {
                programs.iter().for_each(|program| println!("  {}", program.name));
            }
        }
        return Ok(true);
    }

    let needs: Vec<_> =
        Need::ALL.into_iter().filter(|need| chosen.iter().any(|step| step.needs.contains(need))).collect();
    let mut steps = Steps::new(needs.len() + chosen.len());
    let mut missing = Vec::new();
    for need in needs {
        if !steps.run(&format!("set-up, {}", need.name()), || set_up(need, echo)) {
            missing.push(need);
        }
    }
    for step in chosen {
        steps.run(step.name, || match (step.needs.iter().find(|need| missing.contains(need)), &step.run) {
            (Some(need), _) => Err(anyhow!("not run: {} is missing", need.name())),
            (None, Run::Alone(run)) => run(echo),
            (None, Run::Programs) => tests(mem::take(&mut programs), echo),
        });
    }
    println!("\n{}\n\n{}\n\n{}", steps.table(), steps.slowest(), steps.verdict());
    let [_, failed, _] = steps.counts();
    Ok(failed == 0)
}

fn set_up(need: Need, echo: bool) -> anyhow::Result<Done> {
    Ok(Done::all(match setup::provide(need, echo)? {
        Provided::Found(what) => format!("found: {what}"),
        Provided::Installed(what) => format!("installed: {what}"),
    }))
}

/// Runs cargo; the result has no details.
fn cargo<const N: usize>(arguments: [&str; N], echo: bool) -> anyhow::Result<Done> {
    child::run(&mut workspace::cargo(arguments), echo)?;
    Ok(Done::default())
}

fn formatting(echo: bool) -> anyhow::Result<Done> {
    cargo(["fmt", "--all", "--check"], echo)
}

fn clippy_host(echo: bool) -> anyhow::Result<Done> {
    cargo(["clippy", "--workspace", "--exclude", "firmware", "--all-targets", "--", "-D", "warnings"], echo)
}

/// Builds the workbench's formats, each of which is a feature: without any, and with each alone, as programs
/// that embed them may want.
fn formats_one_by_one(echo: bool) -> anyhow::Result<Done> {
    const FEATURES: [&str; 10] =
        ["", "altus", "dataflash", "igc", "mcap", "parquet", "record", "table", "tlog", "ulog"];
    for feature in FEATURES {
        let arguments = ["check", "--package", "formats", "--no-default-features", "--features", feature];
        child::run(&mut workspace::cargo(arguments), echo)?;
    }
    Ok(Done::all("none, and each of 9"))
}

fn clippy_qemu(echo: bool) -> anyhow::Result<Done> {
    clippy_target("bench", "board-qemu", echo)?;
    clippy_target("firmware", "board-qemu", echo)
}

fn clippy_hil(echo: bool) -> anyhow::Result<Done> {
    clippy_target("firmware", "board-hil", echo)
}

fn clippy_f405(echo: bool) -> anyhow::Result<Done> {
    clippy_target("firmware", "board-f405,baro-bmp390", echo)?;
    clippy_target("firmware", "board-f405", echo)
}

fn clippy_target(package: &str, features: &str, echo: bool) -> anyhow::Result<Done> {
    let arguments = ["--target", TARGET, "--features", features, "--", "-D", "warnings"];
    child::run(workspace::cargo(["clippy", "--package", package]).args(arguments), echo)?;
    Ok(Done::default())
}

fn documentation_host(echo: bool) -> anyhow::Result<Done> {
    documentation(&["--workspace", "--exclude", "firmware"], echo)
}

fn documentation_firmware(echo: bool) -> anyhow::Result<Done> {
    let packages = ["--package", "firmware", "--package", "bench"];
    documentation(&[&packages[..], &["--target", TARGET, "--features", "board-qemu"]].concat(), echo)
}

fn documentation(what: &[&str], echo: bool) -> anyhow::Result<Done> {
    let mut doc = workspace::cargo(["doc", "--no-deps", "--document-private-items"]);
    child::run(doc.args(what).env("RUSTDOCFLAGS", "-D warnings"), echo)?;
    Ok(Done::default())
}

fn image_qemu(echo: bool) -> anyhow::Result<Done> {
    image("board-qemu", echo)
}

fn image_hil(echo: bool) -> anyhow::Result<Done> {
    image("board-hil", echo)
}

fn image_f405(echo: bool) -> anyhow::Result<Done> {
    image("board-f405", echo)
}

/// Builds the flight computer's image in the folder where the workbench builds it.
fn image(board: &str, echo: bool) -> anyhow::Result<Done> {
    let mut build = workspace::firmware_build("flight", board);
    child::run(&mut build, echo)?;
    Ok(Done::default())
}

/// The tests of every crate except the firmware, of the page and of the documentation's examples: unit,
/// property and whole-chain tests, including the flights in the emulator.
fn tests(programs: Vec<TestProgram>, echo: bool) -> anyhow::Result<Done> {
    eprintln!();
    let mut report = TestReport::default();
    let mut parts = Parts::default();
    let mut failed = Vec::new();
    let mut take = |Ended { program: TestProgram { name, kind, .. }, outcome, took }: Ended| {
        let mut own = TestReport::default();
        let failure = match outcome {
            Ok(output) => {
                own.hear(kind, &output.all);
                report.hear(kind, &output.all);
                None
            }
            Err(failure) => {
                if let Some(Failure::Ended { output, .. }) = failure.downcast_ref() {
                    own.hear(kind, &output.all);
                    report.hear(kind, &output.all);
                    eprintln!("\n{}", output.all.trim_end());
                }
                Some(failure)
            }
        };
        let counts = format!("{} passed, {} failed", own.passed(), own.failed);
        eprintln!("           {name}: {counts}, {:.1} s", took.as_secs_f64());
        if let Some(failure) = failure {
            eprintln!("           {failure:#}");
            failed.push(name.clone());
        }
        parts.each.push((name, took));
    };
    parts.together = test_programs::run(programs, echo, &mut take)?;
    if !failed.is_empty() {
        let counts = format!("{} tests passed, {} failed", report.passed(), report.failed);
        bail!("{counts}, in {}", failed.join(", "));
    }
    Ok(Done { what: report.to_string(), skipped: report.skipped, parts })
}
