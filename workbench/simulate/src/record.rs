//! Makes a flight from truth and sensors.

use super::effect::{self, Victim};
use super::motion::TruthSample;
use super::scenario::Scenario;
use super::sensor::{self, ImuAltitude, Readings};
use flight_data::{AltitudeDatum, Channel, Column, Flight, Header};

/// Sum of all injected effects on each reading, m, a value for each row.
pub(super) struct Effects {
    pub(super) baro: Vec<f64>,
    pub(super) imu_slave: Vec<f64>,
    pub(super) gps: Vec<f64>,
}

impl Effects {
    pub(super) fn of(scenario: &Scenario, trajectory: &[TruthSample]) -> Self {
        let none = vec![0.0; trajectory.len()];
        let mut effects = Self { baro: none.clone(), imu_slave: none.clone(), gps: none };
        for injected in &scenario.effect {
            let sum = match effect::victim(injected.id) {
                Victim::Baro => &mut effects.baro,
                Victim::ImuSlave => &mut effects.imu_slave,
                Victim::Gps => &mut effects.gps,
            };
            let regressor = effect::regressor(injected, trajectory, scenario.latitude_deg);
            for (total, value) in sum.iter_mut().zip(regressor) {
                *total += injected.coefficient * value;
            }
        }
        effects
    }
}

/// The readings of every sensor of a scenario.
pub(super) fn readings(
    scenario: &Scenario,
    trajectory: &[TruthSample],
    effects: &Effects,
    seed: u64,
) -> Readings {
    let sensors = &scenario.sensors;
    let rate = scenario.rate_hz;
    let settling = scenario.captive.settling_s;
    let imu = |which, sensor, effects: &[f64]| {
        sensor::imu_altitude(which, sensor, trajectory, effects, settling, rate, seed)
    };
    let mut readings = Readings::new();
    if sensors.gps.sampling.enabled {
        readings.extend(sensor::gps(&sensors.gps, trajectory, &effects.gps, rate, seed));
    }
    if sensors.baro.sampling.enabled {
        readings.extend(sensor::baro(&sensors.baro, trajectory, &effects.baro, settling, rate, seed));
    }
    if sensors.imu_master.sampling.enabled {
        let none = vec![0.0; trajectory.len()];
        readings.extend(imu(ImuAltitude::Master, &sensors.imu_master, &none));
    }
    if sensors.imu_slave.sampling.enabled {
        readings.extend(imu(ImuAltitude::Slave, &sensors.imu_slave, &effects.imu_slave));
    }
    if sensors.inertial.sampling.enabled {
        readings.extend(sensor::inertial(&sensors.inertial, trajectory, rate, seed));
    }
    if sensors.air_data.sampling.enabled {
        readings.extend(sensor::air_data(&sensors.air_data, trajectory, rate, seed));
    }
    if sensors.attitude.sampling.enabled {
        readings.extend(sensor::attitude(&sensors.attitude, trajectory, rate, seed));
    }
    readings
}

/// The flight as it would be recorded.
pub(super) fn flight(
    scenario: &Scenario,
    trajectory: &[TruthSample],
    effects: &Effects,
    seed: u64,
) -> Flight {
    let mut flight = Flight {
        header: Header {
            vehicle: scenario.vehicle.name.clone(),
            source: format!("pylon simulate: {}", scenario.source),
            altitude_datum: AltitudeDatum::Msl,
            other: vec![
                ("scenario".to_owned(), scenario.name.clone()),
                ("seed".to_owned(), seed.to_string()),
                ("latitude_deg".to_owned(), scenario.latitude_deg.to_string()),
            ],
        },
        time_s: trajectory.iter().map(|sample| sample.time_s).collect(),
        ..Flight::default()
    };
    let mut launch = Column::with_capacity(trajectory.len());
    for sample in trajectory {
        launch.push(Some(if sample.captive { 0.0 } else { 1.0 }));
    }
    flight.set_channel(Channel::Launch, launch);
    for (channel, series) in readings(scenario, trajectory, effects, seed) {
        let mut column = Column::empty(trajectory.len());
        for (row, value) in series {
            column.set(row, Some(value as f32));
        }
        flight.set_channel(channel, column);
    }
    flight
}
