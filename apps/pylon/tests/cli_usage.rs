//! The command line itself: usage, streams, exit status, output files.
#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used)]

mod common;

use std::fs;
use std::io::Read as _;
use std::process::Stdio;

use common::Recipe;
use common::program::{files, pylon, refusal, run, stdout};

#[test]
fn bad_usage_is_one_line_and_status_2() {
    let directory = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str]| refusal(directory.path(), arguments);
    assert!(refused(&["frobnicate"]).contains("unrecognized subcommand 'frobnicate'"));
    assert!(refused(&["compare"]).contains("<FLIGHT>"));
    assert!(refused(&["compare", "x.csv", "--no-such"]).contains("--no-such"));
    assert!(
        refused(&["export", "x.csv", "--format", "xls", "-o", "y"])
            .contains("[possible values: csv, mcap, parquet, plain-csv]")
    );
    assert!(refused(&["compare", "x.csv", "--step=-3"]).contains("expected a positive number"));
    assert!(
        refused(&["simulate", "x.toml", "-o", "a", "--truth", "a"]).contains("would both be written to it")
    );
}

#[test]
fn help_goes_to_standard_output() {
    let directory = tempfile::tempdir().unwrap();
    for arguments in [&[][..], &["--help"], &["compare", "--help"], &["help", "fly"], &["--version"]] {
        let text = stdout(directory.path(), arguments);
        assert!(text.contains("pylon"), "{text}");
        assert!(!text.contains('\u{1b}'), "colours in a pipe: {text:?}");
    }
    assert_eq!(stdout(directory.path(), &[] as &[&str]), stdout(directory.path(), &["-h"]));
}

#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    let directory = tempfile::tempdir().unwrap();
    Recipe { captive_s: 40.0, free_s: 5.0, ..Recipe::default() }.write(directory.path());
    for arguments in
        [&["compare", "made.csv", "--json"][..], &["compare", "made.csv"], &["compare", "--help"]]
    {
        let mut child = pylon(directory.path())
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let mut stderr = String::new();
        child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        assert!(child.wait().unwrap().success(), "{stderr}");
        assert_eq!(stderr, "");
    }
}

#[test]
fn results_have_no_colours_in_a_pipe_and_json_is_all_there_is() {
    let directory = tempfile::tempdir().unwrap();
    Recipe { captive_s: 40.0, free_s: 5.0, ..Recipe::default() }.write(directory.path());
    let text = stdout(directory.path(), &["compare", "made.csv"]);
    assert!(text.starts_with("made.csv: 44.98 s in 2,250 rows, launch at 40.000 s\n"), "{text}");
    assert!(!text.contains('\u{1b}'));
    let json = run(directory.path(), &["compare", "made.csv", "--json"]);
    assert!(json.stderr.is_empty());
    serde_json::from_slice::<serde_json::Value>(&json.stdout).unwrap();
}

#[test]
fn simulate_writes_flight_and_truth_and_the_same_bytes_for_the_same_seed() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/../../flights/quickstart.toml");
    let line = stdout(path, &["simulate", scenario, "-o", "a.csv"]);
    assert!(line.starts_with("a.csv: simulated "), "{line}");
    stdout(path, &["simulate", scenario, "-o", "b.csv", "--truth", "b.toml"]);
    stdout(path, &["simulate", scenario, "-o", "c.csv", "--seed", "12345"]);
    assert_eq!(files(path), ["a.csv", "a.truth.toml", "b.csv", "b.toml", "c.csv", "c.truth.toml"]);
    let read = |name: &str| fs::read(path.join(name)).unwrap();
    assert_eq!(read("a.csv"), read("b.csv"));
    assert_ne!(read("a.csv"), read("c.csv"));
    let text = stdout(path, &["compare", "a.csv"]);
    assert!(text.contains("simulate"), "simulated data must be called that: {text}");
}

#[test]
fn import_and_export_make_the_same_flight() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    let mut log = "AXXXABC\nHFDTE010424\nI013638TAS\n".to_owned();
    for second in 0..120 {
        let (altitude, pressure) = (1_000 + second / 10, 980 + second / 10);
        log += &format!("B1200{:02}4700000N00800000EA{pressure:05}{altitude:05}028\n", second % 60).replacen(
            "B1200",
            &format!("B12{:02}", second / 60),
            1,
        );
    }
    fs::write(path.join("log.igc"), log).unwrap();
    let line = stdout(path, &["import", "log.igc", "-o", "imported.csv"]);
    assert!(line.starts_with("imported.csv: 120 rows of time_s, "), "{line}");
    stdout(path, &["export", "log.igc", "--format", "csv", "-o", "exported.csv"]);
    let read = |name: &str| fs::read(path.join(name)).unwrap();
    assert_eq!(read("imported.csv"), read("exported.csv"));
    stdout(path, &["export", "imported.csv", "--format", "mcap", "-o", "flight.mcap"]);
    assert_eq!(&read("flight.mcap")[1..5], b"MCAP");
}

#[test]
fn plots_are_drawn_into_a_new_directory_and_stay_small() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    Recipe { captive_s: 80.0, free_s: 400.0, ..Recipe::default() }.write(path);
    stdout(path, &["compare", "made.csv", "--plots", "deep/pictures"]);
    let pictures = path.join("deep/pictures");
    let names = ["figure-2-calibration.svg", "figure-3-residuals.svg", "figure-4-free-flight.svg"];
    assert_eq!(files(&pictures), names);
    for name in names {
        let svg = fs::read_to_string(pictures.join(name)).unwrap();
        assert!(svg.len() < 500_000, "{name}: {} bytes", svg.len());
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{name}");
        assert!(svg.contains("source: made for a test, not measured"), "{name}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
    }
    let last = fs::read_to_string(pictures.join(names[2])).unwrap();
    assert!(last.contains("time after launch, s") && last.contains("error of baro, m"));
    // No free flight: no Figure 4, but all the others.
    Recipe { free_s: 0.0, ..Recipe::default() }.write(path);
    stdout(path, &["compare", "made.csv", "--plots", "captive"]);
    assert_eq!(files(&path.join("captive")), &names[..2]);
    fs::write(path.join("file"), "").unwrap();
    let line = refusal(path, &["compare", "made.csv", "--plots", "file"]);
    assert!(line.contains("file: cannot create the directory"), "{line}");
}
