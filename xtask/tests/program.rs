//! The program as a user meets it.
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
        "error: no step is called no-such-step; `cargo xtask test --list` names them\n"
    );
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
