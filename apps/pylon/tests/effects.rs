//! The flight computer's regressors against the simulator's own, in double precision, over a simulated
//! flight.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use kf_core::effect::{AccelerationSource, Clock, EffectId, Regressor, SignalTracker};
use kf_core::input::TickInput;
use model::Model;
use pylon::replay::Replay;
use pylon::simulate::scenario::{self, InjectionPhase};
use pylon::simulate::{Scenario, Truth, regressor, simulate};

/// A rough flight with every signal in motion.
const ROUGH: &str = include_str!("../../../workbench/simulate/plans/rough.toml");

/// That flight, with error-free sensors.
fn scenario(rates: [f64; 3], shake: f64) -> Scenario {
    let [fixes_hz, signals_hz, inertial_hz] = rates;
    let text = format!(
        r#"
        name = "regressors"
        latitude_deg = 60
        [vehicle]
        vibration_mps2 = {shake}
        {ROUGH}
        [sensors.gps]
        sampling = {{ rate_hz = {fixes_hz} }}
        noise = {{}}
        velocity_sigma_mps = 0
        quantum_m = 0
        [sensors.baro]
        sampling = {{ rate_hz = {signals_hz} }}
        noise = {{}}
        temperature = {{ sigma_c = 0 }}
        [sensors.inertial]
        sampling = {{ rate_hz = {inertial_hz} }}
        accel_noise = {{}}
        accel_quantum_mps2 = 0
        [sensors.air_data]
        sampling = {{ rate_hz = {signals_hz} }}
        airspeed_sigma_mps = 0
        angle_sigma_rad = 0
        [sensors.attitude]
        sampling = {{ rate_hz = {signals_hz} }}
        sigma_rad = 0
        "#
    );
    Scenario::from_toml(&text, "t").unwrap()
}

const TIME_CONSTANT_S: f32 = 7.0;
const ROW_S: f64 = 0.005;

/// The flight computer's regressor for each row of free flight, and the truth.
fn both(
    scenario: &Scenario,
    id: EffectId,
    change: impl Fn(&mut TickInput),
) -> (Vec<f64>, Vec<f64>, SignalTracker) {
    let (flight, truth) = simulate(scenario, 5).unwrap();
    let replay = Replay::new(&flight, &Model::default(), None).unwrap();
    let latitude_deg = replay.model().latitude_deg;
    assert_eq!(latitude_deg, 60.0);
    let mut tracker = SignalTracker::for_effects([id], latitude_deg);
    let wanted = Regressor { id, time_constant_s: TIME_CONSTANT_S, since: Clock::Launch };
    let (mut ours, mut launched) = (Vec::new(), false);
    tracker.begin_calibration();
    for mut input in replay.inputs() {
        change(&mut input);
        if input.launch && !launched {
            launched = true;
            tracker.begin_free_flight(input.time_us);
        }
        tracker.take(&input, input.gps.as_ref());
        if launched {
            ours.push(f64::from(tracker.regressor_m(wanted).unwrap()));
        }
    }
    (ours, exact(&truth, id), tracker)
}

/// The simulator's regressor of free flight.
fn exact(truth: &Truth, id: EffectId) -> Vec<f64> {
    let twin = scenario::EffectId::ALL.iter().find(|twin| twin.name() == id.name()).unwrap();
    let effect = scenario::Effect {
        id: *twin,
        coefficient: 1.0,
        phase: InjectionPhase::Free,
        time_constant_s: Some(f64::from(TIME_CONSTANT_S)),
        width_m: None,
    };
    let all = regressor(&effect, &truth.trajectory, 60.0);
    let launch = truth.trajectory.iter().position(|sample| !sample.captive).unwrap();
    all[launch..].to_vec()
}

