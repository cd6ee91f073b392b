//! Effects on sensors and on the reference, constant and estimated, captive and free.

use super::*;
use crate::effect::{Clock, Regressor};

const BARO: usize = 2;

/// Adds to the altitude of the tick's fix.
fn add_to_fix(input: &mut TickInput, metres: f32) {
    if let Some(fix) = &mut input.gps {
        fix.altitude_m += metres;
    }
}

/// Adds to the barometer's altitude.
fn add_to_baro(input: &mut TickInput, metres: f32) {
    if let Some(BaroReading::AltitudeM(altitude_m)) = input.baro {
        input.baro = Some(BaroReading::AltitudeM(altitude_m + metres));
    }
}

fn with_constant(term: EffectTerm) -> MissionConfig<0> {
    let mut config = config(true);
    config.constant_effects.push(term).unwrap();
    config
}

/// The latched biases, and the moving average of the barometer's error at the end.
fn outcome(config: &MissionConfig<0>, change: impl FnMut(u64, &mut TickInput)) -> ([f32; 3], f32) {
    let mut last = None;
    let mission =
        fly::<0, 4, 0>(config, change, |_, output| last = output.sensors[BARO].moving_average_m.or(last));
    (mission.latch().unwrap().sensors.map(|sensor| sensor.bias_m), last.unwrap())
}

#[test]
fn a_constant_effect_on_the_reference_is_taken_off_its_fixes() {
    // A cold start: 20 m that decay over 25 s from power-on.
    let converging =
        |k: u64, input: &mut TickInput| add_to_fix(input, 20.0 * (-(k as f32) * 0.005 / 25.0).exp());
    let id = EffectId::GpsConvergence;
    let regressor = Regressor { id, time_constant_s: 25.0, since: Clock::Start };
    let known = with_constant(EffectTerm { regressor, ..EffectTerm::new(id, 20.0, 1.0) });
    let healthy = outcome(&config(true), |_, _| {});
    let corrected = outcome(&known, converging);
    let uncorrected = outcome(&config(true), converging);
    for sensor in 0..3 {
        // Rounding of altitudes of 2,000 m, averaged.
        assert!((corrected.0[sensor] - healthy.0[sensor]).abs() < 1e-2, "{corrected:?} {healthy:?}");
        assert!((uncorrected.0[sensor] - healthy.0[sensor]).abs() > 3.0, "{uncorrected:?}");
    }
    assert!((corrected.1 - healthy.1).abs() < 1e-2, "{corrected:?} {healthy:?}");
    assert!((uncorrected.1 - healthy.1).abs() > 3.0, "{uncorrected:?}");
}

/// Pitch that oscillates by 0.3 rad, and an antenna 6 m ahead.
fn swinging(k: u64, input: &mut TickInput) {
    let pitch_rad = 0.3 * (k as f32 * 0.005).sin() + if k < 6_000 { 0.0 } else { 0.5 };
    input.signals.attitude_rad = Some([0.0, pitch_rad, 0.0]);
    add_to_fix(input, 6.0 * pitch_rad.sin());
}

fn learns_a_lever_arm<const HEAD: usize, const TAIL: usize>(climb_rate: bool) {
    let mut config = config::<1>(climb_rate);
    config.estimated_effects = [EffectTerm::new(EffectId::GpsLeverArm, 0.0, 10.0)];
    let mut latched = None;
    let mut last = None;
    let mission = fly::<HEAD, TAIL, 1>(&config, swinging, |k, output| {
        if k >= 6_000 {
            let coefficient = output.coefficients[0];
            assert_eq!(*latched.get_or_insert(coefficient), coefficient, "tick {k}");
        }
        last = output.sensors[BARO].moving_average_m.or(last);
    });
    let learned = latched.unwrap();
    let sigma = learned.variance.sqrt();
    // 140 fixes of 2 m, a regressor of 0.21 rms: 2 / (0.21 sqrt(140)) = 0.8 m, less what the sensors
    // contribute.
    assert!((learned.coefficient - 6.0).abs() < 4.0 * sigma && (0.3..1.2).contains(&sigma), "{learned:?}");
    // In free flight 6 sin(0.5) = 2.9 m of it would show.
    let sigma_of_average = 0.5 * sigma + 0.7;
    assert!(last.unwrap().abs() < 4.0 * sigma_of_average, "{last:?}");
    assert_eq!(mission.latch().unwrap().state[4], learned.coefficient);
}

#[test]
fn an_effect_on_the_reference_is_learned_from_its_fixes_and_held_after_launch() {
    learns_a_lever_arm::<3, 2>(false);
    learns_a_lever_arm::<0, 5>(true);
}

#[test]
fn the_latched_coefficient_of_an_effect_on_the_reference_corrects_free_flight() {
    // Known from the start to a centimetre: then the average is as good as in a healthy flight.
    let mut known = config::<1>(true);
    known.estimated_effects = [EffectTerm::new(EffectId::GpsLeverArm, 6.0, 0.01)];
    let mut last = None;
    fly::<0, 5, 1>(&known, swinging, |_, output| last = output.sensors[BARO].moving_average_m.or(last));
    let healthy = outcome(&config(true), |_, _| {});
    assert!((last.unwrap() - healthy.1).abs() < 0.05, "{last:?} {healthy:?}");
}

