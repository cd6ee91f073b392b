//! The output of `pylon export`, read by the readers that users have: pyarrow, DuckDB, Python's csv and two
//! MCAP libraries. They are installed by pip and npm into the build's folder.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::Recipe;
use common::program::stdout;
use common::python::{python, target_folder};
use pylon::flight::{Channel, Column, Flight};
use serde_json::Value;

/// A flight, and a folder with its CSV.
fn made() -> (tempfile::TempDir, Flight) {
    let directory = tempfile::tempdir().unwrap();
    let mut flight = Recipe { captive_s: 20.0, free_s: 5.0, ..Recipe::default() }.make();
    // A sample that is NaN is not an empty cell.
    let (_, baro) = flight.channels.iter_mut().find(|(channel, _)| *channel == Channel::BaroAltM).unwrap();
    baro.set(7, Some(f32::NAN));
    baro.set(8, None);
    // More digits than f32 can hold, and sums that are exact in any order.
    let position = |start: f64| {
        let mut column = Column::empty_double(flight.rows());
        let fixes = flight.channel(Channel::GpsAltM).unwrap().samples();
        fixes.for_each(|(row, _)| assert!(column.set_f64(row, Some(start + row as f64 / 134_217_728.0))));
        column
    };
    let (latitude, longitude) = (position(47.0), position(8.0));
    flight.extra.push(("latitude_deg".to_owned(), latitude));
    flight.extra.push(("longitude_deg".to_owned(), longitude));
    flight.header.other.push(("recorder".to_owned(), "Größe \"7\"".to_owned()));
    pylon::flight::write(&directory.path().join("made.csv"), &flight).unwrap();
    (directory, flight)
}

/// The columns of a flight as a reader should see them: rows, samples, sum of the finite ones.
fn expected(flight: &Flight) -> Vec<(String, [f64; 3])> {
    let told = |column: &Column| {
        let values: Vec<f64> = column.samples_f64().map(|(_, value)| value).collect();
        let sum = values.iter().filter(|value| value.is_finite()).sum();
        [column.len() as f64, values.len() as f64, sum]
    };
    let rows = flight.rows() as f64;
    let time = ("time_s".to_owned(), [rows, rows, flight.time_s.iter().sum()]);
    let known = flight.channels.iter().map(|(channel, column)| (channel.name().to_owned(), told(column)));
    let signals = flight.extra.iter().map(|(name, column)| (name.clone(), told(column)));
    std::iter::once(time).chain(known).chain(signals).collect()
}

fn assert_same(reader: &str, found: &Value, expected: &[(String, [f64; 3])], relative: f64) {
    assert_eq!(found.as_object().unwrap().len(), expected.len(), "{reader}");
    for (name, told) in expected {
        let found: Vec<f64> = found[name]
            .as_array()
            .unwrap_or_else(|| panic!("{reader}: no {name}"))
            .iter()
            .map(|value| value.as_f64().unwrap())
            .collect();
        assert_eq!(found[..2], told[..2], "{reader}: {name}");
        assert!(
            (found[2] - told[2]).abs() <= relative * told[2].abs() + 1e-9,
            "{reader}: {name}: {found:?} {told:?}"
        );
    }
}

