//! Results of a comparison: the keys of `pylon compare --json`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::phase_statistics::PhaseSummary;
use super::remedies::Remedy;
use super::rules::SensorRules;
use super::timeline::Failures;
use crate::name::Name;
use replay::Usage;

/// How well a model agrees with a flight. When serialised, a value that does not exist or is not finite is
/// null.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Comparison {
    /// Version of the meaning of these keys: it changes if a key changes its meaning or is removed.
    pub version: u32,
    /// The flight.
    pub flight: FlightFacts,
    /// The model's name: a preset or a file.
    pub model: String,
    /// Time of the launch by the flight's own clock, seconds.
    pub launch_s: Option<f64>,
    /// The sensors by name; those without a single reading are left out.
    pub sensors: BTreeMap<Name, SensorComparison>,
    /// Cross-check of barometer and inertial altitude while the reference was lost in free flight; null if it
    /// never was, or if no pair of readings came.
    pub cross_check: Option<CrossCheckFacts>,
    /// The reference.
    pub reference: ReferenceComparison,
    /// The calibration.
    pub calibration: CalibrationFacts,
    /// The effects that the model accounts for, in its order.
    pub effects: Vec<EffectFacts>,
    /// The monitor as configured.
    pub monitor: MonitorFacts,
    /// Cost and detection of the monitor's rule, and a better rule, by sensor.
    pub rules: BTreeMap<Name, SensorRules>,
    /// Section 4's second corrections, side by side.
    pub remedies: Vec<Remedy>,
    /// Where the model fails.
    pub failures: Failures,
    /// Data of the flight that was not used unchanged.
    pub warnings: Vec<String>,
}

impl Comparison {
    /// The version that is written.
    pub const VERSION: u32 = 1;
}

/// Identification of the flight.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FlightFacts {
    /// The file.
    pub file: String,
    /// The vehicle.
    pub vehicle: String,
    /// Origin of the flight.
    pub source: String,
    /// Number of rows.
    pub rows: u64,
    /// Time from the first row to the last, seconds.
    pub duration_s: f64,
    /// The part of it that is analysed.
    #[serde(flatten, deserialize_with = "crate::json::whole")]
    pub usage: Usage,
}

/// One sensor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SensorComparison {
    /// Whether the sensor leaves with the UAV.
    pub flies_free: bool,
    /// Latched bias (without a launch: the last estimate), metres.
    pub bias_m: Option<f64>,
    /// Its standard deviation by the filter, metres.
    pub bias_sigma_m: Option<f64>,
    /// Spread of the calibrated residual in captive flight (Table 1 of the paper), metres.
    pub residual_sigma_m: Option<f64>,
    /// Root mean square error in captive flight, with the latched bias, metres.
    pub captive_rms_m: Option<f64>,
    /// Root mean square error in free flight, metres.
    pub free_flight_rms_m: Option<f64>,
    /// Moving average of the error at the flight's end, metres.
    pub moving_average_end_m: Option<f64>,
    /// When the sensor became doubtful, seconds after launch.
    pub doubtful_after_s: Option<f64>,
    /// When it became untrustworthy, seconds after launch.
    pub untrustworthy_after_s: Option<f64>,
    /// Trust at the flight's end.
    pub trust: Name,
    /// Time without a reference to monitor it, seconds.
    pub unmonitored_s: f64,
    /// The monitor's alarm limit (multiplier times sigma), metres.
    pub bound_m: Option<f64>,
    /// Captive flight after settling.
    pub captive: PhaseSummary,
    /// Free flight.
    pub free_flight: PhaseSummary,
    /// Counts of readings that were and were not used.
    pub readings: ReadingCounts,
}

/// Barometer less inertial altitude while the reference was lost, each with its latched bias.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct CrossCheckFacts {
    /// Number of pairs of readings.
    pub pairs: u64,
    /// The difference farthest from zero, metres.
    pub largest_difference_m: f64,
    /// Their agreement after the last pair: `agree`, `doubtful` or `disagree`.
    pub agreement: Name,
    /// When they were first doubtful or worse, seconds after launch.
    pub doubtful_after_s: Option<f64>,
    /// When they disagreed, seconds after launch.
    pub disagree_after_s: Option<f64>,
}

/// Counts of a source's readings that were used or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ReadingCounts {
    /// Used.
    pub accepted: u32,
    /// NaN or infinite, or an invalid pressure.
    pub not_finite: u32,
    /// A fix held since the last one.
    pub held: u32,
    /// Readings of a sensor that repeats one value.
    pub stuck: u32,
    /// Refused by the filter.
    pub variance: u32,
    /// Finite, but no aircraft can be there or do that.
    pub implausible: u32,
    /// Outliers: too far from the filter's prediction.
    pub gated: u32,
}

/// The reference in captive flight.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ReferenceComparison {
    /// Innovations of its fixes: bias, spread, whiteness, NIS.
    pub captive: PhaseSummary,
    /// Counts of fixes that were and were not used.
    pub fixes: ReadingCounts,
}

/// The calibration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct CalibrationFacts {
    /// `good`, `degraded`, or null if nothing was latched.
    pub quality: Option<Name>,
    /// Names of the checks that failed.
    pub failed_checks: Vec<Name>,
    /// Length of the calibration, seconds.
    pub duration_s: Option<f64>,
    /// What determined the end of captive flight.
    pub source: String,
}

/// An effect accounted for by the model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct EffectFacts {
    /// Its id in the catalogue.
    pub effect: Name,
    /// Its coefficient: the estimate at the end of captive flight, or the model's constant.
    pub coefficient: f64,
    /// Standard deviation of the coefficient.
    pub sigma: f64,
    /// Unit of both.
    pub unit: Name,
    /// Whether it was estimated.
    pub estimated: bool,
    /// The range of its regressor in which the coefficient was learned, metres per unit of coefficient.
    pub envelope_m: Option<[f64; 2]>,
    /// Number of ticks at which it was used outside of that range.
    pub extrapolated_ticks: u32,
}

/// The monitor as configured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct MonitorFacts {
    /// Where sigma comes from.
    pub sigma: Name,
    /// Alarm limit in sigmas.
    pub multiplier: f64,
    /// Length of the moving average, seconds.
    pub window_s: f64,
    /// How long the error must exceed the alarm limit before a sensor is untrustworthy, seconds.
    pub persistence_s: f64,
}
