//! The commands of README.md's "With a flight of your own", as pasted, in order, in one folder. The PX4 and
//! the ArduPilot log are real ones; if they are missing, the test reports it and runs the rest. `fly` needs
//! QEMU and has its own tests.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

use common::program::run;

/// The commands, without comments.
fn commands(readme: &str) -> Vec<String> {
    let section =
        readme.split("\n## ").find(|section| section.starts_with("With a flight of your own")).unwrap();
    let blocks = section.split("```sh\n").skip(1).map(|block| block.split("```").next().unwrap());
    let lines = blocks.flat_map(str::lines).map(|line| line.split(" #").next().unwrap().trim().to_owned());
    lines.filter(|line| !line.is_empty()).collect()
}

#[test]
fn every_command_works_as_pasted() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let directory = tempfile::tempdir().unwrap();
    symlink(root.join("flights").canonicalize().unwrap(), directory.path().join("flights")).unwrap();
    let real = root.join("../shared/flights/real");
    let mut missing = Vec::new();
    for (name, log) in [("LOG.ulg", "ulog/frrs_ekf_failure.ulg"), ("LOG.BIN", "dataflash/pymav_test.BIN")] {
        match real.join(log).canonicalize() {
            Ok(log) => symlink(log, directory.path().join(name)).unwrap(),
            Err(_) => {
                println!("skipped: {name} (no {log})");
                missing.extend([name, "flight.csv"]);
            }
        }
    }
    let mut ran = 0;
    for command in commands(&fs::read_to_string(root.join("README.md")).unwrap()) {
        if let Some(file) = command.strip_prefix("touch ") {
            fs::write(directory.path().join(file), "").unwrap();
            continue;
        }
        let arguments =
            command.strip_prefix("cargo pylon ").unwrap_or_else(|| panic!("not known: {command}"));
        let arguments: Vec<&str> = arguments.split_whitespace().collect();
        if arguments[0] == "fly" || arguments.iter().any(|argument| missing.contains(argument)) {
            println!("skipped: {command}");
            continue;
        }
        let output = run(directory.path(), &arguments);
        assert!(output.status.success(), "{command}\n{}", String::from_utf8_lossy(&output.stderr));
        if command.ends_with("diagnose q.csv") {
            let said = String::from_utf8(output.stdout).unwrap();
            assert!(said.contains("The model lacks baro.dynamic_pressure."), "{said}");
        }
        ran += 1;
    }
    assert!(ran >= 5, "{ran}");
    assert!(missing.is_empty() == directory.path().join("flight.parquet").exists());
}
