//! `pylon add` and `pylon ladder` on simulated flights.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::path::Path;

use common::program::{files, pylon, refusal, run, stdout};
use kf_core::effect::EffectId;
use model::Model;
use pylon::diagnose::{NamedReplay, WantedEffect, study};
use pylon::flight::Flight;
use pylon::learn::{learn, score};
use pylon::replay::Replay;
use pylon::simulate::{Scenario, load_scenario, scenario, simulate};
use serde_json::Value;

fn quickstart(effects: &[(scenario::EffectId, f64)]) -> Scenario {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../flights/quickstart.toml");
    let mut scenario = load_scenario(&file).unwrap();
    scenario.effect = effects
        .iter()
        .map(|(id, coefficient)| scenario::Effect {
            id: *id,
            coefficient: *coefficient,
            phase: scenario::InjectionPhase::Both,
            time_constant_s: None,
            width_m: None,
        })
        .collect();
    scenario
}

fn named<'a>(flights: &'a [Flight], model: &Model) -> Vec<NamedReplay<'a>> {
    let named = |flight| NamedReplay::new("flight".to_owned(), Replay::new(flight, model, None).unwrap());
    flights.iter().map(named).collect()
}

const fn wanted(effect: EffectId) -> WantedEffect {
    WantedEffect { effect, time_constant_s: None, since: None }
}

/// The core's filter in single precision and the diagnosis' normal equations in double precision compute the
/// same estimate: they agree to a small fraction of its sigma, whatever other effects act, and over several
/// flights.
#[test]
fn the_cores_filter_learns_what_the_diagnosis_estimates() {
    use scenario::EffectId as Injected;
    let pressure = (Injected::BaroDynamicPressure, 0.06);
    type Case<'a> = (&'a [(Injected, f64)], EffectId, &'a [u64], &'a str);
    let cases: [Case<'_>; 5] = [
        (&[pressure], EffectId::BaroDynamicPressure, &[1], ""),
        (&[pressure], EffectId::BaroDynamicPressure, &[1, 2], ""),
        (&[pressure, (Injected::ImuAccelBias, 0.004)], EffectId::ImuAccelBias, &[3], ""),
        (&[(Injected::GpsLatency, 0.8)], EffectId::GpsLatency, &[4], ""),
        // The model already has the first effect with some sigma, and it is learned again together with the
        // second.
        (
            &[pressure, (Injected::BaroLag, 0.9)],
            EffectId::BaroLag,
            &[5],
            "[[effect]]\nid = \"baro.dynamic_pressure\"\ncoefficient = 0.05\nsigma = 0.02\n",
        ),
    ];
    for (effects, effect, seeds, model) in cases {
        let scenario = quickstart(effects);
        let flights: Vec<Flight> = seeds.iter().map(|seed| simulate(&scenario, *seed).unwrap().0).collect();
        let model = Model::parse(model).unwrap();
        let (_, problem) = study(&named(&flights, &model), &[], wanted(effect), &mut || ());
        let problem = problem.unwrap();
        let learned = learn(&problem).unwrap();
        let facts = &problem.facts;
        // Single precision, and a prior that is wide but not infinite.
        let apart = (learned.coefficient - facts.coefficient).abs();
        assert!(apart < 0.03 * learned.filter_sigma, "{}: {learned:?} {facts:?}", effect.name());
        assert!((learned.sigma / facts.sigma - 1.0).abs() < 0.03, "{learned:?} {facts:?}");
        let (_, truth) = effects.iter().find(|(id, _)| id.name() == effect.name()).unwrap();
        assert!((learned.coefficient - truth).abs() < 4.0 * learned.sigma, "{truth} {learned:?}");
    }
}

/// A time constant is refined between the values of the diagnosis' grid, while another effect acts. The
/// refined values are a tenth or an eighth apart: one of the two nearest is found, whereas the grid's own, 30
/// and 90 s, are half as large again or more.
#[test]
fn a_time_constant_is_refined_beside_what_else_acts() {
    use scenario::EffectId as Injected;
    let mut scenario = quickstart(&[(Injected::BaroWarmUp, 30.0), (Injected::BaroDynamicPressure, 0.1)]);
    for (time_constant_s, seed) in [(47.0, 1), (60.0, 2)] {
        scenario.effect[0].time_constant_s = Some(time_constant_s);
        let flights = [simulate(&scenario, seed).unwrap().0];
        let (_, problem) =
            study(&named(&flights, &Model::default()), &[], wanted(EffectId::BaroWarmUp), &mut || ());
        let problem = problem.unwrap();
        let effects: Vec<_> = problem.terms.iter().map(|term| term.regressor.id).collect();
        assert_eq!(effects, [EffectId::BaroWarmUp, EffectId::BaroDynamicPressure]);
        let found_s = problem.terms[0].regressor.time_constant_s;
        assert!(
            (found_s / time_constant_s as f32).ln().abs() < 1.125_f32.ln(),
            "{found_s} {time_constant_s}"
        );
        let learned = learn(&problem).unwrap();
        assert!((learned.coefficient - 30.0).abs() < 4.0 * learned.sigma, "{learned:?}");
    }
}

