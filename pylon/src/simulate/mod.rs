//! The flight simulator: a scenario becomes a flight and, apart from it, the truth about it.
//!
//! It is the estimator's opponent, so it shares no physics with it: own atmosphere, own kinematics, own
//! effects, all in double precision. The same scenario and seed give the same bytes on every platform
//! (no platform's mathematics library, no hash order, own random transforms). Flights made here say so
//! in their `source` line.

pub mod atmosphere;
mod effect;
mod motion;
mod random;
mod record;
mod rotation;
pub mod scenario;
mod sensor;
mod truth;

use std::io;
use std::path::Path;

use thiserror::Error;

pub use effect::regressor;
pub use motion::{MotionError, TruthSample};
pub use scenario::{Scenario, ScenarioError};
pub use truth::{SensorTruth, Truth};

use crate::flight::{self, Flight};
use crate::output_file::{OutputError, prepare, write_atomically};

/// Why there is no simulated flight; displays as one line.
#[derive(Debug, Error)]
pub enum SimulateError {
    /// The scenario can not be read or makes no sense.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The scenario makes sense, but the aircraft can not fly it.
    #[error("{scenario}: {reason}")]
    Motion {
        /// The scenario's file or name.
        scenario: String,
        /// What happened to the aircraft.
        reason: MotionError,
    },
    /// An output file can not be written.
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

/// Simulates a scenario in memory.
///
/// # Errors
/// [`MotionError`] when the aircraft can not fly the plan: it meets sea level or stalls.
pub fn simulate(scenario: &Scenario, seed: u64) -> Result<(Flight, Truth), MotionError> {
    let trajectory = motion::fly(scenario, seed)?;
    let effects = record::Effects::of(scenario, &trajectory);
    let flight = record::flight(scenario, &trajectory, &effects, seed);
    let truth = truth::truth(scenario, trajectory, &effects, seed);
    Ok((flight, truth))
}

/// Simulates a scenario file with its own seed; writes the flight (CSV) and the truth about it (TOML), both
/// or neither.
///
/// # Errors
/// [`SimulateError`]; nothing is left behind then.
pub fn run(scenario: &Path, output: &Path, truth: &Path) -> Result<Summary, SimulateError> {
    run_with_seed(scenario, None, output, truth)
}

/// As [`run`], with another seed than the scenario's.
///
/// # Errors
/// As [`run`].
pub fn run_with_seed(
    scenario_file: &Path,
    seed: Option<u64>,
    output: &Path,
    truth_file: &Path,
) -> Result<Summary, SimulateError> {
    let scenario = Scenario::load(scenario_file)?;
    let seed = seed.unwrap_or(scenario.seed);
    let (flight, truth) = simulate(&scenario, seed)
        .map_err(|reason| SimulateError::Motion { scenario: scenario_file.display().to_string(), reason })?;
    // Both are complete before either has its name, and the truth has its first: killed in between, the program leaves no
    // flight without its truth.
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
