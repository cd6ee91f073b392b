//! One signal against another.

use serde::{Deserialize, Serialize};

use super::{ModelText, Numbers, Signal, Times};

/// Asks for the points of one signal against another.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ScatterRequest {
    /// The flight.
    pub flight: String,
    /// The model to fly.
    pub model: ModelText,
    /// The user's times for it.
    pub times: Times,
    /// The signal on the horizontal axis.
    pub x: Signal,
    /// The signal on the vertical axis.
    pub y: Signal,
    /// Start, seconds of the flight's own clock; null: its first row.
    pub from_s: Option<f64>,
    /// End; null: its last row.
    pub to_s: Option<f64>,
    /// Limit on the points; more are thinned out evenly.
    pub at_most: u32,
}

/// Points: every value of y with the value of x at that time, interpolated linearly but not over a gap.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Paired {
    /// Time, seconds.
    pub time_s: Numbers,
    /// Horizontal values.
    pub x: Numbers,
    /// Vertical values.
    pub y: Numbers,
    /// x's unit.
    pub x_unit: String,
    /// y's unit.
    pub y_unit: String,
    /// Number of points before thinning.
    pub of: u32,
    /// Values of y for which x has none.
    pub unpaired: u32,
}
