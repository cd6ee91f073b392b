//! What the parts of a flight are called: one without a launch has no captive flight.

use super::comparison::Comparison;

/// Names of the phases, and of what parts them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Words {
    /// While it is calibrated.
    pub(crate) before: &'static str,
    /// Afterwards.
    pub(crate) after: &'static str,
    /// What is left over while it is calibrated.
    pub(crate) residual: &'static str,
    /// What times are counted from.
    pub(crate) event: &'static str,
}

impl Comparison {
    /// The words for this flight.
    pub(crate) const fn words(&self) -> Words {
        if self.flight.usage.has_launch || self.launch_s.is_none() {
            Words {
                before: "captive flight",
                after: "free flight",
                residual: "captive residual",
                event: "launch",
            }
        } else {
            Words {
                before: "calibration",
                after: "the flight after it",
                residual: "residual of the calibration",
                event: "the calibration",
            }
        }
    }
}
