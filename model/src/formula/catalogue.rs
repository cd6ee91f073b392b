//! The catalogue's effects as formulas.

use kf_core::effect::EffectId;

/// The formula of an effect of the catalogue. `tau` is its time constant, and `t` its time from launch
/// (`t_on` if the effect counts from power-on).
///
/// These are the compiled-in effects of the estimator, with two exceptions: `imu.vibration` takes the
/// variance between two samples as linear, the catalogue as constant; and `imu.tilt` and `imu.gyro_bias` have
/// no substitute for a flight without specific force or attitude.
#[must_use]
pub const fn of_catalogue(effect: EffectId) -> Option<&'static str> {
    Some(match effect {
        EffectId::BaroDynamicPressure => "airspeed_mps^2 / (2*g)",
        EffectId::BaroCarrierField => "at_launch(airspeed_mps)^2 / (2*g) * step(launch)",
        EffectId::BaroAngleOfAttack => "aoa_rad * airspeed_mps^2 / (2*g)",
        EffectId::BaroSideslip => "sideslip_rad^2 * airspeed_mps^2 / (2*g)",
        EffectId::BaroLag | EffectId::GpsLatency => "-climb_rate_mps",
        EffectId::BaroScale => "altitude_m - at_calibration(altitude_m)",
        EffectId::BaroTemperature => "baro_temp_c - at_calibration(baro_temp_c)",
        EffectId::BaroWarmUp => "1 - exp(-t / tau)",
        EffectId::BaroDrift | EffectId::ImuVelocityError => "t",
        EffectId::BaroAcceleration => "load_factor - 1",
        EffectId::BaroPropwash => "throttle^2",
        EffectId::ImuAccelBias => "t^2 / 2",
        EffectId::ImuAccelScale => "integral2(upward_accel_mps2)",
        EffectId::ImuTilt => "integral2(forward_accel_mps2) / 1[rad]",
        EffectId::ImuGyroBias => "integral2(forward_accel_mps2 * t) / 1[rad]",
        EffectId::ImuVibration => "integral2(accel_variance)",
        EffectId::ImuGravityGradient => {
            "integral2(3.086e-6[1/s^2] * (altitude_m - at_calibration(altitude_m)))"
        }
        EffectId::ImuEotvos => {
            "integral2(2*Omega*gps_ve_mps*cos_latitude + (gps_vn_mps^2 + gps_ve_mps^2) / R)"
        }
        EffectId::GpsConvergence => "exp(-t / tau)",
        EffectId::GpsLeverArm => "sin(pitch_rad)",
        _ => return None,
    })
}
