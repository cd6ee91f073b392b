//! `pylon simulate`.

use std::path::{Path, PathBuf};

use clap::Args;
use pylon::simulate::run_with_seed;

use super::failure::Failure;
use super::overwriting::{Role, refuse_overwriting};
use super::progress::while_busy;
use super::terminal;

const EXAMPLES: &str = "\
Examples:
  pylon simulate flights/quickstart.toml -o flight.csv
      flight.csv, and the truth about it in flight.truth.toml
  pylon simulate flights/paper-reconstruction.toml --seed 7 -o flight-7.csv --truth truth-7.toml
      another draw of the same scenario";

/// Simulate a flight from a scenario: a flight's CSV, and apart from it the truth
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The scenario (TOML)
    #[arg(value_name = "SCENARIO")]
    scenario: PathBuf,
    /// The flight to write (CSV)
    #[arg(short, long, value_name = "FLIGHT")]
    output: PathBuf,
    /// Where the truth goes (TOML; without: beside the flight, ending in .truth.toml)
    #[arg(long, value_name = "TRUTH")]
    truth: Option<PathBuf>,
    /// Another seed than the scenario's
    #[arg(long, value_name = "SEED")]
    seed: Option<u64>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let truth = arguments.truth.clone().unwrap_or_else(|| beside(&arguments.output));
    refuse_overwriting(
        &[Role::new(&arguments.scenario, "the scenario")],
        &[Role::new(&arguments.output, "the flight"), Role::new(&truth, "the truth")],
    )?;
    let summary = while_busy("simulating", || {
        run_with_seed(&arguments.scenario, arguments.seed, &arguments.output, &truth)
    })?;
    let launch =
        summary.launch_s.map_or_else(|| "no launch".to_owned(), |launch_s| format!("launch at {launch_s} s"));
    terminal::put(&format!(
        "{}: simulated '{}' (seed {}), {} rows, {} s, {launch}; the truth is in {}\n",
        arguments.output.display(),
        summary.name,
        summary.seed,
        summary.rows,
        summary.duration_s,
        truth.display()
    ))
}

fn beside(flight: &Path) -> PathBuf {
    flight.with_extension("truth.toml")
}
