//! `pylon fly`: needs qemu-system-arm and the Rust target, as every emulated flight does.
#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used)]

mod common;

use common::Recipe;
use common::json::read;
use common::program::{run, stdout};
use pylon::results::FlyResult;
use serde_json::Value;

#[test]
fn bits_that_are_the_same_are_status_0_and_others_status_1() {
    let directory = tempfile::tempdir().unwrap();
    // Without inertial samples it takes 3 s of free flight to decide that a launch happened.
    Recipe { captive_s: 14.0, free_s: 8.0, ..Recipe::default() }.write(directory.path());
    let text = stdout(directory.path(), &["fly", "made.csv"]);
    assert!(
        text.starts_with("made.csv: the emulated flight computer and the host agree to the bit"),
        "{text}"
    );
    // 1,100 rows of 20 ms, the last at 21.98 s, on ticks of 5 ms.
    for part in [
        "all 4397 ticks",
        "instructions a tick",
        "mission",
        "stack",
        "latched              at 14.000 s",
        "on chips: 1100 rows on 4397 ticks",
        "m from ideal sensors (within",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let ideal = stdout(directory.path(), &["fly", "made.csv", "--ideal-sensors"]);
    assert!(ideal.contains("all 1100 ticks") && ideal.contains("sensors              ideal"), "{ideal}");
    let text = stdout(directory.path(), &["fly", "made.csv", "--json"]);
    assert!(matches!(read::<FlyResult>("fly", &text), FlyResult::Agrees(_)));
    let same: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(same["bit_for_bit"], true);
    assert_eq!(same["ticks"], 4397);
    assert_eq!(same["chips"]["agreement"]["baro"]["within_bound"], true);
    assert!(same["instructions_mean"].as_f64().unwrap() > 100.0);

    let output = run(directory.path(), &["fly", "made.csv", "--json", "--plant-host-error"]);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.starts_with("error: made.csv: target and host differ: first at tick "), "{stderr}");
    assert_eq!(stderr.lines().count(), 1);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(matches!(read::<FlyResult>("fly", &text), FlyResult::Differs(_)));
    let other: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(other["bit_for_bit"], false);
    assert!(other["ticks_that_differ"].as_u64().unwrap() > 0);
}

#[test]
fn a_fault_that_can_not_be_is_one_line_and_status_2() {
    let directory = tempfile::tempdir().unwrap();
    Recipe { captive_s: 14.0, free_s: 3.0, ..Recipe::default() }.write(directory.path());
    for (arguments, said) in [
        (&["--fault", "baro melted 3..4"][..], "fault 'melted', expected one of stuck-low"),
        (&["--fault", "gps stuck-low 3..4"], "gps cannot be stuck-low"),
        (&["--fault", "baro reset 99"], "fault at 99 s, and the flight goes from 0.000 s to 16.980 s"),
        (&["--fault", "baro reset 3", "--ideal-sensors"], "cannot be used with"),
    ] {
        let output = run(directory.path(), &[&["fly", "made.csv"], arguments].concat());
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(stderr.contains(said), "{arguments:?}: {stderr}");
    }
}
