//! `cargo xtask endurance`: long and many flights through the emulated flight computer.

use anyhow::{Context, bail};

use crate::child;
use crate::setup::{self, Need};
use crate::workspace;

/// Flies hours of captive flight, then random flights; their output goes to standard output.
pub fn run(hours: f64, flights: u64, seed: u64, verbose: bool) -> anyhow::Result<()> {
    for need in [Need::Target, Need::Qemu, Need::Npm] {
        setup::provide(need, verbose)?;
    }
    eprintln!("building");
    child::run(
        &mut workspace::cargo(["build", "--release", "--package", "host-tests", "--bin", "endurance"]),
        verbose,
    )?;
    let file = workspace::workbench().with_file_name(format!("endurance{}", std::env::consts::EXE_SUFFIX));
    let jobs = [
        ("captive", vec!["--hours".to_owned(), hours.to_string()]),
        ("random", vec!["--flights".to_owned(), flights.to_string(), "--seed".to_owned(), seed.to_string()]),
    ];
    for (job, arguments) in jobs {
        let mut program = workspace::program(&file);
        program.arg(job).args(arguments);
        // The program draws its own progress bar, so it needs the terminal.
        let status = program.status().with_context(|| format!("`{}`", child::shown(&program)))?;
        if !status.success() {
            bail!("`{}` ended with {status}", child::shown(&program));
        }
    }
    Ok(())
}
