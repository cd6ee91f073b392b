//! Why a log could not be imported.

use thiserror::Error;

use super::IMPORTERS;

/// Why a log could not be imported; displays as one line, without the file's name.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ImportError {
    /// No importer knows the format.
    #[error("not a log of a known format, expected one of: {}", known())]
    UnknownFormat,
    /// It is a flight's CSV.
    #[error("it is a flight already, expected a log of another program")]
    AlreadyFlight,
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

fn known() -> String {
    IMPORTERS.iter().map(|importer| importer.name()).collect::<Vec<_>>().join(", ")
}
