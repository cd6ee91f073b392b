//! Files that ask for excessive work or memory: a few bytes must not take down a machine.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used)]

mod common;

use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::Path;
use std::process::{Command, Output};

use common::Recipe;

/// Address space of the program, kilobytes. It reserves some tens of megabytes per thread.
const SPACE_KB: u32 = 2_000_000;

/// Runs the program with this address space.
fn run(directory: &Path, arguments: &[&str]) -> Output {
    let script = format!("ulimit -v {SPACE_KB} && exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &script, env!("CARGO_BIN_EXE_pylon")]).args(arguments).current_dir(directory);
    command.output().unwrap()
}

/// Runs the program; it must end by itself, with success or with one line that gives the reason.
fn ends(directory: &Path, arguments: &[&str]) -> String {
    let output = run(directory, arguments);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(matches!(output.status.code(), Some(0 | 2)), "{arguments:?}: {:?} {error}", output.status);
    for word in ["panicked", "bug in pylon", "memory allocation"] {
        assert!(!error.contains(word), "{arguments:?}: {error}");
    }
    error
}

const EVERY: [&[&str]; 4] =
    [&["open"], &["compare"], &["diagnose"], &["export", "--format", "csv", "-o", "out.csv"]];

#[test]
fn three_rows_with_a_gap_of_twelve_years_are_bounded_work() {
    let directory = tempfile::tempdir().unwrap();
    let text = "# pylon-flight: 1\ntime_s,gps_alt_m,baro_alt_m\n0,100,101\n1,100,101\n4e8,100,101\n";
    fs::write(directory.path().join("gap.csv"), text).unwrap();
    for command in EVERY {
        ends(directory.path(), &[command, &["gap.csv"]].concat());
    }
}

#[test]
fn a_million_columns_are_bounded_work() {
    let directory = tempfile::tempdir().unwrap();
    let mut file = BufWriter::new(File::create(directory.path().join("wide.csv")).unwrap());
    write!(file, "# pylon-flight: 1\ntime_s,gps_alt_m,baro_alt_m").unwrap();
    (0..1_000_000).for_each(|column| write!(file, ",x{column}").unwrap());
    for row in 0..3 {
        write!(file, "\n{row},100,101").unwrap();
        file.write_all(&[b','; 1_000_000]).unwrap();
    }
    file.into_inner().unwrap();
    // The other commands read the file in the same way.
    for command in [EVERY[0], EVERY[3]] {
        ends(directory.path(), &[command, &["wide.csv"]].concat());
    }
}

#[test]
fn a_line_of_a_hundred_megabytes_is_bounded_work() {
    let directory = tempfile::tempdir().unwrap();
    let mut text = b"# pylon-flight: 1\ntime_s,gps_alt_m,baro_alt_m\n0,100,".to_vec();
    text.resize(100_000_000, b'1');
    fs::write(directory.path().join("long.csv"), &text).unwrap();
    // A file of unknown format is searched for a table, too.
    fs::write(directory.path().join("long.txt"), &text[40..]).unwrap();
    for file in ["long.csv", "long.txt"] {
        ends(directory.path(), &["open", file]);
    }
}

#[test]
fn a_window_longer_than_the_universe_is_refused_or_harmless() {
    let directory = tempfile::tempdir().unwrap();
    Recipe { captive_s: 40.0, free_s: 20.0, ..Recipe::default() }.write(directory.path());
    for window in ["1e30", "1e12", "3e38"] {
        fs::write(directory.path().join("wide.toml"), format!("[monitor]\nwindow_s = {window}\n")).unwrap();
        ends(directory.path(), &["compare", "made.csv", "--model", "wide.toml"]);
    }
    ends(directory.path(), &["compare", "made.csv", "--calibrate", "0..1e30"]);
}
