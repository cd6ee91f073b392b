//! Tests of the program from the user's side.
#![allow(clippy::unwrap_used)]

use std::process::{Command, Output};

fn xtask(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask")).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn without_a_job_it_lists_the_jobs() {
    let alone = xtask(&[]);
    assert!(alone.status.success());
    let help = text(&alone.stdout);
    for word in ["setup", "demo", "test", "bench", "Examples:", "cargo xtask demo"] {
        assert!(help.contains(word), "{help}");
    }
    assert_eq!(help, text(&xtask(&["--help"]).stdout));
}

#[test]
fn steps_are_listed_without_running_them_and_an_unknown_one_is_refused() {
    let list = text(&xtask(&["test", "--list"]).stdout);
    assert!(list.lines().any(|line| line == "formatting"), "{list}");
    let some = text(&xtask(&["test", "--list", "clippy"]).stdout);
    assert!(some.lines().count() > 1 && some.lines().all(|line| line.starts_with("clippy")), "{some}");
    let unknown = xtask(&["test", "--list", "no-such-step"]);
    assert!(!unknown.status.success() && unknown.stdout.is_empty());
    assert_eq!(
        text(&unknown.stderr),
        "error: no step or test program is called no-such-step; `cargo xtask test --list` names them\n"
    );
}

#[test]
fn a_program_of_tests_can_be_chosen_by_its_name() {
    assert_eq!(text(&xtask(&["test", "--list", "budgets"]).stdout), "tests\n  budgets\n");
    let studio = text(&xtask(&["test", "--list", "studio"]).stdout);
    assert!(studio.starts_with("studio\ntests\n  studio\n"), "{studio}");
    let all = text(&xtask(&["test", "--list", "tests"]).stdout);
    assert!(all.lines().any(|line| line == "  golden") && all.lines().count() > 50, "{all}");
}

#[test]
fn a_measured_child_has_its_own_peak_of_memory() {
    let peak_bytes = |script: &str| {
        let said = text(&xtask(&["measure", "--", "sh", "-c", script]).stdout);
        let cost: serde_json::Value = serde_json::from_str(&said).unwrap();
        assert!(cost["seconds"].as_f64().unwrap() > 0.0, "{said}");
        cost["peak_bytes"].as_u64().unwrap()
    };
    let little = peak_bytes("true");
    let much = peak_bytes("x=$(head -c 40000000 /dev/zero | tr '\\0' x); echo ${#x}");
    assert!(little < 20_000_000, "{little}");
    assert!((40_000_000..1_000_000_000).contains(&much), "{much}");
}

#[test]
fn a_measured_child_that_fails_has_no_cost() {
    let failed = xtask(&["measure", "--", "sh", "-c", "exit 3"]);
    assert!(!failed.status.success() && failed.stdout.is_empty(), "{failed:?}");
    assert_eq!(text(&failed.stderr), "error: `sh -c exit 3` ended with exit status: 3\n");
}

/// Runs the program with nothing on its PATH except a `probe-rs` that prints this text, if given.
fn with_probe_rs(arguments: &[&str], says: Option<&str>) -> Output {
    use std::os::unix::fs::PermissionsExt;

    let folder = std::env::temp_dir().join(format!("xtask-{}-{}", std::process::id(), arguments.join("-")));
    std::fs::create_dir_all(&folder).unwrap();
    if let Some(says) = says {
        let program = folder.join("probe-rs");
        std::fs::write(&program, format!("#!/bin/sh\necho '{says}'\n")).unwrap();
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    }
    let output =
        Command::new(env!("CARGO_BIN_EXE_xtask")).args(arguments).env("PATH", &folder).output().unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    output
}

/// Status 1 would mean that the bits differ.
#[test]
fn a_flight_that_can_not_be_flown_on_a_board_is_status_2() {
    let hil = with_probe_rs(&["hil", "flight.csv"], None);
    assert_eq!(hil.status.code(), Some(2), "{hil:?}");
    assert!(hil.stdout.is_empty() && text(&hil.stderr).contains("error: "), "{hil:?}");
}

#[test]
fn without_probe_rs_flash_says_how_to_get_it_and_builds_nothing() {
    let flash = with_probe_rs(&["flash"], None);
    assert!(!flash.status.success() && flash.stdout.is_empty());
    let said = text(&flash.stderr);
    assert!(said.starts_with("error: probe-rs is missing"), "{said}");
    assert!(said.contains("cargo install probe-rs-tools --locked") && !said.contains("building"), "{said}");
}

#[test]
fn without_a_probe_flash_says_what_to_look_at_and_builds_nothing() {
    let flash = with_probe_rs(&["flash", "--model", "paper"], Some("No debug probes were found."));
    assert!(!flash.status.success() && flash.stdout.is_empty());
    let said = text(&flash.stderr);
    assert!(said.starts_with("error: probe-rs finds no debug probe"), "{said}");
    assert!(said.contains("docs/bring-up.md") && !said.contains("building"), "{said}");
}

#[test]
fn the_boards_jobs_have_examples() {
    for job in ["flash", "log"] {
        let help = text(&xtask(&[job, "--help"]).stdout);
        assert!(help.contains("Examples:") && help.contains(&format!("cargo xtask {job}")), "{help}");
    }
}
