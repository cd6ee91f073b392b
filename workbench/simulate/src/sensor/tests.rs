use super::super::atmosphere;
use super::super::random::Stream;
use super::super::scenario::{
    AirData, AltitudeSensor, Barometer, CarrierFlow, ColdStart, Gps, Inertial, Interval,
};
use super::*;

const ROW_RATE: f64 = 200.0;

/// A climb at 3 m/s that speeds up, captive for the first half.
fn flight(rows: usize) -> Vec<TruthSample> {
    (0..rows)
        .map(|row| {
            let t = row as f64 / ROW_RATE;
            TruthSample {
                time_s: t,
                captive: row < rows / 2,
                position_m: [28.0 * t, 0.0],
                altitude_m: 1000.0 + 3.0 * t + 0.01 * t * t,
                velocity_mps: [28.0, 0.5 * t, -3.0 - 0.02 * t],
                attitude: [1.0, 0.0, 0.0, 0.0],
                euler_rad: [0.1, 0.2, 0.3],
                specific_force_mps2: [0.5, 0.1 * t, -9.8],
                rate_radps: [0.01 * t, 0.0, -0.02],
                airspeed_mps: 28.0 + t,
                angle_of_attack_rad: 0.05,
                sideslip_rad: -0.01,
                throttle: 0.5,
                vibration_mps2: 0.0,
                pressure_altitude_m: 990.0 + 3.0 * t,
                air_temperature_c: 8.0,
                baro_temperature_c: 20.0 - 0.1 * t,
            }
        })
        .collect()
}

fn silent(rate_hz: f64) -> Sampling {
    Sampling::every(rate_hz)
}

fn silent_gps(rate_hz: f64) -> Gps {
    Gps {
        sampling: silent(rate_hz),
        noise: Noise::default(),
        velocity_sigma_mps: 0.0,
        quantum_m: 0.0,
        ..Gps::default()
    }
}

fn silent_imu(rate_hz: f64) -> AltitudeSensor {
    AltitudeSensor {
        sampling: silent(rate_hz),
        bias_m: 0.0,
        noise: Noise::default(),
        quantum_m: 0.0,
        carrier_flow: CarrierFlow::default(),
    }
}

fn silent_baro(rate_hz: f64) -> Barometer {
    Barometer {
        sampling: silent(rate_hz),
        noise: Noise::default(),
        quantum_pa: 0.0,
        carrier_flow: CarrierFlow::default(),
        ..Barometer::default()
    }
}

fn read_imu(sensor: &AltitudeSensor, flight: &[TruthSample], seed: u64) -> Series {
    let none = vec![0.0; flight.len()];
    imu_altitude(ImuAltitude::Slave, sensor, flight, &none, 0.0, ROW_RATE, seed).remove(0).1
}

fn series(readings: &Readings, channel: Channel) -> &Series {
    &readings.iter().find(|(name, _)| *name == channel).unwrap().1
}

/// Errors of an altitude against the truth.
fn errors(series: &Series, flight: &[TruthSample]) -> Vec<f64> {
    series.iter().map(|(row, value)| value - flight[*row].altitude_m).collect()
}

fn variance(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1.0)
}

/// Five sigma of a sample variance of n independent normal numbers, relative (chi-square).
fn chi_square_bound(n: usize) -> f64 {
    5.0 * (2.0 / (n as f64 - 1.0)).sqrt()
}

#[test]
fn every_rate_is_met() {
    let rows = 20 * 200;
    let flight = flight(rows);
    for rate in [200.0, 100.0, 50.0, 5.0, 7.0, 33.3, 1.0] {
        let due: Vec<Due> =
            schedule(&silent(rate), &flight, ROW_RATE, Random::new(1, Stream::GpsLosses)).collect();
        // Sample m falls on the first row at or after m / rate.
        let expected = ((rows - 1) as f64 * rate / ROW_RATE).floor() as usize + 1;
        assert_eq!(due.len(), expected, "{rate}");
        assert!(due.iter().all(|due| !due.lost));
        for (m, due) in due.iter().enumerate() {
            assert_eq!(due.row, (m as f64 * ROW_RATE / rate - 1e-9).ceil() as usize, "{rate} {m}");
        }
    }
}

