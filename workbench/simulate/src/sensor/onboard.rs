//! Inertial sensors, air data, attitude, throttle.

use super::super::motion::TruthSample;
use super::super::random::{Random, Stream};
use super::super::scenario::{AirData, AttitudeSensor, Inertial};
use super::{NoiseSource, Readings, Series, between, quantise, schedule};
use flight_data::Channel;

/// Specific force (with the engine's vibration) and body rates.
pub(in super::super) fn inertial(
    sensor: &Inertial,
    flight: &[TruthSample],
    row_rate_hz: f64,
    seed: u64,
) -> Readings {
    let mut random = Random::new(seed, Stream::Inertial);
    let mut vibration = Random::new(seed, Stream::Engine);
    let mut accel_noise = [0; 3].map(|_| NoiseSource::new(sensor.accel_noise));
    let mut gyro_noise = [0; 3].map(|_| NoiseSource::new(sensor.gyro_noise));
    let mut columns: [Series; 6] = Default::default();
    let losses = Random::new(seed, Stream::InertialLosses);
    for due in schedule(&sensor.sampling, flight, row_rate_hz, losses) {
        let shake = between(due.source, |row| Some(flight.get(row)?.vibration_mps2));
        let (accel, gyro) = columns.split_at_mut(3);
        for axis in 0..3 {
            let error = sensor.accel_bias_mps2[axis]
                + accel_noise[axis].next(&mut random, due.time_s)
                + shake.unwrap_or(0.0) * vibration.normal();
            let truth = between(due.source, |row| Some(flight.get(row)?.specific_force_mps2[axis]));
            if let Some(truth) = truth.filter(|_| !due.lost) {
                accel[axis].push((due.row, quantise(truth + error, sensor.accel_quantum_mps2)));
            }
            let error = sensor.gyro_bias_radps[axis] + gyro_noise[axis].next(&mut random, due.time_s);
            let truth = between(due.source, |row| Some(flight.get(row)?.rate_radps[axis]));
            if let Some(truth) = truth.filter(|_| !due.lost) {
                gyro[axis].push((due.row, quantise(truth + error, sensor.gyro_quantum_radps)));
            }
        }
    }
    [
        Channel::AccelXMps2,
        Channel::AccelYMps2,
        Channel::AccelZMps2,
        Channel::GyroXRadps,
        Channel::GyroYRadps,
        Channel::GyroZRadps,
    ]
    .into_iter()
    .zip(columns)
    .collect()
}

/// A channel, its noise (1 sigma), and what it measures.
type Signal<'a> = (Channel, f64, &'a dyn Fn(&TruthSample) -> f64);

fn signals(
    list: &[Signal<'_>],
    sampling: &super::Sampling,
    flight: &[TruthSample],
    row_rate_hz: f64,
    mut random: Random,
    losses: Random,
) -> Readings {
    let mut readings: Readings = list.iter().map(|(channel, ..)| (*channel, Series::new())).collect();
    for due in schedule(sampling, flight, row_rate_hz, losses) {
        for ((_, sigma, measured), (_, series)) in list.iter().zip(&mut readings) {
            let error = sigma * random.normal();
            let truth = between(due.source, |row| Some(measured(flight.get(row)?)));
            if let Some(truth) = truth.filter(|_| !due.lost) {
                series.push((due.row, truth + error));
            }
        }
    }
    readings
}

/// True airspeed, flow angles, outside air temperature.
pub(in super::super) fn air_data(
    sensor: &AirData,
    flight: &[TruthSample],
    row_rate_hz: f64,
    seed: u64,
) -> Readings {
    let list: [Signal<'_>; 4] = [
        (Channel::TasMps, sensor.airspeed_sigma_mps, &|s| s.airspeed_mps),
        (Channel::AoaRad, sensor.angle_sigma_rad, &|s| s.angle_of_attack_rad),
        (Channel::SideslipRad, sensor.angle_sigma_rad, &|s| s.sideslip_rad),
        (Channel::OatC, sensor.temperature_sigma_c, &|s| s.air_temperature_c),
    ];
    let (random, losses) = (Random::new(seed, Stream::AirData), Random::new(seed, Stream::AirDataLosses));
    signals(&list, &sensor.sampling, flight, row_rate_hz, random, losses)
}

/// Attitude and throttle (the lever's position, without noise).
pub(in super::super) fn attitude(
    sensor: &AttitudeSensor,
    flight: &[TruthSample],
    row_rate_hz: f64,
    seed: u64,
) -> Readings {
    let list: [Signal<'_>; 4] = [
        (Channel::RollRad, sensor.sigma_rad, &|s| s.euler_rad[0]),
        (Channel::PitchRad, sensor.sigma_rad, &|s| s.euler_rad[1]),
        (Channel::YawRad, sensor.sigma_rad, &|s| s.euler_rad[2]),
        (Channel::Throttle, 0.0, &|s| s.throttle),
    ];
    let (random, losses) = (Random::new(seed, Stream::Attitude), Random::new(seed, Stream::AttitudeLosses));
    signals(&list, &sensor.sampling, flight, row_rate_hz, random, losses)
}
