//! How to fly.

use flight_record::SensorSource;

use super::builder::PlantedError;
use super::debug_link::DebugLink;
use super::fault_script::PlannedFault;

/// What a flight is flown on.
#[derive(Clone, Debug, Default)]
pub enum FlownOn {
    /// QEMU.
    #[default]
    Emulator,
    /// An STM32F405, through its debug link. Its own sensors, lines and crystal have no part in it: chips are
    /// models, as in QEMU.
    Board(DebugLink),
}

/// How to fly.
#[derive(Clone, Debug, Default)]
pub struct FlyOptions {
    /// What is flown on.
    pub on: FlownOn,
    /// How the flight's samples come to the estimator; by default as they are. On chips the rows are put on
    /// the flight computer's grid of ticks.
    pub sensors: SensorSource,
    /// Faults of the chips.
    pub faults: Vec<PlannedFault>,
    /// An error planted in the firmware, to see that it is found.
    pub target_error: Option<PlantedError>,
    /// The host's flight computer gets every barometer reading one unit in the last place off, to see that it
    /// is found.
    pub host_ulp_error: bool,
    /// Records what goes over the telemetry's line, in QEMU: a board's is silent.
    pub telemetry: bool,
    /// Keeps the flight computer's results as it sent them: a flight record.
    pub record: bool,
}
