use super::super::atmosphere::pressure_altitude_m;
use super::super::motion::{TruthSample, fly};
use super::super::record::{Effects, readings};
use super::super::scenario::Scenario;
use super::*;
use flight_data::Channel;

/// A rough flight with every signal in motion; sensors without any error of their own.
const PLAN: &str = include_str!("../../plans/rough.toml");
const HEAD: &str = r#"
    name = "effects"
    latitude_deg = 60
    [vehicle]
    vibration_mps2 = 2
"#;
const SENSORS: &str = r#"
    [sensors.gps]
    sampling = { rate_hz = 200 }
    noise = {}
    quantum_m = 0
    [sensors.baro]
    sampling = { rate_hz = 200 }
    noise = {}
    quantum_pa = 0
    carrier_flow = {}
    [sensors.imu_slave]
    sampling = { rate_hz = 200 }
    noise = {}
    quantum_m = 0
    carrier_flow = {}
"#;

/// The same flight with these effects.
fn flight(effects: &str) -> String {
    [HEAD, PLAN, SENSORS, effects].concat()
}

const RELEASE: usize = 20 * 200;
const DT: f64 = 1.0 / 200.0;

/// The error of a clean sensor with these effects injected, a value for each row; and the truth.
fn added(channel: Channel, effects: &str) -> (Vec<f64>, Vec<TruthSample>) {
    let read = |text: &str| {
        let scenario = Scenario::from_toml(text, "t").unwrap();
        let truth = fly(&scenario, 5).unwrap();
        let effects = Effects::of(&scenario, &truth);
        let series = readings(&scenario, &truth, &effects, 5)
            .into_iter()
            .find_map(|(name, series)| (name == channel).then_some(series))
            .unwrap();
        let metres = |value: f64| {
            if channel == Channel::BaroPa { pressure_altitude_m(value) } else { value }
        };
        (series.into_iter().map(|(_, value)| metres(value)).collect::<Vec<f64>>(), truth)
    };
    let (clean, truth) = read(&flight(""));
    let (dirty, _) = read(&flight(effects));
    assert_eq!((clean.len(), dirty.len()), (truth.len(), truth.len()));
    (dirty.iter().zip(clean).map(|(dirty, clean)| dirty - clean).collect(), truth)
}

fn injection(id: &str, coefficient: f64, more: &str) -> String {
    format!("[[effect]]\nid = \"{id}\"\ncoefficient = {coefficient}\n{more}\n")
}

/// Rounding of the readings: of altitudes of some thousand metres, and for the barometer of the conversion to
/// pressure and back.
const ROUNDING_M: f64 = 1e-8;

fn assert_adds(channel: Channel, id: &str, more: &str, regressor: impl Fn(&[TruthSample], usize) -> f64) {
    let coefficient = -0.37;
    let (added, truth) = added(channel, &injection(id, coefficient, more));
    let mut largest = 0.0_f64;
    for (row, added) in added.iter().enumerate() {
        let expected = coefficient * regressor(&truth, row);
        assert!((added - expected).abs() < ROUNDING_M, "{id} row {row}: {added} {expected}");
        largest = largest.max(expected.abs());
    }
    // The effect is large compared with rounding.
    assert!(largest > 1e3 * ROUNDING_M, "{id}: {largest}");
}

#[test]
fn barometer_effects_add_coefficient_times_regressor() {
    let head = |v: f64| v * v / 19.613_3;
    let baro = Channel::BaroPa;
    let both = |id, formula: &dyn Fn(&TruthSample) -> f64| {
        assert_adds(baro, id, "", |truth, row| formula(&truth[row]));
    };
    both("baro.dynamic_pressure", &|s| head(s.airspeed_mps));
    both("baro.angle_of_attack", &|s| s.angle_of_attack_rad * head(s.airspeed_mps));
    both("baro.sideslip", &|s| s.sideslip_rad.powi(2) * head(s.airspeed_mps));
    both("baro.lag", &|s| s.velocity_mps[2]);
    both("baro.acceleration", &|s| -s.specific_force_mps2[2] / 9.806_65 - 1.0);
    both("baro.propwash", &|s| s.throttle.powi(2));
    both("baro.drift", &|s| s.time_s);
    assert_adds(baro, "baro.warm_up", "time_constant_s = 12", |t, row| 1.0 - (-t[row].time_s / 12.0).exp());
    assert_adds(baro, "baro.carrier_field", "", |truth, row| {
        if row < RELEASE { 0.0 } else { head(truth[RELEASE].airspeed_mps) }
    });
    assert_adds(baro, "baro.scale", "", |t, row| t[row].altitude_m - t[0].altitude_m);
    assert_adds(baro, "baro.temperature", "", |t, row| t[row].baro_temperature_c - t[0].baro_temperature_c);
}

