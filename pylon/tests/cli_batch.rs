//! Several flights on the command line, some of which are of no use.
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
        assert!(said.contains("skipped 2 of 3 flights (--strict refuses instead):"), "{command}: {said}");
        for file in ["  rubbish.bin: ", "  nothing.ulg: "] {
            assert!(said.contains(file), "{command}: {said}");
        }
        assert!(!output.stdout.is_empty());
        let strict = pylon(directory.path(), &[&all[..], &["--strict"]].concat());
        assert_eq!(strict.status.code(), Some(2), "{command}");
        assert!(errors(&strict).starts_with("error: rubbish.bin: "), "{}", errors(&strict));
        // Nothing is left of several that are all of no use, or of one.
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
    assert!(said.contains("skipped 1 of 2 flights (--strict refuses instead):\n  logs/cut.csv: "), "{said}");
    assert!(fs::read_to_string(path.join("ours.toml")).unwrap().contains("baro.lag"));
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
    // A log that is cut off is a log.
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
        (&["diagnose", "logs", "logs/b.csv"], "logs/b.csv: given twice, expected different flights"),
        (&["diagnose", "logs/*.igc"], "logs/*.igc: no file matches this pattern"),
        (&["diagnose", "logs/***"], "logs/***: no pattern of files: "),
        (
            &["diagnose", "made.csv", "--hold-out", "none.csv"],
            "none.csv: can not be read: there is no such file",
        ),
        (&["compare", "logs"], "logs: can not be read: it is a folder, expected one file"),
        (
            &["add", "baro.lag", "--model", "m.toml", "--from", "empty"],
            "empty: no log among the 0 files of this folder",
        ),
    ] {
        fs::create_dir_all(directory.path().join("empty")).unwrap();
        fs::write(directory.path().join("m.toml"), "").unwrap();
        let output = pylon(directory.path(), arguments);
        if message.is_empty() {
            // A hidden folder that is named is meant.
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

#[test]
fn an_effect_is_explained_and_one_that_is_none_is_not() {
    let directory = tempfile::tempdir().unwrap();
    let output = pylon(directory.path(), &["effects", "baro.lag"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("coefficient x -hdot") && text.contains("gps_alt_m"), "{text}");
    let output = pylon(directory.path(), &["effects", "baro.lga"]);
    assert_eq!(errors(&output), "error: no effect 'baro.lga' (is it 'baro.lag'?)\n");
}
