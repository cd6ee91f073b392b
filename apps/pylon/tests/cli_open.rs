//! `pylon open`, and what every command says of a log with ground time in it.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use common::program::{refusal, stdout};
use serde_json::Value;

/// Writes a glider's log without a launch column: two minutes on the ground, a tow and a glide, ten minutes on the ground after the
/// landing. The barometer is 40 m off, and some minutes after the landing, as the cockpit is closed, 70 m.
fn glider(file: &Path) {
    let mut text =
        "# pylon-flight: 1\n# vehicle: LS 6\ntime_s,gps_alt_m,gps_vn_mps,gps_ve_mps,baro_alt_m\n".to_owned();
    for second in 0..1_500 {
        let (height_m, speed_mps) = match second {
            0..120 => (300.0, 0.0),
            120..140 => (300.0, 25.0),
            140..340 => (300.0 + 3.0 * f64::from(second - 140), 30.0),
            340..740 => (900.0 - 1.5 * f64::from(second - 340), 30.0),
            _ => (300.0, if second < 750 { 15.0 } else { 0.0 }),
        };
        let wobble_m = 0.4 * (f64::from(second) * 1.7).sin();
        let baro_m =
            height_m + if second < 900 { 40.0 } else { 70.0 } + 0.1 * (f64::from(second) * 2.9).sin();
        writeln!(text, "{second},{:.2},{speed_mps},0,{baro_m:.2}", height_m + wobble_m).unwrap();
    }
    fs::write(file, text).unwrap();
}

#[test]
fn a_log_explains_itself_and_its_advice_can_be_pasted() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    glider(&directory.join("my glider.csv"));
    let text = stdout(directory, &["open", "my glider.csv"]);
    for said in [
        "LS 6",
        "take-off at 00:02:2",
        "landing at 00:12:",
        "calibrated on the ground before the take-off",
        "on the ground after the landing",
        "after landing, not analysed",
        "barometer              1500 samples at 1 Hz",
    ] {
        assert!(text.contains(said), "no '{said}' in {text}");
    }
    assert!(!text.contains("captive") && !text.contains("launch"), "{text}");
    let next = text.split("\nNext\n").nth(1).unwrap();
    let commands: Vec<&str> = next.lines().filter_map(|line| line.trim().strip_prefix("pylon ")).collect();
    // A flight's CSV is none that `import` would take.
    assert_eq!(commands.len(), 3, "{text}");
    for command in commands {
        let arguments: Vec<String> = command
            .replace("'my glider.csv'", "my\0glider.csv")
            .split(' ')
            .map(|word| word.replace('\0', " "))
            .collect();
        stdout(directory, &arguments.iter().map(String::as_str).collect::<Vec<_>>());
    }
    let found: Value =
        serde_json::from_str(&stdout(directory, &["open", "my glider.csv", "--json"])).unwrap();
    let number = |key: &str| found[key].as_f64().unwrap();
    assert!(
        (number("take_off_s") - 140.0).abs() < 6.0 && (number("landing_s") - 740.0).abs() < 6.0,
        "{found}"
    );
    assert!(found["calibration_window_s"][1].as_f64().unwrap() <= number("take_off_s"), "{found}");
    assert_eq!(found["sensors"][2]["state"], "present");
}

/// The barometer's leap after the landing is in no result.
#[test]
fn every_command_leaves_out_what_follows_the_landing_and_says_so() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    glider(&directory.join("glider.csv"));
    fs::write(directory.join("ours.toml"), "").unwrap();
    let compared = stdout(directory, &["compare", "glider.csv"]);
    assert!(
        compared.contains("not used: 7") && compared.contains("on the ground after the landing"),
        "{compared}"
    );
    assert!(!compared.contains("captive flight") && !compared.contains("launch at"), "{compared}");
    let rms_m = |arguments: &[&str], path: &str| {
        let found: Value = serde_json::from_str(&stdout(directory, arguments)).unwrap();
        found.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {found}"))
    };
    assert!(rms_m(&["compare", "glider.csv", "--json"], "/sensors/baro/free_flight_rms_m") < 2.0);
    let revision = "/revisions/0/flights/0/sensors/baro/free_flight_rms_m";
    assert!(rms_m(&["ladder", "--model", "ours.toml", "glider.csv", "--json"], revision) < 2.0);
    let unused = rms_m(&["diagnose", "glider.csv", "--json"], "/flights/0/unused/0/share");
    assert!((unused - 0.5).abs() < 0.02, "{unused}");
    let refused = refusal(directory, &["compare", "glider.csv", "--calibrate", "900..1000"]);
    assert!(refused.contains("of the flight's own clock reaches beyond the landing at 7"), "{refused}");
    let given = stdout(directory, &["compare", "glider.csv", "--calibrate", "20..90"]);
    assert!(given.contains("20..90 s of the flight's own clock, as given"), "{given}");
}
