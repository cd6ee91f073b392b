//! Logs that are odd as a whole: a pressure setting changed in flight, a reference that is worse than the
//! sensor, receivers that disagree, hours on the ground, a minute, gaps, sensors that measure nothing. A file
//! in, a named and honest answer out; nowhere a cause that does not act.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use common::program::{refusal, stdout};
use pylon::flight::{Channel, Column, Flight, to_writer};
use pylon::simulate::{load_scenario, simulate};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Circles in thermals, and glides between them, metres.
fn soaring_m(time_s: f64) -> f64 {
    let sine = |size_m: f64, period_s: f64| size_m * (TAU * time_s / period_s).sin();
    1500.0 + sine(300.0, 1500.0) + sine(40.0, 140.0) + sine(6.0, 26.0)
}

/// A log of one fix and one reading of the barometer a second, both in whole metres, without climb rates.
struct Log {
    seed: u64,
    seconds: u32,
    altitude_m: fn(f64) -> f64,
    /// Added to the barometer and to the receiver, metres, by time.
    baro_m: fn(f64) -> f64,
    receiver_m: fn(f64) -> f64,
    /// White noise of a fix, and the receiver's wander over 100 s, metres.
    receiver_noise_m: [f64; 2],
    /// The barometer's delay, seconds.
    late_s: f64,
    /// Seconds without a row.
    is_gap: fn(u32) -> bool,
    /// A second receiver: its error, metres, by time.
    other_m: Option<fn(f64) -> f64>,
}

impl Default for Log {
    fn default() -> Self {
        Self {
            seed: 1,
            seconds: 2400,
            altitude_m: soaring_m,
            baro_m: |_| 0.0,
            receiver_m: |_| 0.0,
            receiver_noise_m: [0.8, 2.0],
            late_s: 0.0,
            is_gap: |_| false,
            other_m: None,
        }
    }
}

impl Log {
    /// Writes it as `log.csv` into a folder of its own.
    fn write(&self) -> TempDir {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
        let other = if self.other_m.is_some() { ",gps_2_alt_m" } else { "" };
        let mut text = format!("# pylon-flight: 1\ntime_s,gps_alt_m,baro_alt_m{other}\n");
        let [white_m, wander_sigma_m] = self.receiver_noise_m;
        let mut wander_m = 0.0;
        for second in 0..self.seconds {
            let time_s = f64::from(second);
            wander_m = 0.99 * wander_m + wander_sigma_m * (1.0_f64 - 0.99 * 0.99).sqrt() * normal();
            let fix_m = (self.altitude_m)(time_s) + wander_m + white_m * normal() + (self.receiver_m)(time_s);
            let baro_m =
                (self.altitude_m)(time_s - self.late_s) - 25.0 + 0.4 * normal() + (self.baro_m)(time_s);
            if (self.is_gap)(second) {
                continue;
            }
            text += &format!("{second},{fix_m:.0},{baro_m:.0}");
            if let Some(other_m) = self.other_m {
                text += &format!(",{:.1}", (self.altitude_m)(time_s) + other_m(time_s) + normal());
            }
            text += "\n";
        }
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("log.csv"), text).unwrap();
        folder
    }
}

/// A simulated flight with a launch: one of `flights/`.
fn flown(scenario: &str) -> Flight {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../flights").join(scenario);
    let scenario = load_scenario(&file).unwrap();
    simulate(&scenario, scenario.seed).unwrap().0
}

/// The same with a channel changed, written as `log.csv`.
fn simulated(scenario: &str, channel: Channel, change: impl Fn(f64, f32) -> Option<f32>) -> TempDir {
    let mut flight = flown(scenario);
    let old = flight.channel(channel).unwrap();
    let mut column = Column::default();
    for (row, time_s) in flight.time_s.iter().enumerate() {
        column.push(old.get(row).and_then(|value| change(*time_s, value)));
    }
    flight.set_channel(channel, column);
    written(&flight)
}

fn written(flight: &Flight) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    to_writer(fs::File::create(folder.path().join("log.csv")).unwrap(), flight).unwrap();
    folder
}

/// What `pylon diagnose log.csv` says, and its result.
fn diagnosed(folder: &TempDir) -> (String, Value) {
    let json = stdout(folder.path(), &["diagnose", "log.csv", "--json"]);
    (stdout(folder.path(), &["diagnose", "log.csv"]), serde_json::from_str(&json).unwrap())
}

