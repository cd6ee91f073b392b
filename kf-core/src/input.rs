//! Input of the estimator at one tick.
//!
//! Axes: body forward-right-down, navigation north-east-down; accelerations are specific force.
//! `None` means "no new sample at this tick", never "zero". Values may be non-finite: the estimator refuses
//! and counts them and continues.

use serde::{Deserialize, Serialize};

use crate::formula::MAX_COLUMNS;

/// One fix of the reference receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GpsFix {
    /// Altitude above the flight's altitude datum, metres.
    pub altitude_m: f32,
    /// North, east and down velocity, metres a second.
    pub velocity_north_mps: Option<f32>,
    /// See [`Self::velocity_north_mps`].
    pub velocity_east_mps: Option<f32>,
    /// See [`Self::velocity_north_mps`]; positive while descending.
    pub velocity_down_mps: Option<f32>,
    /// The receiver's own estimate of its vertical accuracy (1 sigma), metres.
    pub vertical_accuracy_m: Option<f32>,
    /// Satellites used in the fix.
    pub satellites: Option<u8>,
    /// When the fix was taken, by the receiver's clock, microseconds. Two fixes with the same time are one
    /// held fix. Without a time, a fix that repeats every bit of the last one is held.
    pub fix_time_us: Option<u64>,
}

/// A reading of the barometer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum BaroReading {
    /// Static pressure, pascals; converted to altitude by [`crate::atmosphere::pressure_altitude_m`].
    PressurePa(f32),
    /// Pressure altitude, metres.
    AltitudeM(f32),
}

/// One inertial sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImuSample {
    /// Specific force, body axes, m/s^2.
    pub accel_mps2: [f32; 3],
    /// Angular rate, body axes, rad/s.
    pub gyro_radps: [f32; 3],
}

/// Signals from which regressors of effects are made; each is the latest value if new at this tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Signals {
    /// True airspeed, m/s.
    pub true_airspeed_mps: Option<f32>,
    /// Angle of attack, rad.
    pub angle_of_attack_rad: Option<f32>,
    /// Sideslip angle, rad.
    pub sideslip_rad: Option<f32>,
    /// Throttle, 0 to 1.
    pub throttle: Option<f32>,
    /// Outside air temperature, degrees Celsius.
    pub outside_air_temperature_c: Option<f32>,
    /// Temperature of the barometer itself, degrees Celsius.
    pub baro_temperature_c: Option<f32>,
    /// Roll, pitch, yaw, rad.
    pub attitude_rad: Option<[f32; 3]>,
}

/// New samples of the extra columns, by the numbers that the model gave them, for its effects by formula.
/// Only the desk has such columns.
#[derive(Clone, Copy, Debug)]
pub struct Columns([f32; MAX_COLUMNS]);

impl Columns {
    /// Sets a new sample of the column with this number, SI units. Values that are not finite and unknown
    /// numbers are ignored.
    pub fn set(&mut self, column: usize, value: f32) {
        if let (Some(slot), true) = (self.0.get_mut(column), value.is_finite()) {
            *slot = value;
        }
    }

    /// The new sample of the column with this number.
    #[must_use]
    pub fn get(&self, column: usize) -> Option<f32> {
        self.0.get(column).copied().filter(|value| !value.is_nan())
    }
}

impl Default for Columns {
    /// Nothing new.
    fn default() -> Self {
        Self([f32::NAN; MAX_COLUMNS])
    }
}

impl PartialEq for Columns {
    fn eq(&self, other: &Self) -> bool {
        (0..MAX_COLUMNS).all(|column| self.get(column) == other.get(column))
    }
}

/// How certain [`TickInput::launch`] is; see [`crate::launch`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum LaunchDoubt {
    /// No doubt: captive or launched, as `launch` states.
    #[default]
    None,
    /// Possibly launched, not confirmed: the calibration is held and takes no data.
    Suspected,
    /// Launched, but shown by the wire only: the latch records [`crate::quality::Check::LaunchConfirmed`] as
    /// failed.
    Unconfirmed,
}

/// Everything that is new at one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TickInput {
    /// Time of the tick, microseconds since an arbitrary origin; must increase.
    pub time_us: u64,
    /// True once the UAV has left the mother ship.
    pub launch: bool,
    /// How certain `launch` is.
    #[serde(default)]
    pub launch_doubt: LaunchDoubt,
    /// A fix of the reference.
    pub gps: Option<GpsFix>,
    /// A barometer reading.
    pub baro: Option<BaroReading>,
    /// The mother ship's inertial altitude, metres.
    pub imu_master_altitude_m: Option<f32>,
    /// The UAV's inertial altitude, metres.
    pub imu_slave_altitude_m: Option<f32>,
    /// An inertial sample.
    pub imu: Option<ImuSample>,
    /// Signals for the effects.
    pub signals: Signals,
    /// Signals for effects by formula that no flight computer has.
    #[serde(skip)]
    pub columns: Columns,
}
