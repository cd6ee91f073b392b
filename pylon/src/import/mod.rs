//! Logs of other programs as flights.
//!
//! What a log is, is told by its content, never by its name. An importer turns what it finds into
//! [`crate::flight`]'s units and axes and says in [`Note`]s what it inferred, left out or could not read.

mod error;
pub mod igc;
pub mod tlog;

use std::path::Path;

use crate::flight::{self, Flight, Note, Problem, ReadError};
use crate::whole_file;

pub use error::ImportError;

/// One kind of log.
pub trait Importer: Sync {
    /// What users call the kind.
    fn name(&self) -> &'static str;

    /// Whether these bytes look like the beginning of such a log. Cheap, and never wrong about a
    /// flight's CSV.
    fn recognises(&self, log: &[u8]) -> bool;

    /// The flight that is in the log.
    ///
    /// # Errors
    /// [`ImportError`] if nothing of use is left after everything unreadable.
    fn import(&self, log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError>;
}

/// Every importer.
pub static IMPORTERS: &[&dyn Importer] = &[&igc::Igc, &tlog::Tlog];

/// Imports a log.
///
/// # Errors
/// [`Problem::Io`], [`Problem::Import`].
pub fn import_file(path: &Path) -> Result<(Flight, Vec<Note>), ReadError> {
    let log = read(path)?;
    if is_flight(&log) {
        return Err(ReadError::new(path, ImportError::AlreadyFlight.into()));
    }
    import(&log).map_err(|error| ReadError::new(path, error.into()))
}

/// Imports a log from its bytes.
///
/// # Errors
/// [`ImportError`].
pub fn import(log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError> {
    IMPORTERS
        .iter()
        .find(|importer| importer.recognises(log))
        .ok_or(ImportError::UnknownFormat)
        .and_then(|importer| importer.import(log))
}

/// Reads a flight: its CSV, or any log that can be imported.
///
/// # Errors
/// As [`flight::read`] for a CSV, as [`import_file`] for a log; [`Problem::NoVersion`] for a file that is
/// neither.
pub fn open(path: &Path) -> Result<(Flight, Vec<Note>), ReadError> {
    let bytes = read(path)?;
    let is_log = !is_flight(&bytes) && IMPORTERS.iter().any(|importer| importer.recognises(&bytes));
    let result = if is_log { import(&bytes).map_err(Problem::from) } else { flight::parse(&bytes) };
    result.map_err(|problem| ReadError::new(path, problem))
}

fn read(path: &Path) -> Result<Vec<u8>, ReadError> {
    whole_file::read(path).map_err(|error| ReadError::new(path, Problem::Io(error.to_string())))
}

/// A flight's CSV begins with header lines; no log does.
fn is_flight(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes.trim_ascii_start().first() == Some(&b'#')
}
