//! `pylon fly`: needs qemu-system-arm and the Rust target, as every emulated flight does.
#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used)]

mod common;

use common::Recipe;
use common::program::{run, stdout};
use serde_json::Value;

#[test]
fn bits_that_are_the_same_are_status_0_and_others_status_1() {
    let directory = tempfile::tempdir().unwrap();
    Recipe { captive_s: 14.0, free_s: 3.0, ..Recipe::default() }.write(directory.path());
    let text = stdout(directory.path(), &["fly", "made.csv"]);
    assert!(
        text.starts_with("made.csv: the emulated flight computer and the host agree to the bit"),
        "{text}"
    );
    for part in ["all 850 ticks", "instructions a tick", "stack", "latched              at 14.000 s"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let same: Value =
        serde_json::from_str(&stdout(directory.path(), &["fly", "made.csv", "--json"])).unwrap();
    assert_eq!(same["bit_for_bit"], true);
    assert_eq!(same["ticks"], 850);
    assert!(same["instructions_mean"].as_f64().unwrap() > 100.0);

    let output = run(directory.path(), &["fly", "made.csv", "--json", "--plant-host-error"]);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.starts_with("error: made.csv: target and host differ: first at tick "), "{stderr}");
    assert_eq!(stderr.lines().count(), 1);
    let other: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(other["bit_for_bit"], false);
    assert!(other["ticks_that_differ"].as_u64().unwrap() > 0);
}