#[test]
fn hysteresis_lags_the_altitude_by_its_width() {
    // Ten metres up, ten down, half a metre a row, with a play of two metres in either direction.
    let (_, mut truth) = added(Channel::BaroPa, &injection("baro.drift", 1.0, ""));
    truth.truncate(41);
    for (row, sample) in truth.iter_mut().enumerate() {
        let row = row as f64;
        sample.altitude_m = 500.0 + 0.5 * if row <= 20.0 { row } else { 40.0 - row };
    }
    let effect = Effect {
        id: EffectId::BaroHysteresis,
        coefficient: 1.0,
        phase: InjectionPhase::Both,
        time_constant_s: None,
        width_m: Some(2.0),
    };
    for (row, value) in regressor(&effect, &truth, 0.0).into_iter().enumerate() {
        let row = row as f64;
        // Low by up to the width on the way up; then, within twice the width on the way down, high by the
        // width.
        let expected =
            if row <= 20.0 { (-0.25 * row).max(-1.0) } else { (0.25 * (row - 20.0) - 1.0).min(1.0) };
        assert!((value - expected).abs() < 1e-12, "{row}: {value} {expected}");
    }
}

#[test]
fn reference_effects_add_coefficient_times_regressor() {
    let gps = Channel::GpsAltM;
    // Latency: a receiver late by tau reads h - tau hdot.
    assert_adds(gps, "gps.latency", "", |t, row| t[row].velocity_mps[2]);
    assert_adds(gps, "gps.lever_arm", "", |t, row| t[row].euler_rad[1].sin());
    assert_adds(gps, "gps.convergence", "time_constant_s = 9", |t, row| (-t[row].time_s / 9.0).exp());
}

#[test]
fn the_latency_effect_is_the_first_order_of_a_late_receiver() {
    let late = flight("").replace(
        "[sensors.gps]\n    sampling = { rate_hz = 200 }",
        "[sensors.gps]\n    sampling = { rate_hz = 200, latency_s = 0.05 }",
    );
    let scenario = Scenario::from_toml(&late, "t").unwrap();
    let truth = fly(&scenario, 5).unwrap();
    let none = Effects::of(&scenario, &truth);
    let readings = readings(&scenario, &truth, &none, 5);
    let (_, fixes) = readings.iter().find(|(name, _)| *name == Channel::GpsAltM).unwrap();
    let (effect, _) = added(Channel::GpsAltM, &injection("gps.latency", 0.05, ""));
    let hardest = truth.iter().map(|s| s.acceleration_mps2()[2].abs()).fold(0.0, f64::max);
    for (row, altitude) in fixes {
        let late = altitude - truth[*row].altitude_m;
        // Taylor's remainder.
        assert!((late - effect[*row]).abs() <= 0.5 * hardest * 0.05 * 0.05 + ROUNDING_M);
    }
}

#[test]
fn inertial_effects_that_grow_with_time_start_at_release() {
    let imu = Channel::ImuSlaveAltM;
    let t = |truth: &[TruthSample], row: usize| (truth[row].time_s - 20.0).max(0.0);
    assert_adds(imu, "imu.velocity_error", "phase = \"free\"", |truth, row| t(truth, row));
    assert_adds(imu, "imu.accel_bias", "phase = \"free\"", |truth, row| 0.5 * t(truth, row).powi(2));
}

/// Double trapezoidal integral, from release on.
fn twice_integrated(truth: &[TruthSample], input: impl Fn(&TruthSample) -> f64) -> Vec<f64> {
    let (mut rate, mut value) = (0.0, 0.0);
    let mut integral = vec![0.0; RELEASE + 1];
    for pair in truth[RELEASE..].windows(2) {
        let next = rate + 0.5 * DT * (input(&pair[0]) + input(&pair[1]));
        value += 0.5 * DT * (rate + next);
        rate = next;
        integral.push(value);
    }
    integral
}

/// Largest difference of two integration rules: at most one sixth of the input's jumps, summed, times dt^2,
/// and half a step of the integral's slope. Both shrink with the step; here they are far below a percent.
const INTEGRATION: f64 = 2e-3;

fn assert_integrates(id: &str, input: impl Fn(&TruthSample) -> f64) {
    let coefficient = 3.0;
    let (added, truth) = added(Channel::ImuSlaveAltM, &injection(id, coefficient, "phase = \"free\""));
    let expected = twice_integrated(&truth, input);
    let largest = expected.iter().fold(0.0_f64, |worst, value| worst.max(value.abs()));
    assert!(coefficient * largest > 1e3 * ROUNDING_M, "{id}");
    for (row, (added, expected)) in added.iter().zip(expected).enumerate() {
        let difference = (added - coefficient * expected).abs();
        assert!(difference < coefficient * largest * INTEGRATION, "{id} row {row}: {added} {expected}");
    }
}

