//! What the parts of a flight are called: one without a launch has no captive flight.

use super::comparison::Comparison;

/// Names of the phases, and of what parts them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Words {
    /// While it is calibrated.
    pub before: &'static str,
    /// Afterwards.
    pub after: &'static str,
    /// What is left over while it is calibrated.
    pub residual: &'static str,
    /// What times are counted from.
    pub event: &'static str,
    /// The axis of such times.
    pub time_after: &'static str,
    /// When a sensor had a bias.
    pub meanwhile: &'static str,
    /// When sensors were compared with the reference.
    pub beforehand: &'static str,
}

impl Comparison {
    /// The words for this flight.
    pub const fn words(&self) -> Words {
        if self.flight.usage.has_launch || self.launch_s.is_none() {
            Words {
                before: "captive flight",
                after: "free flight",
                residual: "captive residual",
                event: "launch",
                time_after: "time after launch, s",
                meanwhile: "Under the pylon",
                beforehand: "Before launch",
            }
        } else {
            Words {
                before: "calibration",
                after: "the flight after it",
                residual: "residual of the calibration",
                event: "the calibration",
                time_after: "time after the calibration, s",
                meanwhile: "While it was calibrated",
                beforehand: "For the calibration",
            }
        }
    }
}