/// Without an airspeed the filter and the diagnosis both estimate the wind's share of it, separately for each
/// flight.
#[test]
fn the_cores_filter_knows_the_wind() {
    let scenario = quickstart(&[(scenario::EffectId::BaroDynamicPressure, 0.12)]);
    let mut other = scenario.clone();
    (other.wind.north_mps, other.wind.east_mps) = (-6.0, 1.0);
    let mut flights = [simulate(&scenario, 1).unwrap().0, simulate(&other, 2).unwrap().0];
    for flight in &mut flights {
        flight.channels.retain(|(channel, _)| channel.name() != "tas_mps");
    }
    let model = Model::default();
    let (_, problem) =
        study(&named(&flights, &model), &[], wanted(EffectId::BaroDynamicPressure), &mut || ());
    let problem = problem.unwrap();
    assert!(problem.wind.is_some());
    let learned = learn(&problem).unwrap();
    let apart = (learned.coefficient - problem.facts.coefficient).abs();
    assert!(apart < 0.03 * learned.filter_sigma, "{learned:?} {:?}", problem.facts);
    assert!((learned.coefficient - 0.12).abs() < 4.0 * learned.sigma, "{learned:?}");
}

#[test]
fn an_effect_without_movement_or_signal_has_no_lesson() {
    let (mut flight, _) = simulate(&quickstart(&[]), 1).unwrap();
    flight.channels.retain(|(channel, _)| channel.name() != "throttle");
    let (diagnosis, problem) =
        study(&named(&[flight], &Model::default()), &[], wanted(EffectId::BaroPropwash), &mut || ());
    assert!(problem.is_none());
    assert!(diagnosis.untested.iter().any(|untested| untested.effect == "baro.propwash"));
}

/// A score equals that part of a comparison.
#[test]
fn a_score_is_what_a_comparison_says() {
    let (flight, _) = simulate(&quickstart(&[(scenario::EffectId::BaroDynamicPressure, 0.2)]), 1).unwrap();
    let replay = Replay::new(&flight, &Model::default(), None).unwrap();
    let scores = score(&replay).unwrap();
    let (comparison, _) =
        pylon::compare::compare(&replay, &pylon::compare::Options::default(), &mut |_| ()).unwrap();
    assert_eq!(scores.len(), comparison.sensors.len());
    assert!(scores["baro"].untrustworthy_after_s.is_some());
    for (name, score) in &scores {
        let compared = &comparison.sensors[name];
        let pairs = [
            (score.captive_rms_m, compared.captive_rms_m),
            (score.free_flight_rms_m, compared.free_flight_rms_m),
            (score.doubtful_after_s, compared.doubtful_after_s),
            (score.untrustworthy_after_s, compared.untrustworthy_after_s),
        ];
        for (ours, theirs) in pairs {
            assert_eq!(ours.is_some(), theirs.is_some(), "{name}");
            assert!(
                (ours.unwrap_or(0.0) - theirs.unwrap_or(0.0)).abs() < 1e-6,
                "{name}: {ours:?} {theirs:?}"
            );
        }
    }
}

const SCENARIO: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../flights/quickstart.toml");

/// Two simulated flights with a hidden effect.
fn two_flights() -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    for (name, seed) in [("a.csv", "1"), ("b.csv", "2")] {
        stdout(directory.path(), &["simulate", SCENARIO, "-o", name, "--seed", seed]);
    }
    directory
}

const ADD: [&str; 6] = ["add", "baro.dynamic_pressure", "--model", "ours.toml", "--from", "a.csv"];

