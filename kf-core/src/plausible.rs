//! Physical limits of an aircraft: finite numbers outside these ranges are refused and counted before
//! anything uses them.
//!
//! The ranges are those of physics or of the instruments, and wide: the innovation gate refuses what is
//! merely unlikely.

use crate::guard::Guard;
use crate::input::{GpsFix, ImuSample};
use crate::output::Rejection;

/// Within the range, or, with the guard removed, at least finite. NaN is in no range.
#[inline]
fn is_within(value: f32, least: f32, largest: f32) -> bool {
    if Guard::PlausibleReading.stands() { value >= least && value <= largest } else { value.is_finite() }
}

/// The reason for refusing a value, if any.
#[inline]
fn refusal(is_finite: bool, is_plausible: bool) -> Option<Rejection> {
    match (is_finite, is_plausible) {
        (false, _) => Some(Rejection::NotFinite),
        (true, false) => Some(Rejection::Implausible),
        (true, true) => None,
    }
}

/// An altitude, metres: the lowest land is at -430 m, where the highest pressure ever recorded (1,084 hPa at
/// sea level) reads as 560 m less; no wing flies at 100 km.
#[must_use]
#[inline]
pub fn altitude(altitude_m: f32) -> Option<Rejection> {
    refusal(altitude_m.is_finite(), is_within(altitude_m, -1_000.0, 100_000.0))
}

/// A velocity over ground or through the air, m/s: civil receivers report none beyond 515 m/s (the export
/// limit of 1,000 knots).
#[must_use]
#[inline]
pub fn velocity(velocity_mps: f32) -> bool {
    is_within(velocity_mps, -515.0, 515.0)
}

/// A fix: altitude and velocities.
#[must_use]
pub fn fix(fix: &GpsFix) -> Option<Rejection> {
    let velocities = [fix.velocity_north_mps, fix.velocity_east_mps, fix.velocity_down_mps];
    let mut numbers = velocities.iter().flatten().chain(&fix.vertical_accuracy_m);
    let is_finite = numbers.all(|number| number.is_finite());
    let of_velocities = refusal(is_finite, velocities.iter().flatten().all(|one| velocity(*one)));
    of_velocities.or(altitude(fix.altitude_m))
}

/// An inertial sample: units of this class measure up to 32 g and 4,000 degrees a second.
#[must_use]
pub fn imu(sample: &ImuSample) -> bool {
    sample.accel_mps2.iter().all(|axis| is_within(*axis, -400.0, 400.0))
        && sample.gyro_radps.iter().all(|axis| is_within(*axis, -70.0, 70.0))
}

/// An angle of attack or sideslip, rad.
#[must_use]
#[inline]
pub fn flow_angle(angle_rad: f32) -> bool {
    is_within(angle_rad, -core::f32::consts::PI, core::f32::consts::PI)
}

/// A throttle of 0 to 1; -1 when reversed, with some overshoot of the scale.
#[must_use]
#[inline]
pub fn throttle(throttle: f32) -> bool {
    is_within(throttle, -1.5, 1.5)
}

/// A temperature, degrees Celsius: from the coldest air ever recorded (-94 above the tropics' tropopause) to
/// the highest that electronics survive.
#[must_use]
#[inline]
pub fn temperature(temperature_c: f32) -> bool {
    is_within(temperature_c, -100.0, 150.0)
}
