//! Several flights on the command line, some of which cannot be used.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use common::Recipe;

fn pylon(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pylon")).current_dir(directory).args(arguments).output().unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[test]
fn a_flight_that_cannot_be_read_is_skipped_and_named_and_strict_refuses_it() {
    let directory = tempfile::tempdir().unwrap();
    Recipe { captive_s: 60.0, free_s: 20.0, ..Recipe::default() }.write(directory.path());
    fs::write(directory.path().join("rubbish.bin"), [7; 100]).unwrap();
    fs::write(directory.path().join("nothing.ulg"), []).unwrap();
    for (command, more) in
        [("diagnose", &[][..]), ("ladder", &["--model", "default"]), ("report", &["-o", "page.html"])]
    {
        let all = [&[command, "rubbish.bin", "made.csv", "nothing.ulg"], more].concat();
        let output = pylon(directory.path(), &all);
        let said = errors(&output);
        assert!(output.status.success(), "{command}: {said}");
        assert!(said.contains("skipped 2 of 3 flights (--strict fails instead):"), "{command}: {said}");
        for file in ["  rubbish.bin: ", "  nothing.ulg: "] {
            assert!(said.contains(file), "{command}: {said}");
        }
        assert!(!output.stdout.is_empty());
        let strict = pylon(directory.path(), &[&all[..], &["--strict"]].concat());
        assert_eq!(strict.status.code(), Some(2), "{command}");
        assert!(errors(&strict).starts_with("error: rubbish.bin: "), "{}", errors(&strict));
        // Nothing is left if none of several flights can be used, or a single one cannot.
        let none = pylon(directory.path(), &[&[command, "rubbish.bin", "nothing.ulg"], more].concat());
        assert_eq!(none.status.code(), Some(2), "{command}");
        let one = pylon(directory.path(), &[&[command, "rubbish.bin"], more].concat());
        assert!(
            errors(&one).starts_with("error: rubbish.bin: ") && one.status.code() == Some(2),
            "{command}"
        );
    }
}

#[test]
fn add_learns_from_what_is_of_use_in_a_folder_and_strict_refuses() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    fs::create_dir(path.join("logs")).unwrap();
    let recipe =
        Recipe { climb_mps: common::dive_mps, baro_error: |_, climb| -0.8 * climb, ..Recipe::default() };
    recipe.write(&path.join("logs"));
    fs::write(path.join("logs/cut.csv"), "# pylon-flight: 1\n").unwrap();
    fs::write(path.join("ours.toml"), common::MODEL).unwrap();
    let add = ["add", "baro.lag", "--model", "ours.toml", "--from", "logs", "--force"];
    let strict = pylon(path, &[&add[..], &["--strict"]].concat());
    assert_eq!(strict.status.code(), Some(2));
    assert!(errors(&strict).starts_with("error: logs/cut.csv: "), "{}", errors(&strict));
    assert_eq!(fs::read_to_string(path.join("ours.toml")).unwrap(), common::MODEL);
    let output = pylon(path, &add);
    let said = errors(&output);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("skipped 1 of 2 flights (--strict fails instead):\n  logs/cut.csv: "), "{said}");
    assert!(fs::read_to_string(path.join("ours.toml")).unwrap().contains("baro.lag"));
    // A log without the effect's own signal cannot be used either; held-out ones are treated alike.
    fs::rename(path.join("logs/cut.csv"), path.join("cut.csv")).unwrap();
    let text = fs::read_to_string(path.join("logs/made.csv")).unwrap();
    let bare: String = text
        .lines()
        .map(|line| match line.strip_prefix('#') {
            Some(_) => format!("{line}\n"),
            None => line.split(',').take(7).collect::<Vec<_>>().join(",") + "\n",
        })
        .collect();
    fs::write(path.join("logs/bare.csv"), bare).unwrap();
    fs::write(path.join("ours.toml"), common::MODEL).unwrap();
    let add = [&add[..], &["--hold-out", "cut.csv", "other.csv"]].concat();
    fs::copy(path.join("logs/made.csv"), path.join("other.csv")).unwrap();
    let output = pylon(
        path,
        &add.iter().map(|word| if *word == "baro.lag" { "baro.propwash" } else { word }).collect::<Vec<_>>(),
    );
    let said = errors(&output);
    assert!(said.contains("can't be learned, the flight has no throttle"), "{said}");
    let output = pylon(path, &add);
    let said = errors(&output);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("skipped 1 of 2 flights (--strict fails instead):\n  cut.csv: "), "{said}");
}