fn span(series: &[f64]) -> f64 {
    let largest = series.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    largest - series.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Our regressor as a multiple of the truth, by least squares together with a constant.
fn slope(ours: &[f64], truth: &[f64]) -> f64 {
    let mean = |series: &[f64]| series.iter().sum::<f64>() / series.len() as f64;
    let (centre, centre_of_truth) = (mean(ours), mean(truth));
    let products = ours.iter().zip(truth).map(|(o, t)| (o - centre) * (t - centre_of_truth)).sum::<f64>();
    products / truth.iter().map(|t| (t - centre_of_truth).powi(2)).sum::<f64>()
}

/// An effect whose regressor is fixed at launch.
const CONSTANT: EffectId = EffectId::BaroCarrierField;

#[test]
fn with_every_signal_in_every_row_the_regressors_are_the_truth() {
    let scenario = scenario([200.0; 3], 0.0);
    for id in EffectId::ALL {
        // The vibration is random, and has its own test.
        if id == EffectId::ImuVibration {
            continue;
        }
        let (ours, truth, _) = both(&scenario, id, |_| {});
        assert_eq!(ours.len(), truth.len());
        let size = truth.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
        let steps = truth.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        let tolerance = match id {
            // A low-pass of 0.05 s: it lags by at most its time constant at the fastest change of load.
            EffectId::BaroAcceleration => 0.05 * steps / ROW_S,
            // V of the last row before launch.
            EffectId::BaroCarrierField => 0.01 * size,
            // Specific force and attitude are in f32, and the simulator's specific force is that at the row's
            // beginning, while its motion is that of the whole row.
            EffectId::ImuAccelScale | EffectId::ImuTilt | EffectId::ImuGyroBias => 2e-3 * size,
            // Altitudes of 1,500 m in f32 have a resolution of 6e-5 m.
            EffectId::BaroScale => 3e-4,
            // Signals in f32, each with 6e-8; time in f32; integrals are a sum of this many steps.
            _ => 1e-5 * size,
        };
        for (row, (ours, truth)) in ours.iter().zip(&truth).enumerate() {
            let apart = (ours - truth).abs();
            assert!(apart <= tolerance, "{} row {row}: {ours} {truth}, tolerance {tolerance}", id.name());
        }
        // The regressor was excited, and has the right size.
        if id != CONSTANT {
            let slope = slope(&ours, &truth);
            assert!(span(&truth) > 3.0 * tolerance && (slope - 1.0).abs() < 0.01, "{}: {slope}", id.name());
        }
    }
}

#[test]
fn with_sensors_at_their_own_rates_the_regressors_are_a_little_late() {
    let scenario = scenario([5.0, 50.0, 200.0], 0.0);
    for id in EffectId::ALL {
        if matches!(id, EffectId::ImuVibration | CONSTANT) {
            continue;
        }
        let (ours, truth, _) = both(&scenario, id, |_| {});
        let is_integrated = id.name().starts_with("imu.");
        // The largest age of a signal, rows: a held fix, a held sample, or the memory of a low-pass.
        let late = match id {
            EffectId::BaroLag | EffectId::GpsLatency => 40,
            EffectId::BaroAcceleration => 100,
            _ => 4,
        };
        let size = span(&truth);
        // A fix is extrapolated over 0.2 s with its climb rate, against accelerations of up to 4 g.
        let tolerance = match id {
            EffectId::BaroScale => 0.5 * 40.0 * 0.2 * 0.2,
            // Between attitude samples the body rates propagate the attitude: little of gravity leaks in.
            _ if is_integrated => 0.02 * size,
            _ => 1e-4 * size,
        };
        for (row, value) in ours.iter().enumerate() {
            let recent = &truth[row.saturating_sub(late)..=row];
            let least = recent.iter().copied().fold(f64::INFINITY, f64::min) - tolerance;
            let largest = recent.iter().copied().fold(f64::NEG_INFINITY, f64::max) + tolerance;
            // The first samples after launch may still be from captive flight.
            assert!(row < late || (least..=largest).contains(value), "{} row {row}: {value}", id.name());
        }
        let slope = slope(&ours, &truth);
        // In gusts the flow angles change from sample to sample.
        assert!((slope - 1.0).abs() < 0.05, "{}: {slope}", id.name());
    }
}

#[test]
fn the_vibration_is_found_under_the_manoeuvres() {
    // 2 m/s^2 on each axis at full throttle: far above what the manoeuvres change from row to row.
    let (ours, truth, _) = both(&scenario([5.0, 50.0, 200.0], 2.0), EffectId::ImuVibration, |_| {});
    let (last, expected) = (ours[ours.len() - 1], truth[truth.len() - 1]);
    // Sum of squared differences of 3 * 4,800 normal numbers: its relative sigma is sqrt(3 / 14,400) = 1.4 %,
    // more since the throttle weights them unequally. The release itself adds one jump.
    assert!((last / expected - 1.0).abs() < 0.08, "{last} {expected}");
}

#[test]
fn without_a_climb_rate_the_altitudes_make_one() {
    for id in [EffectId::BaroLag, EffectId::GpsLatency, EffectId::BaroScale] {
        let (ours, truth, _) = both(&scenario([5.0, 50.0, 200.0], 0.0), id, |input| {
            if let Some(fix) = &mut input.gps {
                fix.velocity_down_mps = None;
            }
        });
        let slope = slope(&ours, &truth);
        // The filter's memory of a second or two smooths the manoeuvres' corners.
        assert!((0.75..1.25).contains(&slope), "{}: {slope}", id.name());
    }
}

#[test]
fn without_specific_force_the_speed_over_ground_makes_the_tilt() {
    for id in [EffectId::ImuTilt, EffectId::ImuGyroBias] {
        let (ours, truth, tracker) = both(&scenario([5.0, 50.0, 200.0], 0.0), id, |input| input.imu = None);
        assert_eq!(tracker.acceleration_source(), Some(AccelerationSource::GroundSpeed));
        // Along the track, not along the heading: they differ by the drift angle and in turns.
        let slope = slope(&ours, &truth);
        assert!((0.7..1.4).contains(&slope), "{}: {slope}", id.name());
    }
}
