//! Any table of numbers, by a mapping that is drafted, read and used on the command line.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fs;
use std::path::Path;

use common::Recipe;
use common::program::{files, refusal, run, stdout};

/// A generated flight as a user's own table: other names, other units, semicolons.
fn write_table(directory: &Path) {
    Recipe { captive_s: 60.0, free_s: 30.0, climb_mps: |_| -8.0, ..Recipe::default() }.write(directory);
    let text = fs::read_to_string(directory.join("made.csv")).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut table = String::new();
    for name in &names {
        table += match *name {
            "time_s" => "Zeit [ms];",
            "gps_alt_m" => "GPS alt [ft];",
            "gps_vd_mps" => "GPS climb [ft/min];",
            "baro_alt_m" => "Baro altitude;",
            "tas_mps" => "colour;",
            other => other,
        };
        if !table.ends_with(';') {
            table.push(';');
        }
    }
    table.push('\n');
    for line in lines {
        for (name, cell) in names.iter().zip(line.split(',')) {
            let cell = match (cell.parse::<f64>(), *name) {
                (Ok(value), "time_s") => (value * 1_000.0).to_string(),
                (Ok(value), "gps_alt_m") => (value / 0.3048).to_string(),
                (Ok(value), "gps_vd_mps") => (-value / 0.3048 * 60.0).to_string(),
                _ => cell.to_owned(),
            };
            table += &format!("{cell};");
        }
        table.push('\n');
    }
    fs::remove_file(directory.join("made.csv")).unwrap();
    fs::write(directory.join("log.csv"), table).unwrap();
}

#[test]
fn a_table_is_guessed_corrected_imported_and_flown() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    write_table(path);
    // Every command reports what to do about it, with commands that can be pasted.
    for command in [&["import", "log.csv", "-o", "flight.csv"][..], &["compare", "log.csv"]] {
        let said = refusal(path, command);
        assert!(said.contains("'pylon import log.csv --guess -o mapping.toml' drafts"), "{said}");
    }
    let said = stdout(path, &["import", "log.csv", "--guess", "-o", "mapping.toml"]);
    assert!(said.contains("gps_alt_m: 'GPS alt [ft]'"), "{said}");
    assert!(said.contains("not placed: 'colour'"), "{said}");
    assert!(said.contains("DOUBTFUL: 'Baro altitude'"), "{said}");
    assert!(said.ends_with("then 'pylon import log.csv --mapping mapping.toml -o flight.csv'\n"), "{said}");
    assert_eq!(files(path), ["log.csv", "mapping.toml"]);
    // A draft is never overwritten by another, and is printed if no file is given.
    let again = refusal(path, &["import", "log.csv", "--guess", "-o", "mapping.toml"]);
    assert!(again.contains("mapping.toml: already exists and would be overwritten"), "{again}");
    let draft = fs::read_to_string(path.join("mapping.toml")).unwrap();
    assert_eq!(stdout(path, &["import", "log.csv", "--guess"]), draft);

    let corrected = draft.replace("# baro_alt_m = ", "baro_alt_m = ");
    assert_ne!(corrected, draft);
    fs::write(path.join("mapping.toml"), corrected).unwrap();
    let output = run(path, &["import", "log.csv", "--mapping", "mapping.toml", "-o", "flight.csv"]);
    let notes = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.success() && notes.contains("note: columns that the mapping does not name, left out: "),
        "{notes}"
    );
    let compared = stdout(path, &["compare", "flight.csv"]);
    assert!(compared.contains("launch at 60.000 s"), "{compared}");
}

