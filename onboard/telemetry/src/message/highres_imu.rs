//! HIGHRES_IMU (105).

use kf_core::input::{BaroReading, TickInput};
use mavlink::dialects::common::{HIGHRES_IMU_DATA, HighresImuUpdatedFlags};

/// The inertial and the barometer samples of one tick.
///
/// | field | is |
/// |---|---|
/// | `xacc` to `zacc` | specific force, body forward-right-down, m/s^2 |
/// | `xgyro` to `zgyro` | body rates, rad/s |
/// | `abs_pressure` | static pressure, hPa |
/// | `pressure_alt` | pressure altitude, m, of a unit that computes it itself |
/// | `temperature` | of the barometer, degrees Celsius |
/// | `fields_updated` | the fields with a sample of this tick; the others are NaN |
/// | magnetic field, `diff_pressure` | NaN: there is no such sensor |
#[must_use]
pub fn highres_imu(input: &TickInput) -> HIGHRES_IMU_DATA {
    use HighresImuUpdatedFlags as Updated;
    let mut updated = Updated::empty();
    let mut inertial = [[f32::NAN; 3]; 2];
    if let Some(imu) = &input.imu {
        inertial = [imu.accel_mps2, imu.gyro_radps];
        updated |= Updated::from_bits_retain(0x3f);
    }
    let (mut abs_pressure, mut pressure_alt) = (f32::NAN, f32::NAN);
    match input.baro {
        Some(BaroReading::PressurePa(pressure_pa)) => {
            abs_pressure = pressure_pa / 100.0;
            updated |= Updated::HIGHRES_IMU_UPDATED_ABS_PRESSURE;
        }
        Some(BaroReading::AltitudeM(altitude_m)) => {
            pressure_alt = altitude_m;
            updated |= Updated::HIGHRES_IMU_UPDATED_PRESSURE_ALT;
        }
        None => {}
    }
    let temperature = input.signals.baro_temperature_c;
    if temperature.is_some() {
        updated |= Updated::HIGHRES_IMU_UPDATED_TEMPERATURE;
    }
    let [[xacc, yacc, zacc], [xgyro, ygyro, zgyro]] = inertial;
    HIGHRES_IMU_DATA {
        time_usec: input.time_us,
        xacc,
        yacc,
        zacc,
        xgyro,
        ygyro,
        zgyro,
        xmag: f32::NAN,
        ymag: f32::NAN,
        zmag: f32::NAN,
        abs_pressure,
        diff_pressure: f32::NAN,
        pressure_alt,
        temperature: temperature.unwrap_or(f32::NAN),
        fields_updated: updated,
        id: 0,
    }
}
