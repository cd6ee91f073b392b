//! Effects on the UAV's inertial altitude: each is an error of the vertical channel's acceleration,
//! integrated twice from launch on (Titterton and Weston, "Strapdown Inertial Navigation Technology",
//! second edition, chapter 12). Sizes: TDK ICM-42688-P data sheet, DS-000347, tables 1 and 2.

use super::catalogue::{EffectSubject, Row, Uses};
use super::{Clock, inertial};
use crate::sensor::Sensor;

/// Transfer alignment from a mother ship: metres a second at worst.
pub(super) const VELOCITY_ERROR: Row = Row {
    name: "imu.velocity_error",
    unit: "m/s",
    subject: EffectSubject::Sensor(Sensor::ImuSlave),
    needs: &[],
    uses: Uses::NOTHING,
    plausible: [-10.0, 10.0],
    typical_regressor_m: 64.0,
    has_time_constant: false,
    value: |tracker, _| Some(tracker.elapsed_s(Clock::Launch)),
};

/// The data sheet's zero-g offset is 20 mg; 100 mg is a broken part.
pub(super) const ACCEL_BIAS: Row = Row {
    name: "imu.accel_bias",
    unit: "m/s^2",
    plausible: [-1.0, 1.0],
    typical_regressor_m: 2048.0,
    value: |tracker, _| {
        let elapsed_s = tracker.elapsed_s(Clock::Launch);
        Some(0.5 * elapsed_s * elapsed_s)
    },
    ..VELOCITY_ERROR
};

/// The data sheet's sensitivity error is 0.5 %; ten times that is a broken part.
pub(super) const ACCEL_SCALE: Row = Row {
    name: "imu.accel_scale",
    unit: "1",
    needs: inertial::COLUMNS_AND_ATTITUDE,
    uses: Uses::ATTITUDE.and(Uses::VERTICAL),
    plausible: [-0.05, 0.05],
    typical_regressor_m: 256.0,
    value: |tracker, _| tracker.vertical_integral_m(),
    ..VELOCITY_ERROR
};

/// A pitch error turns forward acceleration into the vertical channel; beyond 0.2 rad the effect is not
/// linear in it.
pub(super) const TILT: Row = Row {
    name: "imu.tilt",
    unit: "rad",
    needs: inertial::COLUMNS_AND_ATTITUDE,
    uses: Uses::ATTITUDE.and(Uses::FORWARD),
    plausible: [-0.2, 0.2],
    typical_regressor_m: 512.0,
    value: |tracker, _| tracker.forward_integrals_m().map(|[tilt_m, _]| tilt_m),
    ..VELOCITY_ERROR
};

/// A pitch error that grows with time. The data sheet's zero-rate offset is 0.5 degrees a second,
/// 0.009 rad/s.
pub(super) const GYRO_BIAS: Row = Row {
    name: "imu.gyro_bias",
    unit: "rad/s",
    plausible: [-0.05, 0.05],
    typical_regressor_m: 16_384.0,
    value: |tracker, _| tracker.forward_integrals_m().map(|[_, turning_m]| turning_m),
    ..TILT
};

/// Vibration rectification, the second-order term of IEEE Std 1293's accelerometer model: 10 mg per g^2,
/// much for a MEMS part, is 0.001 s^2/m; an unbalanced mount is worse.
pub(super) const VIBRATION: Row = Row {
    name: "imu.vibration",
    unit: "s^2/m",
    needs: inertial::COLUMNS,
    uses: Uses::VIBRATION,
    plausible: [-0.05, 0.05],
    typical_regressor_m: 1024.0,
    value: |tracker, _| tracker.vibration_integral_m(),
    ..VELOCITY_ERROR
};

/// `2 g / R`, the normal gradient of gravity in free air (Torge, "Geodesy", section 3.3). 1 in theory, 0
/// where the navigator already corrects for it.
pub(super) const GRAVITY_GRADIENT: Row = Row {
    name: "imu.gravity_gradient",
    unit: "1",
    needs: &["gps_alt_m"],
    uses: Uses::GRAVITY.and(Uses::HEIGHT),
    plausible: [-1.0, 2.0],
    typical_regressor_m: 4.0,
    value: |tracker, _| tracker.gravity_integral_m(),
    ..VELOCITY_ERROR
};

/// Coriolis and centrifugal acceleration of motion over the earth (Torge, on gravimetry from vehicles). 1 in
/// theory, 0 where the navigator already corrects for it.
pub(super) const EOTVOS: Row = Row {
    name: "imu.eotvos",
    unit: "1",
    needs: &["gps_vn_mps", "gps_ve_mps"],
    uses: Uses::EOTVOS,
    plausible: [-1.0, 2.0],
    typical_regressor_m: 4.0,
    value: |tracker, _| tracker.eotvos_integral_m(),
    ..VELOCITY_ERROR
};
