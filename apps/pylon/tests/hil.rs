//! A flight through a board on its debug link (`pylon fly --hil`), as far as can be tested without one: the
//! image for the board runs in QEMU, and OpenOCD is a stand-in (`common/openocd.rs`).
//!
//! Needs qemu-system-arm and the Rust target.
#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used)]

mod common;

use std::env;
use std::path::Path;
use std::process::Output;
use std::time::{Duration, Instant};

use common::Recipe;
use common::openocd::{Trouble, install, link};
use common::program::{pylon, refusal};
use model::Model;
use pylon::flight::write;
use pylon::fly::{CostUnit, DebugLink, FlownOn, FlyError, FlyOptions, FlyReport, PlantedError, fly};
use pylon::replay::Replay;
use pylon::simulate::{load_scenario, simulate};
use serde_json::Value;

/// Counts of the tick timer: 5 ms at 16 MHz.
const TICK_COUNTS: u64 = 80_000;

/// The first 16 s of calibration and 11 s of free flight of the quickstart, ticks.
const QUICKSTART_TICKS: u64 = 200 * (16 + 5 + 6);

/// The quickstart's flight, cut to the minimum that both phases need, as `flight.csv`.
fn write_quickstart(directory: &Path) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../flights/quickstart.toml");
    let mut scenario = load_scenario(&file).unwrap();
    scenario.captive.duration_s = 16.0;
    scenario.free_flight.truncate(2);
    scenario.free_flight[1].duration_s = 6.0;
    let (flight, _) = simulate(&scenario, scenario.seed).unwrap();
    write(&directory.join("flight.csv"), &flight).unwrap();
}

/// `pylon` with a stand-in first in the path.
fn run(directory: &Path, trouble: Trouble, arguments: &[&str]) -> Output {
    let tools = tempfile::tempdir().unwrap();
    install(tools.path(), trouble);
    let others = env::var_os("PATH").unwrap();
    let path = env::join_paths([tools.path().to_owned()].into_iter().chain(env::split_paths(&others)));
    pylon(directory).env("PATH", path.unwrap()).args(arguments).output().unwrap()
}

