//! Tests of the whole chain, what they compare it with, and what the firmware may cost.

pub mod bench;
pub mod blind;
pub mod budget;
pub mod campaign;
pub mod confusion;
pub mod endurance;
pub mod laws;
pub mod monitor_curves;
pub mod real_logs;
pub mod real_trials;
pub mod reliability;
pub mod textbook;