#[test]
fn inertial_effects_integrate_their_cause_twice() {
    assert_integrates("imu.accel_scale", |s| -s.acceleration_mps2()[2]);
    assert_integrates("imu.tilt", |s| {
        let [north, east, _] = s.acceleration_mps2();
        north * s.euler_rad[2].cos() + east * s.euler_rad[2].sin()
    });
    assert_integrates("imu.gyro_bias", |s| {
        let [north, east, _] = s.acceleration_mps2();
        (north * s.euler_rad[2].cos() + east * s.euler_rad[2].sin()) * (s.time_s - 20.0)
    });
    // Three axes of 2 m/s^2 at full throttle.
    assert_integrates("imu.vibration", |s| 12.0 * s.throttle * s.throttle);
    let (_, truth) = added(Channel::ImuSlaveAltM, &injection("imu.velocity_error", 1.0, ""));
    let h0 = truth[0].altitude_m;
    assert_integrates("imu.gravity_gradient", |s| 3.086e-6 * (s.altitude_m - h0));
    // cos(60 deg) = 1/2.
    assert_integrates("imu.eotvos", |s| {
        let [north, east, _] = s.velocity_mps;
        7.292_115e-5 * east + (north * north + east * east) / 6.371e6
    });
}

#[test]
fn the_double_integral_is_exact_for_what_is_linear_between_rows() {
    let mut integral = DoubleIntegral::default();
    for row in 0..100 {
        let t = 0.3 * f64::from(row);
        let value = integral.next(t, 2.0 - 0.7 * t);
        let expected = t * t - 0.7 * t.powi(3) / 6.0;
        assert!((value - expected).abs() < 1e-9, "{row}: {value} {expected}");
    }
}

#[test]
fn an_accelerometers_scale_error_shows_as_the_height_that_was_gained() {
    // The double integral of upward acceleration is height minus what the first climb rate would have given:
    // a closed form that needs no integration.
    let (added, truth) = added(Channel::ImuSlaveAltM, &injection("imu.accel_scale", 1.0, "phase = \"free\""));
    let release = truth[RELEASE];
    for (row, added) in added.iter().enumerate().skip(RELEASE) {
        let t = truth[row].time_s - release.time_s;
        let expected = truth[row].altitude_m - release.altitude_m - release.climb_rate_mps() * t;
        // Piecewise-linear acceleration: a few centimetres in half a minute of rough air.
        assert!((added - expected).abs() < 0.05, "{row}: {added} {expected}");
    }
}

#[test]
fn phases_bound_an_effect_and_its_clock() {
    let baro = Channel::BaroPa;
    let (captive, truth) = added(baro, &injection("baro.drift", 1.0, "phase = \"captive\""));
    let (free, _) = added(baro, &injection("baro.drift", 1.0, "phase = \"free\""));
    let (both, _) = added(baro, &injection("baro.drift", 1.0, "phase = \"both\""));
    for (row, sample) in truth.iter().enumerate() {
        let near = |value: f64, expected: f64| (value - expected).abs() < ROUNDING_M;
        assert!(near(both[row], sample.time_s));
        if row < RELEASE {
            assert!(near(captive[row], sample.time_s) && near(free[row], 0.0));
        } else {
            assert!(near(captive[row], 0.0) && near(free[row], sample.time_s - 20.0));
        }
    }
}

#[test]
fn effects_of_one_sensor_add_up() {
    let first = injection("baro.lag", 0.4, "");
    let second = injection("baro.dynamic_pressure", 0.05, "phase = \"free\"");
    let (one, _) = added(Channel::BaroPa, &first);
    let (two, _) = added(Channel::BaroPa, &second);
    let (sum, _) = added(Channel::BaroPa, &format!("{first}{second}"));
    for ((one, two), sum) in one.iter().zip(two).zip(sum) {
        assert!((one + two - sum).abs() < 2.0 * ROUNDING_M);
    }
}

#[test]
fn every_effect_acts_on_one_sensor_only() {
    for id in EffectId::ALL {
        let more = match id {
            EffectId::BaroWarmUp | EffectId::GpsConvergence => "time_constant_s = 5",
            EffectId::BaroHysteresis => "width_m = 1",
            _ => "",
        };
        let text = injection(id.name(), 1.0, more);
        for (channel, sensor) in
            [(Channel::BaroPa, "baro."), (Channel::ImuSlaveAltM, "imu."), (Channel::GpsAltM, "gps.")]
        {
            let (added, _) = added(channel, &text);
            let seen = added.iter().any(|added| added.abs() > ROUNDING_M);
            assert_eq!(seen, id.name().starts_with(sensor), "{} on {sensor}", id.name());
        }
    }
}
