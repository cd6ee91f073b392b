//! `cargo xtask campaign`: faults in the whole chain, compared with the same flights without them.

use std::path::PathBuf;

use anyhow::Context;

use crate::child;
use crate::setup::{self, Need};
use crate::steps::Done;
use crate::workspace;

/// The program.
const PROGRAM: &str = "campaign";

/// Arguments of the campaign; see `host-tests/src/bin/campaign.rs`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Number of runs.
    #[arg(default_value_t = 1_000)]
    pub runs: u64,
    /// The campaign's seed.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Fly this run alone, and print its faults and its outcome.
    #[arg(long)]
    pub run: Option<u64>,
    /// Also write both of its flights, tick by tick, as CSV.
    #[arg(long, value_name = "FILE", requires = "run")]
    pub trace: Option<PathBuf>,
    /// Fly this many short runs in QEMU instead, comparing every tick with the host bit for bit.
    #[arg(long, value_name = "RUNS")]
    pub qemu: Option<u64>,
    /// Disable each guard in turn, and fail unless the campaign reports it.
    #[arg(long)]
    pub mutants: bool,
    /// Write the tables of docs/fault-campaign.md.
    #[arg(long)]
    pub write: bool,
    /// Fail only for violations that host-tests/campaign-known.toml does not list.
    #[arg(long)]
    pub known: bool,
    /// Write host-tests/campaign-known.toml again from this campaign.
    #[arg(long, requires = "known")]
    pub accept: bool,
}

/// Flies the campaign; returns whether every invariant was kept. The tables are printed to standard output.
pub fn run(arguments: &Arguments, verbose: bool) -> anyhow::Result<bool> {
    if let Some(runs) = arguments.qemu {
        return qemu(runs, arguments.seed, verbose);
    }
    setup::provide(Need::Npm, verbose)?;
    eprintln!("building the fault campaign");
    let build = ["build", "--release", "--package", "host-tests", "--bin", PROGRAM];
    child::run(&mut workspace::cargo(build), verbose)?;
    let file = workspace::workbench().with_file_name(format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX));
    let mut program = workspace::program(file);
    program.args([&arguments.runs.to_string(), "--seed", &arguments.seed.to_string()]);
    if let Some(index) = arguments.run {
        program.args(["--run", &index.to_string()]);
    }
    if let Some(file) = &arguments.trace {
        program.arg("--trace").arg(file);
    }
    for (flag, is_set) in
        [("--mutants", arguments.mutants), ("--write", arguments.write), ("--accept", arguments.accept)]
    {
        if is_set {
            program.arg(flag);
        }
    }
    if arguments.known {
        program.arg("--known").arg(known());
    }
    // The program draws its own progress bar, so it needs the terminal.
    let status = program.status().with_context(|| format!("`{}`", child::shown(&program)))?;
    Ok(status.success())
}

/// Flies the sample that is also a test of `host-tests`, with another number of runs.
fn qemu(runs: u64, seed: u64, verbose: bool) -> anyhow::Result<bool> {
    for need in [Need::Target, Need::Qemu, Need::Npm] {
        setup::provide(need, verbose)?;
    }
    let arguments = ["test", "--package", "host-tests", "--test", "qemu_campaign", "--", "--nocapture"];
    let mut test = workspace::cargo(arguments);
    test.env("PYLON_CAMPAIGN_RUNS", runs.to_string()).env("PYLON_CAMPAIGN_SEED", seed.to_string());
    let status = test.status().with_context(|| format!("`{}`", child::shown(&test)))?;
    Ok(status.success())
}

/// Runs the campaign of the test command: a thousand runs, and again without each guard in turn. It fails for
/// any violation that `host-tests/campaign-known.toml` does not list.
pub fn test(echo: bool) -> anyhow::Result<Done> {
    child::run(&mut workspace::test(["--no-run"]), echo)?;
    let mut program = workspace::program(workspace::tested(PROGRAM));
    let said = child::run(program.args(["--mutants", "--known"]).arg(known()), echo)?;
    let last = said.stdout.trim_end().lines().last().unwrap_or_default().to_owned();
    Ok(Done::all(last))
}

/// The list of known violations.
fn known() -> PathBuf {
    workspace::root().join("host-tests/campaign-known.toml")
}
