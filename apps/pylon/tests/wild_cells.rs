//! Implausible cells, in every column of a simulated flight: a file in, the verdict and the sentence out.
//! They change no verdict, change a coefficient by less than half a sigma, and are reported.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::path::Path;

use common::program::stdout;
use pylon::flight::{Channel, Flight, to_writer};
use pylon::simulate::{load_scenario, simulate};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// For each column a value that an aircraft has only at other times, or never.
const WILD: [(Channel, f32); 14] = [
    (Channel::TasMps, 300.0),
    (Channel::TasMps, 1_000.0),
    (Channel::BaroPa, 60_000.0),
    (Channel::BaroTempC, 500.0),
    (Channel::GpsAltM, 5_000.0),
    (Channel::GpsVnMps, 900.0),
    (Channel::GpsVdMps, 200.0),
    (Channel::ImuMasterAltM, -500.0),
    (Channel::ImuSlaveAltM, 9_000.0),
    (Channel::RollRad, 3.0),
    (Channel::PitchRad, 1.5),
    (Channel::AoaRad, 1.5),
    (Channel::SideslipRad, -1.4),
    (Channel::OatC, 300.0),
];

fn hidden() -> Flight {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../flights/hidden-static-port.toml");
    let scenario = load_scenario(&file).unwrap();
    simulate(&scenario, scenario.seed).unwrap().0
}

/// The flight with this share of a column's cells, and at least one, set to that value.
fn planted(mut flight: Flight, channel: Channel, value: f32, share: f64) -> Flight {
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let column =
        flight.channels.iter_mut().find(|(name, _)| *name == channel).map(|(_, column)| column).unwrap();
    let mut rows: Vec<usize> = column.samples().map(|(row, _)| row).collect();
    for _ in 0..((share * rows.len() as f64) as usize).max(1) {
        let row = rows.swap_remove(random.random_range(0..rows.len()));
        column.set(row, Some(value));
    }
    flight
}

fn write(folder: &Path, name: &str, flight: &Flight) -> String {
    to_writer(std::fs::File::create(folder.join(name)).unwrap(), flight).unwrap();
    name.to_owned()
}

/// The effects missing for the barometer, their coefficient and sigma; and those missing for the other
/// sensors.
fn verdict(folder: &Path, file: &str) -> (Vec<String>, [f64; 2], Vec<String>) {
    let text = stdout(folder, &["diagnose", "--json", file]);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let names = |sensor: &serde_json::Value| -> Vec<String> {
        sensor["missing"].as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned()).collect()
    };
    let sensors = json["sensors"].as_object().unwrap();
    let baro = &sensors["baro"];
    let first = &baro["candidates"][0];
    let others =
        sensors.iter().filter(|(name, _)| *name != "baro").flat_map(|(_, sensor)| names(sensor)).collect();
    (names(baro), ["coefficient", "sigma"].map(|key| first[key].as_f64().unwrap()), others)
}

#[test]
fn wild_cells_in_any_column_change_no_verdict() {
    let folder = tempfile::tempdir().unwrap();
    let flight = hidden();
    let (missing, [coefficient, sigma], others) =
        verdict(folder.path(), &write(folder.path(), "clean.csv", &flight));
    assert_eq!((missing.as_slice(), others.len()), (["baro.dynamic_pressure".to_owned()].as_slice(), 0));
    for (channel, value) in WILD {
        for share in [0.0, 0.009] {
            let name = format!("{} {value} {share}.csv", channel.name());
            let file = write(folder.path(), &name, &planted(flight.clone(), channel, value, share));
            let (found, [moved, _], others) = verdict(folder.path(), &file);
            assert_eq!((found, others.len()), (missing.clone(), 0), "{name}");
            assert!((moved - coefficient).abs() < 0.5 * sigma, "{name}: {moved}, {coefficient} +- {sigma}");
        }
    }
}

/// One burst of 2.3 s in every column: just below a hundredth of its cells, those of the
/// columns of [`WILD`] and of those that have no largest rate.
#[test]
fn a_burst_in_any_column_changes_no_verdict() {
    let folder = tempfile::tempdir().unwrap();
    let flight = hidden();
    let (missing, [coefficient, sigma], _) =
        verdict(folder.path(), &write(folder.path(), "clean.csv", &flight));
    let others = [
        (Channel::GpsVeMps, -900.0),
        (Channel::AccelXMps2, 900.0),
        (Channel::AccelZMps2, -900.0),
        (Channel::GyroXRadps, 60.0),
        (Channel::YawRad, 9.0),
        (Channel::Throttle, 50.0),
    ];
    for (channel, value) in WILD.into_iter().chain(others) {
        let mut burst = flight.clone();
        // The mother ship's altitude ends with the launch.
        let from_s = if channel == Channel::ImuMasterAltM { 100.0 } else { 170.0 };
        let rows: Vec<usize> =
            (0..burst.rows()).filter(|row| (from_s..from_s + 2.3).contains(&burst.time_s[*row])).collect();
        let column =
            burst.channels.iter_mut().find(|(name, _)| *name == channel).map(|(_, column)| column).unwrap();
        for row in rows {
            if column.get(row).is_some() {
                column.set(row, Some(value));
            }
        }
        let name = format!("{} {value} burst.csv", channel.name());
        let (found, [moved, _], others) = verdict(folder.path(), &write(folder.path(), &name, &burst));
        assert_eq!((found, others.len()), (missing.clone(), 0), "{name}");
        assert!((moved - coefficient).abs() < 0.5 * sigma, "{name}: {moved}, {coefficient} +- {sigma}");
    }
}

#[test]
fn wild_cells_are_said_with_column_value_time_and_number() {
    let folder = tempfile::tempdir().unwrap();
    let one = write(folder.path(), "one.csv", &planted(hidden(), Channel::TasMps, 300.0, 0.0));
    let many = write(folder.path(), "many.csv", &planted(hidden(), Channel::BaroPa, 60_000.0, 0.009));
    let said = |file: &str| stdout(folder.path(), &["diagnose", file]);
    let text = said(&one);
    assert!(text.contains("tas_mps is 300 at ") && text.contains("which is implausible; left out"), "{text}");
    let text = said(&many);
    assert!(text.contains("111 cells of baro_pa are implausible (60000 at "), "{text}");
    let clean = said(&write(folder.path(), "clean.csv", &hidden()));
    assert!(!clean.contains("is implausible") && !clean.contains("are implausible"), "{clean}");
}