#[test]
fn every_tick_of_captive_and_of_free_flight_has_the_hosts_bits() {
    let directory = tempfile::tempdir().unwrap();
    write_quickstart(directory.path());
    let said = |arguments: &[&str]| {
        let output = run(directory.path(), Trouble::None, arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let text = said(&["fly", "flight.csv", "--hil"]);
    let agreement =
        format!("flight.csv: the board and the host agree to the bit in all {QUICKSTART_TICKS} ticks\n");
    assert!(text.starts_with(&agreement), "{text}");
    for part in
        ["cycles a tick", "latched              at 16.000 s", "on chips", "m from ideal sensors (within"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!text.contains("instructions"), "{text}");

    let same: Value = serde_json::from_str(&said(&["fly", "flight.csv", "--hil", "--json"])).unwrap();
    assert_eq!(same["bit_for_bit"], true);
    assert_eq!(same["ticks"], QUICKSTART_TICKS);
    assert_eq!(same["latched_s"], 16.0);
    // The drivers were used, and nothing went wrong.
    assert_eq!(same["sensor_faults"], 0);
    assert_eq!(same["chips"]["agreement"]["baro"]["within_bound"], true);
    assert!(same["parts"]["mission"]["cycles_mean"].as_f64().unwrap() > 100.0, "{same}");
    // A tick is 5 ms of the board's clock, and the chip models, the messages and the results fit into it.
    // QEMU's timer is one count short.
    let period = same["tick_period_cycles"].as_u64().unwrap();
    assert!(period.abs_diff(TICK_COUNTS) <= 1, "{same}");
    assert_eq!((&same["underruns"], &same["stalls"]), (&Value::from(0), &Value::from(0)));
}

/// A generated flight through the image with a planted error or load.
fn fly_planted(planted: PlantedError) -> Result<FlyReport, FlyError> {
    let tools = tempfile::tempdir().unwrap();
    let flight = Recipe { captive_s: 14.0, free_s: 3.0, ..Recipe::default() }.make();
    let model = Model::default();
    let options = FlyOptions {
        on: FlownOn::Board(link(tools.path(), Trouble::None)),
        target_error: Some(planted),
        ..FlyOptions::default()
    };
    fly(&Replay::new(&flight, &model, None).unwrap(), &options)
}

#[test]
fn one_unit_in_the_last_place_on_the_board_is_found() {
    let error = fly_planted(PlantedError::Ulp).unwrap_err();
    let FlyError::Differs(difference) = &error else { panic!("{error}") };
    assert_eq!(difference.field, "input.baro", "{error}");
}

/// The board restarts after any number of panics, and the comparison ends.
#[test]
fn a_panic_on_the_board_restarts_it_and_says_so() {
    let error = fly_planted(PlantedError::Panic).unwrap_err();
    assert!(matches!(error, FlyError::Restarted(_)), "{error}");
    assert!(error.to_string().contains("restarted, after a panic"), "{error}");
}

/// With a board it is the host that is slow.
#[test]
fn ticks_that_wait_for_the_host_are_no_failure() {
    let report = fly_planted(PlantedError::Starve).unwrap();
    assert!(report.underruns > 100 && report.stalls > 100, "{report:?}");
    assert_eq!(report.cost_unit, CostUnit::Cycles);
}

/// One line with the cause and the remedy, and status 2.
#[test]
fn what_keeps_a_board_from_flying_is_said_in_one_line() {
    let directory = tempfile::tempdir().unwrap();
    Recipe { captive_s: 14.0, free_s: 3.0, ..Recipe::default() }.write(directory.path());
    for (trouble, said) in [
        (Trouble::Old, "this is OpenOCD 0.10: a flight on a board needs 0.11 or newer"),
        (Trouble::NoProbe, "openocd finds no debug probe (Error: open failed): is it plugged in"),
        (Trouble::NoBoard, "the probe finds no STM32F405 (Error: init mode failed"),
        (Trouble::NotWritten, "the image could not be written to the board (** Programming Failed **)"),
        (Trouble::Halted, "openocd ended before the flight did (pylon: the core has stopped"),
    ] {
        let output = run(directory.path(), trouble, &["fly", "made.csv", "--hil"]);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(stderr.starts_with(&format!("error: made.csv: {said}")), "{stderr}");
        assert_eq!((stderr.lines().count(), output.stdout.len()), (1, 0), "{stderr}");
    }
}

#[test]
fn without_openocd_it_is_said_how_to_get_it_before_anything_is_built() {
    let directory = tempfile::tempdir().unwrap();
    Recipe { captive_s: 14.0, free_s: 3.0, ..Recipe::default() }.write(directory.path());
    let mut command = pylon(directory.path());
    // Not even cargo can be found.
    let output = command.env("PATH", directory.path()).args(["fly", "made.csv", "--hil"]).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(
        stderr.contains("openocd is not installed or not in PATH: `apt-get install openocd`"),
        "{stderr}"
    );
}

#[test]
fn a_board_of_which_nothing_is_heard_is_given_up() {
    let tools = tempfile::tempdir().unwrap();
    let flight = Recipe { captive_s: 14.0, free_s: 3.0, ..Recipe::default() }.make();
    let model = Model::default();
    let silence = Duration::from_secs(2);
    let link = DebugLink { silence, ..link(tools.path(), Trouble::Hung) };
    let options = FlyOptions { on: FlownOn::Board(link), ..FlyOptions::default() };
    let replay = Replay::new(&flight, &model, None).unwrap();
    let started = Instant::now();
    let error = fly(&replay, &options).unwrap_err();
    assert!(matches!(error, FlyError::Silent { seconds: 2, .. }), "{error}");
    assert!(error.to_string().contains("for 2 s (** Verified OK **): reset the board"), "{error}");
    // The stand-in sleeps for ten minutes; the remaining time is the build of the image.
    assert!(started.elapsed() < Duration::from_secs(500));
}

#[test]
fn options_that_do_not_go_together_are_refused() {
    let directory = tempfile::tempdir().unwrap();
    for arguments in [
        &["fly", "made.csv", "--probe-config", "interface/stlink.cfg"][..],
        &["fly", "made.csv", "--hil", "--telemetry", "made.tlog"],
    ] {
        refusal(directory.path(), arguments);
    }
}
