//! One trait for each kind of sensor.
//!
//! All `poll`s work alike: `now_us` is the flight computer's clock, microseconds, never running backward;
//! `Ok(None)` means "nothing new"; an error is returned once for each time that it occurs.

use kf_core::input::{BaroReading, GpsFix, ImuSample, LaunchDoubt};

use crate::error::SensorError;

/// The reference: a satellite navigation receiver.
pub trait SatelliteReceiver {
    /// A new fix; each is returned once.
    ///
    /// # Errors
    /// See [`SensorError`].
    fn poll(&mut self, now_us: u64) -> Result<Option<GpsFix>, SensorError>;
}

/// What a barometer can deliver in one poll; a chip may alternate between the two.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BarometerSample {
    /// Static pressure, or the pressure altitude of a unit that computes it itself.
    pub reading: Option<BaroReading>,
    /// Temperature of the chip, degrees Celsius.
    pub temperature_c: Option<f32>,
}

/// A barometric sensor.
pub trait Barometer {
    /// A new sample; each is returned once.
    ///
    /// # Errors
    /// See [`SensorError`].
    fn poll(&mut self, now_us: u64) -> Result<Option<BarometerSample>, SensorError>;
}

/// An inertial measurement unit.
pub trait InertialUnit {
    /// A new sample, each returned once: specific force and angular rate in body axes, forward-right-down.
    ///
    /// # Errors
    /// See [`SensorError`].
    fn poll(&mut self, now_us: u64) -> Result<Option<ImuSample>, SensorError>;
}

/// A link to a unit that computes its own altitude: the mother ship's inertial navigation, or the UAV's.
pub trait AltitudeLink {
    /// A new altitude above the flight's datum, metres; each is returned once.
    ///
    /// # Errors
    /// See [`SensorError`].
    fn poll(&mut self, now_us: u64) -> Result<Option<f32>, SensorError>;

    /// Replaces [`Self::poll`] in a tick with more expensive work: stores what has arrived for the next poll.
    /// `Ok(false)` means that nothing can be put off and the link must be polled.
    ///
    /// # Errors
    /// See [`SensorError`].
    fn put_off(&mut self) -> Result<bool, SensorError> {
        Ok(false)
    }

    /// Sets whether the UAV hangs under the mother ship, as far as that is decided. After launch the link to
    /// a unit that stays behind is gone, and silence is no fault.
    fn set_attached(&mut self, _attached: bool) {}
}

/// State of the vehicle from its other equipment. Each field is present when it is new.
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
    /// New values; each is returned once.
    ///
    /// # Errors
    /// See [`SensorError`].
    fn poll(&mut self, now_us: u64) -> Result<Option<VehicleState>, SensorError>;
}

/// The umbilical discrete: it opens when the UAV leaves the mother ship.
pub trait LaunchDiscrete {
    /// Whether the discrete is open.
    ///
    /// # Errors
    /// See [`SensorError`]. The caller then keeps the last state.
    fn poll(&mut self, now_us: u64) -> Result<bool, SensorError>;

    /// How certain the launch is. A bare wire reports no doubt.
    fn doubt(&self) -> LaunchDoubt {
        LaunchDoubt::None
    }
}
