//! One signal over another.

use serde::{Deserialize, Serialize};

use super::{ModelText, Numbers, Signal, Times};

/// Asks for the points of one signal over another.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ScatterRequest {
    /// The flight.
    pub flight: String,
    /// The model that flies.
    pub model: ModelText,
    /// What the user says of its times.
    pub times: Times,
    /// Across.
    pub x: Signal,
    /// Up.
    pub y: Signal,
    /// From when, seconds of the flight's own clock; null: from its first row.
    pub from_s: Option<f64>,
    /// To when; null: to its last.
    pub to_s: Option<f64>,
    /// More points than this are thinned out evenly.
    pub at_most: u32,
}

/// Points: every value of y with x at that time, between x's values on a straight line, and not over a gap.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Paired {
    /// When, seconds.
    pub time_s: Numbers,
    /// Across.
    pub x: Numbers,
    /// Up.
    pub y: Numbers,
    /// x's unit.
    pub x_unit: String,
    /// y's unit.
    pub y_unit: String,
    /// How many points there are, of which those are shown.
    pub of: u32,
    /// Values of y that x has none for.
    pub unpaired: u32,
}
