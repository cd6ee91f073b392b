use std::fs;
use std::path::Path;

use super::*;
use crate::flight::{Channel, to_writer};

const SHORT: &str = r#"
    name = "short"
    seed = 4
    [captive]
    duration_s = 10
    altitude_m = 800
    airspeed_mps = 28
    [turbulence]
    horizontal_sigma_mps = 0.5
    vertical_sigma_mps = 0.3
    [[free_flight]]
    manoeuvre = "dive"
    duration_s = 5
    flight_path_deg = -15
    [sensors.baro]
    bias_m = 20
    [[effect]]
    id = "baro.dynamic_pressure"
    coefficient = 0.05
"#;

fn bytes(text: &str, seed: u64) -> Vec<u8> {
    let scenario = Scenario::from_toml(text, "short.toml").unwrap();
    let (flight, _) = simulate(&scenario, seed).unwrap();
    let mut out = Vec::new();
    to_writer(&mut out, &flight).unwrap();
    out
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_seed_others() {
    assert_eq!(bytes(SHORT, 4), bytes(SHORT, 4));
    assert_ne!(bytes(SHORT, 4), bytes(SHORT, 5));
}

#[test]
fn one_sensors_setting_leaves_the_others_noise_alone() {
    let scenario = Scenario::from_toml(SHORT, "short.toml").unwrap();
    let mut noisier = scenario.clone();
    noisier.sensors.baro.noise.white = 9.0;
    noisier.sensors.imu_master.sampling.enabled = false;
    noisier.sensors.gps.sampling.dropout_probability = 0.3;
    let (one, _) = simulate(&scenario, 1).unwrap();
    let (two, _) = simulate(&noisier, 1).unwrap();
    let cells = |flight: &Flight, channel: Channel| -> Vec<(usize, u32)> {
        flight.channel(channel).unwrap().samples().map(|(row, value)| (row, value.to_bits())).collect()
    };
    for channel in [Channel::ImuSlaveAltM, Channel::AccelZMps2, Channel::TasMps, Channel::RollRad] {
        assert_eq!(cells(&one, channel), cells(&two, channel), "{}", channel.name());
    }
    assert_ne!(cells(&one, Channel::BaroPa), cells(&two, Channel::BaroPa));
    assert!(two.channel(Channel::ImuMasterAltM).is_none());
    // What is left of the fixes is what it was.
    let (all, left) = (cells(&one, Channel::GpsAltM), cells(&two, Channel::GpsAltM));
    assert!(left.len() < all.len() && left.iter().all(|cell| all.contains(cell)));
}

#[test]
fn every_channel_of_the_format_is_filled_at_its_rate() {
    let scenario = Scenario::from_toml(SHORT, "short.toml").unwrap();
    let (flight, truth) = simulate(&scenario, 1).unwrap();
    assert_eq!((flight.rows(), truth.rows), (3000, 3000));
    assert_eq!(truth.launch_s, Some(10.0));
    for channel in Channel::ALL {
        let samples = flight.channel(*channel).map(|column| column.samples().count());
        let expected = match channel.name() {
            // Either pressure or altitude: the simulator writes pressure.
            "baro_alt_m" => None,
            // A flight computer's.
            "launch_doubt" => None,
            "launch" => Some(3000),
            name if name.starts_with("gps") => Some(75),
            name if name.starts_with("accel") || name.starts_with("gyro") => Some(3000),
            "imu_master_alt_m" => Some(500),
            _ => Some(750),
        };
        assert_eq!(samples, expected, "{}", channel.name());
    }
    let launch = flight.channel(Channel::Launch).unwrap();
    assert_eq!((launch.get(1999), launch.get(2000)), (Some(0.0), Some(1.0)));
    assert!(flight.header.source.starts_with("pylon simulate: "), "{}", flight.header.source);
}

#[test]
fn the_truth_says_what_a_calibration_should_find() {
    let text = SHORT.replace("id = \"baro", "phase = \"captive\"\nid = \"baro");
    let mut scenario = Scenario::from_toml(&text, "short.toml").unwrap();
    scenario.sensors.gps.bias_m = 3.0;
    let (_, truth) = simulate(&scenario, 1).unwrap();
    let head = truth.trajectory[..2000].iter().map(|s| s.airspeed_mps.powi(2) / 19.613_3).sum::<f64>() / 2e3;
    let baro = truth.sensors["baro"];
    assert!((baro.captive_offset_m - (20.0 + 0.05 * head - 3.0)).abs() < 1e-9, "{baro:?}");
    assert!((truth.sensors["imu_slave"].captive_offset_m + 3.0).abs() < 1e-12);
}

fn files(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_run_writes_the_flight_and_the_truth_apart_from_it() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    fs::write(at("short.toml"), SHORT).unwrap();
    let summary = run(&at("short.toml"), &at("flight.csv"), &at("truth.toml")).unwrap();
    assert_eq!((summary.seed, summary.rows, summary.launch_s), (4, 3000, Some(10.0)));
    assert_eq!(fs::read(at("flight.csv")).unwrap(), bytes(SHORT, 4));
    // Nothing of what was injected is in the flight; all of it in the truth.
    let flight = String::from_utf8(fs::read(at("flight.csv")).unwrap()).unwrap();
    assert!(!flight.contains("dynamic_pressure"));
    let truth: toml::Table = fs::read_to_string(at("truth.toml")).unwrap().parse().unwrap();
    assert_eq!(truth["effect"][0]["id"].as_str(), Some("baro.dynamic_pressure"));
    assert_eq!(truth["effect"][0]["coefficient"].as_float(), Some(0.05));
    assert_eq!(truth["sensors"]["baro"]["bias_m"].as_float(), Some(20.0));
    assert_eq!(truth["launch_s"].as_float(), Some(10.0));

    let other = run_with_seed(&at("short.toml"), Some(9), &at("flight.csv"), &at("truth.toml")).unwrap();
    assert_eq!(other.seed, 9);
    assert_eq!(fs::read(at("flight.csv")).unwrap(), bytes(SHORT, 9));
}

#[test]
fn a_run_that_fails_says_why_in_one_line_and_leaves_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    fs::write(at("ground.toml"), SHORT.replace("altitude_m = 800", "altitude_m = 4")).unwrap();
    fs::write(at("typo.toml"), SHORT.replace("bias_m", "bais_m")).unwrap();
    fs::write(at("short.toml"), SHORT).unwrap();
    let before = files(directory.path());
    for (scenario, output, truth, expected) in [
        ("ground.toml", "f.csv", "t.toml", "below sea level at"),
        ("typo.toml", "f.csv", "t.toml", "typo.toml:16: unknown field `bais_m`; did you mean `bias_m`?"),
        ("none.toml", "f.csv", "t.toml", "none.toml: cannot read the scenario: "),
        ("short.toml", "no/f.csv", "t.toml", "no/f.csv: can not be written: "),
        ("short.toml", "f.csv", "no/t.toml", "no/t.toml: can not be written: "),
    ] {
        let error = run(&at(scenario), &at(output), &at(truth)).unwrap_err().to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{error}");
        assert_eq!(files(directory.path()), before, "{scenario} {output} {truth}");
    }
}

#[test]
fn bundled_scenarios_fly() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../flights");
    let mut flown = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            let mut scenario = Scenario::load(&path).unwrap();
            // The hour is the same after five minutes.
            scenario.captive.duration_s = scenario.captive.duration_s.min(300.0);
            simulate(&scenario, scenario.seed).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            flown += 1;
        }
    }
    assert!(flown >= 4);
}
