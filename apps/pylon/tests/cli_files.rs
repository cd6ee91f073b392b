//! No command destroys its input, or what another command has just written.
#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used)]

mod common;

use std::fs::{self, File};
use std::path::Path;
use std::process::Stdio;

use common::Recipe;
use common::program::{files, pylon, refusal, stdout};
use tempfile::TempDir;

/// A directory with a generated flight, a scenario, a model and an IGC log, each with a second name of
/// another kind.
fn directory() -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    Recipe { captive_s: 60.0, free_s: 40.0, baro_error: |_, climb_mps| -0.8 * climb_mps, ..climbing() }
        .write(directory.path());
    fs::write(at("ours.toml"), "").unwrap();
    fs::copy(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../flights/quickstart.toml"),
        at("scenario.toml"),
    )
    .unwrap();
    fs::write(at("log.igc"), "AXXX001\r\nHFDTE010120\r\n").unwrap();
    directory
}

/// The last 40 s climb and dive, so that a lag shows.
fn climbing() -> Recipe {
    Recipe {
        climb_mps: |after_s| if after_s < 0.0 { 0.0 } else { 12.0 * (after_s * 0.5).sin() },
        ..Recipe::default()
    }
}

/// Every way to spell the path of a file in the directory.
fn spellings(directory: &Path, name: &str) -> Vec<String> {
    let names = [format!("soft-{name}"), format!("hard-{name}")];
    if !directory.join(&names[0]).exists() {
        std::os::unix::fs::symlink(name, directory.join(&names[0])).unwrap();
        fs::hard_link(directory.join(name), directory.join(&names[1])).unwrap();
    }
    names.into_iter().chain([name.to_owned(), format!("./{name}")]).collect()
}

#[test]
fn no_command_writes_over_what_it_reads() {
    let directory = directory();
    let directory = directory.path();
    let commands: [(&str, &[&str]); 10] = [
        ("log.igc", &["import", "log.igc", "-o"]),
        ("scenario.toml", &["simulate", "scenario.toml", "-o"]),
        ("scenario.toml", &["simulate", "scenario.toml", "-o", "new.csv", "--truth"]),
        ("made.csv", &["export", "made.csv", "--format", "csv", "-o"]),
        ("made.csv", &["report", "made.csv", "-o"]),
        ("ours.toml", &["report", "made.csv", "--model", "ours.toml", "-o"]),
        ("made.csv", &["add", "baro.lag", "--model", "ours.toml", "--from", "made.csv", "-o"]),
        ("made.csv", &["fly", "made.csv", "--telemetry"]),
        ("made.csv", &["fly", "made.csv", "--record"]),
        ("ours.toml", &["fly", "made.csv", "--model", "ours.toml", "--record"]),
    ];
    for (input, arguments) in commands {
        for spelling in spellings(directory, input) {
            let before = fs::read(directory.join(input)).unwrap();
            let line = refusal(directory, &[arguments, &[spelling.as_str()]].concat());
            assert!(
                line.contains("which would be lost") && line.contains(&spelling),
                "{arguments:?}: {line}"
            );
            assert_eq!(fs::read(directory.join(input)).unwrap(), before, "{arguments:?} {spelling}");
        }
    }
}

#[test]
fn a_flight_and_its_truth_are_two_files() {
    let directory = directory();
    for truth in ["a.csv", "./a.csv"] {
        let line = refusal(directory.path(), &["simulate", "scenario.toml", "-o", "a.csv", "--truth", truth]);
        assert!(line.contains("the flight and the truth would both be written to it"), "{line}");
        assert!(!files(directory.path()).contains(&"a.csv".to_owned()));
    }
}

const ADD: [&str; 6] = ["add", "--model", "ours.toml", "--from", "made.csv", "--force"];

#[test]
fn of_two_additions_at_once_none_is_lost() {
    let directory = directory();
    let start = |effect: &str| {
        let mut command = pylon(directory.path());
        command.args(ADD).arg(effect).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let both = [start("baro.lag"), start("baro.scale")];
    for child in both {
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let model = fs::read_to_string(directory.path().join("ours.toml")).unwrap();
    for effect in ["baro.lag", "baro.scale"] {
        assert!(model.contains(&format!("\"{effect}\"")), "{effect} is lost: {model}");
    }
    assert_eq!(model.matches("[[revision]]").count(), 2, "{model}");
}

/// The truth is written first: to a pipe that nothing reads, on which the program waits until it is killed.
/// If the flight were written first, it would be left behind without its truth.
#[cfg(target_os = "linux")]
#[test]
fn a_program_that_is_killed_leaves_no_flight_without_its_truth() {
    let directory = directory();
    let pipe = directory.path().join("truth.toml");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let before = files(directory.path());
    let mut command = pylon(directory.path());
    command.args(["simulate", "scenario.toml", "-o", "flight.csv", "--truth", "truth.toml"]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    // It sleeps forever once it waits for the pipe's reader, which shows in the kernel's name of where it
    // sleeps. If that is hidden, two seconds without processor time show it.
    let of_process = |file: &str| fs::read_to_string(format!("/proc/{}/{file}", child.id())).unwrap();
    let ticks = || of_process("stat").rsplit(')').next().unwrap().split(' ').nth(12).map(str::to_owned);
    let mut quiet = 0;
    while quiet < 20 && !of_process("wchan").contains("partner") {
        let before = ticks();
        std::thread::sleep(std::time::Duration::from_millis(100));
        let is_asleep = of_process("stat").contains(") S ") && ticks() == before;
        quiet = if is_asleep { quiet + 1 } else { 0 };
    }
    child.kill().unwrap();
    assert!(!child.wait().unwrap().success());
    assert_eq!(files(directory.path()), before);
}

#[test]
fn a_result_that_can_not_be_printed_leaves_the_model_as_it_was() {
    let directory = directory();
    let full = File::options().write(true).open("/dev/full").unwrap();
    let output = pylon(directory.path()).args(ADD).arg("baro.lag").stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("standard output"));
    assert_eq!(fs::read_to_string(directory.path().join("ours.toml")).unwrap(), "");
}

#[test]
fn a_model_keeps_its_mode_and_a_read_only_one_its_text() {
    use std::os::unix::fs::PermissionsExt as _;
    let directory = directory();
    let model = directory.path().join("ours.toml");
    let set = |mode| fs::set_permissions(&model, fs::Permissions::from_mode(mode)).unwrap();
    set(0o444);
    let arguments = [&ADD[..], &["baro.lag"]].concat();
    let line = {
        let output = pylon(directory.path()).args(&arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(line.contains("ours.toml: cannot be written: it is read-only"), "{line}");
    assert_eq!(fs::read_to_string(&model).unwrap(), "");
    set(0o600);
    stdout(directory.path(), &arguments);
    assert!(fs::read_to_string(&model).unwrap().contains("baro.lag"));
    assert_eq!(fs::metadata(&model).unwrap().permissions().mode() & 0o777, 0o600);
}

/// Escape sequences harm only a terminal, but what is piped into a file is later viewed on one.
#[test]
fn escape_sequences_in_a_header_are_not_passed_on() {
    let directory = directory();
    let made = directory.path().join("made.csv");
    let text =
        fs::read_to_string(&made).unwrap().replacen("# vehicle: made", "# vehicle: \x1b]0;owned\x07made", 1);
    fs::write(&made, text).unwrap();
    for command in ["compare", "open"] {
        let said = stdout(directory.path(), &[command, "made.csv"]);
        assert!(said.contains("\\u{1b}]0;owned\\u{7}made") && !said.contains('\x1b'), "{said}");
    }
}