/// Every effect that is certainly missing.
fn causes(result: &Value) -> Vec<String> {
    let sensors = result["sensors"].as_object().unwrap().values();
    let missing = sensors.flat_map(|sensor| sensor["missing"].as_array().unwrap());
    missing.map(|effect| effect.as_str().unwrap().to_owned()).collect()
}

const NOTHING: [String; 0] = [];

/// Four hectopascals are 33 m. Every command says it; no cause is found for it, and it is no good fit.
#[test]
fn a_pressure_setting_changed_in_flight_is_a_step_at_its_time_and_no_cause() {
    for seed in [1, 2] {
        let step = |time_s: f64| if time_s >= 1300.0 { 33.0 } else { 0.0 };
        let folder = Log { seed, baro_m: step, ..Log::default() }.write();
        let (text, result) = diagnosed(&folder);
        let said = |text: &str| {
            text.lines().any(|line| {
                line.contains("the barometer's altitude (baro_alt_m) steps by +3")
                    && line.contains(" m at 1300.0 s, as when its pressure setting is changed")
            })
        };
        assert!(said(&text), "{text}");
        assert_eq!(causes(&result), NOTHING, "{text}");
        assert_eq!(result["sensors"]["baro"]["verdict"], "unknown_effect", "{text}");
        assert!(text.contains("the rest follows a lasting jump at 1300 s"), "{text}");
        for command in ["open", "compare"] {
            let text = stdout(folder.path(), &[command, "log.csv"]);
            assert!(said(&text), "{command}: {text}");
        }
    }
}

/// Half as much as that, in a log of whole metres, whose changes from second to second have 1.5 m of noise.
#[test]
fn a_pressure_setting_changed_by_two_hectopascals_is_found_too() {
    let step = |time_s: f64| if time_s >= 700.0 { -16.0 } else { 0.0 };
    let (text, result) = diagnosed(&Log { seed: 3, baro_m: step, ..Log::default() }.write());
    assert!(text.contains("the barometer's altitude (baro_alt_m) steps by -1"), "{text}");
    assert!(text.contains(" m at 700.0 s"), "{text}");
    assert_eq!(causes(&result), NOTHING, "{text}");
    assert_ne!(result["sensors"]["baro"]["verdict"], "no_significant_misfit", "{text}");
}

/// The same with a launch and a pressure column, before and after the launch; and one that comes with the
/// release is none.
#[test]
fn a_step_of_the_pressure_is_named_before_and_after_the_launch() {
    for at_s in [60.0, 190.0] {
        let folder = simulated("clean.toml", Channel::BaroPa, |time_s, pascals| {
            Some(if time_s >= at_s { pascals - 400.0 } else { pascals })
        });
        let (text, result) = diagnosed(&folder);
        let words = format!(" m at {at_s:.1} s, as when its pressure setting is changed");
        assert!(text.contains("the barometer's altitude (baro_pa) steps by +3"), "{text}");
        assert!(text.contains(&words), "{text}");
        assert_eq!(causes(&result), NOTHING, "{text}");
        assert_eq!(result["sensors"]["baro"]["verdict"], "unknown_effect", "{text}");
        assert_eq!(result["sensors"]["imu_slave"]["verdict"], "no_significant_misfit", "{text}");
    }
    let released = simulated("clean.toml", Channel::BaroPa, |time_s, pascals| {
        Some(if time_s >= 120.0 { pascals - 60.0 } else { pascals })
    });
    assert!(!diagnosed(&released).0.contains(" steps by "));
}

/// A receiver that steps is named as the receiver, and the barometer is blamed for nothing.
#[test]
fn a_receiver_that_steps_is_told_from_a_barometer_that_does() {
    let step = |time_s: f64| if time_s >= 1300.0 { 33.0 } else { 0.0 };
    let (text, result) = diagnosed(&Log { receiver_m: step, ..Log::default() }.write());
    assert!(text.contains("the receiver's altitude (gps_alt_m) steps by +3"), "{text}");
    assert!(!text.contains("the barometer's altitude"), "{text}");
    assert_eq!(causes(&result), NOTHING, "{text}");
    assert_eq!(result["sensors"]["baro"]["verdict"], "no_significant_misfit", "{text}");
}

