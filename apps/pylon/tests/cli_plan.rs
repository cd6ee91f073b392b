//! `pylon plan`: from a flight on the disk to a plan in words and as a scenario, which is flown and diagnosed.
//! All flights are simulated.
#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used)]

mod common;

use std::fs;
use std::path::Path;

use common::json::checked;
use common::program::{refusal, stdout};
use pylon::plan::Aim;
use pylon::results::{DiagnoseResult, PlanResult};

const EFFECT: &str = "\n[[effect]]\nid = \"baro.dynamic_pressure\"\ncoefficient = 0.08\n";

/// Faster from the release on: whether the cause of the error is the speed or the time since the release does
/// not show.
const POOR: &str = "name = \"poor\"
[captive]
duration_s = 60.0
altitude_m = 1200.0
airspeed_mps = 28.0
[[free_flight]]
manoeuvre = \"accelerate\"
duration_s = 40.0
airspeed_mps = 36.0
";

fn simulated(here: &Path, name: &str, scenario: &str, seed: &str) {
    fs::write(here.join(format!("{name}.toml")), scenario).unwrap();
    let flight = format!("{name}.csv");
    stdout(here, &["simulate", &format!("{name}.toml"), "--seed", seed, "-o", &flight]);
}

fn diagnosed(here: &Path, flights: &[&str]) -> (Vec<String>, usize) {
    let result: DiagnoseResult = checked("diagnose", here, flights);
    let together = result.together.unwrap();
    let missing = together.missing().map(str::to_owned).collect();
    (missing, together.suspects().count())
}

#[test]
fn the_planned_flight_resolves_what_the_first_left_open() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    simulated(here, "first", &(POOR.to_owned() + EFFECT), "3");
    let (missing, suspects) = diagnosed(here, &["first.csv"]);
    assert!(
        missing.is_empty() && suspects > 1,
        "the flight was to be poor: {missing:?}, {suspects} suspects"
    );
    let said = stdout(here, &["diagnose", "first.csv"]);
    assert!(said.contains("resolve this: pylon plan first.csv\n"), "{said}");

    let plan: PlanResult = checked("plan", here, &["first.csv", "-o", "next.toml"]);
    assert_eq!((plan.aim, plan.is_enough, plan.file.as_deref()), (Aim::Sets, true, Some("next.toml")));
    assert!(plan.outlook.sets.iter().all(|set| set.resolved >= 0.9), "{:?}", plan.outlook.sets);
    let words = stdout(here, &["plan", "first.csv"]);
    for segment in &plan.segments {
        assert!(words.contains(&segment.words), "{} in {words}", segment.words);
    }
    assert!(words.contains("If baro.dynamic_pressure acts, diagnosing the flights together"), "{words}");

    let scenario = fs::read_to_string(here.join("next.toml")).unwrap();
    simulated(here, "next", &(scenario.clone() + EFFECT), "11");
    let (missing, suspects) = diagnosed(here, &["first.csv", "next.csv"]);
    assert_eq!((missing, suspects), (vec!["baro.dynamic_pressure".to_owned()], 0));
    // The same manoeuvre again does not resolve it: the planned ones do.
    simulated(here, "again", &(POOR.to_owned() + EFFECT), "11");
    let (missing, suspects) = diagnosed(here, &["first.csv", "again.csv"]);
    assert!(missing.is_empty() && suspects > 1, "{missing:?}");
}

/// No manoeuvre separates a drift from a slow warming up: time does.
#[test]
fn a_drift_takes_a_long_flight() {
    const DRIFT: &str = "\n[[effect]]\nid = \"baro.drift\"\nphase = \"free\"\ncoefficient = 0.05\n";
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    simulated(here, "first", &(POOR.to_owned() + DRIFT), "3");
    let result: DiagnoseResult = checked("diagnose", here, &["first.csv"]);
    let sets: Vec<String> = result.together.unwrap().suspects().map(str::to_owned).collect();
    assert!(sets.contains(&"baro.drift".to_owned()) && sets.len() > 1, "{sets:?}");

    let plan: PlanResult = checked("plan", here, &["first.csv", "-o", "next.toml"]);
    assert_eq!((plan.aim, plan.is_enough), (Aim::Sets, true), "{:?}", plan.outlook.sets);
    let circles = plan.segments.iter().filter(|segment| segment.words.starts_with("Circle to the"));
    assert!(circles.count() >= 2, "{:?}", plan.segments);

    let scenario = fs::read_to_string(here.join("next.toml")).unwrap();
    simulated(here, "next", &(scenario + DRIFT), "11");
    let (missing, suspects) = diagnosed(here, &["first.csv", "next.csv"]);
    assert_eq!((missing, suspects), (vec!["baro.drift".to_owned()], 0));
}

#[test]
fn a_flight_that_leaves_nothing_open_still_has_a_plan() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    simulated(here, "level", &POOR.replace("accelerate", "straight"), "4");
    let plan: PlanResult = checked("plan", here, &["level.csv"]);
    assert_ne!(plan.aim, Aim::Sets);
    assert_eq!(plan.file, None);
    let words = stdout(here, &["plan", "level.csv"]);
    assert!(words.contains("min of manoeuvres") || words.contains("leave nothing open"), "{words}");
}

#[test]
fn what_cannot_be_planned_for_is_refused_in_one_line() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    simulated(here, "first", POOR, "3");
    assert!(refusal(here, &["plan"]).contains("<FLIGHT>"));
    assert!(refusal(here, &["plan", "none.csv"]).contains("none.csv"));
    fs::write(here.join("empty.csv"), "").unwrap();
    assert!(refusal(here, &["plan", "empty.csv"]).contains("empty.csv"));
    let over_itself = refusal(here, &["plan", "first.csv", "-o", "first.csv"]);
    assert!(over_itself.contains("first.csv"), "{over_itself}");
    assert!(refusal(here, &["plan", "first.csv", "-o", "no/where.toml"]).contains("no/where.toml"));
}
