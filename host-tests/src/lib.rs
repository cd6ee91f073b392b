//! Tests of the whole chain, the references that they compare it with, and the firmware's budgets.

pub mod bench;
pub mod blind;
pub mod budget;
pub mod campaign;
pub mod confusion;
pub mod endurance;
pub mod laws;
mod median;
pub mod monitor_curves;
pub mod real_logs;
pub mod real_trials;
pub mod reliability;
pub mod textbook;
