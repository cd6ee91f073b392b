//! Every kind of bad input has its defined outcome on the command line: one clear line and exit status 2,
//! or a named degraded state in the result; never a partial file.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

const HEAD: &str =
    "# pylon-flight: 1\n# vehicle: made for a test\n# source: made for a test\n# altitude_datum: msl\n";
const COLUMNS: &str = "time_s,launch,gps_alt_m,gps_vd_mps,baro_alt_m,imu_slave_alt_m\n";

/// One row of a healthy flight: 60 s captive, 30 s free, 50 rows a second, gps at 5 Hz, deterministic
/// dither for noise.
struct Row {
    time_s: String,
    launch: String,
    gps: String,
    climb: String,
    baro: String,
    slave: String,
}

fn row(k: u32) -> Row {
    let dither = |salt: u32| {
        f64::from((k.wrapping_mul(2_654_435_761).wrapping_add(salt) >> 8) & 0xffff) / 65_536.0 - 0.5
    };
    let fix = k.is_multiple_of(10);
    Row {
        time_s: format!("{:.3}", f64::from(k) * 0.02),
        launch: u32::from(k >= 3_000).to_string(),
        gps: if fix { format!("{:.3}", 1_000.0 + 2.0 * dither(1)) } else { String::new() },
        climb: if fix { format!("{:.3}", 0.1 * dither(2)) } else { String::new() },
        baro: format!("{:.3}", 1_020.0 + dither(3)),
        slave: format!("{:.3}", 990.0 + dither(4)),
    }
}

/// The flight as CSV, each row edited by `edit`.
fn flight(edit: impl Fn(u32, &mut Row)) -> String {
    let mut text = format!("{HEAD}{COLUMNS}");
    for k in 0..4_500 {
        let mut row = row(k);
        edit(k, &mut row);
        let Row { time_s, launch, gps, climb, baro, slave } = row;
        text.push_str(&format!("{time_s},{launch},{gps},{climb},{baro},{slave}\n"));
    }
    text
}

fn pylon(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pylon")).args(arguments).current_dir(folder).output().unwrap()
}

/// `pylon compare --json` on that file's content.
fn compared(content: &str) -> Output {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("flight.csv"), content).unwrap();
    pylon(&["compare", "flight.csv", "--json"], folder.path())
}

