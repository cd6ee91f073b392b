//! The fuzzers' seeds and findings, passed to the functions that they call (`fuzz/`): no panic.
#![allow(clippy::expect_used, clippy::unwrap_used)]

#[path = "../../../fuzz/src/lib.rs"]
mod fuzzed;

use std::fs;
use std::path::Path;

type Run = fn(&[u8]);

const TARGETS: [(&str, Run); 13] = [
    ("ulog", fuzzed::ulog),
    ("mcap", fuzzed::mcap),
    ("parquet", fuzzed::parquet),
    ("altus", fuzzed::altus),
    ("dataflash", fuzzed::dataflash),
    ("dataflash_text", fuzzed::dataflash_text),
    ("igc", fuzzed::igc),
    ("record", fuzzed::record),
    ("tlog", fuzzed::tlog),
    ("table", fuzzed::table),
    ("flight_csv", fuzzed::flight_csv),
    ("model", fuzzed::model),
    ("scenario", fuzzed::scenario),
];

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz")
}

#[test]
fn nothing_that_was_found_panics_any_more() {
    for (target, run) in TARGETS {
        let seeds = fs::read_dir(folder().join("seeds").join(target)).unwrap();
        let mut files: Vec<_> = seeds.map(|entry| entry.unwrap().path()).collect();
        files.sort();
        assert!(!files.is_empty(), "{target} has nothing to begin with");
        for file in files {
            println!("{}", file.display());
            run(&fs::read(&file).unwrap());
        }
    }
}

/// A fuzz target that is missing here would go unnoticed.
#[test]
fn every_target_is_replayed() {
    let mut found: Vec<String> = fs::read_dir(folder().join("fuzz_targets"))
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    found.sort();
    let mut replayed = TARGETS.map(|(target, _)| target.to_owned());
    replayed.sort();
    assert_eq!(found, replayed);
}
