//! What a sensor read at a tick.

use kf_core::atmosphere::pressure_altitude_m;
use kf_core::input::{BaroReading, TickInput};
use kf_core::sensor::Sensor;

/// What a sensor read, as an altitude, metres: a barometer's is that of the standard atmosphere. `None` where it has no new reading, or a
/// pressure that is no altitude's.
#[must_use]
pub fn reading_m(sensor: Sensor, input: &TickInput) -> Option<f32> {
    match sensor {
        Sensor::ImuMaster => input.imu_master_altitude_m,
        Sensor::ImuSlave => input.imu_slave_altitude_m,
        Sensor::Baro => match input.baro? {
            BaroReading::PressurePa(pressure_pa) => pressure_altitude_m(pressure_pa),
            BaroReading::AltitudeM(altitude_m) => Some(altitude_m),
        },
    }
}
