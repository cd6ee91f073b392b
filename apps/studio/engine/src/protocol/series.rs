//! Curves over time.

use analysis::diagnose::NoiseFacts;
use serde::{Deserialize, Serialize};

use super::{ModelText, Numbers, Times};

/// An effect and its coefficient, as a diagnosis' candidate has them.
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

/// What a curve is of.
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
    /// What the model says that the sensor should read there: measured less error, m.
    Modelled {
        /// The sensor.
        sensor: String,
    },
    /// The sensor's error (eq. 16): reading less bias, effects and reference, m. The reference's own wander
    /// is in it.
    Error {
        /// The sensor.
        sensor: String,
    },
    /// The mean of that error over the monitor's window, in free flight, m.
    MovingAverage {
        /// The sensor.
        sensor: String,
    },
    /// The error beyond the reference, m: what of the error is not the reference's own wander, estimated from
    /// all sensors with the noise that a diagnosis found. It has a `sigma`.
    BeyondReference {
        /// The sensor.
        sensor: String,
        /// The diagnosis' `noise`.
        noise: NoiseFacts,
        /// The effects that it found and that the model lacks: they are no wander of the reference's either.
        found: Vec<Acting>,
    },
    /// What an effect adds to its sensor's error, m: coefficient times regressor, whether the model has it or
    /// not, less its mean over captive flight, which the calibration takes for bias. One of the reference is
    /// in every sensor's error, with the other sign.
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

/// Asks for curves on one time axis, thinned out so that their drawing looks the same: no spike is lost.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SeriesRequest {
    /// The flight.
    pub flight: String,
    /// The model that flies.
    pub model: ModelText,
    /// What the user says of its times.
    pub times: Times,
    /// The curves.
    pub signals: Vec<Signal>,
    /// From when, seconds of the flight's own clock; null: from its first row.
    pub from_s: Option<f64>,
    /// To when; null: to its last.
    pub to_s: Option<f64>,
    /// How many pixels the axis has.
    pub pixels: u32,
}

/// Curves on one time axis.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Series {
    /// The axis, seconds, increasing: a row's time each, or the middle of a pixel's slot.
    pub time_s: Numbers,
    /// Whether a point is a pixel's slot, with least and greatest value; otherwise it is a row, and these are
    /// the same array.
    pub is_thinned: bool,
    /// The curves, in the request's order.
    pub curves: Vec<Drawn>,
}

/// One curve.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Drawn {
    /// What it is of.
    pub signal: Signal,
    /// Its unit; empty where it has none or the flight does not say.
    pub unit: String,
    /// Least value at each point of the axis; NaN where there is no value: the curve is drawn through, but
    /// not over a gap.
    pub least: Numbers,
    /// Greatest value.
    pub greatest: Numbers,
    /// Standard deviation at each point, where the signal has one.
    pub sigma: Option<Numbers>,
    /// From when to when the record has a gap, over which no line is drawn: pairs of seconds, one after the
    /// other.
    pub gaps_s: Numbers,
    /// Values that lie in the asked for time.
    pub values: u32,
}
