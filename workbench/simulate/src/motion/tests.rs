use core::f64::consts::TAU;

use super::super::random::{Random, Stream};
use super::super::rotation::{Attitude, Vector, minus, norm};
use super::super::scenario::{Scenario, Turbulence};
use super::super::{atmosphere::GRAVITY, motion::gusts::Gusts};
use super::*;

fn scenario(text: &str) -> Scenario {
    Scenario::from_toml(text, "test.toml").unwrap()
}

/// Every manoeuvre, in calm air with a sheared wind.
const ALL_MANOEUVRES: &str = r#"
    name = "all manoeuvres"
    [captive]
    duration_s = 30
    altitude_m = 1500
    airspeed_mps = 28
    heading_deg = 70
    phugoid_amplitude_m = 3
    phugoid_period_s = 20
    [wind]
    north_mps = 4
    east_mps = -3
    shear_north_per_s = 0.003
    [[free_flight]]
    manoeuvre = "dive"
    duration_s = 8
    flight_path_deg = -30
    [[free_flight]]
    manoeuvre = "level_off"
    duration_s = 6
    [[free_flight]]
    manoeuvre = "pull_up"
    duration_s = 4
    flight_path_deg = 25
    load_factor = 3
    [[free_flight]]
    manoeuvre = "turn"
    duration_s = 10
    bank_deg = -45
    [[free_flight]]
    manoeuvre = "climb"
    duration_s = 5
    flight_path_deg = 5
    [[free_flight]]
    manoeuvre = "accelerate"
    duration_s = 8
    airspeed_mps = 40
    [[free_flight]]
    manoeuvre = "decelerate"
    duration_s = 8
    airspeed_mps = 26
    [[free_flight]]
    manoeuvre = "straight"
    duration_s = 3
"#;

const TURBULENCE: &str = "[turbulence]\nhorizontal_sigma_mps = 1\nvertical_sigma_mps = 0.7\n";

/// Hamilton product.
fn product([a, b, c, d]: [f64; 4], [w, x, y, z]: [f64; 4]) -> [f64; 4] {
    [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]
}

/// Strapdown navigation from inertial samples alone: mid-point rotation vectors, trapezoids. Returns the
/// largest error of attitude (rad), velocity (m/s) and position (m).
fn strapdown_errors(flight: &[TruthSample]) -> [f64; 3] {
    let first = flight[0];
    let mut attitude = first.attitude;
    let mut velocity: Vector = first.velocity_mps;
    let mut position: Vector = [first.position_m[0], first.position_m[1], -first.altitude_m];
    let mut worst = [0.0_f64; 3];
    for pair in flight.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        let dt = b.time_s - a.time_s;
        let turn = [0, 1, 2].map(|i| 0.5 * dt * (a.rate_radps[i] + b.rate_radps[i]));
        let angle = norm(turn);
        let half = if angle > 0.0 { (0.5 * angle).sin() / angle } else { 0.5 };
        let step = [(0.5 * angle).cos(), turn[0] * half, turn[1] * half, turn[2] * half];
        let next_attitude = product(attitude, step);
        let before = Attitude(attitude).to_ned(a.specific_force_mps2);
        let after = Attitude(next_attitude).to_ned(b.specific_force_mps2);
        let last_velocity = velocity;
        for axis in 0..3 {
            let gravity = if axis == 2 { GRAVITY } else { 0.0 };
            velocity[axis] += dt * (0.5 * (before[axis] + after[axis]) + gravity);
            position[axis] += 0.5 * dt * (last_velocity[axis] + velocity[axis]);
        }
        attitude = next_attitude;

        let conjugate = [b.attitude[0], -b.attitude[1], -b.attitude[2], -b.attitude[3]];
        let error = product(conjugate, attitude);
        let truth = [b.position_m[0], b.position_m[1], -b.altitude_m];
        for (worst, error) in worst.iter_mut().zip([
            2.0 * norm([error[1], error[2], error[3]]),
            norm(minus(velocity, b.velocity_mps)),
            norm(minus(position, truth)),
        ]) {
            *worst = worst.max(error);
        }
    }
    worst
}

