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
fn an_effect_is_explained_and_one_that_is_none_is_not() {
    let directory = tempfile::tempdir().unwrap();
    let output = pylon(directory.path(), &["effects", "baro.lag"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("coefficient x -hdot") && text.contains("gps_alt_m"), "{text}");
    let output = pylon(directory.path(), &["effects", "baro.lga"]);
    assert_eq!(errors(&output), "error: no effect 'baro.lga' (is it 'baro.lag'?)\n");
}
