//! A flight's times as given by the user.

use clap::Args;
use pylon::replay::{CalibrationWindow, GivenAirborne, GivenTimes};

/// The calibration window and the time in the air, if they are not to be found from the flight.
#[derive(Clone, Copy, Debug, Args)]
pub struct TimesArguments {
    /// Calibrate on this part of every flight, and take its end as launch; seconds of the flight's clock, as
    /// `pylon open` shows it
    #[arg(long, value_name = "START..END")]
    pub calibrate: Option<CalibrationWindow>,
    /// Take-off and landing of every flight, instead of those found in it; an end that is left out is not in
    /// the log
    #[arg(long, value_name = "FROM..TO")]
    pub airborne: Option<GivenAirborne>,
}

impl TimesArguments {
    /// The same times as the library's type.
    #[must_use]
    pub const fn given(self) -> GivenTimes {
        GivenTimes { calibration: self.calibrate, airborne: self.airborne }
    }
}
