//! A sensor's reading at a tick.

use kf_core::atmosphere::pressure_altitude_m;
use kf_core::input::{BaroReading, TickInput};
use kf_core::sensor::Sensor;

/// A sensor's reading as an altitude, metres; a barometer's is that of the standard atmosphere. `None` where
/// it has no new reading, or an invalid pressure.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sensor_reads_its_own_altitude() {
        let input = TickInput {
            imu_master_altitude_m: Some(1.0),
            imu_slave_altitude_m: Some(2.0),
            baro: Some(BaroReading::AltitudeM(3.0)),
            ..TickInput::default()
        };
        assert_eq!(Sensor::ALL.map(|sensor| reading_m(sensor, &input)), [Some(1.0), Some(2.0), Some(3.0)]);
        assert_eq!(Sensor::ALL.map(|sensor| reading_m(sensor, &TickInput::default())), [None; 3]);
        // From ICAO's table: 89,874.6 Pa at 1,000 m; 12 Pa correspond to a metre there.
        let at_1000_m = TickInput { baro: Some(BaroReading::PressurePa(89_874.6)), ..TickInput::default() };
        assert!((reading_m(Sensor::Baro, &at_1000_m).unwrap() - 1_000.0).abs() < 0.05);
    }
}
