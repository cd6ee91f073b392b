//! Effects by formula, from a file on disk to the user's output; and the catalogue's effects, written as
//! formulas.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::path::Path;

use common::program::{run, stdout};
use kf_core::effect::{EffectId, Regressor, SignalTracker};
use kf_core::formula::{Evaluation, Frame};
use model::Model;
use model::formula::{Columns, Formula, of_catalogue};
use pylon::flight::{Channel, Column, Flight};
use pylon::replay::Replay;
use pylon::simulate::{load_scenario, simulate};
use serde_json::Value;

fn quickstart(seed: u64) -> Flight {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../flights/quickstart.toml");
    let mut scenario = load_scenario(&file).unwrap();
    scenario.effect.clear();
    simulate(&scenario, seed).unwrap().0
}

/// Every effect of the catalogue, in its compiled form and as a formula, over a whole flight.
#[test]
fn the_catalogue_as_formulas_is_the_catalogue() {
    let flight = quickstart(11);
    let replay = Replay::new(&flight, &Model::default(), None).unwrap();
    for id in EffectId::ALL {
        let regressor = Regressor { time_constant_s: 20.0, ..Regressor::new(id) };
        let formula = Formula::compile(of_catalogue(id).unwrap(), &mut Columns::default()).unwrap();
        let used = formula.program().signals();
        // As in a model with this effect alone: together with an inertial effect, the compiled pitch is
        // propagated by the body rates.
        let mut tracker = SignalTracker::for_effects([id], replay.model().latitude_deg);
        let mut evaluation = Evaluation::new(formula.program(), regressor.time_constant_s);
        let mut frame = Frame::default();
        let (mut settled, mut launched) = (false, false);
        let (mut largest, mut worst, mut count) = (0.0_f32, 0.0_f32, 0_u32);
        for input in replay.inputs() {
            if !settled && input.time_us > 10_000_000 {
                settled = true;
                tracker.begin_calibration();
                frame.begin_calibration();
            }
            if input.launch && !launched {
                launched = true;
                tracker.begin_free_flight(input.time_us);
            }
            tracker.take(&input, input.gps.as_ref());
            frame.take(used, &input, input.gps.as_ref(), &tracker);
            let value = evaluation.step(&frame).ok();
            frame.end();
            let compiled = tracker.regressor_m(regressor);
            // A difference of two samples does not exist at the first.
            let is_first = count == 0 && id == EffectId::ImuVibration;
            assert!(
                value.is_some() == compiled.is_some() || is_first,
                "{} at {} us",
                id.name(),
                input.time_us
            );
            if let (Some(value), Some(compiled)) = (value, compiled) {
                largest = largest.max(compiled.abs());
                worst = worst.max((value - compiled).abs());
                count += 1;
            }
        }
        // A few roundings of the numbers that it is computed from: altitudes of a kilometre and temperatures
        // of 300 K are subtracted from each other.
        let rounding = match id {
            EffectId::BaroScale => 2.0 * 1.2e-4,
            EffectId::BaroTemperature => 2.0 * 3.1e-5,
            // One straight line where the catalogue has two steps: half a sample's share of the change of its
            // variance.
            EffectId::ImuVibration => 0.01 * largest,
            _ => 1e-6 * largest.max(1.0),
        };
        assert!(count > 20_000 && largest > 0.0, "{}: {count} {largest}", id.name());
        assert!(worst <= rounding, "{}: {worst} of {largest}, {rounding}", id.name());
    }
}

/// A hidden law, by the hypsometric equation in double precision: it uses no code of the estimator.
fn raised(pressure_pa: f32, by_m: f64) -> f32 {
    let altitude_m = 44_330.77 * (1.0 - (f64::from(pressure_pa) / 101_325.0).powf(0.190_263_1));
    (101_325.0 * (1.0 - (altitude_m + by_m) / 44_330.77).powf(1.0 / 0.190_263_1)) as f32
}

/// The flap, which extends and retracts every twelve seconds of free flight.
fn flap(free_s: f64) -> f64 {
    if (free_s / 12.0).rem_euclid(1.0) < 0.5 { 0.0 } else { 0.8 }
}