#[test]
fn an_effect_is_learned_written_and_laddered() {
    let directory = two_flights();
    let directory = directory.path();
    let before = "# our aircraft\n[monitor]\nmultiplier = 2.5   # strict\n# the end\n";
    fs::write(directory.join("ours.toml"), before).unwrap();
    let output = pylon(directory)
        .args(ADD)
        .args(["--hold-out", "b.csv", "--json"])
        .env("SOURCE_DATE_EPOCH", "1700000000")
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["effect"], "baro.dynamic_pressure");
    let number = |key: &str| json[key].as_f64().unwrap();
    assert!((number("coefficient") - 0.06).abs() < 4.0 * number("sigma"), "{json}");
    assert!(number("rms_after_m") < 0.7 * number("rms_before_m"), "{json}");
    assert_eq!((&json["judged_on"], &json["concerns"]), (&"held_out_flights".into(), &Value::Array(vec![])));

    let text = fs::read_to_string(directory.join("ours.toml")).unwrap();
    assert!(text.starts_with(before), "{text}");
    let model = Model::parse(&text).unwrap();
    let (effect, revision) = (&model.effects[0], &model.revisions[0]);
    // The JSON has the decimal that was written to the file.
    assert_eq!(effect.term.coefficient, number("coefficient") as f32);
    assert_eq!((effect.estimate, effect.learned_from.as_deref()), (false, Some("a.csv")));
    assert_eq!(effect.date.as_deref(), Some("2023-11-14"));
    assert_eq!((revision.number, revision.coefficient), (1, Some(effect.term.coefficient)));
    assert!((revision.held_out_after_m.unwrap() - number("rms_after_m")).abs() < 1e-4);
    assert_eq!(revision.date.as_deref(), Some("2023-11-14"));

    // All uses on the flight that it was learned from lie within the envelope.
    let compared = |flight: &str| -> Value {
        let json = stdout(directory, &["compare", flight, "--model", "ours.toml", "--json"]);
        serde_json::from_str(&json).unwrap()
    };
    assert_eq!(compared("a.csv")["effects"][0]["extrapolated_ticks"], 0);

    // Learned again, now as a state: the old coefficient is kept, and the file has one effect and two
    // revisions.
    let again = stdout(directory, &[ADD.as_slice(), &["--estimate"]].concat());
    assert!(again.contains("replaces the model's earlier value"), "{again}");
    assert!(again.contains("revision 2") && again.contains("Held-out manoeuvres"), "{again}");
    let model = Model::read(&directory.join("ours.toml")).unwrap();
    assert_eq!((model.effects.len(), model.revisions.len()), (1, 2));
    assert!(model.effects[0].estimate);
    assert_eq!(model.revisions[1].replaced_coefficient, model.revisions[0].coefficient);

    let ladder = stdout(directory, &["ladder", "--model", "ours.toml", "a.csv", "b.csv", "--json"]);
    let ladder: Value = serde_json::from_str(&ladder).unwrap();
    let revisions = ladder["revisions"].as_array().unwrap();
    assert_eq!(revisions.len(), 3);
    let rms = |revision: usize, flight: usize| {
        revisions[revision]["flights"][flight]["sensors"]["baro"]["free_flight_rms_m"].as_f64().unwrap()
    };
    // Its values are those measured when the revisions were made.
    assert!((rms(0, 1) - number("rms_before_m")).abs() < 1e-9);
    assert!((rms(1, 1) - number("rms_after_m")).abs() < 1e-9);
    assert!(rms(0, 0) > rms(1, 0));
    assert_eq!((&revisions[0]["effects"], &revisions[1]["number"]), (&Value::Array(vec![]), &1.into()));
    let text = stdout(directory, &["ladder", "--model", "ours.toml", "a.csv"]);
    assert!(text.contains("untrustworthy") && text.contains("baro.dynamic_pressure"), "{text}");
}

#[test]
fn a_preset_is_never_changed_and_starts_a_file_of_ones_own() {
    let directory = two_flights();
    let directory = directory.path();
    let from = |model: &'static str| ["add", "baro.dynamic_pressure", "--model", model, "--from", "a.csv"];
    let refused = refusal(directory, &from("default"));
    assert!(refused.contains("default is a preset") && refused.contains("-o ours.toml"), "{refused}");
    let refused = refusal(directory, &from("ours.toml"));
    assert!(
        refused.contains("ours.toml: cannot be read") && refused.contains("touch ours.toml"),
        "{refused}"
    );
    stdout(directory, &[from("default").as_slice(), &["-o", "ours.toml"]].concat());
    assert_eq!(Model::read(&directory.join("ours.toml")).unwrap().effects.len(), 1);
    let refused = refusal(directory, &[from("default").as_slice(), &["-o", "ours.toml"]].concat());
    assert!(refused.contains("already exists"), "{refused}");
    // Written to another file, so the model is unchanged.
    let before = fs::read(directory.join("ours.toml")).unwrap();
    stdout(directory, &[from("ours.toml").as_slice(), &["-o", "next.toml"]].concat());
    assert_eq!(fs::read(directory.join("ours.toml")).unwrap(), before);
    assert_eq!(Model::read(&directory.join("next.toml")).unwrap().revisions.len(), 2);
}

