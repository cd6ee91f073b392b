//! Flights through the firmware in the emulated flight computer: every tick has the host's bits, and errors
//! planted on either side are found.
//!
//! Needs qemu-system-arm and the Rust target; without them the tests fail and say what to install
//! (`cargo xtask test` installs it).
#![allow(clippy::unwrap_used)]

mod ticks;

use std::path::Path;

use kf_core::effect::EffectId;
use kf_core::input::TickInput;
use model::Model;
use pylon::fly::{FlyError, FlyOptions, FlyReport, PlantedError, fly_inputs};
use pylon::replay::Replay;
use pylon::simulate::{load_scenario, simulate};

use ticks::{LAUNCH, TICK_US, TICKS, flight, must, prompt};

fn fly(inputs: &[TickInput], model: &Model, options: FlyOptions) -> Result<FlyReport, FlyError> {
    fly_inputs(inputs.iter().copied(), model, &options)
}

fn effects(estimate: bool) -> Model {
    let effect = format!(
        "[[effect]]\nid = \"{}\"\ncoefficient = 0.01\nsigma = 0.05\nestimate = {estimate}\n",
        EffectId::BaroDynamicPressure.name()
    );
    Model::parse(&effect).unwrap()
}

/// Effects of every family, on sensors and on the reference: four as states, eight as constants. Together
/// they have every kind of regressor (products, time constants, sine, single and double integrals).
fn many_effects(propagate_climb_rate: bool) -> Model {
    let mut text = format!("gps.propagate_climb_rate = {propagate_climb_rate}\n");
    for id in ["baro.dynamic_pressure", "baro.lag", "gps.lever_arm", "imu.vibration"] {
        text += &format!("[[effect]]\nid = \"{id}\"\nsigma = 0.05\nestimate = true\nenvelope_m = [-5, 5]\n");
    }
    for (id, coefficient, more) in [
        ("imu.tilt", 0.01, ""),
        ("imu.gyro_bias", 0.001, ""),
        ("imu.accel_scale", 0.01, "envelope_m = [0, 1]"),
        ("imu.eotvos", 1.0, ""),
        ("baro.warm_up", 3.0, "time_constant_s = 9\nsince = \"start\""),
        ("gps.convergence", 2.0, "time_constant_s = 4\nsince = \"start\""),
        ("gps.latency", 0.1, ""),
        ("baro.acceleration", 0.5, ""),
    ] {
        text += &format!("[[effect]]\nid = \"{id}\"\ncoefficient = {coefficient}\n{more}\n");
    }
    Model::parse(&text).unwrap()
}

#[test]
fn every_tick_has_the_hosts_bits_with_four_effects_as_states_and_eight_as_constants() {
    for propagate_climb_rate in [false, true] {
        let model = prompt(many_effects(propagate_climb_rate));
        let mut host = pylon::replay::mission(&model).unwrap();
        let mut extrapolated = 0;
        for input in flight() {
            let output = host.tick(&input);
            extrapolated |= output.extrapolated;
            assert_eq!(output.coefficients.len(), 4);
        }
        let report = must(fly(&flight(), &model, FlyOptions::default()));
        assert_eq!(report.ticks as usize, TICKS);
        // No signal was missing, and every effect contributed: with coefficients of zero the bits would be
        // equal too.
        assert_eq!(host.counters().effects_without_signal, 0);
        assert_eq!(report.latch.as_ref(), host.latch());
        assert_eq!(report.latch.as_ref().unwrap().state.len(), 8);
        // The dynamic pressure leaves its envelope of 5 m at once, the lag at launch, and so does the
        // vertical integral.
        assert_eq!(extrapolated & 0b11, 0b11, "{extrapolated:b}");
        assert_eq!(extrapolated >> 10 & 1, 1, "{extrapolated:b}");
        assert!(report.instructions_mean < 8_000.0, "{report:?}");
    }
}

