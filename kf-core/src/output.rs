//! Output of the estimator after one tick.

use serde::{Deserialize, Serialize};

use crate::config::MAX_ESTIMATED_EFFECTS;
use crate::sensor::SENSORS;

/// Phase of the mission at a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// The first seconds of captive flight, ignored.
    Settling,
    /// Captive flight: biases are being estimated.
    Calibrating,
    /// After launch: the calibration is latched and the sensors are watched.
    FreeFlight,
}

/// Trust in a sensor's readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Trust {
    /// Captive flight: no assessment yet.
    Calibrating,
    /// Launched, and within the alarm limit so far.
    Trusted,
    /// The error has been beyond the alarm limit once (eq. 17, left).
    Doubtful,
    /// After that, the moving average has been beyond the alarm limit (eq. 17, right).
    Untrustworthy,
    /// Unknown: there is no reference to compare the sensor with, or no credible one, or the reference had
    /// moved during the calibration.
    Unmonitored,
}

impl Trust {
    /// The name used in files and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Calibrating => "calibrating",
            Self::Trusted => "trusted",
            Self::Doubtful => "doubtful",
            Self::Untrustworthy => "untrustworthy",
            Self::Unmonitored => "unmonitored",
        }
    }
}

/// Why a reading was not used at this tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Rejection {
    /// NaN or infinite, or an invalid pressure.
    NotFinite,
    /// The reading has been the same, to the bit, for too long.
    Stuck,
    /// A fix that repeats the last one.
    Held,
    /// The filter refused the update: its innovation variance was not positive and finite.
    Variance,
    /// Too far from the filter's prediction: an outlier; in free flight, a fix that the receiver's own climb
    /// rate contradicts.
    Gated,
    /// Finite, but no aircraft can be there or do that ([`crate::plausible`]).
    Implausible,
}

/// One sensor after one tick. A value that does not exist at this tick is `None`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorOutput {
    /// Estimated (later: latched) bias, metres.
    pub bias_m: f32,
    /// The filter's variance of the bias, square metres.
    pub bias_variance_m2: f32,
    /// Innovation of this tick's update (reading minus prediction), metres.
    pub innovation_m: Option<f32>,
    /// Normalised innovation squared, with the sign of the innovation.
    pub signed_nis: Option<f32>,
    /// Sensor error of eq. 16 at this tick: reading minus bias, effects and reference, metres.
    pub error_m: Option<f32>,
    /// Moving average of the error over the monitor's window, metres; only in free flight, and only if the
    /// error was judged, not if the reference may have caused it.
    pub moving_average_m: Option<f32>,
    /// Trust.
    pub trust: Trust,
    /// Why this tick's reading was not used, if it was not.
    pub rejection: Option<Rejection>,
}

/// Whether the two sensors of free flight agree with each other while the reference is lost or suspect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Agreement {
    /// Within the alarm limit so far.
    Agree,
    /// The difference has been beyond it once (as [`Trust::Doubtful`]).
    Doubtful,
    /// After that, its moving average has (as [`Trust::Untrustworthy`]): one of the two is wrong, but it is
    /// unknown which.
    Disagree,
}

impl Agreement {
    /// The name used in files and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Agree => "agree",
            Self::Doubtful => "doubtful",
            Self::Disagree => "disagree",
        }
    }
}

/// The cross-check of the barometer and the UAV's inertial altitude at a tick that completed a pair of
/// readings (at most 20 ms apart) without a reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CrossCheckOutput {
    /// Barometer less inertial altitude, each less its effects and its latched bias, metres.
    pub difference_m: f32,
    /// Its moving average over the monitor's window, metres.
    pub moving_average_m: f32,
    /// By the rule of eq. 17 with the sum of both squared alarm limits. It latches.
    pub agreement: Agreement,
}

/// A coefficient after one tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoefficientOutput {
    /// Estimated coefficient, in the effect's unit.
    pub coefficient: f32,
    /// Its variance, in that unit squared.
    pub variance: f32,
}

/// Everything that one tick reports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TickOutput {
    /// Time of the tick as received, microseconds.
    pub time_us: u64,
    /// The tick's time was not after the last tick's: it was counted and otherwise ignored.
    pub out_of_order: bool,
    /// Phase of the mission.
    pub phase: Phase,
    /// True only at the tick at which the calibration was latched.
    pub latched_now: bool,
    /// Names of failed checks of the latched calibration, one bit each.
    pub failed_checks: u16,
    /// Reference altitude as estimated, metres.
    pub altitude_m: f32,
    /// Its variance, square metres.
    pub altitude_variance_m2: f32,
    /// Innovation of this tick's fix, metres.
    pub gps_innovation_m: Option<f32>,
    /// Normalised innovation squared of this tick's fix, with the sign of the innovation.
    pub gps_signed_nis: Option<f32>,
    /// Why this tick's fix was not used, if it was not.
    pub gps_rejection: Option<Rejection>,
    /// The sensors, in the order of [`crate::sensor::Sensor`].
    pub sensors: [SensorOutput; SENSORS],
    /// Effects that corrected a reading or fix of this tick outside
    /// [`crate::effect::EffectTerm::envelope_m`]: the estimated ones from bit 0 on, in the model's order, the
    /// constant ones from bit [`MAX_ESTIMATED_EFFECTS`] on.
    pub extrapolated: u16,
    /// Check of the sensors against each other, in free flight while the reference is lost or suspect.
    pub cross_check: Option<CrossCheckOutput>,
    /// At the first tick after [`crate::mission::Mission::restore_snapshot`]: the time without data,
    /// microseconds, from the last tick of the snapshot to this one.
    pub bridged_us: Option<u64>,
    /// The estimated coefficients, in the model's order.
    pub coefficients: heapless::Vec<CoefficientOutput, MAX_ESTIMATED_EFFECTS>,
}