#[test]
fn what_speaks_against_an_effect_is_said_and_nothing_is_written_without_force() {
    let directory = two_flights();
    let directory = directory.path();
    let model = "# ours\n";
    fs::write(directory.join("ours.toml"), model).unwrap();
    let names = files(directory);
    let add = |effect: &'static str, more: &[&'static str]| {
        [&["add", effect, "--model", "ours.toml", "--from", "a.csv"], more].concat()
    };
    let refused = refusal(directory, &add("baro.lag", &[]));
    assert!(refused.contains("within 3 sigma") && refused.contains("--force"), "{refused}");
    let refused = refusal(directory, &add("baro.lag", &["--hold-out", "./a.csv"]));
    assert!(refused.contains("a.csv: is already used for learning"), "{refused}");
    let refused = refusal(directory, &add("baro.dynamicpressure", &[]));
    assert!(refused.contains("nearest: baro.dynamic_pressure"), "{refused}");
    let refused = refusal(directory, &add("baro.lag", &["--time-constant", "3"]));
    assert!(refused.contains("baro.lag has no time constant"), "{refused}");
    for bad in ["0", "-1", "nan", "x"] {
        let refused = refusal(directory, &[add("baro.warm_up", &[]), vec!["--time-constant", bad]].concat());
        assert!(refused.contains("expected"), "{refused}");
    }
    let output = pylon(directory).args(ADD).env("SOURCE_DATE_EPOCH", "soon").output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("SOURCE_DATE_EPOCH is 'soon'"));
    assert_eq!(fs::read_to_string(directory.join("ours.toml")).unwrap(), model);
    assert_eq!(files(directory), names);

    let forced = run(directory, &add("baro.lag", &["--force", "--json"]));
    assert!(forced.status.success(), "{}", String::from_utf8_lossy(&forced.stderr));
    let json: Value = serde_json::from_slice(&forced.stdout).unwrap();
    assert!(!json["concerns"].as_array().unwrap().is_empty());
    assert!(fs::read_to_string(directory.join("ours.toml")).unwrap().starts_with("# ours\n\n[[effect]]\n"));

    // Two revisions with the same number: both rows are named, and the file is unchanged.
    let clash = "[[revision]]\nnumber = 3\n[[revision]]\nnumber = 3\n";
    fs::write(directory.join("ours.toml"), clash).unwrap();
    let refused = refusal(directory, &ADD);
    assert!(refused.contains("row 4") && refused.contains("row 2"), "{refused}");
    assert_eq!(fs::read_to_string(directory.join("ours.toml")).unwrap(), clash);
    let refused = refusal(directory, &["ladder", "--model", "ours.toml", "a.csv"]);
    assert!(refused.contains("clashes"), "{refused}");
}

/// A flight of six minutes at 10 Hz that climbs and dives within seconds, launched after a minute, whose
/// barometer stands behind a tube: a low pass of three seconds, with noise of a few decimetres.
fn behind_a_tube(seed: u64) -> String {
    use rand::SeedableRng as _;
    use rand_distr::{Distribution as _, Normal};

    const TUBE_S: f64 = 3.0;
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let white = Normal::new(0.0, 0.3).unwrap();
    let mut csv =
        "# pylon-flight: 1\ntime_s,launch,gps_alt_m,gps_vn_mps,gps_ve_mps,gps_vd_mps,baro_alt_m,imu_slave_alt_m\n".to_owned();
    let (mut altitude_m, mut late_m) = (500.0_f64, 500.0_f64);
    for k in 0..3600_u32 {
        let t = f64::from(k) * 0.1;
        // Level under the carrier; then pull-ups of 9 s and dives of other lengths.
        let climb_mps =
            if t < 60.0 { 0.3 * (t / 7.0).sin() } else { 8.0 * (t / 1.5).sin() * (t / 23.0).sin() };
        altitude_m += 0.1 * climb_mps;
        late_m += 0.1 / TUBE_S * (altitude_m - late_m);
        let mut noise = || white.sample(&mut random);
        csv += &format!(
            "{t:.1},{},{:.3},25,0,{:.3},{:.3},{:.3}\n",
            u8::from(t >= 60.0),
            altitude_m + noise(),
            -climb_mps + 0.1 * noise(),
            late_m + 3.0 + noise(),
            altitude_m + noise()
        );
    }
    csv
}