#[test]
fn inertial_samples_integrate_back_to_the_motion() {
    // The navigator's own error is of second order in the step; any error left as the step shrinks would be
    // an inconsistency of the simulated motion. So halving the step must quarter the error, in each phase
    // (the specific force jumps at release, where the airframe changes).
    let errors = |rate: f64, captive: bool| {
        let mut scenario = scenario(ALL_MANOEUVRES);
        scenario.rate_hz = rate;
        let flight = fly(&scenario, 1).unwrap();
        let phase: Vec<TruthSample> = flight.into_iter().filter(|s| s.captive == captive).collect();
        strapdown_errors(&phase)
    };
    for captive in [true, false] {
        let (coarse, fine) = (errors(200.0, captive), errors(400.0, captive));
        for (coarse, fine) in coarse.into_iter().zip(fine) {
            let ratio = fine / coarse;
            assert!((0.2..0.3).contains(&ratio), "captive {captive}: {coarse} {fine} {ratio}");
        }
    }
}

#[test]
fn inertial_samples_integrate_back_through_turbulence() {
    let flight = fly(&scenario(&format!("{ALL_MANOEUVRES}{TURBULENCE}")), 3).unwrap();
    let free: Vec<TruthSample> = flight.into_iter().filter(|s| !s.captive).collect();
    let [attitude, velocity, position] = strapdown_errors(&free);
    // A trapezoid's error over n steps of a force that jumps in slope by J at each is J dt^2 sqrt(n) / 12:
    // here 500 m/s^3, 1e4 steps, 0.1 m/s; a wrong sign or frame gives tens of metres a second.
    assert!(attitude < 1e-3 && velocity < 1e-1 && position < 1.0, "{attitude} {velocity} {position}");
    // And the rates are rough enough to matter.
    assert!(free.iter().any(|s| (s.load_factor() - 1.0).abs() > 0.2));
}

#[test]
fn flow_angles_and_wind_make_up_the_velocity_over_ground() {
    for sample in fly(&scenario(ALL_MANOEUVRES), 1).unwrap() {
        let (sa, ca) = sample.angle_of_attack_rad.sin_cos();
        let (sb, cb) = sample.sideslip_rad.sin_cos();
        let v = sample.airspeed_mps;
        let air = Attitude::from_euler(sample.euler_rad).to_ned([v * ca * cb, v * sb, v * sa * cb]);
        let wind = [4.0 + 0.003 * (sample.altitude_m - 1500.0), -3.0, 0.0];
        let sum = [0, 1, 2].map(|i| air[i] + wind[i]);
        assert!(norm(minus(sum, sample.velocity_mps)) < 1e-9, "{sample:?}");
    }
}

#[test]
fn without_disturbance_captive_flight_is_trimmed() {
    let flight =
        fly(&scenario("name = \"t\"\n[captive]\nduration_s = 60\naltitude_m = 2100\nairspeed_mps = 28"), 1)
            .unwrap();
    for sample in flight {
        assert!((sample.altitude_m - 2100.0).abs() < 0.05, "{sample:?}");
        assert!((sample.airspeed_mps - 28.0).abs() < 1e-2, "{sample:?}");
        assert!((norm(sample.specific_force_mps2) / GRAVITY - 1.0).abs() < 1e-3, "{sample:?}");
        assert!(sample.sideslip_rad.abs() < 1e-12 && sample.captive);
    }
}

#[test]
fn the_phugoid_has_its_amplitude_and_period_and_trades_speed_for_height() {
    let (amplitude, period) = (4.0, 30.0);
    let flight = fly(
        &scenario(
            "name = \"t\"\n[captive]\nduration_s = 120\naltitude_m = 900\nairspeed_mps = 30\n\
             phugoid_amplitude_m = 4\nphugoid_period_s = 30",
        ),
        1,
    )
    .unwrap();
    let wave = |value: &dyn Fn(&TruthSample) -> f64, part: fn(f64) -> f64| {
        let sum: f64 = flight.iter().map(|s| value(s) * part(TAU * s.time_s / period)).sum();
        2.0 * sum / flight.len() as f64
    };
    // The autopilot follows its target with a lag of some hundredths of a period.
    let height = wave(&|s| s.altitude_m, f64::sin);
    assert!((height / amplitude - 1.0).abs() < 0.05, "{height}");
    assert!(wave(&|s| s.altitude_m, f64::cos).abs() < 0.15 * amplitude);
    let speed = wave(&|s| s.airspeed_mps, f64::sin);
    let expected = -GRAVITY * amplitude / 30.0;
    assert!((speed / expected - 1.0).abs() < 0.05, "{speed} {expected}");
}

