//! Why a plan cannot be flown.

use replay::ReplayError;
use simulate::{MotionError, ScenarioError};
use thiserror::Error;

/// Why a plan cannot be flown.
#[derive(Debug, Error)]
pub enum PlanError {
    /// One of its values is outside the range.
    #[error("{what} is {value}: expected {least} to {most}")]
    Range {
        /// Which one, with its unit.
        what: String,
        /// Its value.
        value: f64,
        /// The least value.
        least: f64,
        /// The largest value.
        most: f64,
    },
    /// It has no manoeuvres, or too many.
    #[error("the plan has {found} manoeuvres: expected 1 to {most}")]
    Manoeuvres {
        /// How many.
        found: usize,
        /// How many there may be.
        most: usize,
    },
    /// Its scenario is refused.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The simulated aircraft cannot fly it.
    #[error(transparent)]
    Flight(#[from] MotionError),
    /// The simulated flight cannot be replayed.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}
