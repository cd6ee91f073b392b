//! Parquet as a flight: Pylon's own export comes back unchanged, and a table written by pyarrow is imported
//! by a mapping, channel by channel.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::Recipe;
use common::program::{files, refusal, run, stdout};
use common::python::python;
use pylon::flight::{Channel, Flight};
use pylon::import;

const MAPPING: &str = r#"pylon-mapping = 1
[time]
column = "stamp"
[signals]
launch = { column = "released" }
gps_alt_m = { column = "gps_altitude_m" }
gps_vn_mps = { column = "vn" }
gps_ve_mps = { column = "ve" }
gps_vd_mps = { column = "climb", unit = "km/h", scale = -1 }
baro_alt_m = { column = "baro_ft", unit = "ft" }
imu_master_alt_m = { column = "ins" }
imu_slave_alt_m = { column = "slave_mm", unit = "mm" }
tas_mps = { column = "speed", unit = "m/s" }
half = { column = "pair.a" }
"#;

/// Every cell of every channel is in the same place, to the digits of the table.
fn assert_same(found: &Flight, made: &Flight, what: &str) {
    assert_eq!(found.rows(), made.rows(), "{what}");
    for (row, (time_s, expected_s)) in found.time_s.iter().zip(&made.time_s).enumerate() {
        assert!((time_s - expected_s).abs() < 1e-6, "{what}: row {row} at {time_s} s, not {expected_s} s");
    }
    for (channel, expected) in &made.channels {
        let name = channel.name();
        let column = found.channel(*channel).unwrap_or_else(|| panic!("{what}: no {name}"));
        let within = if *channel == Channel::ImuSlaveAltM { 7e-4 } else { 2e-4 };
        for row in 0..made.rows() {
            match (column.get(row), expected.get(row)) {
                (None, None) => {}
                (Some(value), Some(expected)) if (value - expected).abs() <= within => {}
                (value, expected) => panic!("{what}: {name}, row {row}: {value:?}, not {expected:?}"),
            }
        }
    }
}

#[test]
fn a_table_of_pyarrows_is_the_flight_by_a_mapping() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    let recipe = Recipe { captive_s: 60.0, free_s: 10.0, climb_mps: common::dive_mps, ..Recipe::default() };
    let made = recipe.make();
    recipe.write(path);
    fs::write(path.join("mapping.toml"), MAPPING).unwrap();
    for (compression, pages, dictionary) in
        [("snappy", "1.0", "yes"), ("zstd", "2.0", "yes"), ("lz4", "1.0", "no"), ("none", "2.0", "no")]
    {
        let what = format!("{compression}, pages {pages}, dictionaries: {dictionary}");
        let written = Command::new(python())
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/import_parquet/write.py"))
            .args(["made.csv", "table.parquet", compression, pages, dictionary])
            .current_dir(path)
            .output()
            .unwrap();
        assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
        let output = run(path, &["import", "table.parquet", "--mapping", "mapping.toml", "-o", "flight.csv"]);
        let notes = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{what}: {notes}");
        for words in [
            "note: 3500 rows over 70.0 s",
            "columns with several values a row, left out: several.list.element",
            "columns that the mapping does not name, left out: mode, nothing, pair.b",
        ] {
            assert!(notes.contains(words), "{what}: {notes}");
        }
        assert!(!notes.contains("damaged"), "{what}: {notes}");
        let (flight, _) = import::open(&path.join("flight.csv")).unwrap();
        assert_same(&flight, &made, &what);
        let start = flight.header.other.iter().find(|(key, _)| key == "start_utc");
        assert_eq!(start.map(|(_, value)| value.as_str()), Some("2024-05-01T23:59:00Z"), "{what}");
        let (_, half) = flight.extra.iter().find(|(name, _)| name == "half").unwrap();
        assert!(half.samples().count() == 3_500 && half.samples().all(|(_, value)| value == 1.5), "{what}");
        fs::remove_file(path.join("flight.csv")).unwrap();
    }

    // The draft finds the time and the barometer's unit, and works without a correction.
    let said = stdout(path, &["import", "table.parquet", "--guess", "-o", "draft.toml"]);
    assert!(said.contains("14 columns in 3500 rows"), "{said}");
    assert!(said.contains("columns with several values a row, left out: several.list.element"), "{said}");
    let draft = fs::read_to_string(path.join("draft.toml")).unwrap();
    assert!(draft.contains("[time]\ncolumn = \"stamp\"\n") && !draft.contains("[file]"), "{draft}");
    assert!(draft.contains("\nbaro_alt_m = { column = \"baro_ft\", unit = \"ft\" }"), "{draft}");
    stdout(path, &["import", "table.parquet", "--mapping", "draft.toml", "-o", "guessed.csv"]);

    // Without a mapping it is not recognised.
    let open = refusal(path, &["compare", "table.parquet"]);
    assert!(open.contains("'pylon import table.parquet --guess -o mapping.toml' drafts"), "{open}");
    fs::write(path.join("layout.toml"), format!("{MAPPING}[file]\nseparator = \";\"\n")).unwrap();
    let layout = refusal(path, &["import", "table.parquet", "--mapping", "layout.toml", "-o", "x.csv"]);
    assert!(layout.contains("[file] describes the layout of a text, expected no [file]"), "{layout}");
}