#[test]
fn a_folder_is_every_log_in_it_and_a_pattern_what_it_matches() {
    let directory = tempfile::tempdir().unwrap();
    let logs = directory.path().join("logs");
    fs::create_dir_all(logs.join("2026/may")).unwrap();
    fs::create_dir_all(logs.join(".trash")).unwrap();
    Recipe { captive_s: 60.0, free_s: 20.0, ..Recipe::default() }.write(directory.path());
    let made = directory.path().join("made.csv");
    for place in
        ["logs/b.csv", "logs/2026/may/a.csv", "logs/.trash/old.csv", "logs/page.html", "logs/SOURCES.md"]
    {
        let place = directory.path().join(place);
        if place.extension().is_some_and(|extension| extension == "csv") {
            fs::copy(&made, place).unwrap();
        } else {
            fs::write(place, "<p>not a flight</p>").unwrap();
        }
    }
    // A truncated log is still a log.
    fs::write(logs.join("cut.csv"), "# pylon-flight: 1\n").unwrap();
    let left_out = "note: logs: 3 logs; 2 other files were left out: SOURCES.md, page.html\n";
    for (command, more) in [
        ("diagnose", &["--json"][..]),
        ("ladder", &["--model", "default"]),
        ("report", &["-o", "logs/page.html"]),
    ] {
        let output = pylon(directory.path(), &[&[command, "logs"], more].concat());
        let said = errors(&output);
        assert!(output.status.success(), "{command}: {said}");
        assert!(said.contains(left_out), "{command}: {said}");
        assert!(
            said.contains("skipped 1 of 3 flights") && said.contains("logs/cut.csv: "),
            "{command}: {said}"
        );
        assert!(!said.contains(".trash"), "{command}: {said}");
    }
    let output = pylon(
        directory.path(),
        &["ladder", "--model", "default", "logs/*.csv", "logs/2026/*/?.csv", "--json"],
    );
    let said = errors(&output);
    assert!(output.status.success() && said.contains("skipped 1 of 3 flights"), "{said}");
    assert!(!said.contains("left out"), "{said}");

    for (arguments, message) in [
        (&["diagnose", "logs/.trash", "logs"][..], ""),
        (&["diagnose", "logs", "logs/b.csv"], "logs/b.csv: given twice; expected different flights"),
        (&["diagnose", "logs/*.igc"], "logs/*.igc: no file matches this pattern"),
        (&["diagnose", "logs/***"], "logs/***: invalid file pattern: "),
        (
            &["diagnose", "made.csv", "--hold-out", "none.csv"],
            "none.csv: cannot be read: there is no such file",
        ),
        (&["compare", "logs"], "logs: cannot be read: it is a folder, expected one file"),
        (
            &["add", "baro.lag", "--model", "m.toml", "--from", "empty"],
            "empty: no log among the 0 files of this folder",
        ),
    ] {
        fs::create_dir_all(directory.path().join("empty")).unwrap();
        fs::write(directory.path().join("m.toml"), "").unwrap();
        let output = pylon(directory.path(), arguments);
        if message.is_empty() {
            // A hidden folder that is named explicitly is used.
            assert!(output.status.success(), "{}", errors(&output));
        } else {
            assert_eq!(output.status.code(), Some(2), "{arguments:?}");
            assert!(
                errors(&output).contains(&format!("error: {message}")),
                "{arguments:?}: {}",
                errors(&output)
            );
        }
    }
}

/// Four flights of one vehicle with a lag of 0.8 s and one with three times that, and one flight of another
/// vehicle.
fn fleet(directory: &Path) {
    let lags: [fn(f64, f64) -> f64; 2] = [|_, climb| -0.8 * climb, |_, climb| -2.4 * climb];
    for (name, seed, lag, vehicle) in [
        ("a", 1, lags[0], "made"),
        ("b", 2, lags[0], "made"),
        ("c", 3, lags[0], "made"),
        ("d", 4, lags[0], "made"),
        ("odd", 5, lags[1], "made"),
        ("other", 6, lags[1], "another"),
    ] {
        let recipe = Recipe { seed, climb_mps: common::dive_mps, baro_error: lag, ..Recipe::default() };
        let mut flight = recipe.make();
        flight.header.vehicle = vehicle.to_owned();
        pylon::flight::write(&directory.join(name).with_extension("csv"), &flight).unwrap();
    }
}

const FLEET: [&str; 6] = ["a.csv", "b.csv", "c.csv", "d.csv", "odd.csv", "other.csv"];

