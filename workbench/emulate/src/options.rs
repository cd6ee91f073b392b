//! Options of a flight.

use flight_record::SensorSource;

use super::builder::PlantedError;
use super::debug_link::DebugLink;
use super::fault_script::PlannedFault;

/// What the flight runs on.
#[derive(Clone, Debug, Default)]
pub enum FlownOn {
    /// QEMU.
    #[default]
    Emulator,
    /// An STM32F405, through its debug link. Its own sensors, lines and crystal are not used: chips are
    /// models, as in QEMU.
    Board(DebugLink),
}

/// Options of a flight.
#[derive(Clone, Debug, Default)]
pub struct FlyOptions {
    /// What the flight runs on.
    pub on: FlownOn,
    /// How the flight's samples reach the estimator; by default unchanged. With chips the rows are put on the
    /// flight computer's grid of ticks.
    pub sensors: SensorSource,
    /// Faults of the chips.
    pub faults: Vec<PlannedFault>,
    /// An error injected into the firmware, to check that it is detected.
    pub target_error: Option<PlantedError>,
    /// Shifts every barometer reading of the host's flight computer by one unit in the last place, to check
    /// that it is detected.
    pub host_ulp_error: bool,
    /// Records the output of the telemetry line, in QEMU: a board's is silent.
    pub telemetry: bool,
    /// Keeps the flight computer's results as it sent them: a flight record.
    pub record: bool,
}
