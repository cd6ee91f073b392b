//! Why a flight was not flown, or differed from the host's.

use std::str::Utf8Error;
use std::{fmt, io};

use flight_record::{ExitStatus, FrameError, Kind, PayloadError};
use model::ModelError;
use rand_distr::NormalError;
use replay::ReplayError;
use thiserror::Error;

use super::compare::Difference;
use super::fault_script::FaultError;

/// Why a flight through the firmware failed; displays as one line.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FlyError {
    /// QEMU is not installed.
    #[error(
        "qemu-system-arm is not installed: `apt-get install qemu-system-arm` (Debian, Ubuntu), `brew install qemu` (macOS)"
    )]
    NoEmulator,
    /// OpenOCD is not installed.
    #[error(
        "openocd is not installed or not in PATH: `apt-get install openocd` (Debian, Ubuntu), `brew install open-ocd` (macOS)"
    )]
    NoDebugger,
    /// An OpenOCD that does not pass on the image's exit status.
    #[error("this is OpenOCD 0.{minor}: a flight on a board needs 0.11 or newer")]
    OldDebugger {
        /// Its version, after the `0.`.
        minor: u32,
    },
    /// OpenOCD found no debug probe.
    #[error(
        "openocd finds no debug probe ({said}): is it plugged in, by a cable that carries data? is the probe's configuration \
         (`--probe-config`) the right one? on Linux: may this user open it (OpenOCD's udev rules, 60-openocd.rules)?"
    )]
    NoProbe {
        /// The most informative line of OpenOCD's output.
        said: String,
    },
    /// The probe reached no microcontroller.
    #[error(
        "the probe finds no STM32F405 ({said}): is the board powered? are SWDIO, SWCLK and ground connected, and not swapped \
         (docs/bring-up.md)?"
    )]
    NoBoard {
        /// The most informative line of OpenOCD's output.
        said: String,
    },
    /// The image was not written to the flash.
    #[error(
        "the image could not be written to the board ({said}): is its flash protected? is its supply steady?"
    )]
    NotWritten {
        /// The most informative line of OpenOCD's output.
        said: String,
    },
    /// OpenOCD ended before the flight did.
    #[error("openocd ended before the flight did ({said})")]
    DebugLink {
        /// The most informative line of OpenOCD's output.
        said: String,
    },
    /// Neither the board nor OpenOCD sent anything any more.
    #[error(
        "neither the board nor openocd has responded for {seconds} s ({said}): reset the board and try again"
    )]
    Silent {
        /// How long it waited, seconds.
        seconds: u64,
        /// The most informative line of OpenOCD's output.
        said: String,
    },
    /// cargo is not installed.
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
    /// The firmware's source is not at the path where this workbench was built.
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
    /// A file could not be read or written, or a program could not be run.
    #[error("{what}: {source}")]
    Io {
        /// What was tried, on which file.
        what: String,
        /// Why it failed.
        source: io::Error,
    },
    /// The image is not an ELF file as the build produces it.
    #[error("{path}: {why}")]
    Image {
        /// The image.
        path: String,
        /// What is wrong with it.
        #[source]
        why: object::Error,
    },
    /// The image does not define which RAM a reset leaves unchanged.
    #[error("{path}: it has no symbol _retained_start")]
    NoRetained {
        /// The image.
        path: String,
    },
    /// The model cannot be flown.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The host's mission refuses the model, or its launch detector its limits.
    #[error(transparent)]
    Mission(#[from] ReplayError),
    /// A gap of more than an hour, or a time near the end of the clock.
    #[error(
        "the flight has a gap of {gap_s:.0} s after {after_s:.3} s: it cannot be flown tick by tick on chips, only with ideal \
         sensors"
    )]
    Gap {
        /// Length of the gap, seconds.
        gap_s: f64,
        /// The last time before it, seconds.
        after_s: f64,
    },
    /// More rows than a flight record can count.
    #[error("the flight has more than 2^32 rows: a flight record cannot hold it")]
    TooManyRows,
    /// A tick that does not fit into a frame.
    #[error("a tick is too long for a frame of the flight record")]
    TickTooLong,
    /// Faults of chips were planned for a flight without chips.
    #[error("ideal sensors have no chips that could fail")]
    IdealSensors,
    /// Telemetry was requested from a board that sends none.
    #[error("a board on its debug link sends no telemetry to record")]
    NoTelemetry,
    /// The name of a flight record's file is not UTF-8.
    #[error("a file name of the flight record is not UTF-8")]
    FileName(#[source] Utf8Error),
    /// The barometer's noise, as estimated from the flight, is not finite.
    #[error("the barometer's noise: {0}")]
    BarometerNoise(#[source] NormalError),
    /// The planned faults are not valid.
    #[error(transparent)]
    Fault(#[from] FaultError),
    /// The flight did not end at the end of the record.
    #[error("the flight computer stopped: {}{}", ended(*.status), last_line(.log))]
    Stopped {
        /// Its status, if it is one of the firmware's.
        status: Option<ExitStatus>,
        /// What it logged, or QEMU's own output.
        log: Vec<String>,
    },
    /// The emulation did not end.
    #[error("the emulated flight computer did not finish within {seconds} s")]
    Timeout {
        /// How long it waited, seconds.
        seconds: u64,
    },
    /// The firmware's output is not a stream of results.
    #[error("the results of the flight computer are damaged: {0}")]
    Results(#[from] ResultsError),
    /// The firmware did not receive or did not fly the whole record.
    #[error("the flight computer did not fly the whole record: {0}")]
    Incomplete(Shortfall),
    /// Host and target computed different bits.
    #[error("target and host differ: {0}")]
    Differs(Box<Difference>),
}

/// Why the firmware's output is not a stream of results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ResultsError {
    /// It ends in the middle of a frame.
    #[error("the last one is cut")]
    Cut,
    /// Some bytes are not a frame.
    #[error("{}", frame_words(.0))]
    Frame(FrameError),
    /// Frames are missing.
    #[error("{0} are missing")]
    Missing(u32),
    /// A frame's payload does not match its kind.
    #[error("a result does not decode")]
    Payload(PayloadError),
    /// Another version of the firmware wrote them.
    #[error("they are of another version of the format")]
    Version,
    /// There is no header before them.
    #[error("they do not start with a header")]
    NoHeader,
    /// A frame of a kind that results do not contain.
    #[error("a frame is out of place")]
    Misplaced(Kind),
    /// More ticks than inputs.
    #[error("there are more results than inputs")]
    MoreThanInputs,
    /// The summary at the end is missing.
    #[error("they have no summary")]
    NoSummary,
}

fn frame_words(error: &FrameError) -> String {
    match error {
        FrameError::TooLong => "a frame is too long".to_owned(),
        FrameError::TooShort => "a frame is too short".to_owned(),
        FrameError::Stuffing => "a frame's byte stuffing is broken".to_owned(),
        FrameError::Check => "a frame's checksum is wrong".to_owned(),
        FrameError::Kind(kind) => format!("a frame is of the unknown kind {kind}"),
        FrameError::Repeated => "a frame appears twice".to_owned(),
    }
}

/// Which part of a record the firmware did not fly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Shortfall {
    /// Events that must not occur.
    Counted {
        /// Their name, in the plural.
        what: &'static str,
        /// How often.
        count: u32,
    },
    /// The target's sensors failed differently from the host's.
    SensorFaults {
        /// Polls that failed on the target.
        target: u32,
        /// And on the host.
        host: u32,
    },
    /// The numbers of inputs, ticks and results differ.
    Ticks {
        /// Ticks of the record.
        inputs: u32,
        /// Ticks that the target reports it has flown.
        ticks: u32,
        /// Results received.
        results: u64,
    },
}

impl fmt::Display for Shortfall {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Counted { what, count } => write!(formatter, "{what}: {count}"),
            Self::SensorFaults { target, host } => {
                write!(formatter, "{target} polls of sensors failed on the target, {host} on the host")
            }
            Self::Ticks { inputs, ticks, results } => {
                write!(formatter, "{inputs} inputs, {ticks} ticks flown, {results} results")
            }
        }
    }
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