/// A flight as CSV, with a flap that adds this share of the dynamic head to the barometer's altitude, and a
/// slipstream proportional to throttle and airspeed squared.
fn flown(directory: &Path, name: &str, seed: u64, of_flap: f64, of_slipstream: f64) {
    flown_late(directory, name, seed, [of_flap, of_slipstream], 0.0);
}

/// The same, but the pressure follows the flap with a time constant.
fn flown_late(directory: &Path, name: &str, seed: u64, [of_flap, of_slipstream]: [f64; 2], late_s: f64) {
    let mut flight = quickstart(seed);
    let rows = flight.rows();
    let launch = flight.channel(Channel::Launch).unwrap();
    let first = launch.samples().find(|(_, value)| *value > 0.0).unwrap().0;
    let launch_s = flight.time_s[first];
    let (mut airspeed, mut throttle) = (0.0_f64, 0.0_f64);
    let (mut followed, mut last_s) = (0.0, flight.time_s[0]);
    let mut position = Column::empty(rows);
    let mut pressure = flight.channel(Channel::BaroPa).unwrap().clone();
    for row in 0..rows {
        let free_s = flight.time_s[row] - launch_s;
        let is_free = row >= first;
        let out = if is_free { flap(free_s) } else { 0.0 };
        position.set(row, Some(out as f32));
        followed = if late_s > 0.0 {
            out + (followed - out) * (-(flight.time_s[row] - last_s) / late_s).exp()
        } else {
            out
        };
        last_s = flight.time_s[row];
        if let Some(value) = flight.channel(Channel::TasMps).and_then(|column| column.get(row)) {
            airspeed = f64::from(value);
        }
        if let Some(value) = flight.channel(Channel::Throttle).and_then(|column| column.get(row)) {
            throttle = f64::from(value);
        }
        if let Some(value) = pressure.get(row) {
            let head_m = airspeed.powi(2) / 19.613_3;
            let by_m =
                head_m * (of_flap * followed * f64::from(u8::from(is_free)) + of_slipstream * throttle);
            pressure.set(row, Some(raised(value, by_m)));
        }
    }
    flight.set_channel(Channel::BaroPa, pressure);
    flight.extra.push(("flap".to_owned(), position));
    let mut bytes = Vec::new();
    flight_data::to_writer(&mut bytes, &flight).unwrap();
    fs::write(directory.join(name), bytes).unwrap();
}

const FLAP: &str = r#"[[effect_definition]]
id = "baro.flap_wash"
on = "baro"
regressor = "tas_mps^2 / (2*g) * flap * step(launch)"
plausible = [-0.5, 0.5]
about = "pressure under the deflected flap"
"#;

const SLIPSTREAM: &str = r#"[[effect_definition]]
id = "baro.fast_slipstream"
on = "baro"
regressor = "throttle * tas_mps^2 / (2*g)"
plausible = [-0.5, 0.5]
"#;

fn json(directory: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&stdout(directory, arguments)).unwrap()
}