#[test]
fn what_is_wrong_is_said_in_one_line_and_nothing_is_written() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    write_table(path);
    fs::write(path.join("binary"), [0_u8; 64]).unwrap();
    fs::write(path.join("prose.txt"), "dear diary\ntoday we flew\n").unwrap();
    fs::write(path.join("wrong.toml"), "pylon-mapping = 1\n[time]\ncolum = 1\n").unwrap();
    fs::write(path.join("other.toml"), "x = 1\n").unwrap();
    fs::write(path.join("good.toml"), "pylon-mapping = 1\n[time]\ncolumn = \"Zeit\"\nunit = \"ms\"\n")
        .unwrap();
    let before = files(path);
    let import = |log: &'static str, mapping: &'static str| {
        refusal(path, &["import", log, "--mapping", mapping, "-o", "flight.csv"])
    };
    assert!(import("log.csv", "none.toml").starts_with("error: none.toml: cannot be read: "));
    assert!(import("log.csv", "wrong.toml").starts_with("error: wrong.toml: line 3: unknown field `colum`"));
    assert!(import("log.csv", "other.toml").starts_with("error: other.toml: "));
    assert!(import("binary", "good.toml").contains("error: binary: it is not text"));
    let said = import("log.csv", "good.toml");
    assert!(said.contains("error: good.toml: [time] no column 'Zeit' in the table"), "{said}");
    let guess = |log: &'static str| refusal(path, &["import", log, "--guess", "-o", "m.toml"]);
    assert!(guess("prose.txt").contains("no table of numbers was found in it"));
    assert!(guess("binary").contains("it is not text"));
    assert!(guess("none.csv").contains("there is no such file"));
    assert!(refusal(path, &["import", "log.csv"]).contains("--output"));
    let lost = refusal(path, &["import", "log.csv", "--mapping", "good.toml", "-o", "good.toml"]);
    assert!(lost.contains("is the mapping, which would be lost"), "{lost}");
    assert_eq!(files(path), before);
}

/// A ten-millionth of a degree is a centimetre, and the resolution of receivers; f32 would turn it into a
/// metre.
#[test]
fn every_digit_of_a_position_comes_through_import_csv_and_exports() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    let positions =
        [("47.1234567", "-179.7654321"), ("47.1234568", "-179.765432"), ("47.1234569", "-179.7654319")];
    let mut table = "time,lat,lon,alt,baro\n".to_owned();
    for (second, (latitude, longitude)) in positions.iter().enumerate() {
        table += &format!("{second},{latitude},{longitude},{},{}\n", 500 + second, 510 + second);
    }
    fs::write(path.join("log.csv"), table).unwrap();
    let mapping = "pylon-mapping = 1\n[time]\ncolumn = \"time\"\nunit = \"s\"\n[signals]\n\
                   gps_alt_m = { column = \"alt\", unit = \"m\" }\nbaro_alt_m = { column = \"baro\", unit = \"m\" }\n\
                   latitude_deg = { column = \"lat\", unit = \"deg\" }\nlongitude_deg = { column = \"lon\", unit = \"deg\" }\n";
    fs::write(path.join("mapping.toml"), mapping).unwrap();
    stdout(path, &["import", "log.csv", "--mapping", "mapping.toml", "-o", "flight.csv"]);
    let found = |file: &str| -> Vec<(String, String)> {
        let text = fs::read_to_string(path.join(file)).unwrap();
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        let place = |name: &str| names.iter().position(|found| *found == name).unwrap();
        let (latitude, longitude) = (place("latitude_deg"), place("longitude_deg"));
        let cells = lines.map(|line| line.split(',').collect::<Vec<_>>());
        cells.map(|cells| (cells[latitude].to_owned(), cells[longitude].to_owned())).collect()
    };
    let expected: Vec<(String, String)> = positions
        .iter()
        .map(|(latitude, longitude)| ((*latitude).to_owned(), (*longitude).to_owned()))
        .collect();
    assert_eq!(found("flight.csv"), expected);
    // Every export reads the flight's CSV; the two formats that can be imported are written as CSV again.
    stdout(path, &["export", "flight.csv", "--format", "plain-csv", "-o", "plain.csv"]);
    assert_eq!(found("plain.csv"), expected);
    for (format, file, again) in
        [("mcap", "a.mcap", "of_mcap.csv"), ("parquet", "a.parquet", "of_parquet.csv")]
    {
        stdout(path, &["export", "flight.csv", "--format", format, "-o", file]);
        stdout(path, &["import", file, "-o", again]);
        assert_eq!(found(again), expected, "{format}");
    }
}