#[test]
fn what_was_exported_comes_back_byte_for_byte() {
    let real = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/flights/real");
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    Recipe { captive_s: 20.0, free_s: 5.0, ..Recipe::default() }.write(path);
    let mut logs = vec![path.join("made.csv")];
    for name in ["ulog/frrs_motor_failure.ulg", "dataflash/pymav_test.BIN"] {
        if real.join(name).exists() { logs.push(real.join(name)) } else { println!("skipped: {name}") }
    }
    for log in logs {
        let log = log.to_str().unwrap();
        let csv = match log.ends_with(".csv") {
            true => "made.csv",
            false => {
                stdout(path, &["import", log, "-o", "flight.csv"]);
                "flight.csv"
            }
        };
        stdout(path, &["export", csv, "--format", "parquet", "-o", "flight.parquet"]);
        let output = run(path, &["import", "flight.parquet", "-o", "back.csv"]);
        let notes = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success() && !notes.contains("damaged"), "{log}: {notes}");
        assert!(fs::read(path.join("back.csv")).unwrap() == fs::read(path.join(csv)).unwrap(), "{log}");
        // Every command reads it like the CSV.
        assert!(stdout(path, &["open", "flight.parquet"]).contains("Pylon's Parquet"), "{log}");
        let guess = refusal(path, &["import", "flight.parquet", "--guess"]);
        assert!(
            guess.contains("Pylon's Parquet), which 'pylon import' reads without a mapping"),
            "{log}: {guess}"
        );
        for file in ["flight.parquet", "back.csv"] {
            fs::remove_file(path.join(file)).unwrap();
        }
    }
}

#[test]
fn one_that_is_cut_off_is_refused_in_words_and_nothing_is_written() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    Recipe { captive_s: 20.0, free_s: 5.0, ..Recipe::default() }.write(path);
    stdout(path, &["export", "made.csv", "--format", "parquet", "-o", "whole.parquet"]);
    let whole = fs::read(path.join("whole.parquet")).unwrap();
    fs::write(path.join("cut.parquet"), &whole[..whole.len() / 2]).unwrap();
    let before = files(path);
    for arguments in [
        &["import", "cut.parquet", "-o", "x.csv"][..],
        &["import", "cut.parquet", "--guess", "-o", "m.toml"],
        &["compare", "cut.parquet"],
    ] {
        let said = refusal(path, arguments);
        assert!(said.contains("cut.parquet: Parquet that is cut off, or still being written"), "{said}");
    }
    assert_eq!(files(path), before);
}