/// A flight level is a constant, however large: the bias, and nothing else.
#[test]
fn a_barometer_on_a_flight_level_has_a_bias_and_nothing_else() {
    let plain = Log::default().write();
    let level = Log { baro_m: |_| 412.0, ..Log::default() }.write();
    let [of_plain, of_level] = [&plain, &level].map(|folder| diagnosed(folder).1["sensors"]["baro"].clone());
    assert_eq!(of_level["verdict"], of_plain["verdict"]);
    assert_eq!([&of_level["missing"], &of_level["indistinguishable"]], [&json!([]), &json!([])]);
    let bias_m = |folder: &TempDir| {
        let json: Value =
            serde_json::from_str(&stdout(folder.path(), &["compare", "log.csv", "--json"])).unwrap();
        json["sensors"]["baro"]["bias_m"].as_f64().unwrap()
    };
    // Both are calibrated on the same stretch, whose noise is the same; the filter's prior takes a little.
    assert!((bias_m(&level) - bias_m(&plain) - 412.0).abs() < 2.0);
    assert!(!diagnosed(&level).0.contains("warning"));
}

#[test]
fn a_reference_that_is_worse_than_the_sensor_is_said_so_and_no_cause_is_found() {
    for seed in [5, 6, 7] {
        let folder = Log { seed, receiver_noise_m: [15.0, 20.0], ..Log::default() }.write();
        let (text, result) = diagnosed(&folder);
        assert!(
            text.contains("log.csv: the reference is worse than the sensor: its fixes scatter by 1"),
            "{text}"
        );
        assert_eq!(causes(&result), NOTHING, "{text}");
    }
    // With a launch, and a second sensor.
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut normal = || -> f32 { StandardNormal.sample(&mut random) };
    let noise: Vec<f32> = (0..300_000).map(|_| 15.0 * normal()).collect();
    let folder = simulated("clean.toml", Channel::GpsAltM, |time_s, metres| {
        Some(metres + noise[(time_s * 200.0) as usize])
    });
    let (text, result) = diagnosed(&folder);
    assert!(text.contains("the reference is worse than the sensor"), "{text}");
    assert_eq!(causes(&result), NOTHING, "{text}");
    // The usual receiver is not.
    assert!(!diagnosed(&Log::default().write()).0.contains("worse"));
}

/// Two receivers that part are said, with the one that the barometer contradicts; only the first is used.
#[test]
fn two_receivers_that_disagree_are_said_with_the_worse_one() {
    let folder = Log { other_m: Some(|time_s| 12.0 + 0.02 * time_s), ..Log::default() }.write();
    for command in ["open", "compare", "diagnose"] {
        let text = stdout(folder.path(), &[command, "log.csv"]);
        let line =
            text.lines().find(|line| line.contains("several receivers: gps_alt_m is the reference")).unwrap();
        assert!(
            line.contains("gps_2_alt_m is another: its altitude differs from the other's by +3"),
            "{line}"
        );
        let spread_m = |after: &str| -> f64 {
            line.split(after).nth(1).unwrap().split_whitespace().next().unwrap().parse().unwrap()
        };
        assert!(
            spread_m("the reference spreads by ") < 4.0 && spread_m("and gps_2_alt_m by ") > 12.0,
            "{line}"
        );
    }
    assert_eq!(causes(&diagnosed(&folder).1), NOTHING);
}

/// Hours on the ground show a drift and a warming up at most: too little for a good fit.
#[test]
fn hours_on_the_ground_are_no_good_fit() {
    let (text, result) =
        diagnosed(&Log { seconds: 4 * 3600, altitude_m: |_| 400.0, ..Log::default() }.write());
    assert_eq!(result["verdict"], "insufficient_excitation", "{text}");
    assert!(text.contains("could not have revealed most of what it may lack"), "{text}");
    assert_eq!(causes(&result), NOTHING, "{text}");
}

/// With a flight among them, the flight is used and the rest is said not to be.
#[test]
fn of_hours_on_the_ground_with_a_flight_the_flight_is_used() {
    let altitude_m = |time_s: f64| {
        let climbed_m = (1.5 * (time_s - 7200.0)).clamp(0.0, 900.0);
        let waves_m = if (7600.0..9500.0).contains(&time_s) { 40.0 * (time_s / 40.0).sin() } else { 0.0 };
        400.0 + (climbed_m - 0.9 * (time_s - 9500.0).max(0.0)).max(0.0) + waves_m
    };
    let (text, result) =
        diagnosed(&Log { seconds: 14_400, altitude_m, late_s: 3.0, ..Log::default() }.write());
    assert!(text.contains("take-off at 02:00:"), "{text}");
    assert!(
        text.contains(": before the calibration") && text.contains(": on the ground after the landing"),
        "{text}"
    );
    assert_eq!(causes(&result), ["baro.lag"], "{text}");
}

