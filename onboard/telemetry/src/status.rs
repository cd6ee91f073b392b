//! What only the flight computer's own code knows about itself.

use kf_core::launch::WireCondition;

/// State, and counts since the start; all saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ComputerStatus {
    /// What the umbilical's wire is taken for; `None` where the sensors' record says itself when the launch
    /// was.
    pub wire: Option<WireCondition>,
    /// Failed polls of sensors.
    pub sensor_faults: u32,
    /// Results that found no room on their way to the flight record.
    pub lost_results: u32,
    /// The longest tick, per mille of its period; `None` where it is not measured.
    pub load_permille: Option<u16>,
}
