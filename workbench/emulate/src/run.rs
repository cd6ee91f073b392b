//! One run of an image: how it ended, and what it left in its directory.

use std::fs;
use std::path::Path;
use std::time::Duration;

use flight_record::{ExitStatus, OUTPUT_FILE};

use super::emulator::{Emulation, emulate};
use super::error::FlyError;
use super::log;
use super::record::Results;

/// Longest wait for an emulation that does not end, plus [`PATIENCE_PER_TICK`].
const PATIENCE: Duration = Duration::from_secs(120);
/// The same for each tick: some fifty times what a tick takes.
const PATIENCE_PER_TICK: Duration = Duration::from_millis(10);

/// File of the telemetry line's bytes, in the emulation's folder.
pub(crate) const TELEMETRY_FILE: &str = "telemetry.bin";

/// What a flight left behind.
pub struct Run {
    /// How the firmware ended it; `None` if it did not.
    pub status: Option<ExitStatus>,
    /// What it logged; QEMU's own output if the firmware did not end it.
    pub log: Vec<String>,
    /// Its results.
    pub results: Results,
}

/// Runs an image in QEMU on the record in this directory, of at most this many ticks.
pub(crate) fn emulated(
    image: &Path,
    directory: &Path,
    ticks: u32,
    telemetry: Option<&'static str>,
) -> Result<Run, FlyError> {
    let patience = PATIENCE + PATIENCE_PER_TICK.saturating_mul(ticks);
    Run::of(emulate(image, directory, telemetry, patience)?, image, directory)
}

impl Run {
    /// Reads what an image has left in its directory.
    pub(crate) fn of(ended: Emulation, image: &Path, directory: &Path) -> Result<Self, FlyError> {
        let status = ended.code.and_then(ExitStatus::from_code);
        let elf = fs::read(image).map_err(FlyError::io(image.display().to_string()))?;
        let mut log = log::lines(&elf, &ended.stdout);
        log.extend(ended.stderr.lines().map(str::to_owned));
        let output = directory.join(name(OUTPUT_FILE)?);
        if !output.is_file() {
            return Err(FlyError::Stopped { status, log });
        }
        Ok(Self { status, log, results: Results::open(&output)? })
    }
}

/// A file's name as a Rust string.
pub(crate) fn name(file: &'static std::ffi::CStr) -> Result<&'static str, FlyError> {
    file.to_str().map_err(FlyError::FileName)
}

/// The results that an image left in its directory, as it sent them.
pub(crate) fn results(directory: &Path) -> Result<Vec<u8>, FlyError> {
    fs::read(directory.join(name(OUTPUT_FILE)?)).map_err(FlyError::io("the results"))
}