/// Manoeuvres as short as the tube's lag: the climb rate itself explains little of it, so a model with the
/// catalogue's lag removes little. What is added is a low pass of that size, which removes the error on a
/// flight that it was not learned from too; added again, it stays the one effect, and the model lacks no
/// more.
#[test]
fn a_lag_behind_a_tube_is_added_as_a_low_pass() {
    let folder = tempfile::tempdir().unwrap();
    for (name, seed) in [("first.csv", 1), ("next.csv", 2)] {
        fs::write(folder.path().join(name), behind_a_tube(seed)).unwrap();
    }
    fs::write(folder.path().join("ours.toml"), "").unwrap();
    let run = |arguments: &[&str]| {
        let output = pylon(folder.path()).args(arguments).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let text = run(&["diagnose", "first.csv", "--model", "ours.toml"]);
    assert!(text.contains("pylon add baro.lag"), "{text}");
    let add = [
        "add",
        "baro.lag",
        "--model",
        "ours.toml",
        "--from",
        "first.csv",
        "--hold-out",
        "next.csv",
        "--json",
    ];
    let added: Value = serde_json::from_str(&run(&add)).unwrap();
    assert_eq!(added["effect"], "baro.low_pass_lag", "{added}");
    assert_eq!(added["instead_of"], "baro.lag");
    let number = |key: &str| added[key].as_f64().unwrap();
    assert!((number("coefficient") - 3.0).abs() < 4.0 * number("sigma"), "{added}");
    // The catalogue's lag leaves more than half of the error here, and the noise is a twentieth of it.
    let on = |flights: &str, when: &str| {
        added[flights][0]["sensors"]["baro"][when]["free_flight_rms_m"].as_f64().unwrap()
    };
    for flights in ["learning", "held_out"] {
        assert!(on(flights, "after") < 0.25 * on(flights, "before"), "{added}");
    }
    let again = ["add", "baro.low_pass_lag", "--model", "ours.toml", "--from", "first.csv"];
    let regressors = || {
        let model = Model::parse(&fs::read_to_string(folder.path().join("ours.toml")).unwrap()).unwrap();
        let of = |effect: &model::Effect| (effect.term.id().name(), effect.term.regressor.time_constant_s);
        model.effects.iter().map(of).collect::<Vec<_>>()
    };
    run(&[&again[..], &["--time-constant", "2.0"]].concat());
    assert_eq!(regressors(), [("baro.low_pass_lag", 2.0)]);
    run(&again);
    let [("baro.low_pass_lag", time_constant_s)] = regressors()[..] else { panic!("{:?}", regressors()) };
    assert!((time_constant_s - 3.0).abs() < 0.5, "{time_constant_s}");
    let text = run(&["diagnose", "next.csv", "--model", "ours.toml"]);
    assert!(!text.contains("pylon add"), "{text}");
    // A user's own formula under that id is an effect like any other, and is not overwritten.
    let own = "[[effect_definition]]\nid = \"baro.low_pass_lag\"\non = \"baro\"\nregressor = \"-lowpass(climb_rate_mps, 3[s])\"\n\
               unit = \"s\"\nplausible = [0.0, 5.0]\n";
    fs::write(folder.path().join("own.toml"), own).unwrap();
    let text = run(&["diagnose", "first.csv", "--model", "own.toml"]);
    assert!(text.contains("baro.low_pass_lag"), "{text}");
    let arguments = ["add", "baro.lag", "--model", "own.toml", "--from", "first.csv"];
    let refused = pylon(folder.path()).args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(
        !refused.status.success() && said.contains("another formula") && said.contains("another id"),
        "{said}"
    );
    assert_eq!(fs::read_to_string(folder.path().join("own.toml")).unwrap(), own);
}

#[test]
fn a_flight_that_lacks_a_signal_is_told_which() {
    let directory = two_flights();
    let directory = directory.path();
    fs::write(directory.join("ours.toml"), "").unwrap();
    let text = fs::read_to_string(directory.join("a.csv")).unwrap();
    fs::write(directory.join("a.csv"), text.replace("sideslip_rad", "beta_rad")).unwrap();
    let refused = refusal(directory, &["add", "baro.sideslip", "--model", "ours.toml", "--from", "a.csv"]);
    assert!(refused.contains("a.csv: baro.sideslip can't be learned"), "{refused}");
    assert!(refused.contains("no sideslip_rad"), "{refused}");
    assert_eq!(fs::read_to_string(directory.join("ours.toml")).unwrap(), "");
}
