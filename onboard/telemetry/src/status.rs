//! Status known only to the flight computer's own code.

use kf_core::launch::WireCondition;

/// State, and counts since the start. All counts saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ComputerStatus {
    /// Condition of the umbilical's wire; `None` if the sensors' record itself has the launch.
    pub wire: Option<WireCondition>,
    /// Failed polls of sensors.
    pub sensor_faults: u32,
    /// Results that found no room in the queue to the flight record.
    pub lost_results: u32,
    /// The longest tick, per mille of its period; `None` if it is not measured.
    pub load_permille: Option<u16>,
}
