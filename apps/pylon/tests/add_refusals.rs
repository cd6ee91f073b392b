//! What `pylon add` refuses, what it writes anyway with `--force`, and what happens to the model file.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs::{self, File};
use std::io::Read as _;
use std::path::Path;

use common::program::{files, refusal, stdout};
use kf_core::effect::Clock;
use model::Model;
use serde_json::Value;
use tempfile::TempDir;

const PLAN: &str = include_str!("../../../flights/clean.toml");
/// The model of every test, with comments that must be kept.
const MODEL: &str = "# ours\nsettling_s = 10   # seconds\n";

/// A folder with `ours.toml` and flights of these names, effects and seeds.
fn folder(flights: &[(&str, &str, u64)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("ours.toml"), MODEL).unwrap();
    for (name, effects, seed) in flights {
        fs::write(folder.path().join("scenario.toml"), format!("{PLAN}\n{effects}")).unwrap();
        let arguments = ["simulate", "scenario.toml", "-o", name, "--seed", &seed.to_string()];
        stdout(folder.path(), &arguments);
    }
    folder
}

fn effect(id: &str, coefficient: f64, more: &str) -> String {
    format!("[[effect]]\nid = \"{id}\"\ncoefficient = {coefficient}\n{more}\n")
}

/// Removes columns from a flight.
fn without_columns(file: &Path, names: &[&str]) {
    let text = fs::read_to_string(file).unwrap();
    let mut dropped: Vec<usize> = Vec::new();
    let lines = text.lines().map(|line| {
        if line.starts_with('#') {
            return line.to_owned();
        }
        let cells: Vec<&str> = line.split(',').collect();
        if dropped.is_empty() {
            dropped = (0..cells.len()).filter(|at| names.contains(&cells[*at])).collect();
        }
        let kept = cells.iter().enumerate().filter(|(at, _)| !dropped.contains(at)).map(|(_, cell)| *cell);
        kept.collect::<Vec<_>>().join(",")
    });
    let text = lines.collect::<Vec<_>>().join("\n") + "\n";
    fs::write(file, text).unwrap();
}

fn add<'a>(effect: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["add", effect, "--model", "ours.toml", "--from", "a.csv"], more].concat()
}

fn json(directory: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&stdout(directory, &[arguments, &["--json"]].concat())).unwrap()
}

fn model_text(directory: &Path) -> String {
    fs::read_to_string(directory.join("ours.toml")).unwrap()
}

#[test]
fn an_effect_that_others_look_like_is_named_with_them_and_needs_force() {
    let folder = folder(&[("a.csv", &effect("baro.acceleration", 8.0, ""), 1)]);
    let directory = folder.path();
    // Lift makes the load factor proportional to angle of attack times dynamic pressure: without the angle
    // the two effects cannot be distinguished.
    without_columns(&directory.join("a.csv"), &["aoa_rad"]);
    let names = files(directory);
    let refused = refusal(directory, &add("baro.acceleration", &[]));
    assert!(refused.contains("they can't distinguish it from baro.angle_of_attack"), "{refused}");
    assert!(refused.contains("nothing was written") && refused.contains("--force"), "{refused}");
    assert_eq!((model_text(directory).as_str(), files(directory)), (MODEL, names));

    let said = stdout(directory, &add("baro.acceleration", &["--force"]));
    assert!(said.contains("written despite this (--force): these flights can't identify it"), "{said}");
    assert!(said.contains("baro.angle_of_attack"), "{said}");
    assert!(model_text(directory).starts_with(MODEL));
    assert_eq!(Model::read(&directory.join("ours.toml")).unwrap().effects.len(), 1);
}

