//! What `pylon export` writes, read by the readers of those who use it: pyarrow, DuckDB, Python's csv and the MCAP library. They are
//! installed by pip into the build's folder.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;

use common::Recipe;
use common::program::stdout;
use pylon::flight::{Channel, Column, Flight};
use serde_json::Value;

const PACKAGES: [&str; 3] = ["pyarrow", "duckdb", "mcap"];

/// Python with the packages; they are installed once.
fn python() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| here.join("../target"), PathBuf::from);
    let folder = target.join("export-readers");
    let python = folder.join("bin/python");
    let imports = format!("import {}", PACKAGES.join(", "));
    let has_all =
        || Command::new(&python).args(["-c", &imports]).output().is_ok_and(|output| output.status.success());
    if !has_all() {
        let run = |program: &Path, arguments: &[&str]| {
            let output = Command::new(program).args(arguments).output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        };
        run(Path::new("python3"), &["-m", "venv", folder.to_str().unwrap()]);
        let requirements = here.join("tests/export_readers/requirements.txt");
        let quietly = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"];
        run(&python, &[&quietly[..], &[requirements.to_str().unwrap()]].concat());
        assert!(has_all());
    }
    python
}

/// The columns of a flight as a reader should see them: rows, samples, sum of the finite ones.
fn expected(flight: &Flight) -> Vec<(String, [f64; 3])> {
    let told = |column: &Column| {
        let values: Vec<f64> = column.samples().map(|(_, value)| f64::from(value)).collect();
        let sum = values.iter().filter(|value| value.is_finite()).sum();
        [column.len() as f64, values.len() as f64, sum]
    };
    let rows = flight.rows() as f64;
    let time = ("time_s".to_owned(), [rows, rows, flight.time_s.iter().sum()]);
    let known = flight.channels.iter().map(|(channel, column)| (channel.name().to_owned(), told(column)));
    std::iter::once(time).chain(known).collect()
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
    let directory = tempfile::tempdir().unwrap();
    let mut flight = Recipe { captive_s: 20.0, free_s: 5.0, ..Recipe::default() }.make();
    // A sample that is none is not an empty cell.
    let (_, baro) = flight.channels.iter_mut().find(|(channel, _)| *channel == Channel::BaroAltM).unwrap();
    baro.set(7, Some(f32::NAN));
    baro.set(8, None);
    flight.header.other.push(("recorder".to_owned(), "Größe \"7\"".to_owned()));
    pylon::flight::write(&directory.path().join("made.csv"), &flight).unwrap();
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
    // The digits are the fewest that give the same f32 back.
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
    // MCAP: a message for every sample, null for what is no number.
    for (name, [_, samples, sum]) in expected.iter().skip(1) {
        let found = &read["mcap"][name];
        assert_eq!(found[0].as_f64(), Some(*samples), "mcap: {name}");
        assert!(
            (found[1].as_f64().unwrap() - sum).abs() <= 1e-6 * sum.abs() + 1e-6,
            "mcap: {name}: {found} {sum}"
        );
    }
}
