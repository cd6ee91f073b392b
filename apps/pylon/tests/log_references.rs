//! Autopilots' logs against the formats' reference readers: every column's rows, times, values and sums. The
//! logs are real ones, read in place; a test reports if its log is missing.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use pylon::flight::{Channel, Column, Flight};
use pylon::import::import;

/// A column's samples: seconds and value.
type Samples = Vec<(f64, f64)>;

fn real(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/flights/real").join(name);
    if !path.exists() {
        println!("skipped: {name}");
        return None;
    }
    Some(path)
}

/// The output of one of the scripts.
fn script(name: &str, arguments: &[&std::ffi::OsStr]) -> String {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let target =
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| here.join("../../target"), PathBuf::from);
    let python = target.join("pymavlink/bin/python");
    assert!(python.exists(), "no pymavlink and pyulog: `cargo xtask setup` installs them");
    let output = Command::new(python)
        .arg(here.join("tests/log_references").join(name))
        .args(arguments)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn referred(name: &str, file: &Path) -> BTreeMap<String, Samples> {
    serde_json::from_str(&script(name, &[file.as_os_str()])).unwrap()
}

fn imported(flight: &Flight) -> BTreeMap<String, Samples> {
    let samples = |column: &Column| -> Samples {
        column.samples().map(|(row, value)| (flight.time_s[row], f64::from(value))).collect()
    };
    let known = flight.channels.iter().map(|(channel, column)| (channel.name().to_owned(), samples(column)));
    known.chain(flight.extra.iter().map(|(name, column)| (name.clone(), samples(column)))).collect()
}

/// Every column of the reference is present, sample by sample. Both compute their value from the same number,
/// in f64, and ours is rounded to f32 once: half a unit in its last place, plus the effect of the order of
/// factors in f64.
fn agree(file: &str, flight: &Flight, reference: &BTreeMap<String, Samples>) {
    let ours = imported(flight);
    // Times have the same zero if the reference has the first column as well.
    let first = |columns: &BTreeMap<String, Samples>, name: &str| {
        columns.get(name).and_then(|all| all.first()).map(|one| one.0)
    };
    for (name, expected) in reference {
        let found = ours.get(name).unwrap_or_else(|| panic!("{file}: no {name}"));
        assert_eq!(found.len(), expected.len(), "{file}: rows of {name}");
        let shift = first(&ours, name).unwrap() - first(reference, name).unwrap();
        let mut bound = 0.0;
        for ((time_s, value), (expected_s, expected)) in found.iter().zip(expected) {
            // Microseconds, as f64 seconds.
            assert!(
                (time_s - shift - expected_s).abs() < 5e-7,
                "{file}, {name}: {time_s} s, not {expected_s} s"
            );
            let tolerance = (1.0 + 1e-6) * 2_f64.powi(-24) * expected.abs() + 1e-30;
            assert!(
                (value - expected).abs() <= tolerance,
                "{file}, {name} at {time_s} s: {value}, not {expected}"
            );
            bound += tolerance;
        }
        let sum = |samples: &Samples| samples.iter().map(|(_, value)| value).sum::<f64>();
        assert!((sum(found) - sum(expected)).abs() <= bound + 1e-9, "{file}: sum of {name}");
    }
    println!("{file}: {} columns, {} rows", reference.len(), flight.rows());
}

#[test]
fn a_binary_log_of_ardupilot_is_read_as_pymavlink_reads_it() {
    let name = "dataflash/pymav_test.BIN";
    let Some(path) = real(name) else { return };
    let (flight, _) = import(&std::fs::read(&path).unwrap()).unwrap();
    let reference = referred("dataflash.py", &path);
    assert!(reference.len() >= 24, "{:?}", reference.keys());
    agree(name, &flight, &reference);
}

#[test]
fn the_same_log_as_text_is_the_same_flight() {
    let name = "dataflash/pymav_test.BIN";
    let Some(path) = real(name) else { return };
    let text = script("dataflash.py", &["--text".as_ref(), path.as_os_str()]);
    let (flight, _) = import(&std::fs::read(&path).unwrap()).unwrap();
    let (from_text, notes) = import(text.as_bytes()).unwrap();
    assert_eq!(imported(&flight), imported(&from_text), "{notes:?}");
    assert_eq!(flight.header, from_text.header);
}

#[test]
fn px4s_logs_are_read_as_pyulog_reads_them() {
    for (name, columns) in [
        ("ulog/frrs_ekf_failure.ulg", 23),
        ("ulog/frrs_motor_failure.ulg", 23),
        ("ulog/pyulog_small.ulg", 23),
    ] {
        let Some(path) = real(name) else { continue };
        let (flight, _) = import(&std::fs::read(&path).unwrap()).unwrap();
        let reference = referred("ulog.py", &path);
        assert!(reference.len() >= columns, "{name}: {:?}", reference.keys());
        agree(name, &flight, &reference);
    }
}

/// Altitudes of zero are left out on both sides, with the satellites of such a fix: recorders write zero for
/// a missing altitude, and at the coast for a real one.
#[test]
fn gliders_logs_are_read_as_aerofiles_reads_them() {
    let (Some(few), Some(many)) = (real("igc"), real("igc_many")) else { return };
    let mut files: Vec<PathBuf> = [few, many]
        .iter()
        .flat_map(|folder| std::fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "igc"))
        .collect();
    files.sort();
    let mut compared = 0;
    for path in files {
        let name = path.file_name().unwrap().to_str().unwrap();
        let Ok((flight, _)) = import(&std::fs::read(&path).unwrap()) else { continue };
        let mut reference = referred("igc.py", &path);
        let ours = imported(&flight);
        // A pressure altitude that copies the receiver's, or is missing, is reported and not used as a
        // barometer's.
        reference.retain(|name, _| ours.contains_key(name) || name != "baro_alt_m");
        // In hundredths of km/h. aerofiles keeps the numbers unchanged, as does a flight whose unit cannot be
        // determined.
        if name == "igclib_new_zealand.igc" {
            let speeds = reference.remove("igc_tas").unwrap();
            let in_mps = speeds.into_iter().map(|(time_s, value)| (time_s, value / 360.0)).collect();
            reference.insert("tas_mps".to_owned(), in_mps);
        }
        let mut flight = flight;
        let zeros = |flight: &Flight, altitude| -> Vec<usize> {
            let samples = flight.channel(altitude).into_iter().flat_map(Column::samples);
            samples.filter(|(_, value)| *value == 0.0).map(|(row, _)| row).collect()
        };
        for (altitude, of_it) in [
            (Channel::GpsAltM, [Channel::GpsAltM, Channel::GpsSats].as_slice()),
            (Channel::BaroAltM, &[Channel::BaroAltM]),
        ] {
            let zeros = zeros(&flight, altitude);
            for (_, column) in flight.channels.iter_mut().filter(|(channel, _)| of_it.contains(channel)) {
                zeros.iter().for_each(|row| {
                    column.set(*row, None);
                });
            }
        }
        agree(name, &flight, &reference);
        compared += 1;
    }
    assert!(compared >= 40, "{compared}");
}

#[test]
fn a_log_without_a_receiver_is_refused_in_words_for_a_pilot() {
    let Some(path) = real("ulog/pyulog_appended_multiple.ulg") else { return };
    let error = import(&std::fs::read(&path).unwrap()).unwrap_err().to_string();
    assert!(error.starts_with("PX4 ULog without a 3D fix of a receiver"), "{error}");
}
