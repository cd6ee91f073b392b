//! What the aircraft did and what its sensors were worth, over time.

use analysis::compare::MotionSources;
use serde::Serialize;
use std::collections::BTreeMap;

use super::Numbers;

/// A stretch of time and what there was in it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Span {
    /// From when, seconds of the flight's own clock.
    pub from_s: f64,
    /// To when.
    pub to_s: f64,
    /// What, a word of the catalogue: a manoeuvre, a trust, a phase.
    pub what: String,
}

/// How the aircraft moved, second by second; NaN where the flight does not say.
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
    /// Which signals it was read from.
    pub sources: MotionSources,
    /// The alarm limit of each sensor's moving average and error, m, either side of zero.
    pub bounds_m: BTreeMap<String, f64>,
    /// When the UAV was launched, seconds of the flight's own clock.
    pub launch_s: Option<f64>,
}
