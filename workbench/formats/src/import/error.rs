//! Why a log could not be imported.

use flight_data::CsvProblem;
use thiserror::Error;

use super::IMPORTERS;

/// Why a log could not be imported; displays as one line, without the file's name.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ImportError {
    /// No importer knows the format.
    #[error("not a log of a known format, expected one of: {}", known())]
    UnknownFormat,
    /// It is a flight's CSV.
    #[error("it is a flight already, expected a log of another program")]
    AlreadyFlight,
    /// A table of numbers that no importer knows.
    #[error(
        "a table of numbers of no known format: 'pylon import {file} --guess -o mapping.toml' drafts what its columns may be, \
         and 'pylon import {file} --mapping mapping.toml -o flight.csv' reads it by that"
    )]
    Table {
        /// The file.
        file: String,
    },
    /// Parquet that cannot be read.
    #[cfg(feature = "parquet")]
    #[error(transparent)]
    Parquet(#[from] super::parquet::ParquetError),
    /// A log of a known maker in which there is no altitude of a receiver.
    #[error("{what}; there is nothing to compare its barometer with")]
    WithoutReceiver {
        /// What it is, and what to do.
        what: &'static str,
    },
    /// MCAP of another program.
    #[error(
        "MCAP that pylon did not write, expected one of 'pylon export FLIGHT --format mcap': what another program's topics \
         mean, it does not say"
    )]
    ForeignMcap,
    /// There is nothing in it.
    #[error("an empty file: nothing was recorded")]
    Empty,
    /// A flight record of another version of the format.
    #[error(
        "a flight record of version {found}, and this program reads version {expected}: import it with the pylon of the \
         checkout that the image was built from"
    )]
    RecordVersion {
        /// The record's.
        found: u16,
        /// This program's.
        expected: u16,
    },
    /// A flight record without a tick.
    #[error(
        "flight record without a tick ({frames} frames read, {damaged} damaged stretches, {undecodable} frames that do not \
         decode){}, expected at least one",
        .said.as_deref().map_or_else(String::new, |said| format!("; {said}"))
    )]
    NoTick {
        /// Frames that were read.
        frames: usize,
        /// What is no frame.
        damaged: usize,
        /// Frames whose content is none.
        undecodable: usize,
        /// What the flight computer said of itself, or the reason.
        said: Option<String>,
    },
    /// A flight record without a fix of the reference.
    #[error(
        "flight record of {ticks} ticks without a fix of the receiver, expected at least one: was it connected?"
    )]
    NoFixInRecord {
        /// Ticks.
        ticks: usize,
    },
    /// Not one position with an altitude in a recording of messages.
    #[error(
        "{format} without a 3D fix ({messages} messages read, {unreadable} damaged), expected GPS_RAW_INT or \
         GLOBAL_POSITION_INT"
    )]
    NoReference {
        /// Kind of log.
        format: &'static str,
        /// Messages that were read.
        messages: usize,
        /// Frames that could not be.
        unreadable: usize,
    },
    /// Not one fix with an altitude in an autopilot's own log.
    #[error(
        "{format} without a 3D fix of a receiver ({messages} messages read, {fixes_without} of them of a receiver without \
         one), expected {expected}: there is nothing to compare the barometer with{}",
        lost.iter().map(|what| format!("; {what}")).collect::<String>()
    )]
    NoFixInLog {
        /// Kind of log.
        format: &'static str,
        /// Messages that were read.
        messages: usize,
        /// Messages of receivers that had no 3D fix.
        fixes_without: usize,
        /// What would have been one.
        expected: &'static str,
        /// What could not be read, in words: the fixes may have been in it.
        lost: Vec<String>,
    },
    /// A column whose sign is to be turned, and that is not there.
    #[error("no column {name} in this flight, expected one of its velocities to turn")]
    NothingToTurn {
        /// The column.
        name: String,
    },
    /// An altitude to be converted that is not there.
    #[error(
        "no altitude {name} in this flight, expected one of its altitudes (such as gps_alt_m) to convert"
    )]
    NoSuchAltitude {
        /// What was given.
        name: String,
    },
    /// An altitude to be converted that is measured from something else.
    #[error(
        "{name} is measured {is}, expected an altitude above the ellipsoid to convert to one above mean sea level"
    )]
    NotAboveEllipsoid {
        /// The column.
        name: String,
        /// What it is measured from, in words.
        is: &'static str,
    },
    /// Several files in one.
    #[error("a {kind}: unpack it, and give the log that is in it")]
    Packed {
        /// What kind of archive.
        kind: &'static str,
    },
    /// A MATLAB file, which holds whatever its user put into it.
    #[error(
        "a MATLAB file (.mat), which pylon does not read: save its table as CSV (in MATLAB: writetable or writetimetable), and import that with --guess"
    )]
    Matlab,
    /// Text of two bytes a letter.
    #[error("text in UTF-16, expected UTF-8: save it as UTF-8 (iconv -f UTF-16 -t UTF-8) and import that")]
    Utf16,
    /// Not one fix with an altitude.
    #[error(
        "{format} log without a usable fix ({fixes} fixes without altitude, {corrupt} unreadable lines), expected at least one"
    )]
    NoFix {
        /// Kind of log.
        format: &'static str,
        /// Fixes that had no altitude.
        fixes: usize,
        /// Lines that could not be read.
        corrupt: usize,
    },
}

/// Why bytes are no flight; displays as one line, without the file's name.
#[derive(Debug, Error)]
pub enum OpenError {
    /// It is no flight's CSV, or one with an error in it.
    #[error(transparent)]
    Csv(#[from] CsvProblem),
    /// A log of another format that could not be imported.
    #[error(transparent)]
    Import(#[from] ImportError),
}

fn known() -> String {
    IMPORTERS.iter().map(|importer| importer.name()).collect::<Vec<_>>().join(", ")
}
