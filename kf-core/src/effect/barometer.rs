//! Effects on the barometer.
//!
//! An error `dp` of the static pressure causes one of `-dp / (rho g)` in pressure altitude (hydrostatic
//! equation), so a pressure coefficient `Cp` at the port reads `-Cp V^2 / (2 g)`: the density cancels.
//! Sources for sizes: Gracey, "Measurement of Aircraft Speed and Altitude", NASA RP-1046 (1980), on static
//! ports and on lag; TE Connectivity, MS5611-01BA03 data sheet.

use super::catalogue::{EffectSubject, Row, Uses};
use super::tracker::SignalTracker;
use crate::atmosphere::STANDARD_GRAVITY_MPS2;
use crate::sensor::Sensor;

const BARO: EffectSubject = EffectSubject::Sensor(Sensor::Baro);

/// `V^2 / (2 g)` in metres: the altitude error of a port that reads the whole dynamic pressure.
///
/// From `dp = rho V^2 / 2` and the hydrostatic `dh = dp / (rho g)`; the density cancels.
#[must_use]
pub fn dynamic_pressure_head_m(airspeed_squared_m2ps2: f32) -> f32 {
    airspeed_squared_m2ps2 * (0.5 / STANDARD_GRAVITY_MPS2)
}

fn head_m(tracker: &SignalTracker) -> Option<f32> {
    tracker.airspeed_squared_m2ps2().map(dynamic_pressure_head_m)
}

/// The coefficient is minus the port's `Cp`: -1 where the flow stagnates (Bernoulli); +1 is the suction on
/// a strongly curved skin. Good ports: within 0.1 (Gracey).
pub(super) const DYNAMIC_PRESSURE: Row = Row {
    name: "baro.dynamic_pressure",
    unit: "1",
    subject: BARO,
    needs: &["tas_mps"],
    uses: Uses::NOTHING,
    plausible: [-1.0, 1.0],
    typical_regressor_m: 256.0,
    has_time_constant: false,
    value: |tracker, _| head_m(tracker),
};

/// The mother ship's pressure field at the port, a `Cp` that she causes. In captive flight it is part of the
/// bias, so the release shows it with the opposite sign. Bounds as for the port's own.
pub(super) const CARRIER_FIELD: Row = Row {
    name: "baro.carrier_field",
    value: |tracker, _| tracker.latched_airspeed_squared_m2ps2().map(dynamic_pressure_head_m),
    ..DYNAMIC_PRESSURE
};

/// `Cp` changes with the angle of attack by no more than a thin aerofoil's lift coefficient does, 2 pi a
/// radian (Anderson, "Fundamentals of Aerodynamics", section 4.7).
pub(super) const ANGLE_OF_ATTACK: Row = Row {
    name: "baro.angle_of_attack",
    unit: "1/rad",
    needs: &["aoa_rad", "tas_mps"],
    uses: Uses::ANGLE_OF_ATTACK,
    plausible: [-6.3, 6.3],
    typical_regressor_m: 16.0,
    value: |tracker, _| Some(tracker.angle_of_attack_rad? * head_m(tracker)?),
    ..DYNAMIC_PRESSURE
};

/// Even in sideslip: ports on both sides, joined, cancel the odd part. A cylinder across the flow has
/// `Cp = 1 - 4 sin^2` of the angle round it (potential flow; Anderson, section 3.13), so `Cp` changes by -3
/// to 1 times sideslip squared; both signs are allowed, for ports in another body's flow.
pub(super) const SIDESLIP: Row = Row {
    name: "baro.sideslip",
    unit: "1/rad^2",
    needs: &["sideslip_rad", "tas_mps"],
    uses: Uses::SIDESLIP,
    plausible: [-5.0, 5.0],
    typical_regressor_m: 1.0,
    value: |tracker, _| {
        let sideslip_rad = tracker.sideslip_rad?;
        Some(sideslip_rad * sideslip_rad * head_m(tracker)?)
    },
    ..DYNAMIC_PRESSURE
};

/// First-order lag: the reading is the altitude one lag ago. Tubing and chamber of a UAV take some 0.01 to 1
/// s, long lines several (Gracey, on lag). Never negative.
pub(super) const LAG: Row = Row {
    name: "baro.lag",
    unit: "s",
    needs: &["gps_alt_m"],
    uses: Uses::HEIGHT,
    plausible: [0.0, 5.0],
    typical_regressor_m: 16.0,
    value: |tracker, _| tracker.climb_rate_mps().map(|climb_rate_mps| -climb_rate_mps),
    ..DYNAMIC_PRESSURE
};

/// A column of air `dT` off the standard's 288 K is thicker in proportion: 40 K (MIL-HDBK-310's extremes) is
/// 14 %.
pub(super) const SCALE: Row = Row {
    name: "baro.scale",
    needs: &["gps_alt_m"],
    uses: Uses::HEIGHT,
    plausible: [-0.2, 0.2],
    value: |tracker, _| tracker.height_gained_m(),
    ..DYNAMIC_PRESSURE
};

/// The MS5611's error over its temperature range, 2.5 hPa, is 21 m over some tens of kelvin; an uncompensated
/// sensor is ten times as bad.
pub(super) const TEMPERATURE: Row = Row {
    name: "baro.temperature",
    unit: "m/K",
    needs: &["baro_temp_c"],
    uses: Uses::BARO_TEMPERATURE,
    plausible: [-5.0, 5.0],
    typical_regressor_m: 8.0,
    value: |tracker, _| tracker.baro_warming_k(),
    ..DYNAMIC_PRESSURE
};

/// As [`TEMPERATURE`], where the temperature itself is not measured: twice the 2.5 hPa.
pub(super) const WARM_UP: Row = Row {
    name: "baro.warm_up",
    unit: "m",
    needs: &[],
    plausible: [-50.0, 50.0],
    typical_regressor_m: 1.0,
    has_time_constant: true,
    value: |tracker, regressor| {
        Some(-libm::expm1f(-tracker.elapsed_s(regressor.since) / regressor.time_constant_s))
    },
    ..DYNAMIC_PRESSURE
};

/// Weather: 1 hPa an hour is 0.0023 m/s; 0.1 m/s is 7 hPa in ten minutes, a squall line.
pub(super) const DRIFT: Row = Row {
    name: "baro.drift",
    unit: "m/s",
    needs: &[],
    plausible: [-0.1, 0.1],
    typical_regressor_m: 128.0,
    value: |tracker, _| Some(tracker.elapsed_s(super::Clock::Launch)),
    ..DYNAMIC_PRESSURE
};

/// The weight of membrane and gel: some pascals a g; 10 m are 120 Pa.
pub(super) const ACCELERATION: Row = Row {
    name: "baro.acceleration",
    unit: "m",
    needs: super::inertial::COLUMNS,
    uses: Uses::LOAD_FACTOR,
    plausible: [-10.0, 10.0],
    typical_regressor_m: 1.0,
    value: |tracker, _| tracker.load_factor().map(|load_factor| load_factor - 1.0),
    ..DYNAMIC_PRESSURE
};

/// The slipstream's dynamic pressure is the disc loading (momentum theory), which goes with the square of
/// the propeller's speed: 600 Pa, a small UAV's at full throttle, are 50 m.
pub(super) const PROPWASH: Row = Row {
    name: "baro.propwash",
    unit: "m",
    needs: &["throttle"],
    uses: Uses::THROTTLE,
    plausible: [-50.0, 50.0],
    typical_regressor_m: 1.0,
    value: |tracker, _| tracker.throttle.map(|throttle| throttle * throttle),
    ..DYNAMIC_PRESSURE
};
