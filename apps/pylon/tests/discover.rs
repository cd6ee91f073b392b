//! Laws over recorded signals: a simulated flight with a column of unknown meaning in, the law on the command
//! line out.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::Path;
use std::process::Command;

use common::Recipe;
use pylon::flight::{Channel, Column, Flight};
use serde_json::Value;

/// The flap's position at a row: it is out for some seconds now and then, which no other signal follows.
fn flap(row: usize) -> f32 {
    let time_s = row as f64 / common::ROWS_PER_S;
    let out = [
        (20.0, 26.0, 0.4),
        (95.0, 104.0, 0.5),
        (110.0, 117.0, 0.9),
        (128.0, 139.0, 0.3),
        (150.0, 160.0, 0.7),
    ];
    let now = out.iter().find(|(from_s, to_s, _)| (*from_s..*to_s).contains(&time_s));
    now.map_or(0.0, |(.., deflection)| *deflection)
}

/// A door that moves with the flap, except once by a little.
fn door(row: usize) -> f32 {
    let time_s = row as f64 / common::ROWS_PER_S;
    if (128.0..139.0).contains(&time_s) { 0.85 * flap(row) } else { flap(row) }
}

/// A simulated flight in which the flap adds this many metres per unit to the barometer; its column is
/// recorded.
fn flight(seed: u64, metres: f32) -> Flight {
    let mut flight = Recipe { free_s: 100.0, seed, climb_mps: common::dive_mps, ..Recipe::default() }.make();
    let column = |of: &dyn Fn(usize) -> Option<f32>| {
        let mut column = Column::with_capacity(flight.rows());
        (0..flight.rows()).for_each(|row| column.push(of(row)));
        column
    };
    let recorded = column(&|row| Some(flap(row)));
    let baro = flight.channel(Channel::BaroAltM).unwrap();
    let changed = column(&|row| baro.get(row).map(|value| value + metres * flap(row)));
    flight.set_channel(Channel::BaroAltM, changed);
    flight.extra.push(("flap".to_owned(), recorded));
    flight
}

fn write(folder: &Path, name: &str, flight: &Flight) {
    pylon::flight::to_writer(std::fs::File::create(folder.join(name)).unwrap(), flight).unwrap();
}

fn pylon(folder: &Path, arguments: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_pylon")).current_dir(folder).args(arguments).output().unwrap()
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = pylon(folder, arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The law is found with its coefficient and becomes a definition of a model; with that model no further law
/// is found.
#[test]
fn the_law_of_a_column_that_nobody_knows_is_found_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "flap.csv", &flight(3, 6.0));
    let found = json(folder, &["discover", "flap.csv", "--json", "--plots", "pictures"]);
    // The picture of the first law: it has the law's name, its axes and its curves.
    let picture = std::fs::read_to_string(folder.join("pictures/law-1.svg")).unwrap();
    for said in ["1. baro += c * flap", "law, m", "measured on baro, m", "left by it, m", "the law"] {
        assert!(picture.contains(said), "{said}: {picture}");
    }
    let pictures = std::fs::read_dir(folder.join("pictures")).unwrap().count();
    assert_eq!(pictures, found["laws"].as_array().unwrap().len());
    let law = &found["laws"][0];
    assert_eq!(law["on"], "baro", "{found:#}");
    assert_eq!(law["regressor"], "flap", "{found:#}");
    assert_eq!(law["unit"], "m");
    let (coefficient, sigma) = (law["coefficient"].as_f64().unwrap(), law["sigma"].as_f64().unwrap());
    // Four of its own sigmas: one false alarm in 16,000 seeds.
    assert!(sigma > 0.0 && sigma < 1.5 && (coefficient - 6.0).abs() < 4.0 * sigma, "{law:#}");
    let rms = |key: &str| law[key].as_f64().unwrap();
    assert!(rms("rms_after_m") < rms("rms_before_m"), "{law:#}");
    assert!(found["laws"].as_array().unwrap().len() <= 5);
    assert_eq!(found["without_unit"], serde_json::json!(["flap"]));

    std::fs::write(folder.join("ours.toml"), "# ours\n").unwrap();
    let written = pylon(folder, &["discover", "flap.csv", "--write", "ours.toml", "1"]);
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    let said = String::from_utf8(written.stdout).unwrap();
    assert!(said.contains("pylon add baro.flap --model ours.toml --from flap.csv"), "{said}");
    let model = std::fs::read_to_string(folder.join("ours.toml")).unwrap();
    assert!(model.starts_with("# ours\n") && model.contains("[[effect_definition]]"), "{model}");
    let again = pylon(folder, &["discover", "flap.csv", "--write", "ours.toml", "9"]);
    assert_eq!(again.status.code(), Some(2), "there is no law 9");
    assert_eq!(std::fs::read_to_string(folder.join("ours.toml")).unwrap(), model);

    let added = pylon(folder, &["add", "baro.flap", "--model", "ours.toml", "--from", "flap.csv"]);
    assert!(added.status.success(), "{}", String::from_utf8_lossy(&added.stderr));
    let rest = json(folder, &["discover", "flap.csv", "--model", "ours.toml", "--json"]);
    assert_eq!(rest["laws"], serde_json::json!([]), "{rest:#}");
}

/// A door that moves with the flap could be the cause as well: both are reported as equal on this flight,
/// with the manoeuvre that would distinguish them.
#[test]
fn laws_that_are_equal_on_a_flight_are_named_with_the_manoeuvre_that_tells_them_apart() {
    let folder = tempfile::tempdir().unwrap();
    let mut flown = flight(5, 1.5);
    let mut column = Column::with_capacity(flown.rows());
    (0..flown.rows()).for_each(|row| column.push(Some(door(row))));
    flown.extra.push(("door".to_owned(), column));
    write(folder.path(), "both.csv", &flown);
    let found = json(folder.path(), &["discover", "both.csv", "--json"]);
    let laws = found["laws"].as_array().unwrap();
    let of = |name: &str| laws.iter().find(|law| law["regressor"] == name);
    let law = of("flap").or_else(|| of("door")).unwrap_or_else(|| panic!("{found:#}"));
    let other = if law["regressor"] == "flap" { "door" } else { "flap" };
    let equals = law["equal_to"].as_array().unwrap();
    assert!(equals.iter().any(|equal| equal["law"].as_str().unwrap().contains(other)), "{law:#}");
    let advice = law["advice"].as_str().unwrap();
    // Either is moved while the other stays.
    assert!(advice.contains("moved in steps of 10 s between 0 and 0.9"), "{law:#}");
    let said = String::from_utf8(pylon(folder.path(), &["discover", "both.csv"]).stdout).unwrap();
    assert!(said.contains(advice), "{said}");
}

#[test]
fn a_flight_without_a_misfit_has_no_law() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "null.csv", &flight(4, 0.0));
    let found = json(folder.path(), &["discover", "null.csv", "--json"]);
    assert_eq!(found["laws"], serde_json::json!([]), "{found:#}");
    assert!(found["none"].as_f64().unwrap() > 0.95);
}