/// A user's law is found, learned and removed from the error; and refused where it cannot fly.
#[test]
fn a_law_of_ones_own_is_found_learned_and_taken_off() {
    let directory = tempfile::tempdir().unwrap();
    let at = directory.path();
    flown(at, "monday.csv", 21, 0.3, 0.0);
    flown(at, "friday.csv", 22, 0.3, 0.0);
    fs::write(at.join("ours.toml"), FLAP).unwrap();
    let diagnosis = json(at, &["diagnose", "monday.csv", "friday.csv", "--model", "ours.toml", "--json"]);
    assert_eq!(diagnosis["sensors"]["baro"]["missing"][0], "baro.flap_wash", "{diagnosis}");
    let before = json(at, &["compare", "friday.csv", "--model", "ours.toml", "--json"]);
    let added = json(
        at,
        &[
            "add",
            "baro.flap_wash",
            "--model",
            "ours.toml",
            "--from",
            "monday.csv",
            "--hold-out",
            "friday.csv",
            "--json",
        ],
    );
    let (coefficient, sigma) = (added["coefficient"].as_f64().unwrap(), added["sigma"].as_f64().unwrap());
    assert!((coefficient - 0.3).abs() < 4.0 * sigma && sigma < 0.05, "{coefficient} {sigma}");
    let after = json(at, &["compare", "friday.csv", "--model", "ours.toml", "--json"]);
    let rms = |comparison: &Value| comparison["sensors"]["baro"]["free_flight_rms_m"].as_f64().unwrap();
    assert!(rms(&after) < 0.6 * rms(&before), "{} {}", rms(&before), rms(&after));
    let model = fs::read_to_string(at.join("ours.toml")).unwrap();
    assert!(model.contains("formula = \""), "{model}");

    // The flight computer has no flap signal.
    let refused = run(at, &["fly", "friday.csv", "--model", "ours.toml"]);
    let said = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(said.contains("baro.flap_wash reads flap, which the flight computer does not have"), "{said}");

    // A coefficient belongs to the formula for which it was learned.
    fs::write(at.join("changed.toml"), model.replace("(2*g)", "(2.2*g)")).unwrap();
    let refused = run(at, &["compare", "friday.csv", "--model", "changed.toml"]);
    let said = String::from_utf8(refused.stderr).unwrap();
    assert!(
        said.contains("was learned for another formula") && said.contains("pylon add baro.flap_wash"),
        "{said}"
    );

    // A column spelt differently.
    fs::write(
        at.join("typo.toml"),
        FLAP.replace("flap *", "flaps *") + "\n[[effect]]\nid = \"baro.flap_wash\"\ncoefficient = 0.3\n",
    )
    .unwrap();
    let said = run(at, &["compare", "friday.csv", "--model", "typo.toml"]);
    let said = String::from_utf8(said.stdout).unwrap() + &String::from_utf8(said.stderr).unwrap();
    assert!(said.contains("reads flaps, but the flight has no such column (nearest: flap"), "{said}");

    let listed = stdout(at, &["effects", "--model", "ours.toml"]);
    assert!(
        listed.contains("baro.flap_wash") && listed.contains("pressure under the deflected flap"),
        "{listed}"
    );
    let explained = stdout(at, &["effects", "baro.flap_wash", "--model", "ours.toml"]);
    assert!(explained.contains("flap counts as a plain number"), "{explained}");
}

/// A law over signals that the flight computer measures, as a state of its filter.
#[test]
fn a_law_that_can_fly_is_learned_as_a_state() {
    let directory = tempfile::tempdir().unwrap();
    let at = directory.path();
    flown(at, "monday.csv", 31, 0.0, 0.2);
    flown(at, "friday.csv", 32, 0.0, 0.2);
    fs::write(at.join("ours.toml"), SLIPSTREAM).unwrap();
    let added = json(
        at,
        &[
            "add",
            "baro.fast_slipstream",
            "--model",
            "ours.toml",
            "--from",
            "monday.csv",
            "--hold-out",
            "friday.csv",
            "--estimate",
            "--force",
            "--json",
        ],
    );
    let (coefficient, sigma) = (added["coefficient"].as_f64().unwrap(), added["sigma"].as_f64().unwrap());
    assert!((coefficient - 0.2).abs() < 4.0 * sigma, "{coefficient} {sigma}");
    assert!(added["rms_after_m"].as_f64().unwrap() < added["rms_before_m"].as_f64().unwrap(), "{added}");
    let ladder = stdout(at, &["ladder", "--model", "ours.toml", "friday.csv"]);
    assert!(ladder.contains("baro.fast_slipstream"), "{ladder}");
}