#[test]
fn what_is_integrated_starts_at_launch() {
    let falling = |k: u64, input: &mut TickInput| {
        let free_s = k.saturating_sub(6_000) as f32 * 0.005;
        if let Some(altitude_m) = &mut input.imu_slave_altitude_m {
            *altitude_m += 0.1 * free_s * free_s;
        }
    };
    let error_end = |config: &MissionConfig<0>| {
        let mut last = None;
        fly::<0, 4, 0>(config, falling, |_, output| last = output.sensors[1].moving_average_m.or(last));
        last.unwrap()
    };
    // 0.1 * 9^2 in the middle of the window.
    assert!((error_end(&config(true)) - 8.1).abs() < 5.0 * 0.7);
    let known = with_constant(EffectTerm::new(EffectId::ImuAccelBias, 0.2, 0.0));
    assert!(error_end(&known).abs() < 5.0 * 0.7);
}

#[test]
fn a_use_outside_of_the_envelope_is_said_and_counted() {
    let faster = |k: u64, input: &mut TickInput| {
        let speed = if k < 6_000 { 60.0 } else { 90.0 };
        input.signals.true_airspeed_mps = Some(speed);
        add_to_baro(input, 0.1 * speed * speed / 19.613_3);
    };
    let term = EffectTerm {
        envelope_m: Some([100.0, 200.0]),
        ..EffectTerm::new(EffectId::BaroDynamicPressure, 0.1, 0.01)
    };
    let mut constant = config::<1>(true);
    constant.constant_effects.push(term).unwrap();
    // No range, no extrapolation; one effect on the other sensor, and one on the reference outside its range.
    constant.estimated_effects =
        [EffectTerm { envelope_m: Some([0.5, 0.9]), ..EffectTerm::new(EffectId::GpsConvergence, 0.0, 1.0) }];
    let mut said = (0, 0);
    let mission = fly::<0, 5, 1>(&constant, faster, |k, output| {
        let baro_is_new = k % 4 == 0;
        let fix_is_new = k % 40 == 0;
        let expected_baro = baro_is_new && k >= 6_000;
        assert_eq!(output.extrapolated >> 8 & 1 == 1, expected_baro, "tick {k}");
        // exp(-t / 60 s) is above 0.9 for the first 6.3 s after launch, and 1 before.
        let expected_fix = fix_is_new && k as f32 * 0.005 < 30.0 + 60.0 * (1.0_f32 / 0.9).ln();
        assert_eq!(output.extrapolated & 1 == 1, expected_fix, "tick {k}");
        assert_eq!(output.extrapolated & !0x101, 0);
        said.0 += u32::from(expected_baro);
        said.1 += u32::from(expected_fix);
    });
    assert_eq!(said.0, 500);
    assert_eq!(mission.counters().effects_extrapolated, said.0 + said.1);
}

#[test]
fn fixes_taken_without_an_effect_are_counted() {
    let known = with_constant(EffectTerm::new(EffectId::GpsLeverArm, 6.0, 0.0));
    let mission = fly::<0, 4, 0>(&known, |_, _| {}, |_, _| {});
    assert_eq!(mission.counters().effects_without_signal, 200);
}

#[test]
fn effects_out_of_range_are_refused() {
    let refuse = |term: EffectTerm| Mission::<0, 4, 0>::new(&with_constant(term)).err();
    let warm_up = |time_constant_s| {
        let id = EffectId::BaroWarmUp;
        let regressor = Regressor { id, time_constant_s, since: Clock::Launch };
        EffectTerm { regressor, ..EffectTerm::new(id, 1.0, 0.0) }
    };
    let within = |envelope_m| EffectTerm {
        envelope_m: Some(envelope_m),
        ..EffectTerm::new(EffectId::BaroLag, 1.0, 0.0)
    };
    assert_eq!(refuse(warm_up(1.0)), None);
    assert_eq!(refuse(within([1.0, 1.0])), None);
    for bad in [warm_up(0.0), warm_up(f32::NAN), within([1.0, 0.0]), within([f32::NAN, 0.0])] {
        assert_eq!(refuse(bad), Some(ConfigError::OutOfRange), "{bad:?}");
    }
    // An unused time constant may have any value.
    let lag = EffectTerm::new(EffectId::BaroLag, 1.0, 0.0);
    let regressor = Regressor { time_constant_s: f32::NAN, ..lag.regressor };
    assert_eq!(refuse(EffectTerm { regressor, ..lag }), None);
    let mut nowhere = config::<0>(true);
    nowhere.latitude_deg = 90.5;
    assert_eq!(Dense::new(&nowhere).err(), Some(ConfigError::OutOfRange));
}
