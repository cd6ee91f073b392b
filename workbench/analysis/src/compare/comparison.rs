//! What a comparison found: the keys of `pylon compare --json`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::phase_statistics::PhaseSummary;
use super::remedies::Remedy;
use super::rules::SensorRules;
use super::timeline::Failures;
use crate::name::Name;
use replay::Usage;

/// How well a model agrees with a flight. Serialised, a value that does not exist is null, and so is
/// one that is not finite.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Comparison {
    /// Version of what these keys mean: a new one where a key changes its meaning or goes.
    pub version: u32,
    /// The flight.
    pub flight: FlightFacts,
    /// The model's name: a preset or a file.
    pub model: String,
    /// When the UAV was launched, by the flight's own clock, seconds.
    pub launch_s: Option<f64>,
    /// The sensors by name; those without a single reading are left out.
    pub sensors: BTreeMap<Name, SensorComparison>,
    /// What barometer and inertial altitude said of each other while the reference was lost in free
    /// flight; null where it never was, or no pair of readings came.
    pub cross_check: Option<CrossCheckFacts>,
    /// The reference.
    pub reference: ReferenceComparison,
    /// The calibration.
    pub calibration: CalibrationFacts,
    /// The effects that the model accounts for, in its order.
    pub effects: Vec<EffectFacts>,
    /// The monitor as configured.
    pub monitor: MonitorFacts,
    /// What the monitor's rule costs and catches, and a better one, by sensor.
    pub rules: BTreeMap<Name, SensorRules>,
    /// Section 4's second correction, side by side.
    pub remedies: Vec<Remedy>,
    /// Where the model fails.
    pub failures: Failures,
    /// What was in the flight and not used as it stood.
    pub warnings: Vec<String>,
}

impl Comparison {
    /// The version that is written.
    pub const VERSION: u32 = 1;
}

/// Which flight it was.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FlightFacts {
    /// The file.
    pub file: String,
    /// The vehicle.
    pub vehicle: String,
    /// Where the flight comes from.
    pub source: String,
    /// Rows.
    pub rows: u64,
    /// From the first row to the last, seconds.
    pub duration_s: f64,
    /// Which part of it is analysed.
    #[serde(flatten, deserialize_with = "crate::json::whole")]
    pub usage: Usage,
}

/// One sensor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SensorComparison {
    /// Whether the sensor leaves with the UAV.
    pub flies_free: bool,
    /// Bias as latched (without a launch: as estimated last), metres.
    pub bias_m: Option<f64>,
    /// Its standard deviation by the filter, metres.
    pub bias_sigma_m: Option<f64>,
    /// Spread of the calibrated residual in captive flight (Table 1 of the paper), metres.
    pub residual_sigma_m: Option<f64>,
    /// Root mean square error in captive flight, by the latched bias, metres.
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
    /// For how long there was no reference to watch it by, seconds.
    pub unmonitored_s: f64,
    /// The monitor's alarm limit (multiplier times sigma), metres.
    pub bound_m: Option<f64>,
    /// Captive flight after settling.
    pub captive: PhaseSummary,
    /// Free flight.
    pub free_flight: PhaseSummary,
    /// Readings that were and were not used.
    pub readings: ReadingCounts,
}

/// Barometer less inertial altitude while the reference was lost, each by its latched bias.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct CrossCheckFacts {
    /// Pairs of readings.
    pub pairs: u64,
    /// The difference farthest from zero, metres.
    pub largest_difference_m: f64,
    /// What the two had come to after the last pair: `agree`, `doubtful` or `disagree`.
    pub agreement: Name,
    /// When they were first doubtful or worse, seconds after launch.
    pub doubtful_after_s: Option<f64>,
    /// When they disagreed, seconds after launch.
    pub disagree_after_s: Option<f64>,
}

/// How often a source's readings were used or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ReadingCounts {
    /// Used.
    pub accepted: u32,
    /// NaN or infinite, or an invalid pressure.
    pub not_finite: u32,
    /// A fix held since the last.
    pub held: u32,
    /// A sensor that repeats itself.
    pub stuck: u32,
    /// Refused by the filter.
    pub variance: u32,
    /// Finite, and no aircraft can be there or do that.
    pub implausible: u32,
    /// Outliers: too far from what the filter expected.
    pub gated: u32,
}

/// The reference in captive flight.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ReferenceComparison {
    /// Innovations of its fixes: bias, spread, whiteness, NIS.
    pub captive: PhaseSummary,
    /// Fixes that were and were not used.
    pub fixes: ReadingCounts,
}

/// The calibration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct CalibrationFacts {
    /// `good`, `degraded`, or null when nothing was latched.
    pub quality: Option<Name>,
    /// Names of the checks that failed.
    pub failed_checks: Vec<Name>,
    /// Length of the calibration, seconds.
    pub duration_s: Option<f64>,
    /// What decided when the captive flight ends.
    pub source: String,
}

/// An effect that the model accounts for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct EffectFacts {
    /// Its id in the catalogue.
    pub effect: Name,
    /// Its coefficient: as estimated by the end of captive flight, or the model's constant.
    pub coefficient: f64,
    /// Standard deviation of the coefficient.
    pub sigma: f64,
    /// Unit of both.
    pub unit: Name,
    /// Whether it was estimated.
    pub estimated: bool,
    /// The range of its regressor that the coefficient was learned in, metres per unit of coefficient.
    pub envelope_m: Option<[f64; 2]>,
    /// Ticks at which it was used outside of that range.
    pub extrapolated_ticks: u32,
}

/// The monitor as configured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct MonitorFacts {
    /// Where sigma comes from.
    pub sigma: Name,
    /// Threshold in sigmas.
    pub multiplier: f64,
    /// Length of the moving average, seconds.
    pub window_s: f64,
    /// For how long the error must have been beyond the threshold before a sensor is untrustworthy, seconds.
    pub persistence_s: f64,
}
