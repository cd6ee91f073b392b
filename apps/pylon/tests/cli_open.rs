//! `pylon open`, and what every command reports for a log with ground time in it.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use common::program::{refusal, stdout};
use serde_json::Value;

/// Writes a glider's log without a launch column: two minutes on the ground, a tow and a glide, ten minutes
/// on the ground after landing. The barometer is off by 40 m, and by 70 m from some minutes after landing,
/// when the cockpit is closed.
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
    // A flight's CSV is not suggested for `import`.
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

/// The barometer's jump after landing affects no result.
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

/// Writes the log of a vehicle that is carried up, hangs under a mother ship in level flight for two minutes
/// from 200 s on, is dropped at 320 s and pulls out after three seconds; without a launch column. Barometer
/// at 20 Hz, receiver at 5 Hz.
fn dropped(file: &Path) {
    let mut text = "# pylon-flight: 1\ntime_s,gps_alt_m,gps_vn_mps,gps_ve_mps,baro_alt_m\n".to_owned();
    for row in 0..10_000 {
        let time_s = f64::from(row) / 20.0;
        let (height_m, speed_mps) = match row {
            0..2_000 => (100.0, 0.0),
            2_000..4_000 => (100.0 + 4.0 * (time_s - 100.0), 25.0),
            4_000..6_400 => (500.0, 30.0),
            6_400..6_460 => (500.0 - 4.9 * (time_s - 320.0).powi(2), 30.0),
            6_460..8_000 => (455.9 - 4.5 * (time_s - 323.0), 30.0),
            _ => (109.4, 0.0),
        };
        let baro_m = height_m + 40.0 + 0.2 * (f64::from(row) * 2.9).sin();
        let fix = if row % 4 == 0 {
            format!("{:.2},{speed_mps},0", height_m + 0.4 * (f64::from(row) * 1.7).sin())
        } else {
            ",,".to_owned()
        };
        writeln!(text, "{time_s},{fix},{baro_m:.2}").unwrap();
    }
    fs::write(file, text).unwrap();
}

#[test]
fn a_drop_from_a_carrier_is_found_and_the_sensors_are_calibrated_under_it() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    dropped(&directory.join("drop.csv"));
    let text = stdout(directory, &["open", "drop.csv"]);
    for said in [
        "take-off at 00:01:4",
        "drop       at 00:05:",
        "dropped from a carrier at 00:05:",
        "calibrated on the quiet flight under the carrier before the drop",
    ] {
        assert!(text.contains(said), "no '{said}' in {text}");
    }
    let found: Value = serde_json::from_str(&stdout(directory, &["open", "drop.csv", "--json"])).unwrap();
    assert!((found["drop_s"].as_f64().unwrap() - 320.0).abs() <= 0.5, "{found}");
    let window_s = [0, 1].map(|end| found["calibration_window_s"][end].as_f64().unwrap());
    assert!(window_s[0] >= 195.0 && (310.0..=320.5).contains(&window_s[1]), "{window_s:?}");
    let compared = stdout(directory, &["compare", "drop.csv"]);
    assert!(compared.contains("quiet flight under the carrier"), "{compared}");
}

#[test]
fn altitudes_of_two_datums_are_refused_until_one_is_converted_by_name() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    glider(&directory.join("glider.csv"));
    let text = fs::read_to_string(directory.join("glider.csv")).unwrap();
    let with_master = |line: &str| match line.split_once(',') {
        Some(("time_s", _)) => format!("{line},imu_master_alt_m"),
        Some((_, cells)) => {
            let altitude_m: f64 = cells.split(',').next().unwrap().parse().unwrap();
            format!("{line},{}", altitude_m + 47.0)
        }
        None => line.to_owned(),
    };
    let text: String = text.lines().map(|line| with_master(line) + "\n").collect();
    let head = "# pylon-flight: 1\n# altitude_datum imu_master_alt_m: ellipsoid";
    fs::write(directory.join("mixed.csv"), text.replacen("# pylon-flight: 1", head, 1)).unwrap();
    let words =
        "mixed.csv: imu_master_alt_m is measured above the ellipsoid and gps_alt_m above mean sea level";
    for command in ["compare", "diagnose"] {
        let said = refusal(directory, &[command, "mixed.csv"]);
        assert!(said.contains(words) && said.contains("--to-msl imu_master_alt_m=GEOID_HEIGHT"), "{said}");
    }
    let opened = stdout(directory, &["open", "mixed.csv"]);
    assert!(opened.contains("(gps_alt_m), above mean sea level"), "{opened}");
    assert!(opened.contains("(imu_master_alt_m), above the ellipsoid"), "{opened}");
    assert!(opened.contains("(baro_alt_m), above 1013.25 hPa"), "{opened}");
    stdout(directory, &["import", "mixed.csv", "--to-msl", "imu_master_alt_m=47", "-o", "one.csv"]);
    let found: Value = serde_json::from_str(&stdout(directory, &["compare", "one.csv", "--json"])).unwrap();
    let bias_m = found["sensors"]["imu_master"]["bias_m"].as_f64().unwrap();
    assert!(bias_m.abs() < 1.0, "{bias_m}");
    let said = refusal(directory, &["import", "glider.csv", "-o", "again.csv"]);
    assert!(said.contains("it is a flight already"), "{said}");
}

/// Five hours without a row: neither a landing nor a take-off is invented for them.
#[test]
fn a_flight_that_a_gap_parts_has_not_landed_in_it() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let file = directory.join("gap.csv");
    glider(&file);
    let text = fs::read_to_string(&file).unwrap();
    let later = |line: &str| match line.split_once(',') {
        Some((time, rest)) if time.parse::<u32>().is_ok_and(|second| second >= 400) => {
            format!("{},{rest}", time.parse::<u32>().unwrap() + 18_000)
        }
        _ => line.to_owned(),
    };
    fs::write(&file, text.lines().map(|line| later(line) + "\n").collect::<String>()).unwrap();
    let text = stdout(directory, &["open", "gap.csv"]);
    for said in [
        "in the air when a gap in the log begins",
        "in the air when a gap in the log ends, landing at 05:12:",
        "nothing was recorded for 18001 s",
    ] {
        assert!(text.contains(said), "no '{said}' in {text}");
    }
    assert!(!text.contains("after the landing: on the ground, and"), "{text}");
}