fn json(content: &str) -> Value {
    let output = compared(content);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn failed_checks(result: &Value) -> Vec<String> {
    let checks = result["calibration"]["failed_checks"].as_array().unwrap();
    checks.iter().map(|check| check.as_str().unwrap().to_owned()).collect()
}

/// The one line that a refusal says.
fn refusal(content: &str) -> String {
    let output = compared(content);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(output.stdout.is_empty());
    let errors: Vec<&str> = said.lines().filter(|line| line.starts_with("error: ")).collect();
    assert_eq!(errors.len(), 1, "{said}");
    assert!(errors[0].contains("flight.csv"), "{said}");
    errors[0].to_owned()
}

#[test]
fn the_healthy_flight_is_good() {
    let result = json(&flight(|_, _| {}));
    assert_eq!(result["calibration"]["quality"], "good", "{:?}", failed_checks(&result));
    assert!((result["launch_s"].as_f64().unwrap() - 60.0).abs() < 1e-6);
    assert!((result["sensors"]["baro"]["bias_m"].as_f64().unwrap() - 20.0).abs() < 1.0);
    assert!(result["sensors"]["baro"]["doubtful_after_s"].is_null());
}

#[test]
fn cells_that_are_not_finite_and_times_out_of_order_degrade_by_name() {
    for bad in ["nan", "inf", "-inf"] {
        let result = json(&flight(|k, row| {
            if k == 1_500 {
                row.baro = bad.into()
            }
        }));
        assert_eq!(failed_checks(&result), ["inputs_valid"], "{bad}");
    }
    for time_s in ["29.960", "10.000"] {
        let result = json(&flight(|k, row| {
            if k == 1_500 {
                row.time_s = time_s.into()
            }
        }));
        assert_eq!(failed_checks(&result), ["inputs_valid"], "{time_s}");
    }
}

#[test]
fn a_stuck_sensor_and_a_frozen_reference_degrade_by_name() {
    let stuck = json(&flight(|k, row| {
        if k > 1_500 {
            row.baro = "1020.2".into()
        }
    }));
    assert!(failed_checks(&stuck).contains(&"sensors_alive".to_owned()));
    let frozen = json(&flight(|k, row| {
        if k > 1_500 && !row.gps.is_empty() {
            row.gps = "1000.1".into();
            row.climb = "0.01".into();
        }
    }));
    assert!(failed_checks(&frozen).contains(&"reference_fresh".to_owned()));
}

#[test]
fn launches_too_early_twice_and_never_are_defined() {
    let early = json(&flight(|k, row| row.launch = u32::from(k >= 1_000).to_string()));
    assert!(failed_checks(&early).contains(&"long_enough".to_owned()));
    let in_settling = json(&flight(|k, row| row.launch = u32::from(k >= 250).to_string()));
    assert!(failed_checks(&in_settling).contains(&"settled".to_owned()));
    let twice =
        json(&flight(|k, row| row.launch = u32::from((2_500..2_600).contains(&k) || k >= 3_000).to_string()));
    assert!((twice["launch_s"].as_f64().unwrap() - 50.0).abs() < 1e-6);
    let never = json(&flight(|_, row| row.launch = "0".into()));
    assert!(never["launch_s"].is_null());
    assert!(never["sensors"]["baro"]["free_flight_rms_m"].is_null());
}

#[test]
fn a_flight_shorter_than_settling_says_so() {
    let text: String = flight(|_, _| {}).lines().take(200).map(|line| format!("{line}\n")).collect();
    let result = json(&text);
    assert!(result["launch_s"].is_null());
}

#[test]
fn files_that_are_no_flight_are_refused_in_one_line() {
    assert!(refusal("").contains("empty"));
    let cut = flight(|_, _| {});
    let cut = &cut[..cut.len() - 9];
    assert!(refusal(cut).contains("row"), "{}", refusal(cut));
    let no_reference = flight(|_, _| {}).replace("gps_alt_m", "something_else");
    assert!(refusal(&no_reference).contains("gps_alt_m"));
    let no_altitude = flight(|_, _| {}).replace("baro_alt_m", "a").replace("imu_slave_alt_m", "b");
    assert!(refusal(&no_altitude).contains("altitude"), "{}", refusal(&no_altitude));
    let wrong_units = flight(|_, _| {}).replace("gps_alt_m", "gps_alt_ft");
    let said = refusal(&wrong_units);
    assert!(said.contains("gps_alt_ft") && said.contains("gps_alt_m"), "{said}");
    let word = flight(|k, row| {
        if k == 7 {
            row.baro = "high".into()
        }
    });
    let said = refusal(&word);
    assert!(said.contains("baro_alt_m") && said.contains("high"), "{said}");
    let wrong_version = flight(|_, _| {}).replace("pylon-flight: 1", "pylon-flight: 9");
    assert!(refusal(&wrong_version).contains('9'));
}

#[test]
fn a_refusal_leaves_no_file_behind() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("flight.csv"), "no flight").unwrap();
    fs::write(folder.path().join("scenario.toml"), "seed = -1").unwrap();
    for arguments in [
        &["compare", "flight.csv", "--plots", "pictures"][..],
        &["import", "flight.csv", "-o", "out.csv"],
        &["export", "flight.csv", "--format", "csv", "-o", "out.csv"],
        &["simulate", "scenario.toml", "-o", "out.csv"],
        &["compare", "nowhere.csv"],
        &["compare"],
        &["compare", "flight.csv", "--calibrate", "9..3"],
    ] {
        let output = pylon(arguments, folder.path());
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert_eq!(said.lines().count(), 1, "{arguments:?}: {said}");
        let mut files: Vec<_> =
            fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        files.sort();
        assert_eq!(files, ["flight.csv", "scenario.toml"], "{arguments:?}");
    }
}
