use std::fs;
use std::path::Path;

use super::*;
use crate::flight::to_writer;

/// The simulator's own test scenario.
const SHORT: &str = include_str!("../../../../workbench/simulate/plans/short.toml");

fn bytes(text: &str, seed: u64) -> Vec<u8> {
    let scenario = Scenario::from_toml(text, "short.toml").unwrap();
    let (flight, _) = simulate(&scenario, seed).unwrap();
    let mut out = Vec::new();
    to_writer(&mut out, &flight).unwrap();
    out
}

fn files(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_run_writes_the_flight_and_the_truth_apart_from_it() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    fs::write(at("short.toml"), SHORT).unwrap();
    let summary = run(&at("short.toml"), &at("flight.csv"), &at("truth.toml")).unwrap();
    assert_eq!((summary.seed, summary.rows, summary.launch_s), (4, 3000, Some(10.0)));
    assert_eq!(fs::read(at("flight.csv")).unwrap(), bytes(SHORT, 4));
    // The flight contains nothing of what was injected; the truth contains all of it.
    let flight = String::from_utf8(fs::read(at("flight.csv")).unwrap()).unwrap();
    assert!(!flight.contains("dynamic_pressure"));
    let truth: toml::Table = fs::read_to_string(at("truth.toml")).unwrap().parse().unwrap();
    assert_eq!(truth["effect"][0]["id"].as_str(), Some("baro.dynamic_pressure"));
    assert_eq!(truth["effect"][0]["coefficient"].as_float(), Some(0.05));
    assert_eq!(truth["sensors"]["baro"]["bias_m"].as_float(), Some(20.0));
    assert_eq!(truth["launch_s"].as_float(), Some(10.0));

    let other = run_with_seed(&at("short.toml"), Some(9), &at("flight.csv"), &at("truth.toml")).unwrap();
    assert_eq!(other.seed, 9);
    assert_eq!(fs::read(at("flight.csv")).unwrap(), bytes(SHORT, 9));
}

#[test]
fn a_run_that_fails_says_why_in_one_line_and_leaves_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    fs::write(at("ground.toml"), SHORT.replace("altitude_m = 800", "altitude_m = 4")).unwrap();
    fs::write(at("typo.toml"), SHORT.replace("bias_m", "bais_m")).unwrap();
    fs::write(at("short.toml"), SHORT).unwrap();
    let before = files(directory.path());
    for (scenario, output, truth, expected) in [
        ("ground.toml", "f.csv", "t.toml", "below sea level at"),
        ("typo.toml", "f.csv", "t.toml", "typo.toml:16: unknown field `bais_m`; did you mean `bias_m`?"),
        ("none.toml", "f.csv", "t.toml", "none.toml: cannot read the scenario: "),
        ("short.toml", "no/f.csv", "t.toml", "no/f.csv: cannot be written: "),
        ("short.toml", "f.csv", "no/t.toml", "no/t.toml: cannot be written: "),
    ] {
        let error = run(&at(scenario), &at(output), &at(truth)).unwrap_err().to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{error}");
        assert_eq!(files(directory.path()), before, "{scenario} {output} {truth}");
    }
}

#[test]
fn bundled_scenarios_fly() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../flights");
    let mut flown = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            let mut scenario = load_scenario(&path).unwrap();
            // An hour's scenario does not change after five minutes.
            scenario.captive.duration_s = scenario.captive.duration_s.min(300.0);
            simulate(&scenario, scenario.seed).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            flown += 1;
        }
    }
    assert!(flown >= 4);
}

#[test]
fn a_missing_file_is_named() {
    let error = load_scenario(Path::new("/nowhere/s.toml")).unwrap_err().to_string();
    assert!(error.starts_with("/nowhere/s.toml: cannot read the scenario: "), "{error}");
}
