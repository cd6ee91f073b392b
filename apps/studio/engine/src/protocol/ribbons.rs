//! The aircraft's motion and the sensors' trust over time.

use analysis::compare::MotionSources;
use serde::Serialize;
use std::collections::BTreeMap;

use super::Numbers;

/// A stretch of time with its label.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Span {
    /// Start, seconds of the flight's own clock.
    pub from_s: f64,
    /// End.
    pub to_s: f64,
    /// The label: a manoeuvre, a trust or a phase.
    pub what: String,
}

/// The aircraft's motion, second by second; NaN where the flight does not record it.
#[derive(Clone, Debug, Default, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct MotionNumbers {
    /// Middle of the second, seconds of the flight's own clock.
    pub time_s: Numbers,
    /// Climb rate, m/s.
    pub climb_rate_mps: Numbers,
    /// Speed, m/s.
    pub speed_mps: Numbers,
    /// Load factor.
    pub load_factor: Numbers,
    /// Turn rate, rad/s.
    pub turn_rate_radps: Numbers,
}

/// The ribbons below a flight's curves.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Ribbons {
    /// `settling`, `calibrating`, `free_flight`.
    pub phases: Vec<Span>,
    /// By sensor: `calibrating`, `trusted`, `doubtful`, `untrustworthy`, `unmonitored`.
    pub trust: BTreeMap<String, Vec<Span>>,
    /// `level_flight`, `climb`, `dive` and so on.
    pub manoeuvres: Vec<Span>,
    /// The motion.
    pub motion: MotionNumbers,
    /// The signals from which it was computed.
    pub sources: MotionSources,
    /// The alarm limit of each sensor's moving average and error, m, either side of zero.
    pub bounds_m: BTreeMap<String, f64>,
    /// When the UAV was launched, seconds of the flight's own clock.
    pub launch_s: Option<f64>,
}
