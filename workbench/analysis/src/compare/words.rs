//! Names of the parts of a flight: a flight without a launch has no captive flight.

use super::comparison::Comparison;

/// Names of the phases, and of the event between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Words {
    /// The phase of the calibration.
    pub before: &'static str,
    /// The phase after it.
    pub after: &'static str,
    /// The residual during the calibration.
    pub residual: &'static str,
    /// The event from which times are counted.
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