#[test]
fn dropouts_are_binomial_and_outages_complete() {
    let flight = flight(100 * 200);
    let mut sampling = Sampling { dropout_probability: 0.1, ..silent(50.0) };
    let losses = || Random::new(3, Stream::GpsLosses);
    let lost = |sampling: &Sampling| -> Vec<bool> {
        schedule(sampling, &flight, ROW_RATE, losses()).map(|due| due.lost).collect()
    };
    let dropped = lost(&sampling);
    let n = dropped.len() as f64;
    let count = dropped.iter().filter(|lost| **lost).count() as f64;
    assert!((count - 0.1 * n).abs() < 5.0 * (n * 0.1 * 0.9).sqrt(), "{count}");

    sampling.outages = vec![Interval { start_s: 20.0, duration_s: 10.0 }];
    for (index, (out, dropped)) in lost(&sampling).into_iter().zip(dropped).enumerate() {
        let inside = (1000..1500).contains(&index);
        assert_eq!(out, inside || dropped, "{index}");
    }
    let sensor = AltitudeSensor { sampling, ..silent_imu(50.0) };
    assert!(read_imu(&sensor, &flight, 3).iter().all(|(row, _)| !(4000..6000).contains(row)));
}

#[test]
fn latency_delivers_the_past_and_nothing_before_there_is_one() {
    let flight = flight(2000);
    // 31.25 ms: six rows and a quarter.
    let latency_s = 0.031_25;
    let sampling = Sampling { latency_s, ..silent(50.0) };
    let sensor = AltitudeSensor { sampling: sampling.clone(), bias_m: 5.0, ..silent_imu(50.0) };
    let readings = read_imu(&sensor, &flight, 1);
    assert_eq!(readings[0].0, 8, "the first row that is older than the latency");
    for (row, value) in readings {
        let (before, after) = (flight[row - 7].altitude_m, flight[row - 6].altitude_m);
        let expected = 5.0 + before + 0.75 * (after - before);
        assert!((value - expected).abs() < 1e-9, "{row}");
    }
    let fixes = gps(
        &Gps { sampling: Sampling { latency_s: 0.2, ..silent(5.0) }, ..silent_gps(5.0) },
        &flight,
        &vec![0.0; 2000],
        ROW_RATE,
        1,
    );
    for (row, altitude) in series(&fixes, Channel::GpsAltM) {
        assert!((altitude - flight[row - 40].altitude_m).abs() < 1e-9);
    }
    for (row, time_s) in series(&fixes, Channel::GpsTimeS) {
        assert!((time_s - (flight[*row].time_s - 0.2)).abs() < 1e-12);
    }
    for (row, down) in series(&fixes, Channel::GpsVdMps) {
        assert!((down - flight[row - 40].velocity_mps[2]).abs() < 1e-9);
    }
}

#[test]
fn white_noise_and_wander_have_their_spread() {
    let flight = flight(200 * 400);
    let white = AltitudeSensor { noise: Noise { white: 0.7, ..Noise::default() }, ..silent_imu(200.0) };
    let noise = errors(&read_imu(&white, &flight, 2), &flight);
    let ratio = variance(&noise) / (0.7 * 0.7);
    assert!((ratio - 1.0).abs() < chi_square_bound(noise.len()), "{ratio}");
    let lagged: f64 = noise.windows(2).map(|p| p[0] * p[1]).sum::<f64>() / noise.len() as f64;
    assert!((lagged / 0.49).abs() < 5.0 / (noise.len() as f64).sqrt());

    let wander =
        AltitudeSensor { noise: Noise { white: 0.0, wander: 2.0, wander_time_s: 0.5 }, ..silent_imu(50.0) };
    let noise = errors(&read_imu(&wander, &flight, 2), &flight);
    let n = noise.len() as f64;
    let rho: f64 = (-0.02_f64 / 0.5).exp();
    let bound = 5.0 * (2.0 / n * (1.0 + rho * rho) / (1.0 - rho * rho)).sqrt();
    let variance = noise.iter().map(|x| x * x).sum::<f64>() / n;
    assert!((variance / 4.0 - 1.0).abs() < bound, "{variance}");
    let tenth: f64 = noise.iter().zip(&noise[10..]).map(|(a, b)| a * b).sum::<f64>() / n;
    assert!((tenth / 4.0 - rho.powi(10)).abs() < 2.0_f64.sqrt() * bound, "{tenth}");
}

#[test]
fn quantisation_rounds_to_the_nearest_step() {
    let flight = flight(200 * 100);
    let sensor = AltitudeSensor { quantum_m: 0.25, ..silent_imu(200.0) };
    let error = errors(&read_imu(&sensor, &flight, 1), &flight);
    for ((_, value), error) in read_imu(&sensor, &flight, 1).iter().zip(&error) {
        assert!((value / 0.25).fract() == 0.0 && error.abs() <= 0.125 + 1e-9);
    }
    // Uniform over a step: variance q^2 / 12, its sample variance's spread sqrt(4/5) (q^2/12) / sqrt(n).
    let ratio = variance(&error) * 12.0 / 0.0625;
    assert!((ratio - 1.0).abs() < 5.0 * (0.8 / error.len() as f64).sqrt(), "{ratio}");

    let sensor = Barometer { quantum_pa: 4.0, ..silent_baro(50.0) };
    let readings = baro(&sensor, &flight, &vec![0.0; flight.len()], 0.0, ROW_RATE, 1);
    assert!(series(&readings, Channel::BaroPa).iter().all(|(_, pa)| (pa / 4.0).fract() == 0.0));
}

