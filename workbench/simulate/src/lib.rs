//! The flight simulator: turns a scenario into a flight and, separately, the truth about it.
//!
//! It checks the estimator, so it shares no physics with it: it has its own atmosphere, kinematics and
//! effects, all in double precision. The same scenario and seed give the same bytes on every platform (no
//! platform's mathematics library, no hash order, own random transforms). The `source` line of a simulated
//! flight states that it is simulated.

pub mod atmosphere;
mod effect;
mod motion;
mod random;
mod record;
mod rotation;
pub mod scenario;
mod sensor;
mod truth;

pub use effect::regressor;
pub use motion::{MotionError, TruthSample};
pub use scenario::{Scenario, ScenarioError, ScenarioProblem};
pub use truth::{SensorTruth, Truth};

use flight_data::Flight;

/// Simulates a scenario.
///
/// # Errors
/// [`MotionError`] when the aircraft cannot fly the plan: it meets sea level or stalls.
pub fn simulate(scenario: &Scenario, seed: u64) -> Result<(Flight, Truth), MotionError> {
    let trajectory = motion::fly(scenario, seed)?;
    let effects = record::Effects::of(scenario, &trajectory);
    let flight = record::flight(scenario, &trajectory, &effects, seed);
    let truth = truth::truth(scenario, trajectory, &effects, seed);
    Ok((flight, truth))
}

#[cfg(test)]
mod tests;
