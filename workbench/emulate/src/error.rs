//! Why a flight did not fly, or flew otherwise than on the host.

use std::io;

use flight_record::ExitStatus;
use model::ModelError;
use thiserror::Error;

use super::compare::Difference;
use super::fault_script::FaultError;

/// Why a flight through the firmware failed; displays as one line.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FlyError {
    /// QEMU is not there.
    #[error(
        "qemu-system-arm is not installed: `apt-get install qemu-system-arm` (Debian, Ubuntu), `brew install qemu` (macOS)"
    )]
    NoEmulator,
    /// OpenOCD is not there.
    #[error(
        "openocd is not installed or not in PATH: `apt-get install openocd` (Debian, Ubuntu), `brew install open-ocd` (macOS)"
    )]
    NoDebugger,
    /// An OpenOCD that does not hand on the image's exit status.
    #[error("this is OpenOCD 0.{minor}: a flight on a board needs 0.11 or newer")]
    OldDebugger {
        /// Its version, after the `0.`.
        minor: u32,
    },
    /// OpenOCD found no debug probe.
    #[error(
        "openocd finds no debug probe ({said}): is it plugged in, by a cable that carries data? is the probe's configuration \
         (`--probe-config`) that of its kind? on Linux: may this user open it (OpenOCD's udev rules, 60-openocd.rules)?"
    )]
    NoProbe {
        /// OpenOCD's most telling line.
        said: String,
    },
    /// The probe reached no microcontroller.
    #[error(
        "the probe finds no STM32F405 ({said}): is the board powered? are SWDIO, SWCLK and ground connected, and not swapped \
         (docs/bring-up.md)?"
    )]
    NoBoard {
        /// OpenOCD's most telling line.
        said: String,
    },
    /// The image did not get into the flash.
    #[error(
        "the image could not be written to the board ({said}): is its flash protected? is its supply steady?"
    )]
    NotWritten {
        /// OpenOCD's most telling line.
        said: String,
    },
    /// OpenOCD ended before the flight did.
    #[error("openocd ended before the flight did ({said})")]
    DebugLink {
        /// OpenOCD's most telling line.
        said: String,
    },
    /// Neither the board nor OpenOCD said anything any more.
    #[error(
        "neither the board nor openocd has responded for {seconds} s ({said}): reset the board and try again"
    )]
    Silent {
        /// How long was waited, seconds.
        seconds: u64,
        /// OpenOCD's most telling line.
        said: String,
    },
    /// cargo is not there.
    #[error(
        "cargo is not installed or not in PATH: the firmware is built for every model; see https://rustup.rs"
    )]
    NoCargo,
    /// The compiler has no standard library for the target.
    #[error("the Rust target of the flight computer is not installed: `rustup target add {target}`")]
    NoTarget {
        /// The target's name.
        target: &'static str,
    },
    /// The firmware's source is not where this workbench was built.
    #[error("no firmware in {path}: the workbench must stay in the checkout that it was built from")]
    NoSource {
        /// Where it should be.
        path: String,
    },
    /// The flight computer restarted in the middle of the flight.
    #[error("the flight computer restarted, after {0}: ticks are missing")]
    Restarted(&'static str),
    /// The firmware does not build.
    #[error("the firmware does not build: {first_error}")]
    Build {
        /// The compiler's first error line.
        first_error: String,
    },
    /// A file could not be read or written, or a program not be run.
    #[error("{what}: {source}")]
    Io {
        /// What was tried, on which file.
        what: String,
        /// Why it failed.
        source: io::Error,
    },
    /// The image is not an ELF file as the build makes them.
    #[error("{path}: {why}")]
    Image {
        /// The image.
        path: String,
        /// What is wrong with it.
        why: String,
    },
    /// The model can not be flown.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The host's mission refuses the model, or the flight.
    #[error("{0}")]
    Host(String),
    /// The planned faults can not be followed.
    #[error(transparent)]
    Fault(#[from] FaultError),
    /// The flight ended otherwise than at the end of the record.
    #[error("the flight computer stopped: {}{}", ended(*.status), last_line(.log))]
    Stopped {
        /// Its status, if it is one of the firmware's.
        status: Option<ExitStatus>,
        /// What it logged, or QEMU's own words.
        log: Vec<String>,
    },
    /// The emulation did not end.
    #[error("the emulated flight computer did not finish within {seconds} s")]
    Timeout {
        /// How long was waited, seconds.
        seconds: u64,
    },
    /// What the firmware wrote is not a stream of results.
    #[error("the results of the flight computer are damaged: {0}")]
    Results(String),
    /// The firmware did not get or did not fly all of the record.
    #[error("the flight computer did not fly the whole record: {0}")]
    Incomplete(String),
    /// Host and target computed different bits.
    #[error("target and host differ: {0}")]
    Differs(Box<Difference>),
}

impl FlyError {
    pub(super) fn io(what: impl Into<String>) -> impl FnOnce(io::Error) -> Self {
        let what = what.into();
        move |source| Self::Io { what, source }
    }
}

const fn ended(status: Option<ExitStatus>) -> &'static str {
    match status {
        Some(ExitStatus::Finished) => "at the end of the record",
        Some(ExitStatus::NoInput) => "it could not open the record",
        Some(ExitStatus::NoHeader) => "the record has no header of this version",
        Some(ExitStatus::OtherModel) => "the record is meant for another model than the one compiled in",
        Some(ExitStatus::Configuration) => "the mission refused its configuration",
        Some(ExitStatus::NoOutput) => "it could not write its results",
        Some(ExitStatus::Panic) => "it panicked",
        Some(ExitStatus::HardFault) => "the core faulted",
        Some(ExitStatus::Standby) => "it restarted too often",
        None => "QEMU failed",
    }
}

fn last_line(log: &[String]) -> String {
    log.last().map_or_else(String::new, |line| format!(" ({line})"))
}
