//! `cargo xtask hil`: flies a flight through a board by its debug link (hardware in the loop).

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use anyhow::{Context, anyhow};

use crate::child;
use crate::setup::{self, Need};
use crate::workspace;

/// Exit status if nothing could be compared: the same as the workbench's.
pub const NOT_FLOWN: u8 = 2;

/// Arguments: the flight, and how the board is reached.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// The flight: a flight's CSV, or a log that `pylon import` reads.
    flight: PathBuf,
    /// A model file, or a preset's name.
    #[arg(long, default_value = "default")]
    model: String,
    /// OpenOCD configuration file of the probe, from OpenOCD or your own; may be given more than once.
    #[arg(long = "probe-config", value_name = "FILE", default_value = "interface/stlink.cfg")]
    probe_configs: Vec<PathBuf>,
    /// Further options of `pylon fly`.
    #[arg(last = true, value_name = "OPTIONS")]
    further: Vec<String>,
}

/// Builds the workbench and runs `pylon fly`; returns its exit status.
///
/// # Errors
/// The workbench or the target cannot be provided, or the workbench was ended by a signal.
pub fn run(arguments: &Arguments, echo: bool) -> anyhow::Result<ExitCode> {
    for need in [Need::Npm, Need::Target] {
        setup::provide(need, echo)?;
    }
    eprintln!("building the workbench");
    child::run(&mut workspace::build_workbench(), echo).context("the workbench does not build")?;
    let mut fly = fly(&workspace::workbench(), arguments);
    let shown = child::shown(&fly);
    eprintln!("$ {shown}");
    // The workbench prints progress and report itself, so it needs the terminal.
    let status = fly.stdin(Stdio::inherit()).status().with_context(|| shown.clone())?;
    eprintln!(
        "a board that was written to keeps this image, which does nothing without a probe; `cargo xtask flash` writes the flight \
         computer's again"
    );
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    code.map(ExitCode::from).ok_or_else(|| anyhow!("`{shown}` ended with {status}"))
}

/// The workbench's command line. It runs in the user's folder, because the paths are relative to it.
fn fly(workbench: &Path, arguments: &Arguments) -> Command {
    let Arguments { flight, model, probe_configs, further } = arguments;
    let mut fly = Command::new(workbench);
    fly.arg("fly").arg(flight).args(["--hil", "--model", model]);
    for file in probe_configs {
        fly.arg("--probe-config").arg(file);
    }
    fly.args(further);
    fly
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;
    use crate::cli::{Cli, Job};

    fn shown(line: &str) -> String {
        let cli = Cli::try_parse_from(line.split(' ')).unwrap();
        let Some(Job::Hil(arguments)) = cli.job else { panic!("{cli:?}") };
        child::shown(&fly(Path::new("pylon"), &arguments))
    }

    #[test]
    fn the_workbench_gets_the_flight_the_model_the_probe_and_what_follows() {
        assert_eq!(
            shown("xtask hil q.csv"),
            "pylon fly q.csv --hil --model default --probe-config interface/stlink.cfg"
        );
        assert_eq!(
            shown("xtask hil q.csv --model ours.toml --probe-config a.cfg --probe-config b.cfg -- --json"),
            "pylon fly q.csv --hil --model ours.toml --probe-config a.cfg --probe-config b.cfg --json"
        );
    }

    #[test]
    fn it_runs_where_the_user_is() {
        let cli = Cli::try_parse_from(["xtask", "hil", "q.csv"]).unwrap();
        let Some(Job::Hil(arguments)) = cli.job else { panic!("{cli:?}") };
        assert_eq!(fly(Path::new("pylon"), &arguments).get_current_dir(), None);
    }
}