#[test]
fn each_flight_and_each_vehicle_has_its_coefficients_and_the_odd_flight_is_named() {
    let directory = tempfile::tempdir().unwrap();
    fleet(directory.path());
    let output = pylon(directory.path(), &[&["diagnose", "--json"], &FLEET[..]].concat());
    assert!(output.status.success(), "{}", errors(&output));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let lag =
        |flight: usize| json["by_flight"][flight]["coefficients"]["baro.lag"]["value"].as_f64().unwrap();
    for (flight, expected) in [0.8, 0.8, 0.8, 0.8, 2.4, 2.4].into_iter().enumerate() {
        assert!((lag(flight) - expected).abs() < 0.1, "{flight}: {}", lag(flight));
    }
    let vehicles = json["by_vehicle"].as_array().unwrap();
    let names: Vec<&str> = vehicles.iter().map(|vehicle| vehicle["vehicle"].as_str().unwrap()).collect();
    assert_eq!(names, ["another", "made"]);
    let effects = vehicles[1]["effects"].as_array().unwrap();
    let lag = effects.iter().find(|effect| effect["effect"] == "baro.lag").unwrap();
    assert!((lag["mean"].as_f64().unwrap() - 0.8).abs() < 0.05, "{lag}");
    assert_eq!(lag["outliers"].as_array().unwrap().len(), 1, "{lag}");
    assert_eq!(lag["outliers"][0]["file"], "odd.csv");
    // With a single flight of a vehicle there is nothing to show whether it is odd.
    for effect in vehicles[0]["effects"].as_array().unwrap() {
        assert_eq!(effect["outliers"].as_array().unwrap().len(), 0, "{effect}");
    }
    let text =
        String::from_utf8(pylon(directory.path(), &[&["diagnose"], &FLEET[..]].concat()).stdout).unwrap();
    assert!(text.contains("\nFlight by flight"), "{text}");
    assert!(text.contains("\n  outlier: odd.csv: baro.lag is "), "{text}");
    assert!(text.contains("\nmade: 5 flights\n"), "{text}");
}

#[test]
fn a_report_of_many_flights_opens_on_the_verdict_and_draws_the_odd_ones_only() {
    let directory = tempfile::tempdir().unwrap();
    fleet(directory.path());
    let report = |files: &[&str]| {
        let output = pylon(directory.path(), &[&["report", "-o", "page.html"], files].concat());
        assert!(output.status.success(), "{}", errors(&output));
        fs::read_to_string(directory.path().join("page.html")).unwrap()
    };
    let page = report(&FLEET);
    let place = |words: &str| page.find(words).unwrap_or_else(|| panic!("no {words}"));
    let verdict = place("<section id=\"found\">");
    assert!(verdict < place("<section id=\"diagnosis\">") && page.len() < 5_000_000, "{}", page.len());
    assert!(
        verdict < place("<section id=\"batch\">")
            && place("<section id=\"batch\">") < place("class=\"summary\"")
    );
    assert!(place("do not belong with the other flights") > verdict && page.contains("odd.csv: baro.lag is"));
    let drawn: Vec<usize> =
        (1..=6).filter(|number| page.contains(&format!("<section id=\"flight-{number}\">"))).collect();
    assert_eq!(drawn.len(), 2, "{drawn:?}");
    assert!(drawn.contains(&5), "{drawn:?}");
    assert!(page.contains("4 more flights, in words"));
    // A flight without diagrams has no data on the page either.
    let without = (1..=6).find(|number| !drawn.contains(number)).unwrap();
    assert!(!page.contains(&format!("\"flight-{without}-")), "{without}");
}

#[test]
fn an_effect_is_explained_and_one_that_is_none_is_not() {
    let directory = tempfile::tempdir().unwrap();
    let output = pylon(directory.path(), &["effects", "baro.lag"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("coefficient x -hdot") && text.contains("gps_alt_m"), "{text}");
    assert!(
        text.contains("A simulated flight (flights/quickstart.toml), not a measured one")
            && text.contains("error of baro"),
        "{text}"
    );
    let output = pylon(directory.path(), &["effects", "baro.lag", "--svg", "lag.svg"]);
    assert!(output.status.success(), "{}", errors(&output));
    let svg = fs::read_to_string(directory.path().join("lag.svg")).unwrap();
    assert!(
        svg.starts_with("<svg") && svg.contains("What baro.lag looks like") && svg.contains("simulated"),
        "{svg}"
    );
    let several = pylon(directory.path(), &["effects", "gps", "--svg", "gps.svg"]);
    assert_eq!(
        errors(&several),
        "error: --svg draws one effect, expected one of: gps.latency, gps.convergence, gps.lever_arm\n"
    );
    assert!(!directory.path().join("gps.svg").exists());
    let output = pylon(directory.path(), &["effects", "baro.lga"]);
    assert_eq!(errors(&output), "error: no effect 'baro.lga' (is it 'baro.lag'?)\n");
}