#[test]
fn a_flight_of_a_minute_says_what_it_cannot_show() {
    for seed in [8, 9, 10] {
        let (text, result) = diagnosed(&Log { seed, seconds: 60, ..Log::default() }.write());
        assert!(
            text.contains(" s of flight; the reference's own error lasts ")
                && text.contains("a drift, a warming up or a height's error cannot be distinguished from it"),
            "{text}"
        );
        assert_eq!(causes(&result), NOTHING, "{text}");
    }
}

/// Gaps are said with their share, make no step, and hide no effect.
#[test]
fn a_path_with_gaps_is_diagnosed_from_what_is_there() {
    let is_gap = |second: u32| second % 400 < 100;
    let (text, result) = diagnosed(&Log { is_gap, late_s: 3.0, ..Log::default() }.write());
    assert!(text.contains("nothing was recorded 5 times, for ") && text.contains(" % of the log)"), "{text}");
    assert!(!text.contains(" steps by "), "{text}");
    assert_eq!(causes(&result), ["baro.lag"], "{text}");
    let (text, result) = diagnosed(&Log { is_gap, ..Log::default() }.write());
    assert_eq!(causes(&result), NOTHING, "{text}");
}

/// An inertial altitude that repeats the fixes, or one value, is named and left out. The barometer's error is
/// found as without it, where nine effects were suspected.
#[test]
fn an_inertial_altitude_that_measures_nothing_is_named_and_left_out() {
    let flight = |change: &dyn Fn(&Flight) -> Column| {
        let mut flight = flown("hidden-static-port.toml");
        let column = change(&flight);
        flight.set_channel(Channel::ImuSlaveAltM, column);
        written(&flight)
    };
    let copied = flight(&|flight| flight.channel(Channel::GpsAltM).unwrap().clone());
    let stuck = flight(&|flight| {
        let mut column = Column::default();
        (0..flight.rows()).for_each(|row| column.push((row % 4 == 0).then_some(1200.0)));
        column
    });
    for (folder, words) in [
        (&copied, "no inertial altitude: its column is a copy of the receiver's altitude, +0 m"),
        (&stuck, "the inertial altitude is stuck: it repeats one value for the whole flight"),
    ] {
        let (text, result) = diagnosed(folder);
        let (before, _) = text.split_once("\nbaro: ").unwrap();
        assert!(before.contains(words) && before.contains("; it is left out"), "{text}");
        assert_eq!(causes(&result), ["baro.dynamic_pressure"], "{text}");
        assert!(result["sensors"].get("imu_slave").is_none(), "{text}");
        for command in ["open", "compare"] {
            assert!(stdout(folder.path(), &[command, "log.csv"]).contains(words), "{command}");
        }
    }
}

/// A barometer whose column has no number is dead, which is not the same as none; the other sensor is
/// diagnosed.
#[test]
fn a_dead_barometer_is_named() {
    let folder = simulated("clean.toml", Channel::BaroPa, |_, _| Some(f32::NAN));
    for command in ["open", "compare", "diagnose"] {
        let text = stdout(folder.path(), &[command, "log.csv"]);
        assert!(text.contains("baro_pa is dead: it has no reading in the whole log"), "{command}: {text}");
    }
    assert_eq!(causes(&diagnosed(&folder).1), NOTHING);
}

/// Readings and fixes that never come together leave nothing to test: an error, not a good fit.
#[test]
fn no_block_to_test_on_is_an_error() {
    let folder = simulated("clean.toml", Channel::GpsAltM, |time_s, metres| (time_s < 1.0).then_some(metres));
    for arguments in [&["diagnose", "log.csv"][..], &["diagnose", "log.csv", "--json"]] {
        let line = refusal(folder.path(), arguments);
        assert!(
            line.contains(
                "log.csv: the model could not be tested: no sensor has a reading while the reference"
            ),
            "{line}"
        );
    }
}