#[test]
fn the_written_pressure_is_the_altitude_that_the_sensor_reads() {
    let flight = flight(4000);
    let effects: Vec<f64> = (0..flight.len()).map(|row| (row as f64 * 0.01).sin() * 20.0).collect();
    let sensor = Barometer { bias_m: -31.0, ..silent_baro(50.0) };
    let readings = baro(&sensor, &flight, &effects, 0.0, ROW_RATE, 1);
    let pressures = series(&readings, Channel::BaroPa);
    assert_eq!(pressures.len(), 1000);
    for (row, pressure) in pressures {
        let expected = flight[*row].pressure_altitude_m - 31.0 + effects[*row];
        assert!((atmosphere::pressure_altitude_m(*pressure) - expected).abs() < 1e-8);
    }
    for (row, temperature) in series(&readings, Channel::BaroTempC) {
        // Noise of the temperature: 0.02 degrees; six sigma over a thousand samples.
        assert!((temperature - flight[*row].baro_temperature_c).abs() < 0.12);
    }
}

#[test]
fn the_carriers_flow_is_there_until_release_and_stronger_while_settling() {
    let flight = flight(200 * 400);
    let carrier_flow = CarrierFlow { sigma_m: 30.0, correlation_time_s: 0.005, settling_factor: 2.0 };
    let sensor = AltitudeSensor { carrier_flow, ..silent_imu(200.0) };
    let none = vec![0.0; flight.len()];
    let read = imu_altitude(ImuAltitude::Slave, &sensor, &flight, &none, 100.0, ROW_RATE, 9).remove(0).1;
    let error = errors(&read, &flight);
    let rho: f64 = (-1.0_f64).exp();
    let bound = |n: usize| 5.0 * (2.0 / n as f64 * (1.0 + rho * rho) / (1.0 - rho * rho)).sqrt();
    let settling = variance(&error[..20_000]) / 3600.0;
    let settled = variance(&error[20_000..40_000]) / 900.0;
    assert!((settling - 1.0).abs() < bound(20_000), "{settling}");
    assert!((settled - 1.0).abs() < bound(20_000), "{settled}");
    assert!(error[40_000..].iter().all(|error| *error == 0.0));
}

#[test]
fn the_mother_ships_altitude_ends_at_release() {
    let flight = flight(4000);
    let none = vec![0.0; flight.len()];
    let master = imu_altitude(ImuAltitude::Master, &silent_imu(50.0), &flight, &none, 0.0, ROW_RATE, 1);
    let (channel, series) = &master[0];
    assert_eq!((*channel, series.len()), (Channel::ImuMasterAltM, 500));
    assert!(series.iter().all(|(row, _)| *row < 2000));
}

#[test]
fn a_cold_start_converges() {
    let flight = flight(200 * 100);
    let sensor = Gps {
        cold_start: Some(ColdStart { altitude_error_m: 40.0, time_constant_s: 20.0, satellites: 5 }),
        satellites: 15,
        noise: Noise { white: 0.5, ..Noise::default() },
        ..silent_gps(5.0)
    };
    let fixes = gps(&sensor, &flight, &vec![0.0; flight.len()], ROW_RATE, 4);
    for (row, altitude) in series(&fixes, Channel::GpsAltM) {
        let expected = flight[*row].altitude_m + 40.0 * (-flight[*row].time_s / 20.0).exp();
        assert!((altitude - expected).abs() < 3.0, "six sigma: {altitude} {expected}");
    }
    let satellites = series(&fixes, Channel::GpsSats);
    assert_eq!((satellites[0].1, satellites[satellites.len() - 1].1), (5.0, 15.0));
    assert!(satellites.windows(2).all(|pair| pair[0].1 <= pair[1].1));
    let accuracy = series(&fixes, Channel::GpsVaccM);
    assert!(accuracy[0].1 > 40.0 && (accuracy[accuracy.len() - 1].1 - 0.5).abs() < 0.1);
}

#[test]
fn held_and_frozen_fixes_repeat_the_last_one() {
    let flight = flight(200 * 20);
    let none = vec![0.0; flight.len()];
    let held = Gps { hold: true, ..silent_gps(5.0) };
    let fixes = gps(&held, &flight, &none, ROW_RATE, 1);
    let altitudes = series(&fixes, Channel::GpsAltM);
    assert_eq!(altitudes.len(), flight.len());
    for (row, altitude) in altitudes {
        assert_eq!(altitude.to_bits(), flight[row - row % 40].altitude_m.to_bits());
    }

    let frozen =
        Gps { freezes: vec![Interval { start_s: 5.0, duration_s: 3.0 }], fix_time: false, ..silent_gps(5.0) };
    let fixes = gps(&frozen, &flight, &none, ROW_RATE, 1);
    assert!(fixes.iter().all(|(channel, _)| *channel != Channel::GpsTimeS));
    for (row, altitude) in series(&fixes, Channel::GpsAltM) {
        let source = if (1000..1600).contains(row) { 960 } else { *row };
        assert_eq!(altitude.to_bits(), flight[source].altitude_m.to_bits());
    }
}