#[test]
fn every_tick_has_the_hosts_bits_for_every_shape_of_the_filter() {
    for model in [Model::default(), Model::paper(), effects(true), effects(false)] {
        let report = must(fly(&flight(), &prompt(model), FlyOptions::default()));
        assert_eq!(report.ticks as usize, TICKS);
        let latch = report.latch.as_ref().unwrap();
        assert_eq!(latch.time_us, 1_000_000 + LAUNCH as u64 * TICK_US);
        // The record's readings must have been used, or equal bits would mean nothing.
        assert!(latch.sensors.iter().all(|sensor| sensor.readings > 800), "{latch:?}");
        let slave = latch.sensors[1];
        assert!((slave.bias_m + 72.9).abs() < 4.0 * slave.bias_variance_m2.sqrt(), "{latch:?}");
        assert!(report.instructions_mean > 100.0 && report.instructions_worst < 100_000, "{report:?}");
        assert!(f64::from(report.instructions_worst) >= report.instructions_mean);
        assert!(report.stack_used_bytes > 0 && report.stack_used_bytes < report.stack_size_bytes);
        assert!(report.log.iter().any(|line| line.contains("latched at")), "{:?}", report.log);
        assert_eq!((report.underruns, report.stalls), (0, 0));
    }
}

#[test]
fn the_same_flight_takes_the_same_instructions() {
    let fly = || must(fly(&flight(), &prompt(Model::default()), FlyOptions::default()));
    // The start time of a tick is not the flight computer's work: in one run of ten QEMU 7.2 takes the
    // timer's interrupt some fifty instructions later, for an unknown reason. The budget bounds it.
    let but_for_starts = |report| FlyReport { start_jitter: 0, ..report };
    assert_eq!(but_for_starts(fly()), but_for_starts(fly()));
}

#[test]
fn a_simulated_flight_has_the_hosts_bits_with_both_presets() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../flights/paper-reconstruction.toml");
    let scenario = load_scenario(&file).unwrap();
    let (flight, _) = simulate(&scenario, scenario.seed).unwrap();
    for model in [Model::default(), Model::paper()] {
        let replay = Replay::new(&flight, &model, None).unwrap();
        let report = must(pylon::fly::fly(&replay, &FlyOptions::default()));
        assert_eq!(report.ticks as usize, flight.rows());
        assert!(report.latch.is_some());
        assert_eq!(report.latch, replay.run(&mut |_, _| ()).unwrap().latch);
    }
}

#[test]
fn a_flight_computer_without_time_waits_and_loses_nothing() {
    let options = FlyOptions { target_error: Some(PlantedError::Starve), ..FlyOptions::default() };
    let report = must(fly(&flight(), &prompt(Model::default()), options));
    assert_eq!(report.ticks as usize, TICKS);
    assert!(report.underruns > 100 && report.stalls > 100, "{report:?}");
}

#[test]
fn one_unit_in_the_last_place_on_the_target_is_found() {
    let options = FlyOptions { target_error: Some(PlantedError::Ulp), ..FlyOptions::default() };
    let error = fly(&flight(), &prompt(Model::default()), options).unwrap_err();
    let FlyError::Differs(difference) = &error else { panic!("{error}") };
    assert_eq!(difference.field, "input.baro", "{error}");
    assert!(difference.tick < TICKS as u64 / 10 && difference.ticks_that_differ > 100, "{error}");
}

#[test]
fn one_unit_in_the_last_place_on_the_host_is_found() {
    let options = FlyOptions { host_ulp_error: true, ..FlyOptions::default() };
    let error = fly(&flight(), &prompt(Model::default()), options).unwrap_err();
    let FlyError::Differs(difference) = &error else { panic!("{error}") };
    assert_eq!(difference.field, "input.baro", "{error}");
    assert_eq!(error.to_string().lines().count(), 1);
}

#[test]
fn a_panic_and_a_fault_restart_the_flight_computer_and_say_so() {
    for (planted, word) in [(PlantedError::Panic, "panic"), (PlantedError::Fault, "fault")] {
        let options = FlyOptions { target_error: Some(planted), ..FlyOptions::default() };
        let error = fly(&flight()[..100], &prompt(Model::default()), options).unwrap_err();
        let FlyError::Restarted(cause) = &error else { panic!("{error}") };
        assert!(cause.contains(word), "{cause}");
    }
}