#[test]
fn manoeuvres_reach_what_they_ask_for() {
    let flight = fly(&scenario(ALL_MANOEUVRES), 1).unwrap();
    let at = |time_s: f64| flight[(time_s * 200.0).round() as usize];
    let path = |s: &TruthSample| (s.climb_rate_mps() / s.airspeed_mps).asin().to_degrees();
    // Ends of the segments: dive at 38 s, level-off 44, pull-up 48, turn 58, climb 63, accelerate 71,
    // decelerate 79.
    assert!((path(&at(37.9)) + 30.0).abs() < 1.0, "{}", path(&at(37.9)));
    assert!(path(&at(43.9)).abs() < 1.0, "{}", path(&at(43.9)));
    let hardest = (44 * 200..46 * 200).map(|row| flight[row].load_factor()).fold(0.0, f64::max);
    assert!((2.0..3.2).contains(&hardest), "{hardest}");
    let turning = at(57.0);
    assert!((turning.euler_rad[0].to_degrees() + 45.0).abs() < 1.0);
    let east_of_north = |s: &TruthSample| s.euler_rad[2];
    let yaw_rate = (east_of_north(&at(57.0)) - east_of_north(&at(56.0)) + TAU).rem_euclid(TAU) - TAU;
    assert!(yaw_rate < 0.0, "a left turn turns left: {yaw_rate}");
    assert!((at(70.9).airspeed_mps - 40.0).abs() < 1.5, "{}", at(70.9).airspeed_mps);
    assert!(at(78.9).airspeed_mps < 33.0, "{}", at(78.9).airspeed_mps);
}

#[test]
fn a_level_turn_has_the_load_factor_and_yaw_rate_of_the_books() {
    let text = "name = \"t\"\n[captive]\nduration_s = 1\naltitude_m = 900\nairspeed_mps = 30\n[[free_flight]]\n\
                manoeuvre = \"turn\"\nduration_s = 40\nbank_deg = 50\nairspeed_mps = 30";
    let flight = fly(&scenario(text), 1).unwrap();
    let last = flight[flight.len() - 1];
    let bank = 50.0_f64.to_radians();
    assert!((last.load_factor() * bank.cos() - 1.0).abs() < 0.02, "{}", last.load_factor());
    let earlier = flight[flight.len() - 1 - 200];
    let turned = (last.euler_rad[2] - earlier.euler_rad[2]).rem_euclid(TAU);
    let expected = GRAVITY * bank.tan() / last.airspeed_mps;
    assert!((turned / expected - 1.0).abs() < 0.02, "{turned} {expected}");
    assert!(last.sideslip_rad.abs() < 0.02);
}

#[test]
fn what_cannot_be_flown_is_said() {
    let dive = "name = \"t\"\n[captive]\nduration_s = 1\naltitude_m = 100\nairspeed_mps = 28\n[[free_flight]]\n\
                manoeuvre = \"dive\"\nduration_s = 20\nflight_path_deg = -40\n";
    let error = fly(&scenario(dive), 1).unwrap_err();
    assert!(matches!(error, MotionError::Ground { .. }), "{error}");
    let slow = "name = \"t\"\n[captive]\nduration_s = 9\naltitude_m = 100\nairspeed_mps = 8\n";
    let error = fly(&scenario(slow), 1).unwrap_err();
    assert!(matches!(error, MotionError::Envelope { .. }), "{error}");
    assert!(!error.to_string().contains('\n'));
}

#[test]
fn gusts_have_their_spread_and_length() {
    let turbulence = Turbulence { horizontal_sigma_mps: 2.0, vertical_sigma_mps: 0.5, length_m: 100.0 };
    let mut random = Random::new(5, Stream::Turbulence);
    let mut gusts = Gusts::new(turbulence);
    let (dt, airspeed, rows) = (0.25, 40.0, 100_000);
    let series: Vec<Vector> = (0..rows).map(|_| gusts.next(&mut random, airspeed, dt)).collect();
    let rho: f64 = (-dt * airspeed / 100.0_f64).exp();
    for (axis, sigma) in [2.0, 2.0, 0.5].into_iter().enumerate() {
        let n = rows as f64;
        let variance = series.iter().map(|g| g[axis] * g[axis]).sum::<f64>() / n;
        let lagged = series.windows(2).map(|p| p[0][axis] * p[1][axis]).sum::<f64>() / n;
        // Bartlett's formula for the sample variance of a first-order process; five sigma.
        let bound = 5.0 * (2.0 / n * (1.0 + rho * rho) / (1.0 - rho * rho)).sqrt();
        assert!((variance / (sigma * sigma) - 1.0).abs() < bound);
        assert!((lagged / (sigma * sigma) - rho).abs() < 2.0_f64.sqrt() * bound);
    }
}
