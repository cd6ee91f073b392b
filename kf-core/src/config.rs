//! Configuration of a mission: reference, sensors, monitor, effects.

use serde::{Deserialize, Serialize};

use crate::effect::EffectTerm;
use crate::input::GpsFix;
use crate::sensor::SENSORS;

/// Largest number of effects that a model can hold as constants, beside those that are states.
pub const MAX_CONSTANT_EFFECTS: usize = 8;
/// Largest number of effects that a model can hold as states.
pub const MAX_ESTIMATED_EFFECTS: usize = 8;

/// The climb rate that carries the reference altitude between fixes (input `u` of eq. 4).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClimbRate {
    /// Error of the climb rate (1 sigma), m/s.
    pub sigma_mps: f32,
    /// Correlation time of that error, seconds.
    pub correlation_time_s: f32,
}

/// The reference: the accuracy of the receiver's altitude.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceConfig {
    /// Error of one fix (1 sigma), metres.
    pub sigma_m: f32,
    /// Correlation time of that error, seconds; 0 for white noise. A fix every `dt` is then weighted with the
    /// equivalent white noise `sigma^2 max(1, 2 tau / dt)`.
    pub correlation_time_s: f32,
    /// Prior altitude, metres; without it, the first fix.
    pub prior_altitude_m: Option<f32>,
    /// Prior uncertainty of the altitude (1 sigma), metres.
    pub prior_sigma_m: f32,
    /// How the altitude moves between fixes; without it, it does not (A = I, Q = 0).
    pub climb_rate: Option<ClimbRate>,
    /// Age beyond which the reference is lost, seconds.
    pub lost_after_s: f32,
}

/// A sensor's noise, and the prior of its bias.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorConfig {
    /// Error of one reading (1 sigma), metres.
    pub sigma_m: f32,
    /// As [`ReferenceConfig::correlation_time_s`].
    pub correlation_time_s: f32,
    /// Prior mean of the bias, metres.
    pub prior_bias_m: f32,
    /// Prior sigma of the bias, metres.
    pub prior_sigma_m: f32,
    /// Noise floor: how far the bias wanders in one second (1 sigma), metres per root second.
    /// 0 claims a constant.
    pub wander_m_per_sqrt_s: f32,
}

/// Where the monitor's sigma of eq. 17 comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SigmaSource {
    /// The spread of the calibrated residual in captive flight. Where the reference's error is correlated in
    /// time, a calibration sees only part of it. The part that its length must miss is added twice: for the
    /// spread, and for the bias, which contains it ([`crate::gauss_markov::mean_variance_factor`]). With a
    /// white reference (the paper's) nothing is added.
    Residual,
    /// The filter's own covariance of the bias.
    Covariance,
    /// The sensor's configured sigma.
    Datasheet,
}

/// The monitor of eqs 16 and 17.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MonitorConfig {
    /// Where sigma comes from.
    pub sigma: SigmaSource,
    /// Threshold in sigmas; the paper's is 1.
    pub multiplier: f32,
    /// Length of the moving average, seconds.
    pub window_s: f32,
    /// How long the error must have exceeded the threshold before a sensor is untrustworthy, seconds; the
    /// paper's value is 0.
    pub persistence_s: f32,
    /// Whether an error that may be the reference's is not blamed on a sensor (`reference_check.rs`); the
    /// paper's is.
    pub reference_check: bool,
}

/// The paper's section 4: a second correction of the sensors in free flight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum SecondCorrection {
    /// None: the paper's section 3.
    Off,
    /// The moving average of the error is subtracted from the sensor.
    MovingAverage,
    /// A one-state Kalman filter of the error (random walk) replaces the moving average.
    Kalman {
        /// How far the error wanders in one second (1 sigma), metres per root second.
        wander_m_per_sqrt_s: f32,
    },
}

/// Thresholds of the named checks of the calibration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct QualityConfig {
    /// Shortest calibration after settling, seconds.
    pub minimum_duration_s: f32,
    /// Largest spread of the trimmed altitude (1 sigma of block means), metres.
    pub trimmed_altitude_m: f32,
    /// Largest spread of the trimmed airspeed (1 sigma of block means), m/s.
    pub trimmed_airspeed_mps: f32,
    /// Largest drift of the reference against its own integrated climb rate over the last half of
    /// the calibration, metres.
    pub reference_drift_m: f32,
    /// Fewest satellites.
    pub minimum_satellites: u8,
    /// Largest vertical accuracy that the receiver may report, metres.
    pub vertical_accuracy_m: f32,
    /// Largest drift of a bias over the calibration, in sigmas of the sensor's residual.
    pub bias_drift_sigmas: f32,
    /// Largest share of innovations beyond three sigmas.
    pub implausible_share: f32,
}

impl QualityConfig {
    /// Whether the accuracy that a receiver reports for its fix is good enough; true if it reports none.
    pub(crate) fn accepts(&self, fix: &GpsFix) -> bool {
        fix.vertical_accuracy_m.is_none_or(|sigma_m| sigma_m <= self.vertical_accuracy_m)
            && fix.satellites.is_none_or(|count| count >= self.minimum_satellites)
    }
}

/// The whole configuration of one mission; `E` effects are states.
#[derive(Clone, Debug, PartialEq)]
pub struct MissionConfig<const E: usize> {
    /// Initial part of captive flight that is ignored, seconds.
    pub settling_s: f32,
    /// The reference.
    pub reference: ReferenceConfig,
    /// Latitude of the flight, degrees, north positive; only `imu.eotvos` needs it.
    pub latitude_deg: f32,
    /// The sensors, in the order of [`crate::sensor::Sensor`].
    pub sensors: [SensorConfig; SENSORS],
    /// The monitor.
    pub monitor: MonitorConfig,
    /// Section 4's second correction.
    pub second_correction: SecondCorrection,
    /// The calibration's checks.
    pub quality: QualityConfig,
    /// Effects whose coefficients are states of the filter.
    pub estimated_effects: [EffectTerm; E],
    /// Effects whose coefficients are constants.
    pub constant_effects: heapless::Vec<EffectTerm, MAX_CONSTANT_EFFECTS>,
}
