//! Runs the flight simulator ([`::simulate`]) on files.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

pub use ::simulate::*;

use crate::flight;
use crate::output_file::{OutputError, prepare, write_atomically};

/// Why there is no simulated flight; displays as one line.
#[derive(Debug, Error)]
pub enum SimulateError {
    /// The scenario's file cannot be read.
    #[error("{}: cannot read the scenario: {source}", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The scenario is invalid.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The scenario is valid, but the aircraft cannot fly it.
    #[error("{scenario}: {reason}")]
    Motion {
        /// The scenario's file or name.
        scenario: String,
        /// What happened to the aircraft.
        #[source]
        reason: MotionError,
    },
    /// An output file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// What was simulated, for the program's last line.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Name of the scenario.
    pub name: String,
    /// Seed that was used.
    pub seed: u64,
    /// Rows of the flight.
    pub rows: usize,
    /// Length of the flight, s.
    pub duration_s: f64,
    /// Time of launch, s; `None` when the UAV was never launched.
    pub launch_s: Option<f64>,
}

/// Reads a scenario file.
///
/// # Errors
/// When the file cannot be read, is not TOML, has an unknown key or lacks one, or asks for something that
/// cannot be simulated.
pub fn load_scenario(path: &Path) -> Result<Scenario, SimulateError> {
    let text = std::fs::read_to_string(path)
        .map_err(|source| SimulateError::Unreadable { file: path.to_path_buf(), source })?;
    Ok(Scenario::from_toml(&text, &path.display().to_string())?)
}

/// Simulates a scenario file with its own seed; writes the flight (CSV) and its truth (TOML), both or
/// neither.
///
/// # Errors
/// [`SimulateError`]; nothing is left behind then.
pub fn run(scenario: &Path, output: &Path, truth: &Path) -> Result<Summary, SimulateError> {
    run_with_seed(scenario, None, output, truth)
}

/// As [`run`], with a seed other than the scenario's.
///
/// # Errors
/// As [`run`].
pub fn run_with_seed(
    scenario_file: &Path,
    seed: Option<u64>,
    output: &Path,
    truth_file: &Path,
) -> Result<Summary, SimulateError> {
    let scenario = load_scenario(scenario_file)?;
    let seed = seed.unwrap_or(scenario.seed);
    let (flight, truth) = simulate(&scenario, seed)
        .map_err(|reason| SimulateError::Motion { scenario: scenario_file.display().to_string(), reason })?;
    // Both files are complete before either has its name, and the truth is named first: if killed in between,
    // the program leaves no flight without its truth.
    let flight_file = prepare(output, |out| flight::to_writer(out, &flight))?;
    let toml = truth
        .to_toml()
        .map_err(|error| OutputError { path: truth_file.to_path_buf(), reason: io::Error::other(error) })?;
    write_atomically(truth_file, |out| out.write_all(toml.as_bytes()))?;
    flight_file.publish()?;
    Ok(Summary {
        name: scenario.name.clone(),
        seed,
        rows: flight.rows(),
        duration_s: scenario.duration_s(),
        launch_s: scenario.launch_s(),
    })
}

#[cfg(test)]
mod tests;