#[test]
fn other_programs_read_what_was_exported() {
    let (directory, flight) = made();
    for (format, file) in [("parquet", "made.parquet"), ("plain-csv", "plain.csv"), ("mcap", "made.mcap")] {
        stdout(directory.path(), &["export", "made.csv", "--format", format, "-o", file]);
    }
    let output = Command::new(python())
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/export_readers/read.py"))
        .args(["made.parquet", "plain.csv", "made.mcap"])
        .current_dir(directory.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read: Value = serde_json::from_slice(&output.stdout).unwrap();

    let expected = expected(&flight);
    assert_same("pyarrow", &read["pyarrow"]["columns"], &expected, 0.0);
    assert_same("duckdb", &read["duckdb"], &expected, 0.0);
    // The shortest decimals that give the same f32 back.
    assert_same("csv", &read["csv"], &expected, 1e-6);
    assert_eq!(read["pyarrow"]["groups"], 1);
    let metadata = &read["pyarrow"]["metadata"];
    assert_eq!(metadata["vehicle"], "made");
    assert_eq!(metadata["recorder"], "Größe \"7\"");
    let units: Value = serde_json::from_str(metadata["pylon-units"].as_str().unwrap()).unwrap();
    assert_eq!(
        (&units["baro_alt_m"], &units["gps_vd_mps"], &units["time_s"]),
        (&"m".into(), &"m/s".into(), &"s".into())
    );
    // MCAP: a message for every sample, null for one that is not finite.
    for (name, [_, samples, sum]) in expected.iter().skip(1) {
        let found = &read["mcap"][name];
        assert_eq!(found[0].as_f64(), Some(*samples), "mcap: {name}");
        assert!(
            (found[1].as_f64().unwrap() - sum).abs() <= 1e-6 * sum.abs() + 1e-6,
            "mcap: {name}: {found} {sum}"
        );
    }
}

/// The folder with Foxglove's reader, installed once; `None` without Node.js and npm.
fn node_readers() -> Option<std::path::PathBuf> {
    let has = |program: &str| {
        Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
    };
    if !has("node") || !has("npm") {
        println!("skipped: @mcap/core, without node and npm");
        return None;
    }
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/export_readers/node");
    let folder = target_folder().join("export-readers-node");
    let is_current = ["package-lock.json", "package.json"].iter().all(|file| {
        fs::read(folder.join("node_modules/.pinned").join(file))
            .is_ok_and(|found| found == fs::read(here.join(file)).unwrap())
    });
    fs::create_dir_all(&folder).unwrap();
    for file in ["package.json", "package-lock.json", "read.mjs"] {
        fs::copy(here.join(file), folder.join(file)).unwrap();
    }
    if !is_current {
        let quietly = ["ci", "--ignore-scripts", "--no-audit", "--no-fund", "--silent"];
        let output = Command::new("npm").args(quietly).current_dir(&folder).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let pinned = folder.join("node_modules/.pinned");
        fs::create_dir_all(&pinned).unwrap();
        for file in ["package.json", "package-lock.json"] {
            fs::copy(here.join(file), pinned.join(file)).unwrap();
        }
    }
    Some(folder)
}

/// Through its index and from its beginning, with every checksum; every message by the schema of its channel.
#[test]
fn foxgloves_own_reader_reads_the_mcap_by_its_schemas() {
    let Some(readers) = node_readers() else { return };
    let (directory, flight) = made();
    stdout(directory.path(), &["export", "made.csv", "--format", "mcap", "-o", "made.mcap"]);
    let output = Command::new("node")
        .arg(readers.join("read.mjs"))
        .arg(directory.path().join("made.mcap"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read: Value = serde_json::from_slice(&output.stdout).unwrap();
    for (name, [_, samples, sum]) in expected(&flight).iter().skip(1) {
        let found = &read["counts"][name];
        assert_eq!(found[0].as_f64(), Some(*samples), "{name}");
        assert!((found[1].as_f64().unwrap() - sum).abs() <= 1e-6 * sum.abs() + 1e-6, "{name}: {found} {sum}");
    }
    let schema_of = |topic: &str| read["channels"][topic].as_str().unwrap().to_owned();
    assert_eq!((schema_of("/gps"), schema_of("/baro")), ("pylon.gps".to_owned(), "pylon.baro".to_owned()));
    // The fixes also appear on Foxglove's map.
    assert_eq!(schema_of("/gps/fix"), "foxglove.LocationFix");
    let fixes = flight.extra[0].1.samples().count();
    let last = &read["fixes"][fixes - 1];
    assert_eq!(read["fixes"].as_array().unwrap().len(), fixes);
    let (row, latitude) = flight.extra[0].1.samples_f64().last().unwrap();
    assert_eq!(last["latitude"].as_f64().unwrap(), latitude, "{last}");
    let time_s =
        last["timestamp"]["sec"].as_f64().unwrap() + last["timestamp"]["nsec"].as_f64().unwrap() / 1e9;
    assert!((time_s - flight.time_s[row]).abs() < 1e-9, "{last}");
    assert_eq!(read["metadata"][0][0], "pylon-flight");
    assert_eq!(read["metadata"][0][1]["recorder"], "Größe \"7\"");
}
