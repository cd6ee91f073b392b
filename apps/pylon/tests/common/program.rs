//! The program itself, run as a user would.

use std::ffi::OsStr;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// The program, to be run in this directory.
pub fn pylon(directory: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pylon"));
    command.current_dir(directory);
    command
}

/// Runs the program.
pub fn run<S: AsRef<OsStr>>(directory: &Path, arguments: &[S]) -> Output {
    pylon(directory).args(arguments).output().unwrap()
}

/// Standard output of a run that must succeed.
pub fn stdout<S: AsRef<OsStr>>(directory: &Path, arguments: &[S]) -> String {
    let output = run(directory, arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// JSON of a comparison that must succeed.
pub fn compared(directory: &Path, file: &str) -> Value {
    serde_json::from_str(&stdout(directory, &["compare", file, "--json"])).unwrap()
}

/// The one line of a run that must be refused: exit status 2, nothing on standard output.
pub fn refusal<S: AsRef<OsStr>>(directory: &Path, arguments: &[S]) -> String {
    let output = run(directory, arguments);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert_eq!(String::from_utf8(output.stdout).unwrap(), "");
    assert!(stderr.starts_with("error: ") && stderr.ends_with('\n'), "{stderr}");
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
    stderr
}

/// Names of the files in a directory.
pub fn files(directory: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(directory).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}
