//! `cargo xtask monitor-curves`: the monitor's rules as curves.

use std::process::Command;

use anyhow::{Context, bail};

use crate::child;
use crate::setup::{self, Need};
use crate::workspace;

/// Builds and runs the program, which writes docs/monitor-rules.md and its picture.
pub fn run(seed: u64, echo: bool) -> anyhow::Result<()> {
    setup::provide(Need::Npm, echo)?;
    eprintln!("building the monitor's curves");
    let build = ["build", "--release", "--package", "host-tests", "--bin", "monitor_curves"];
    child::run(&mut workspace::cargo(build), echo)?;
    let file =
        workspace::workbench().with_file_name(format!("monitor_curves{}", std::env::consts::EXE_SUFFIX));
    let mut program: Command = workspace::program(file);
    program.args(["--seed", &seed.to_string(), "--folder"]).arg(workspace::root().join("docs"));
    let status = program.status().with_context(|| format!("`{}`", child::shown(&program)))?;
    if !status.success() {
        bail!("`{}` ended with {status}", child::shown(&program));
    }
    Ok(())
}
