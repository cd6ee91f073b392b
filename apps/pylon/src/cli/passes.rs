//! How often commands pass over a flight's ticks. These tests are in this program, whose other tests fly
//! nothing, because passes are counted for the whole process.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use clap::Parser;
use pylon::replay::passes_begun;

use super::{Failure, diagnose, report};

#[derive(Parser)]
struct ReportLine {
    #[command(flatten)]
    arguments: report::Arguments,
}

#[derive(Parser)]
struct DiagnoseLine {
    #[command(flatten)]
    arguments: diagnose::Arguments,
}

/// Two minutes at 20 Hz, the first of them captive: marked by a launch column, or on the ground before
/// take-off.
fn write_flight(file: &Path, has_launch: bool, seed: u32) {
    let mut csv =
        "# pylon-flight: 1\ntime_s,launch,gps_alt_m,gps_vn_mps,gps_ve_mps,gps_vd_mps,baro_alt_m\n".to_owned();
    for k in 0..2400_u32 {
        let t = 0.05 * f64::from(k);
        let flown_s = if has_launch { t } else { (t - 60.0).max(0.0) };
        let speed_mps = if has_launch || k > 1200 { 30.0 } else { 0.0 };
        let (gained_m, climb_mps) =
            (60.0 * (1.0 - (flown_s / 9.0).cos()), 60.0 / 9.0 * (flown_s / 9.0).sin());
        let launch = if has_launch { u8::from(k >= 1200).to_string() } else { String::new() };
        let fix = format!("{:.3},{speed_mps},0,{:.3}", 500.0 + gained_m, -climb_mps);
        let fix = if k % 4 == 0 { fix.as_str() } else { ",,," };
        let rough = f64::from((k * 37 + seed) % 19) / 190.0;
        let _ = writeln!(csv, "{t:.3},{launch},{fix},{:.3}", 503.0 + gained_m - climb_mps + rough);
    }
    fs::write(file, csv).unwrap();
}

/// A model with a revision, so that the ladder flies two models.
const MODEL: &str = "\
[[effect]]
id = \"baro.lag\"
coefficient = 0.4
sigma = 0.1

[[revision]]
number = 1
effect = \"baro.lag\"
coefficient = 0.4
sigma = 0.1
";

/// A new question about a flight must be an observer of a pass that is already made: see "Passes over a
/// flight" in docs/workbench.md.
#[test]
fn reports_and_diagnoses_pass_a_flight_once_and_once_more_for_its_block_means() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    write_flight(Path::new(&file("one.csv")), true, 1);
    write_flight(Path::new(&file("two.csv")), true, 5);
    write_flight(Path::new(&file("held.csv")), true, 9);
    write_flight(Path::new(&file("from-the-ground.csv")), false, 3);
    fs::write(file("ours.toml"), MODEL).unwrap();
    let line = |flights: &[&str], held: &[&str]| {
        let mut words = vec![String::new()];
        words.extend(flights.iter().map(|name| file(name)));
        words.extend(held.iter().flat_map(|name| ["--hold-out".to_owned(), file(name)]));
        words.extend(["--model".to_owned(), file("ours.toml")]);
        words
    };
    let passes = |command: &dyn Fn() -> Result<(), Failure>| {
        let before = passes_begun();
        command().unwrap();
        passes_begun() - before
    };
    let both: &[&str] = &["one.csv", "two.csv"];
    for (flights, held) in
        [(&["one.csv"][..], &[][..]), (&["from-the-ground.csv"], &[]), (both, &[]), (both, &["held.csv"])]
    {
        let each = 2 * (flights.len() + held.len()) as u64;
        let mut words = line(flights, held);
        let found = passes(&|| diagnose::run(&DiagnoseLine::parse_from(&words).arguments));
        assert_eq!(found, each, "diagnose {flights:?} {held:?}");
        words.extend(["-o".to_owned(), file("page.html")]);
        let found = passes(&|| report::run(&ReportLine::parse_from(&words).arguments));
        assert_eq!(found, each, "report {flights:?} {held:?}");
    }
}
