//! Why a log could not be imported.

use flight_data::CsvProblem;
use thiserror::Error;

use super::IMPORTERS;

/// Why a log could not be imported; displays as one line, without the file's name.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ImportError {
    /// No importer recognises the format.
    #[error("not a log of a known format, expected one of: {}", known())]
    UnknownFormat,
    /// It is a flight's CSV.
    #[error("it is a flight already, expected a log of another program")]
    AlreadyFlight,
    /// A table of numbers that no importer recognises.
    #[error(
        "a table of numbers of no known format: 'pylon import {file} --guess -o mapping.toml' drafts a mapping of its columns, \
         and 'pylon import {file} --mapping mapping.toml -o flight.csv' reads it with that mapping"
    )]
    Table {
        /// The file.
        file: String,
    },
    /// Parquet that cannot be read.
    #[cfg(feature = "parquet")]
    #[error(transparent)]
    Parquet(#[from] super::parquet::ParquetError),
    /// A log of a known maker that has no receiver altitude.
    #[error("{what}; there is nothing to compare its barometer with")]
    WithoutReceiver {
        /// What the log is, and what to do.
        what: &'static str,
    },
    /// MCAP of another program.
    #[error(
        "MCAP that pylon did not write, expected one of 'pylon export FLIGHT --format mcap': MCAP does not \
         define the meaning of another program's topics"
    )]
    ForeignMcap,
    /// The file is empty.
    #[error("an empty file: nothing was recorded")]
    Empty,
    /// A flight record of another version of the format.
    #[error(
        "a flight record of version {found}, and this program reads version {expected}: import it with the pylon of the \
         checkout that the image was built from"
    )]
    RecordVersion {
        /// The record's version.
        found: u16,
        /// This program's version.
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
        /// Parts that are not a frame.
        damaged: usize,
        /// Frames whose content is invalid.
        undecodable: usize,
        /// What the flight computer reported, or the reason.
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
    /// A recording of messages without a single position with an altitude.
    #[error(
        "{format} without a 3D fix ({messages} messages read, {unreadable} damaged), expected GPS_RAW_INT or \
         GLOBAL_POSITION_INT"
    )]
    NoReference {
        /// Kind of log.
        format: &'static str,
        /// Messages that were read.
        messages: usize,
        /// Frames that could not be read.
        unreadable: usize,
    },
    /// An autopilot's own log without a single fix with an altitude.
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
        /// Receiver messages without a 3D fix.
        fixes_without: usize,
        /// The message that was expected.
        expected: &'static str,
        /// What could not be read, as text: the fixes may have been in it.
        lost: Vec<String>,
    },
    /// A column whose sign was to be reversed, but which does not exist.
    #[error("no column {name} in this flight, expected one of its velocities to turn")]
    NothingToTurn {
        /// The column.
        name: String,
    },
    /// An altitude that was to be converted, but does not exist.
    #[error(
        "no altitude {name} in this flight, expected one of its altitudes (such as gps_alt_m) to convert"
    )]
    NoSuchAltitude {
        /// The name that was given.
        name: String,
    },
    /// An altitude that was to be converted, but has another datum.
    #[error(
        "{name} is measured {is}, expected an altitude above the ellipsoid to convert to one above mean sea level"
    )]
    NotAboveEllipsoid {
        /// The column.
        name: String,
        /// What it is measured from, as text.
        is: &'static str,
    },
    /// An archive of several files.
    #[error("a {kind}: unpack it and import the log inside")]
    Packed {
        /// Kind of archive.
        kind: &'static str,
    },
    /// A MATLAB file, whose content its user defines.
    #[error(
        "a MATLAB file (.mat), which pylon does not read: save its table as CSV (in MATLAB: writetable or writetimetable), and import that with --guess"
    )]
    Matlab,
    /// Text with two bytes a character.
    #[error("text in UTF-16, expected UTF-8: save it as UTF-8 (iconv -f UTF-16 -t UTF-8) and import that")]
    Utf16,
    /// No fix with an altitude.
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

/// Why bytes are not a flight; displays as one line, without the file's name.
#[derive(Debug, Error)]
pub enum OpenError {
    /// It is not a flight's CSV, or one with an error.
    #[error(transparent)]
    Csv(#[from] CsvProblem),
    /// A log of another format that could not be imported.
    #[error(transparent)]
    Import(#[from] ImportError),
}

fn known() -> String {
    IMPORTERS.iter().map(|importer| importer.name()).collect::<Vec<_>>().join(", ")
}
