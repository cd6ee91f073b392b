//! `pylon diagnose` on simulated flights: a hidden effect is found, and without one nothing is found.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::path::Path;

use common::program::{refusal, stdout};
use model::Model;
use pylon::diagnose::{Diagnosis, NamedReplay, Verdict, diagnose};
use pylon::flight::Flight;
use pylon::replay::Replay;
use pylon::simulate::{Scenario, load_scenario, simulate};

fn scenario(name: &str) -> Scenario {
    load_scenario(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../flights").join(name)).unwrap()
}

fn named<'a>(flight: &'a Flight, model: &Model) -> NamedReplay<'a> {
    NamedReplay::new("flight".to_owned(), Replay::new(flight, model, None).unwrap())
}

fn diagnosed(scenario: &Scenario, seed: u64, model: &Model) -> Diagnosis {
    let (flight, _) = simulate(scenario, seed).unwrap();
    diagnose(&[named(&flight, model)], &[], &mut || ())
}

#[test]
fn a_hidden_static_port_error_is_identified_with_its_coefficient() {
    let diagnosis = diagnosed(&scenario("quickstart.toml"), 7, &Model::default());
    assert_eq!(diagnosis.verdict, Verdict::Identified);
    let baro = &diagnosis.sensors["baro"];
    assert_eq!(baro.missing, ["baro.dynamic_pressure"]);
    let found = &baro.candidates[0];
    assert!(found.chosen && found.p_value < 1e-6, "{found:?}");
    // The scenario's 0.06; four sigma once in 16,000.
    assert!((found.coefficient - 0.06).abs() < 4.0 * found.sigma, "{found:?}");
    assert!(found.rms_after_m.unwrap() < 0.7 * found.rms_before_m.unwrap(), "{found:?}");
    assert_eq!(diagnosis.sensors["imu_slave"].verdict, Verdict::NoSignificantMisfit);
}

#[test]
fn a_flight_without_effects_has_no_significant_misfit() {
    for seed in [1, 2, 3] {
        let diagnosis = diagnosed(&scenario("clean.toml"), seed, &Model::default());
        assert_eq!(diagnosis.verdict, Verdict::NoSignificantMisfit, "{diagnosis:?}");
        assert!(diagnosis.sensors.values().all(|sensor| sensor.missing.is_empty()));
    }
}

#[test]
fn what_the_model_has_already_is_not_found_again() {
    let model = Model::parse(
        "[[effect]]\nid = \"baro.dynamic_pressure\"\ncoefficient = 0.06\nsigma = 0.002\nestimate = false\n",
    )
    .unwrap();
    let diagnosis = diagnosed(&scenario("quickstart.toml"), 7, &model);
    assert_eq!(diagnosis.verdict, Verdict::NoSignificantMisfit, "{diagnosis:?}");
}

#[test]
fn an_error_that_all_sensors_share_is_the_receivers() {
    let mut scenario = scenario("clean.toml");
    scenario.effect = vec![pylon::simulate::scenario::Effect {
        id: pylon::simulate::scenario::EffectId::GpsLatency,
        coefficient: 0.8,
        phase: pylon::simulate::scenario::InjectionPhase::Both,
        time_constant_s: None,
        width_m: None,
    }];
    let diagnosis = diagnosed(&scenario, 5, &Model::default());
    assert_eq!(diagnosis.sensors["gps"].missing, ["gps.latency"], "{diagnosis:?}");
    assert!(diagnosis.sensors["baro"].missing.is_empty());
    // With only one sensor, the sign shows whose delay it is: a barometer is never early.
    let (mut flight, _) = simulate(&scenario, 5).unwrap();
    flight.channels.retain(|(channel, _)| !channel.name().starts_with("imu_"));
    let diagnosis = diagnose(&[named(&flight, &Model::default())], &[], &mut || ());
    assert_eq!(diagnosis.missing().collect::<Vec<_>>(), ["gps.latency"], "{diagnosis:?}");
}

