//! Curves over time.

use analysis::diagnose::NoiseFacts;
use serde::{Deserialize, Serialize};

use super::{ModelText, Numbers, Times};

/// An effect and its coefficient, as in a diagnosis' candidate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Acting {
    /// Its id.
    pub effect: String,
    /// Its coefficient.
    pub coefficient: f64,
    /// Time constant, seconds, for an effect that has one.
    pub time_constant_s: Option<f64>,
    /// `launch` or `start`, for an effect that has a time constant.
    pub since: Option<String>,
}

/// The quantity that a curve shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "signal", rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Signal {
    /// A column as it was logged, by its name.
    Column {
        /// The name.
        name: String,
    },
    /// The reference's altitude at its accepted fixes, m.
    Reference,
    /// The altitude that the filter estimates in captive flight, m.
    Estimate,
    /// A sensor's altitude as measured (a pressure as its altitude in the standard atmosphere), m.
    Measured {
        /// The sensor.
        sensor: String,
    },
    /// The model's prediction of the sensor's reading: measured less error, m.
    Modelled {
        /// The sensor.
        sensor: String,
    },
    /// The sensor's error (eq. 16): reading less bias, effects and reference, m. It includes the reference's
    /// own wander.
    Error {
        /// The sensor.
        sensor: String,
    },
    /// The mean of that error over the monitor's window, in free flight, m.
    MovingAverage {
        /// The sensor.
        sensor: String,
    },
    /// The error beyond the reference, m: the part that is not the reference's own wander, estimated from all
    /// sensors with the noise found by a diagnosis. It has a `sigma`.
    BeyondReference {
        /// The sensor.
        sensor: String,
        /// The diagnosis' `noise`.
        noise: NoiseFacts,
        /// The effects that it found and that the model lacks: they too are not the reference's wander.
        found: Vec<Acting>,
    },
    /// What an effect adds to its sensor's error, m: coefficient times regressor, whether the model has it or
    /// not, less its mean over captive flight, which the calibration attributes to the bias. An effect on the
    /// reference appears in every sensor's error with the opposite sign.
    Effect {
        /// The effect.
        of: Acting,
    },
    /// Climb rate, second by second, m/s.
    ClimbRate,
    /// Speed, second by second: true airspeed, or else over ground, m/s.
    Speed,
    /// Load factor, second by second.
    LoadFactor,
    /// Turn rate, second by second, rad/s.
    TurnRate,
}

/// Asks for curves on one time axis, thinned out without changing how they look: no spike is lost.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SeriesRequest {
    /// The flight.
    pub flight: String,
    /// The model to fly.
    pub model: ModelText,
    /// The user's times for it.
    pub times: Times,
    /// The curves.
    pub signals: Vec<Signal>,
    /// Start, seconds of the flight's own clock; null: its first row.
    pub from_s: Option<f64>,
    /// End; null: its last row.
    pub to_s: Option<f64>,
    /// Width of the axis, pixels.
    pub pixels: u32,
}

/// Curves on one time axis.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Series {
    /// The axis, seconds, increasing: the time of each row, or the middle of each pixel's slot.
    pub time_s: Numbers,
    /// Whether a point is a pixel's slot with least and greatest value; otherwise it is a row, and both are
    /// the same array.
    pub is_thinned: bool,
    /// The curves, in the request's order.
    pub curves: Vec<Drawn>,
}

/// One curve.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Drawn {
    /// The quantity that it shows.
    pub signal: Signal,
    /// Its unit; empty if it has none or the flight does not record it.
    pub unit: String,
    /// Least value at each point of the axis; NaN if there is none. The curve is drawn across such points,
    /// but not over a gap.
    pub least: Numbers,
    /// Greatest value.
    pub greatest: Numbers,
    /// Standard deviation at each point, if the signal has one.
    pub sigma: Option<Numbers>,
    /// Gaps in the record, over which no line is drawn: start and end in seconds, pair after pair.
    pub gaps_s: Numbers,
    /// Number of values in the requested time.
    pub values: u32,
}
