//! The firmware's own memory copy and fill routines, with every length, in QEMU.
#![allow(clippy::unwrap_used)]

use std::time::Duration;

use model::Model;
use pylon::fly::{Program, build, emulate};

#[test]
fn copies_and_fills_of_every_length_do_that_and_nothing_else() {
    let image = build(Program::CopyCheck, &Model::default(), None).unwrap();
    let directory = tempfile::tempdir().unwrap();
    let emulation = emulate(&image, directory.path(), None, Duration::from_secs(120)).unwrap();
    assert_eq!(emulation.code, Some(0), "{}", emulation.stderr);
}
