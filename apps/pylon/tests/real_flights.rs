//! Every available real log: its format, its take-off and landing, and which part is used. The logs are read
//! in place; the test reports if they are missing. The table is `real_flights/table.txt`, whose take-offs and
//! landings were read off plots.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use model::Model;
use pylon::import::{format_name, open};
use pylon::overview::{Overview, SensorState};
use pylon::replay::{GivenTimes, Replay};

/// Largest allowed distance of a take-off or landing from the plotted one, seconds: two blocks of the slowest
/// logger.
const WITHIN_S: f64 = 20.0;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/flights/real")
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_none_or(|ending| ending != "md") {
            found.push(path);
        }
    }
}

fn table() -> BTreeMap<String, Vec<String>> {
    let text = include_str!("real_flights/table.txt");
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines
        .map(|line| {
            let mut cells = line.split(" | ").map(str::to_owned);
            (cells.next().unwrap(), cells.collect())
        })
        .collect()
}

/// A time in the table's notation.
fn is_at(found: Option<f64>, expected: &str) -> bool {
    match (found, expected.parse::<f64>()) {
        (Some(found), Ok(expected)) => (found - expected).abs() <= WITHIN_S,
        (None, Err(_)) => expected == "air",
        _ => false,
    }
}

fn sensors(overview: &Overview) -> String {
    fn name(sensor: &str) -> &str {
        match sensor {
            "receiver's altitude" => "gps",
            "receiver's velocity" => "velocity",
            "barometer" => "baro",
            "accelerometer" => "accel",
            "air's temperature" => "oat",
            "inertial altitude" => "imu",
            other => other,
        }
    }
    let words = overview.sensors.iter().map(|view| match view.state {
        SensorState::Present => name(&view.sensor).to_owned(),
        SensorState::Stuck => format!("{}:stuck", name(&view.sensor)),
        SensorState::Copied => format!("{}:copied", name(&view.sensor)),
        SensorState::Absent => format!("{}:absent", name(&view.sensor)),
    });
    words.collect::<Vec<_>>().join(" ")
}

#[test]
fn every_real_log_is_what_the_table_says_and_nothing_is_analysed_after_a_landing() {
    let folder = folder();
    if !folder.exists() {
        println!("skipped: every_real_log_is_what_the_table_says (no {})", folder.display());
        return;
    }
    let table = table();
    let mut found = Vec::new();
    files(&folder, &mut found);
    found.sort();
    let mut wrong = Vec::new();
    for file in &found {
        let name = file.strip_prefix(&folder).unwrap().display().to_string();
        let Some(row) = table.get(&name) else {
            wrong.push(format!("{name}: not in the table"));
            continue;
        };
        if let Err(why) = check(file, row) {
            wrong.push(format!("{name}: {why}"));
        }
    }
    for name in table.keys().filter(|name| !folder.join(name).exists()) {
        println!("skipped: {name}");
    }
    assert!(found.len() >= 50, "{} logs", found.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn check(file: &Path, row: &[String]) -> Result<(), String> {
    let (flight, notes) = match (open(file), row) {
        (Err(error), [refused, begins]) if refused == "refused" => {
            let why = error.problem.to_string();
            return if why.starts_with(begins.as_str()) { Ok(()) } else { Err(why) };
        }
        (read, _) => read.map_err(|error| error.to_string())?,
    };
    let [kind, duration, flights, used, expected] = row else { return Err(format!("is read: {row:?}")) };
    let overview = Overview::new("log", format_name(file).unwrap(), &flight, &notes, None);
    let says = |what: &str, found: String| Err(format!("{what}: {found}"));
    if overview.format != *kind {
        return says("kind", overview.format);
    }
    if format!("{:.0}", overview.duration_s) != *duration {
        return says("duration", overview.duration_s.to_string());
    }
    let expected_flights: Vec<&str> = flights.split(' ').filter(|word| *word != "none").collect();
    let agrees = expected_flights.len() == overview.airborne.len()
        && expected_flights.iter().zip(&overview.airborne).all(|(expected, found)| {
            let (take_off, landing) = expected.split_once("..").unwrap();
            is_at(found.take_off_s, take_off) && is_at(found.landing_s, landing)
        });
    if !agrees {
        return says("flights", format!("{:?}", overview.airborne));
    }
    // Only one of these is a rocket; the others, gliders, copters and a lost motor among them, are not.
    let is_launched = overview.notes.iter().any(|note| note.starts_with("launched by a rocket motor"));
    if is_launched != (kind == "AltusMetrum CSV") {
        return says("launched by a rocket motor", is_launched.to_string());
    }
    if sensors(&overview) != *expected {
        return says("sensors", sensors(&overview));
    }
    if let Some(why) = used.strip_prefix("nothing: ") {
        let refused = overview.refused.unwrap_or_default();
        return if refused.starts_with(why) { Ok(()) } else { says("refused", refused) };
    }
    let share = 100.0 * overview.usage.used_share;
    if (share - used.parse::<f64>().unwrap()).abs() > 2.0 {
        return says("used", share.to_string());
    }
    // The reported use is the actual use, for every kind of replay.
    let model = Model::default();
    let given = GivenTimes::default();
    for replay in [
        Replay::new(&flight, &model, given),
        Replay::calibrated_or_not(&flight, &model, given),
        Replay::to_diagnose(&flight, &model, given),
    ] {
        let replay = replay.unwrap();
        let landing_s =
            replay.extent().interval().and_then(|interval| interval.landing_s).unwrap_or(f64::INFINITY);
        let last_us = replay.inputs().map(|input| input.time_us).max().unwrap();
        let calibrated_s = replay.source().window().map_or(0.0, |window| window.end_s);
        // Ticks are rounded to microseconds.
        if last_us as f64 * 1e-6 > landing_s + 1e-6 || calibrated_s > landing_s {
            return says(
                "analysed after its landing",
                format!("{last_us} us, calibrated until {calibrated_s} s"),
            );
        }
        let [used, all] = [replay.inputs().count(), flight.rows()].map(|rows| rows as f64);
        if replay.unused().is_empty() && used < 0.95 * all {
            return says("left out and not said", format!("{used} of {all} rows"));
        }
    }
    Ok(())
}
