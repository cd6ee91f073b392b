//! `pylon simulate`.

use std::path::{Path, PathBuf};

use clap::Args;
use pylon::results::{SimulateResult, VERSION};
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

/// Simulate a flight from a scenario: a flight CSV and, separately, the truth
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The scenario (TOML)
    #[arg(value_name = "SCENARIO")]
    scenario: PathBuf,
    /// The flight to write (CSV)
    #[arg(short, long, value_name = "FLIGHT")]
    output: PathBuf,
    /// Where to write the truth (TOML) [default: beside the flight, ending in .truth.toml]
    #[arg(long, value_name = "TRUTH")]
    truth: Option<PathBuf>,
    /// Seed to use instead of the scenario's
    #[arg(long, value_name = "SEED")]
    seed: Option<u64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
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
    if arguments.json {
        return terminal::put_json(&SimulateResult {
            version: VERSION,
            file: arguments.output.display().to_string(),
            truth: truth.display().to_string(),
            scenario: summary.name,
            seed: summary.seed,
            rows: summary.rows,
            duration_s: summary.duration_s,
            launch_s: summary.launch_s,
        });
    }
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