#[test]
fn an_effect_that_another_flight_contradicts_needs_force() {
    let folder = folder(&[
        ("a.csv", &effect("baro.dynamic_pressure", 0.12, ""), 1),
        ("none.csv", "", 2),
        ("opposite.csv", &effect("baro.dynamic_pressure", -0.12, ""), 3),
        // The true cause is another one: the weather of one day.
        ("weather.csv", &effect("baro.drift", 0.2, ""), 4),
    ]);
    let directory = folder.path();
    for held_out in ["none.csv", "opposite.csv"] {
        let refused = refusal(directory, &add("baro.dynamic_pressure", &["--hold-out", held_out]));
        assert!(refused.contains("the held-out flights are less likely with it, beyond chance"), "{refused}");
        assert!(refused.contains("raw rms") && refused.contains("--force"), "{refused}");
        assert_eq!(model_text(directory), MODEL);
    }
    let weather =
        ["add", "baro.drift", "--model", "ours.toml", "--from", "weather.csv", "--hold-out", "none.csv"];
    let refused = refusal(directory, &weather);
    assert!(refused.contains("less likely with it, beyond chance"), "{refused}");
    let forced = add("baro.dynamic_pressure", &["--hold-out", "none.csv", "--force"]);
    let found = json(directory, &forced);
    let verdict = &found["held_out_verdict"];
    assert_eq!((&verdict["is_worse"], &verdict["can_tell"]), (&Value::Bool(true), &Value::Bool(true)));
    assert!(verdict["gain"].as_f64().unwrap() < -1.645 * verdict["gain_sigma"].as_f64().unwrap());
    // The raw errors are still reported.
    assert!(found["rms_after_m"].as_f64().unwrap() > found["rms_before_m"].as_f64().unwrap(), "{found}");
    let said = stdout(directory, &forced);
    for words in ["written despite this (--force)", "raw rms", "worse with the effect, beyond chance"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert_eq!(Model::read(&directory.join("ours.toml")).unwrap().revisions.len(), 2);
}

#[test]
fn a_window_calibrates_a_flight_that_does_not_say_when_it_was_launched() {
    let folder = folder(&[("a.csv", &effect("baro.dynamic_pressure", 0.12, ""), 1)]);
    let directory = folder.path();
    let launched = json(directory, &add("baro.dynamic_pressure", &[]));
    fs::write(directory.join("ours.toml"), MODEL).unwrap();
    without_columns(&directory.join("a.csv"), &["launch"]);
    let window = ["--calibrate", "10..120"];
    let given = json(directory, &add("baro.dynamic_pressure", &window));
    let number = |value: &Value, key: &str| value[key].as_f64().unwrap();
    let apart = number(&launched, "coefficient") - number(&given, "coefficient");
    assert!(apart.abs() < 0.2 * number(&given, "sigma"), "{launched} {given}");
    assert_eq!(given["learning"][0]["file"], "a.csv");
    let refused = refusal(directory, &add("baro.dynamic_pressure", &["--calibrate", "900..950"]));
    assert!(refused.contains("a.csv: "), "{refused}");
}

/// Any flight that can be diagnosed can be learned from; the mission is flown over the part that it can be
/// calibrated on.
#[test]
fn a_flight_with_nothing_to_calibrate_on_is_learned_from_all_the_same() {
    let effects = effect("baro.dynamic_pressure", 0.12, "");
    let folder = folder(&[("a.csv", &effects, 1), ("b.csv", &effects, 2)]);
    let directory = folder.path();
    for name in ["a.csv", "b.csv"] {
        // From the first dive on, where nothing is quiet.
        let text = fs::read_to_string(directory.join(name)).unwrap();
        let mut is_named = false;
        let kept = text.lines().filter(|line| {
            let time_s = line.split(',').next().and_then(|cell| cell.parse::<f64>().ok());
            let keep = time_s.is_none_or(|time_s| (124.0..215.0).contains(&time_s)) || !is_named;
            is_named |= line.starts_with("time_s");
            keep
        });
        let text = kept.collect::<Vec<_>>().join("\n") + "\n";
        fs::write(directory.join(name), text).unwrap();
        without_columns(&directory.join(name), &["launch"]);
    }
    let compared = stdout(directory, &["compare", "a.csv"]);
    assert!(compared.contains("calibrated on the calmest stretch, as none is quiet"), "{compared}");
    let found = json(directory, &add("baro.dynamic_pressure", &["--hold-out", "b.csv"]));
    let number = |key: &str| found[key].as_f64().unwrap();
    assert!((number("coefficient") - 0.12).abs() < 4.0 * number("sigma"), "{found}");
    assert!(number("rms_after_m") < number("rms_before_m"), "{found}");
    assert_eq!((&found["learning"], &found["held_out"]), (&Value::Array(vec![]), &Value::Array(vec![])));
    let warnings = found["warnings"].to_string();
    assert!(warnings.contains("a.csv: no launch column and no quiet stretch"), "{warnings}");
    assert!(warnings.contains("b.csv: ") && warnings.contains("--calibrate START..END"), "{warnings}");
}

#[test]
fn time_constants_are_given_or_found_and_written() {
    let warm_up = effect("baro.warm_up", 12.0, "time_constant_s = 30");
    let settling = effect("gps.convergence", 15.0, "time_constant_s = 30");
    let folder = folder(&[("a.csv", &warm_up, 1), ("settling.csv", &settling, 2)]);
    let directory = folder.path();
    let read = || Model::read(&directory.join("ours.toml")).unwrap().effects.pop().unwrap();

    let given = ["--time-constant", "30", "--since", "start", "--force"];
    let found = json(directory, &add("baro.warm_up", &given));
    assert_eq!((found["time_constant_s"].as_f64(), found["since"].as_str()), (Some(30.0), Some("start")));
    let written = read();
    assert_eq!(written.term.regressor.time_constant_s, 30.0);
    assert_eq!(written.term.regressor.since, Clock::Start);
    let number = |key: &str| found[key].as_f64().unwrap();
    assert!((number("coefficient") - 12.0).abs() < 4.0 * number("sigma"), "{found}");

    fs::write(directory.join("ours.toml"), MODEL).unwrap();
    let settling = [
        "add",
        "gps.convergence",
        "--model",
        "ours.toml",
        "--from",
        "settling.csv",
        "--since",
        "start",
        "--force",
    ];
    let found = json(directory, &settling);
    let constant_s = found["time_constant_s"].as_f64().unwrap();
    assert!((10.0..=90.0).contains(&constant_s), "the grid's neighbours of 30 s: {found}");
    // The file and the results have the same decimal number.
    assert_eq!(read().term.regressor.time_constant_s, constant_s as f32);
    assert!(model_text(directory).contains(&format!("time_constant_s = {constant_s}\n")), "{found}");
    let text = stdout(directory, &settling);
    assert!(text.contains("time constant") && text.contains("since the first tick"), "{text}");
}

#[test]
fn a_coefficient_that_nature_does_not_make_is_written_with_its_range() {
    let folder = folder(&[("a.csv", &effect("baro.lag", -1.5, ""), 1)]);
    let found = json(folder.path(), &add("baro.lag", &[]));
    let warnings = found["warnings"].to_string();
    assert!(warnings.contains("outside of its physical range 0 to 5 s"), "{warnings}");
    let text = stdout(folder.path(), &add("baro.lag", &[]));
    assert!(text.contains("warning: coefficient of effect baro.lag is -1."), "{text}");
}

#[test]
fn models_with_inline_arrays_keep_their_form() {
    let folder = folder(&[("a.csv", &effect("baro.dynamic_pressure", 0.12, ""), 1)]);
    let directory = folder.path();
    let text =
        "effect = [\n  { id = \"baro.lag\", coefficient = 0.1, sigma = 0.05 }, # of the shop\n]\n# the end\n";
    fs::write(directory.join("ours.toml"), text).unwrap();
    json(directory, &add("baro.dynamic_pressure", &[]));
    let changed = model_text(directory);
    assert!(changed.contains("# of the shop\n") && changed.contains("# the end\n"), "{changed}");
    assert!(!changed.contains("[[effect]]"), "{changed}");
    let model = Model::read(&directory.join("ours.toml")).unwrap();
    assert_eq!((model.effects.len(), model.revisions.len()), (2, 1));
}

/// A program that has the file open, or reads it at any moment, sees either the old model or the new one,
/// complete.
#[test]
fn a_model_is_replaced_and_never_rewritten() {
    let folder = folder(&[("a.csv", &effect("baro.dynamic_pressure", 0.12, ""), 1)]);
    let directory = folder.path();
    let mut open = File::open(directory.join("ours.toml")).unwrap();
    let names = files(directory);
    json(directory, &add("baro.dynamic_pressure", &[]));
    let mut old = String::new();
    open.read_to_string(&mut old).unwrap();
    assert_eq!(old, MODEL);
    assert!(model_text(directory).starts_with(MODEL) && model_text(directory).len() > MODEL.len());
    assert_eq!(files(directory), names, "nothing is left beside it");
}

#[test]
fn every_refusal_leaves_the_folder_as_it_was() {
    let folder = folder(&[("a.csv", "", 1)]);
    let directory = folder.path();
    let text = fs::read_to_string(directory.join("a.csv")).unwrap();
    fs::write(directory.join("cut.csv"), &text[..text.len() / 2]).unwrap();
    let mut broken: Vec<String> = text.lines().map(str::to_owned).collect();
    let last = broken.len() - 1;
    broken[last] = format!("{},what", broken[last]);
    fs::write(directory.join("broken.csv"), broken.join("\n")).unwrap();
    fs::write(directory.join("bad.toml"), "[[effect]]\nid = \"baro.lug\"\n").unwrap();
    let names = files(directory);
    for arguments in [
        add("baro.lag", &[]),
        add("baro.lug", &[]),
        add("baro.lag", &["--hold-out", "a.csv"]),
        add("baro.lag", &["--hold-out", "absent.csv"]),
        add("baro.lag", &["--hold-out", "broken.csv"]),
        add("baro.lag", &["--calibrate", "900..950"]),
        add("baro.lag", &["--force", "-o", "no/such/folder.toml"]),
        vec!["add", "baro.lag", "--model", "bad.toml", "--from", "a.csv", "--force"],
        vec!["add", "baro.lag", "--model", "ours.toml", "--from", "a.csv", "./a.csv"],
    ] {
        let refused = refusal(directory, &arguments);
        assert_eq!(model_text(directory), MODEL, "{arguments:?}: {refused}");
        assert_eq!(files(directory), names, "{arguments:?}");
    }
}
