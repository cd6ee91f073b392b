//! `cargo xtask test`: every test of every kind.

use anyhow::{anyhow, bail};

use crate::campaign;
use crate::child::{self, Failure};
use crate::demo;
use crate::setup::{self, Need, Provided};
use crate::site;
use crate::steps::{Done, Steps};
use crate::test_report::{TestProgress, TestReport};
use crate::wasm;
use crate::workspace::{self, TARGET};

/// A step and what the machine must have for it.
struct Step {
    name: &'static str,
    needs: &'static [Need],
    run: fn(echo: bool) -> anyhow::Result<Done>,
}

const STEPS: &[Step] = &[
    Step { name: "formatting", needs: &[Need::Rustfmt], run: formatting },
    Step { name: "clippy, host", needs: &[Need::Clippy, Need::Npm], run: clippy_host },
    Step { name: "formats, one by one", needs: &[], run: formats_one_by_one },
    Step { name: "clippy, board-qemu", needs: &[Need::Clippy, Need::Target], run: clippy_qemu },
    Step { name: "clippy, board-hil", needs: &[Need::Clippy, Need::Target], run: clippy_hil },
    Step { name: "clippy, board-f405", needs: &[Need::Clippy, Need::Target], run: clippy_f405 },
    Step { name: "workbench, wasm32", needs: &[Need::Wasm], run: wasm::check },
    Step { name: "studio", needs: &[Need::Wasm, Need::Npm, Need::Chromium], run: site::test },
    Step { name: "documentation, host", needs: &[Need::Npm], run: documentation_host },
    Step { name: "documentation, firmware", needs: &[Need::Target], run: documentation_firmware },
    Step { name: "image, board-qemu", needs: &[Need::Target], run: image_qemu },
    Step { name: "image, board-hil", needs: &[Need::Target], run: image_hil },
    Step { name: "image, board-f405", needs: &[Need::Target], run: image_f405 },
    Step {
        name: "tests",
        needs: &[Need::Target, Need::Wasm, Need::Qemu, Need::Npm, Need::Chromium, Need::Pymavlink],
        run: tests,
    },
    Step { name: "fault campaign", needs: &[Need::Npm], run: campaign::test },
    Step { name: "demo", needs: &[Need::Target, Need::Qemu, Need::Npm], run: demo::test },
];

/// Runs the steps whose name contains one of the words, or all; says whether none failed.
pub fn run(words: &[String], list: bool, echo: bool) -> anyhow::Result<bool> {
    let wanted =
        |step: &&Step| words.is_empty() || words.iter().any(|word| step.name.contains(word.as_str()));
    let chosen: Vec<_> = STEPS.iter().filter(wanted).collect();
    if chosen.is_empty() {
        bail!("no step is called {}; `cargo xtask test --list` names them", words.join(" or "));
    }
    if list {
        for step in chosen {
            println!("{}", step.name);
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
        steps.run(step.name, || match step.needs.iter().find(|need| missing.contains(need)) {
            Some(need) => Err(anyhow!("not run: {} is missing", need.name())),
            None => (step.run)(echo),
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

/// Runs cargo and has no more to say than that it ended well.
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

/// The workbench's formats, each of which is a feature: without any, and with each alone, as who embeds them may want them.
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

/// Builds the flight computer's image where the workbench builds it.
fn image(board: &str, echo: bool) -> anyhow::Result<Done> {
    let mut build = workspace::firmware_build("flight", board);
    child::run(&mut build, echo)?;
    Ok(Done::default())
}

/// The tests of every crate but the firmware: unit, property, documentation and whole-chain tests, the
/// flights in the emulator among them.
fn tests(echo: bool) -> anyhow::Result<Done> {
    let mut cargo = workspace::test(["--no-fail-fast", "--", "--show-output"]);
    eprintln!();
    let mut progress = TestProgress::default();
    let mut show = |line: &str| {
        if let Some(ended) = progress.hear(line) {
            eprintln!("           {ended}");
        }
    };
    let report = match child::run_in_order(&mut cargo, echo, &mut show) {
        Ok(output) => TestReport::read(&output.all),
        Err(failure) => {
            let report = match &failure {
                Failure::Ended { output, .. } => TestReport::read(&output.all),
                Failure::NotStarted { .. } => TestReport::default(),
            };
            let counts = format!("{} tests passed, {} failed", report.passed(), report.failed);
            return Err(anyhow::Error::from(failure).context(counts));
        }
    };
    Ok(Done { what: report.to_string(), skipped: report.skipped, parts: progress.took })
}