/// A formula with a `tau` is tried with every time constant of the grid, and keeps the right one.
#[test]
fn the_time_constant_of_a_formula_is_found_in_the_grid() {
    let directory = tempfile::tempdir().unwrap();
    let at = directory.path();
    flown_late(at, "monday.csv", 51, [0.3, 0.0], 10.0);
    let late = FLAP.replace("* flap *", "* lowpass(flap, tau) *").replace("flap_wash", "late_wash");
    fs::write(at.join("ours.toml"), &late).unwrap();
    let added =
        json(at, &["add", "baro.late_wash", "--model", "ours.toml", "--from", "monday.csv", "--json"]);
    let found_s = added["time_constant_s"].as_f64().unwrap();
    // The grid has 3, 10 and 30 s.
    assert!((5.0..=20.0).contains(&found_s), "{added}");
    let (coefficient, sigma) = (added["coefficient"].as_f64().unwrap(), added["sigma"].as_f64().unwrap());
    assert!(coefficient > 0.1 && sigma < 0.1, "{added}");
    let model = fs::read_to_string(at.join("ours.toml")).unwrap();
    assert!(model.contains(&format!("time_constant_s = {found_s}")), "{model}");
    // A coefficient does not apply to another formula, nor a time constant to a formula without one.
    fs::write(at.join("changed.toml"), model.replace("lowpass(flap, tau)", "flap")).unwrap();
    let said = run(at, &["compare", "monday.csv", "--model", "changed.toml"]);
    assert_eq!(said.status.code(), Some(2), "{said:?}");
}

/// An invalid definition is refused with one message that points at the error.
#[test]
fn a_definition_that_can_not_be_is_refused_where_it_is_wrong() {
    let directory = tempfile::tempdir().unwrap();
    let at = directory.path();
    let of = |regressor: &str| FLAP.replace("tas_mps^2 / (2*g) * flap * step(launch)", regressor);
    let cyclic = of("baro.other * flap")
        + "\n[[effect_definition]]\nid = \"baro.other\"\non = \"baro\"\nregressor = \"2 * baro.flap_wash\"\nplausible = [-1, 1]\n";
    let long = vec!["throttle"; 60].join(" + ");
    for (text, said) in [
        (cyclic, "baro.flap_wash -> baro.other -> baro.flap_wash"),
        (of("tas_mps^2 / (2*g) * sine(roll_rad)"), "no function 'sine'; nearest: sin"),
        (of("flap * (tas_mps > 20)"), "expected the same dimension on both sides"),
        (of(&long), "operations"),
        (FLAP.replace("baro.flap_wash", "baro.lag"), "has the id of an effect of the catalogue"),
        (FLAP.replace("\"baro\"", "\"barro\""), "is not a sensor; nearest: baro"),
    ] {
        fs::write(at.join("wrong.toml"), &text).unwrap();
        let refused = run(at, &["effects", "--model", "wrong.toml"]);
        let message = String::from_utf8(refused.stderr).unwrap();
        assert_eq!(refused.status.code(), Some(2), "{text}\n{message}");
        assert!(message.contains("wrong.toml") && message.contains(said), "{text}\n{message}");
    }
}

/// The fenced blocks of this kind in docs/effects.md.
fn blocks<'a>(text: &'a str, kind: &str) -> Vec<&'a str> {
    let fence = format!("```{kind}\n");
    text.split(fence.as_str()).skip(1).map(|block| block.split("```").next().unwrap()).collect()
}

/// The page's own model and commands, as pasted.
#[test]
fn every_command_of_the_page_works_as_pasted() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/effects.md");
    let page = fs::read_to_string(page).unwrap();
    let directory = tempfile::tempdir().unwrap();
    flown(directory.path(), "monday.csv", 41, 0.3, 0.0);
    flown(directory.path(), "friday.csv", 42, 0.3, 0.0);
    fs::write(directory.path().join("ours.toml"), blocks(&page, "toml")[0]).unwrap();
    let mut ran = 0;
    for command in blocks(&page, "sh").into_iter().flat_map(str::lines).filter(|line| !line.is_empty()) {
        let arguments: Vec<&str> = command.strip_prefix("cargo pylon ").unwrap().split_whitespace().collect();
        let output = run(directory.path(), &arguments);
        assert!(output.status.success(), "{command}\n{}", String::from_utf8_lossy(&output.stderr));
        let said = String::from_utf8(output.stdout).unwrap();
        if !matches!(arguments[0], "compare") {
            assert!(said.contains("baro.flap_wash"), "{command}\n{said}");
        }
        ran += 1;
    }
    assert_eq!(ran, 6);
}
