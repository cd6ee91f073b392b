//! The catalogue's effects in plain words, for a reader who does not know their ids.

/// An effect in plain words.
pub(super) fn meaning(id: &str) -> &'static str {
    match id {
        "baro.dynamic_pressure" => "the static port also feels the airspeed",
        "baro.carrier_field" => "the mother ship disturbs the pressure until release",
        "baro.angle_of_attack" => "the static port also feels the angle of attack",
        "baro.sideslip" => "the static port also feels sideslip",
        "baro.lag" => "the pressure arrives late",
        "baro.scale" => "heights come out too large or too small, as in air that is not standard",
        "baro.temperature" => "the sensor drifts with its own temperature",
        "baro.warm_up" => "the sensor drifts while it warms up",
        "baro.drift" => "the weather changes, or the sensor drifts steadily",
        "baro.acceleration" => "the sensor feels acceleration",
        "baro.propwash" => "the propeller blows on the static port",
        "imu.velocity_error" => "the climb rate was off at launch",
        "imu.accel_bias" => "the vertical accelerometer has an offset",
        "imu.accel_scale" => "the vertical accelerometer has a wrong scale",
        "imu.tilt" => "the platform is not level",
        "imu.gyro_bias" => "the platform tilts more and more",
        "imu.vibration" => "vibration is rectified into acceleration",
        "imu.gravity_gradient" => "gravity grows weaker with height",
        "imu.eotvos" => "flying east or west changes the weight",
        "gps.latency" => "the reference arrives late",
        "gps.convergence" => "the receiver had not settled yet",
        "gps.lever_arm" => "the antenna is not where the sensors are",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kf_core::effect::EffectId;

    #[test]
    fn every_effect_of_the_catalogue_has_words() {
        for effect in EffectId::ALL {
            assert_ne!(meaning(effect.name()), "", "{}", effect.name());
        }
    }
}