/// A flight whose barometer drifts by this much, m/s, under the pylon too, and nothing else is wrong with it.
fn drifting(coefficient: f64) -> Diagnosis {
    let mut scenario = scenario("hidden-static-port.toml");
    scenario.effect = vec![pylon::simulate::scenario::Effect {
        id: pylon::simulate::scenario::EffectId::BaroDrift,
        coefficient,
        phase: pylon::simulate::scenario::InjectionPhase::Both,
        time_constant_s: None,
        width_m: None,
    }];
    diagnosed(&scenario, 11, &Model::default())
}

/// A warming up of 800 s since the flight's start fits better than the catalogue's drift, which begins at
/// launch; but no other of its time constants does.
#[test]
fn a_drift_is_not_taken_for_a_warming_up() {
    for coefficient in [0.018, 0.022] {
        let diagnosis = drifting(coefficient);
        assert_eq!(diagnosis.missing().count(), 0, "{diagnosis:?}");
        assert!(diagnosis.suspects().any(|suspect| suspect == "baro.drift"), "{diagnosis:?}");
    }
}

/// A drift of a metre that is too weak to be named is perhaps there. Because the reference wanders, the other
/// sensor seems to drift the other way, but not beside the drift.
#[test]
fn a_weak_drift_is_perhaps_there_on_its_own_sensor_only() {
    let diagnosis = drifting(0.010);
    let baro: Vec<_> = diagnosis.sensors["baro"].sets().collect();
    let [set] = baro.as_slice() else { panic!("{baro:?}") };
    assert!(set.effects.iter().any(|effect| effect == "baro.drift"), "{set:?}");
    assert!(set.nothing.is_some_and(|nothing| (0.05..0.5).contains(&nothing)), "{set:?}");
    assert_eq!(diagnosis.sensors["imu_slave"].verdict, Verdict::NoSignificantMisfit);
}

#[test]
fn a_second_flight_is_held_out_and_never_the_one_learned_from() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/../../flights/quickstart.toml");
    for (name, seed) in [("a.csv", "1"), ("b.csv", "2")] {
        stdout(directory, &["simulate", scenario, "-o", name, "--seed", seed]);
    }
    let json = stdout(directory, &["diagnose", "a.csv", "--hold-out", "b.csv", "--json"]);
    // The JSON is read back to the last digit.
    let read: Diagnosis = serde_json::from_str(&json).unwrap();
    assert_eq!(read.version, Diagnosis::VERSION);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(serde_json::to_value(&read).unwrap(), json);
    assert_eq!(json["verdict"], "identified");
    assert_eq!(json["sensors"]["baro"]["missing"][0], "baro.dynamic_pressure");
    let found = &json["sensors"]["baro"]["candidates"][0];
    for key in ["effect", "coefficient", "sigma", "unit", "p_value", "rms_before_m", "rms_after_m"] {
        assert!(!found[key].is_null(), "{key}: {found}");
    }
    let text = stdout(directory, &["diagnose", "a.csv"]);
    assert!(text.contains("The model lacks baro.dynamic_pressure."), "{text}");

    let refused = refusal(directory, &["diagnose", "a.csv", "--hold-out", "./a.csv"]);
    assert!(refused.contains("a.csv: is already used for learning or held out"), "{refused}");
    assert!(refusal(directory, &["diagnose", "a.csv", "a.csv"]).contains("a.csv: given twice"));
}

#[test]
fn a_flight_without_launch_and_without_a_quiet_stretch_is_diagnosed_as_it_is() {
    let (mut flight, _) = simulate(&scenario("quickstart.toml"), 7).unwrap();
    flight.channels.retain(|(channel, _)| channel.name() != "launch");
    let model = Model::default();
    let replay = Replay::uncalibrated(&flight, &model, None).unwrap();
    let diagnosis = diagnose(&[NamedReplay::new("flight".to_owned(), replay)], &[], &mut || ());
    assert_eq!(diagnosis.sensors["baro"].missing, ["baro.dynamic_pressure"], "{diagnosis:?}");
}
