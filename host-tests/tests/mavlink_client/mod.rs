//! pymavlink, an independent implementation, as the reader of the telemetry.
// Each test file uses only part of this.
#![allow(dead_code, clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// Its decoding of the bytes of a line, message by message.
pub fn decode(bytes: &[u8]) -> Vec<Value> {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    run(&[file.path().as_os_str()])
}

/// Its decoding of a recording.
pub fn decode_tlog(file: &Path) -> Vec<Value> {
    run(&["--tlog".as_ref(), file.as_os_str()])
}

fn run(arguments: &[&std::ffi::OsStr]) -> Vec<Value> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| here.join("../target"), PathBuf::from);
    let python = target.join("pymavlink/bin/python");
    assert!(python.exists(), "no pymavlink: `cargo xtask setup` installs it");
    let output = Command::new(python).arg(here.join("telemetry/decode.py")).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout)
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

/// Messages of one type.
pub fn of<'a>(messages: &'a [Value], kind: &str) -> Vec<&'a Value> {
    messages.iter().filter(|message| message["mavpackettype"] == kind).collect()
}

/// A field as the f32 that it was on the wire; NaN where it was not finite.
pub fn f32_of(message: &Value, field: &str) -> f32 {
    match &message[field] {
        Value::Null => f32::NAN,
        value => value.as_f64().unwrap_or_else(|| panic!("{field} of {message}")) as f32,
    }
}

/// A field as a whole number.
pub fn whole(message: &Value, field: &str) -> i64 {
    message[field].as_i64().unwrap_or_else(|| panic!("{field} of {message}"))
}

/// The values with that name: milliseconds and number.
pub fn named(messages: &[Value], name: &str) -> Vec<(i64, f32)> {
    of(messages, "NAMED_VALUE_FLOAT")
        .into_iter()
        .filter(|message| message["name"] == name)
        .map(|message| (whole(message, "time_boot_ms"), f32_of(message, "value")))
        .collect()
}

/// The texts, in order.
pub fn texts(messages: &[Value]) -> Vec<String> {
    of(messages, "STATUSTEXT").iter().map(|message| message["text"].as_str().unwrap().to_owned()).collect()
}

/// Number of missing sequence numbers between neighbours.
pub fn gaps(messages: &[Value]) -> i64 {
    messages
        .windows(2)
        .map(|pair| (whole(&pair[1], "seq") - whole(&pair[0], "seq") - 1).rem_euclid(256))
        .sum()
}
