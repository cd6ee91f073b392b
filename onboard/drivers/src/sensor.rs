//! One trait for each kind of sensor.
//!
//! All `poll`s alike: `now_us` is the flight computer's clock, microseconds, never running backward;
//! `Ok(None)` is "nothing new"; an error is returned once for each time that it occurs.

use kf_core::input::{BaroReading, GpsFix, ImuSample, LaunchDoubt};

use crate::error::SensorError;

/// The reference: a satellite navigation receiver.
pub trait SatelliteReceiver {
    /// A fix, once.
    ///
    /// # Errors
    /// See [`SensorError`].
    fn poll(&mut self, now_us: u64) -> Result<Option<GpsFix>, SensorError>;
}

/// What a barometer can deliver at one time; a chip may alternate between the two.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BarometerSample {
    /// Static pressure, or the pressure altitude of a unit that computes it itself.
    pub reading: Option<BaroReading>,
    /// Temperature of the chip, degrees Celsius.
    pub temperature_c: Option<f32>,
}

/// A barometric sensor.
pub trait Barometer {
    /// A sample, once.
    ///
    /// # Errors
    /// See [`SensorError`].
    fn poll(&mut self, now_us: u64) -> Result<Option<BarometerSample>, SensorError>;
}

/// An inertial measurement unit.
pub trait InertialUnit {
    /// A sample, once: specific force and angular rate in body axes, forward-right-down.
    ///
    /// # Errors
    /// See [`SensorError`].
    fn poll(&mut self, now_us: u64) -> Result<Option<ImuSample>, SensorError>;
}

/// A link to a unit that computes an altitude of its own: the mother ship's inertial navigation, or the
/// UAV's.
pub trait AltitudeLink {
    /// An altitude above the flight's datum, metres, once.
    ///
    /// # Errors
    /// See [`SensorError`].
    fn poll(&mut self, now_us: u64) -> Result<Option<f32>, SensorError>;

    /// Instead of [`Self::poll`], where this tick has dearer work: takes what has arrived and looks at it at
    /// the next poll. `Ok(false)` where there is nothing to put off, and it must be polled.
    ///
    /// # Errors
    /// See [`SensorError`].
    fn put_off(&mut self) -> Result<bool, SensorError> {
        Ok(false)
    }

    /// Whether the UAV hangs under the mother ship, as far as that is decided. The link to a unit that stays
    /// behind is gone when it does not: silence is then no fault.
    fn set_attached(&mut self, _attached: bool) {}
}

/// What other equipment of the vehicle knows about its state; each is there when it is new.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VehicleState {
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
    /// Roll, pitch, yaw, rad.
    pub attitude_rad: Option<[f32; 3]>,
}

/// A link to the vehicle's air data, engine and attitude equipment (autopilot bus).
pub trait VehicleLink {
    /// What is new, once.
    ///
    /// # Errors
    /// See [`SensorError`].
    fn poll(&mut self, now_us: u64) -> Result<Option<VehicleState>, SensorError>;
}

/// The umbilical discrete: it opens when the UAV leaves the mother ship.
pub trait LaunchDiscrete {
    /// Whether it is open.
    ///
    /// # Errors
    /// See [`SensorError`]. The caller then holds the last state.
    fn poll(&mut self, now_us: u64) -> Result<bool, SensorError>;

    /// What stands behind that. A bare wire knows of no doubt.
    fn doubt(&self) -> LaunchDoubt {
        LaunchDoubt::None
    }
}