#[test]
fn smoothing_is_a_first_order_low_pass() {
    let mut flight = flight(200 * 40);
    for sample in &mut flight {
        sample.altitude_m = if sample.time_s < 20.0 { 100.0 } else { 110.0 };
    }
    let sensor = Gps { smoothing_s: 3.0, ..silent_gps(5.0) };
    let fixes = gps(&sensor, &flight, &vec![0.0; flight.len()], ROW_RATE, 1);
    for (row, altitude) in series(&fixes, Channel::GpsAltM) {
        // The step is first seen by the fix at 20 s, one interval (0.2 s) of filtering after the last old
        // one.
        let since = flight[*row].time_s - 19.8;
        let expected = if since < 0.1 { 100.0 } else { 110.0 - 10.0 * (-since / 3.0).exp() };
        assert!((altitude - expected).abs() < 1e-9, "{row}: {altitude} {expected}");
    }
}

#[test]
fn inertial_samples_have_bias_noise_vibration_and_resolution() {
    let mut flight = flight(200 * 200);
    for sample in &mut flight {
        sample.vibration_mps2 = if sample.captive { 0.0 } else { 1.5 };
        sample.specific_force_mps2 = [0.0; 3];
        sample.rate_radps = [0.0; 3];
    }
    let sensor = Inertial {
        sampling: silent(200.0),
        accel_noise: Noise { white: 0.2, ..Noise::default() },
        accel_bias_mps2: [0.1, -0.2, 0.3],
        accel_quantum_mps2: 0.0,
        gyro_noise: Noise { white: 0.01, ..Noise::default() },
        gyro_bias_radps: [0.02, 0.0, -0.01],
        gyro_quantum_radps: 0.001,
    };
    let readings = inertial(&sensor, &flight, ROW_RATE, 1);
    let half = flight.len() / 2;
    for (axis, bias) in [0.1, -0.2, 0.3].into_iter().enumerate() {
        let values: Vec<f64> = readings[axis].1.iter().map(|(_, value)| *value).collect();
        for (part, expected) in [(&values[..half], 0.04), (&values[half..], 0.04 + 2.25)] {
            let n = part.len();
            let mean = part.iter().sum::<f64>() / n as f64;
            assert!((mean - bias).abs() < 5.0 * (expected / n as f64).sqrt(), "{axis} {mean}");
            assert!((variance(part) / expected - 1.0).abs() < chi_square_bound(n), "{axis}");
        }
    }
    for (axis, bias) in [0.02, 0.0, -0.01].into_iter().enumerate() {
        let values: Vec<f64> = readings[3 + axis].1.iter().map(|(_, value)| *value).collect();
        let n = values.len();
        let mean = values.iter().sum::<f64>() / n as f64;
        assert!((mean - bias).abs() < 5.0 * 0.01 / (n as f64).sqrt());
        // White noise and the uniform rounding error add (q = sigma / 10).
        let expected = 1e-4 + 1e-6 / 12.0;
        assert!((variance(&values) / expected - 1.0).abs() < chi_square_bound(n));
        assert!(values.iter().all(|v| ((v / 0.001) - (v / 0.001).round()).abs() < 1e-9));
    }
}

#[test]
fn air_data_and_attitude_are_the_truth_with_noise() {
    let flight = flight(200 * 200);
    let sensor = AirData { sampling: silent(50.0), ..AirData::default() };
    let readings = air_data(&sensor, &flight, ROW_RATE, 1);
    let error: Vec<f64> = series(&readings, Channel::TasMps)
        .iter()
        .map(|(row, value)| value - flight[*row].airspeed_mps)
        .collect();
    assert_eq!(error.len(), 10_000);
    assert!((variance(&error) / 0.09 - 1.0).abs() < chi_square_bound(error.len()));
    let sensor = super::super::scenario::AttitudeSensor { sampling: silent(50.0), sigma_rad: 0.0 };
    let readings = attitude(&sensor, &flight, ROW_RATE, 1);
    for (channel, expected) in
        [(Channel::RollRad, 0.1), (Channel::PitchRad, 0.2), (Channel::YawRad, 0.3), (Channel::Throttle, 0.5)]
    {
        assert!(series(&readings, channel).iter().all(|(_, value)| *value == expected));
    }
}
