//! Logs of other programs as flights.
//!
//! What a log is, is told by its content, never by its name. An importer turns what it finds into
//! [`crate::flight`]'s units and axes and says in [`Note`]s what it inferred, left out or could not read.

mod airspeed;
pub mod altus;
pub mod barometer;
pub mod clock_offset;
mod damage;
pub mod dataflash;
mod error;
mod fixes;
mod gps_time;
pub mod guess;
pub mod igc;
pub mod mapping;
pub mod mcap;
pub mod record;
pub mod signs;
mod stamps;
mod table;
#[cfg(test)]
mod testing;
pub mod tlog;
pub mod ulog;
mod words;

use std::io;
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

/// Every importer. Those whose beginning is the surest are asked first. The record is asked before the tlog: its frames
/// have a check of 32 bits, and a MAVLink frame, whose check has 16, may be found in any long file.
pub static IMPORTERS: &[&dyn Importer] = &[
    &ulog::Ulog,
    &mcap::Mcap,
    &altus::Altus,
    &dataflash::DataFlash,
    &dataflash::DataFlashText,
    &igc::Igc,
    &record::Record,
    &tlog::Tlog,
];

/// Imports a log.
///
/// # Errors
/// [`Problem::Io`], [`Problem::Import`].
pub fn import_file(path: &Path) -> Result<(Flight, Vec<Note>), ReadError> {
    import_file_turned(path, &[])
}

/// Imports a log and turns the signs of columns, by their names.
///
/// # Errors
/// As [`import_file`]; [`ImportError::NothingToTurn`] for a column that the flight does not have.
pub fn import_file_turned(path: &Path, turned: &[String]) -> Result<(Flight, Vec<Note>), ReadError> {
    let log = read(path)?;
    if is_flight(&log) {
        return Err(ReadError::new(path, ImportError::AlreadyFlight.into()));
    }
    import_turned(&log, turned).map_err(|error| {
        let error = if error == ImportError::UnknownFormat && mapping::Layout::find(&log).is_some() {
            ImportError::Table { file: path.display().to_string() }
        } else {
            error
        };
        ReadError::new(path, error.into())
    })
}

/// Imports a log from its bytes.
///
/// # Errors
/// [`ImportError`].
pub fn import(log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError> {
    import_turned(log, &[])
}

fn import_turned(log: &[u8], turned: &[String]) -> Result<(Flight, Vec<Note>), ImportError> {
    let (mut flight, mut notes) = as_logged(log)?;
    turn_and_check(&mut flight, &mut notes, turned)?;
    Ok((flight, notes))
}

/// Turns the signs of columns, and says what contradicts what.
fn turn_and_check(flight: &mut Flight, notes: &mut Vec<Note>, turned: &[String]) -> Result<(), ImportError> {
    for name in turned {
        if !signs::turn(flight, name) {
            return Err(ImportError::NothingToTurn { name: name.clone() });
        }
    }
    notes.extend(signs::notes(flight));
    notes.extend(barometer::note(flight));
    Ok(())
}

fn as_logged(log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError> {
    if log.is_empty() {
        return Err(ImportError::Empty);
    }
    match IMPORTERS.iter().find(|importer| importer.recognises(log)) {
        Some(importer) => importer.import(log),
        None if is_utf16(log) => Err(ImportError::Utf16),
        None => Err(archive(log).map_or(ImportError::UnknownFormat, |kind| ImportError::Packed { kind })),
    }
}

/// What kind of archive this is, by its first bytes.
fn archive(log: &[u8]) -> Option<&'static str> {
    const KINDS: [(&[u8], &str); 4] = [
        (b"PK\x03\x04", "ZIP archive"),
        (b"\x1f\x8b", "gzip archive"),
        (b"7z\xbc\xaf\x27\x1c", "7-Zip archive"),
        (b"BZh", "bzip2 archive"),
    ];
    KINDS.iter().find(|(magic, _)| log.starts_with(magic)).map(|(_, kind)| *kind)
}

/// Text of two bytes a letter, as some programs of Windows save it: by its mark, or by zeros in every other place.
fn is_utf16(log: &[u8]) -> bool {
    let head = log.get(..64).unwrap_or(log);
    let (even, odd): (Vec<_>, Vec<_>) = head.iter().enumerate().partition(|(place, _)| place % 2 == 0);
    let all = |bytes: &[(usize, &u8)], is: fn(u8) -> bool| bytes.iter().all(|(_, byte)| is(**byte));
    let is_letter = |byte: u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    let is_zero = |byte: u8| byte == 0;
    head.starts_with(b"\xff\xfe")
        || head.starts_with(b"\xfe\xff")
        || (head.len() >= 8
            && ((all(&even, is_letter) && all(&odd, is_zero))
                || (all(&even, is_zero) && all(&odd, is_letter))))
}

/// Reads a flight: its CSV, or any log that can be imported.
///
/// # Errors
/// As [`flight::read`] for a CSV, as [`import_file`] for a log; [`Problem::NoVersion`] for a file that is
/// neither.
pub fn open(path: &Path) -> Result<(Flight, Vec<Note>), ReadError> {
    let bytes = read(path)?;
    let is_csv = is_flight(&bytes);
    let is_log = !is_csv && IMPORTERS.iter().any(|importer| importer.recognises(&bytes));
    if let Some(kind) = archive(&bytes).filter(|_| !is_csv && !is_log) {
        return Err(ReadError::new(path, ImportError::Packed { kind }.into()));
    }
    let result = match is_log {
        true => import(&bytes).map_err(Problem::from),
        false if !is_csv && !has_flights_names(&bytes) && mapping::Layout::find(&bytes).is_some() => {
            Err(ImportError::Table { file: path.display().to_string() }.into())
        }
        false => flight::parse(&bytes),
    };
    result.map_err(|problem| ReadError::new(path, problem))
}

/// What kind of file one is that [`open`] reads, in the words of who has it.
///
/// # Errors
/// [`Problem::Io`].
pub fn format_name(path: &Path) -> Result<&'static str, ReadError> {
    let bytes = read(path)?;
    let importer = IMPORTERS.iter().find(|importer| importer.recognises(&bytes));
    Ok(match importer {
        Some(importer) if !is_flight(&bytes) => importer.name(),
        _ => "Pylon's own CSV",
    })
}

/// Whether a file is one that [`open`] knows how to read: a flight's CSV or a log, by what is in it.
///
/// # Errors
/// [`Problem::Io`].
pub fn is_known(path: &Path) -> Result<bool, ReadError> {
    let bytes = read(path)?;
    Ok(is_flight(&bytes) || IMPORTERS.iter().any(|importer| importer.recognises(&bytes)))
}

fn read(path: &Path) -> Result<Vec<u8>, ReadError> {
    whole_file::read(path).map_err(|error| {
        let why = match error.kind() {
            io::ErrorKind::IsADirectory => {
                "it is a folder, expected one file (diagnose, report, ladder and add take folders)".to_owned()
            }
            io::ErrorKind::NotFound => "there is no such file".to_owned(),
            _ => error.to_string(),
        };
        ReadError::new(path, Problem::Io(why))
    })
}

/// Whether the beginning has the names that every flight has: what is missing then is the flight's own first line.
fn has_flights_names(bytes: &[u8]) -> bool {
    let head = bytes.get(..4_096).unwrap_or(bytes);
    [&b"time_s"[..], b"gps_alt_m"].iter().all(|name| memchr::memmem::find(head, name).is_some())
}

/// A flight's CSV begins with header lines, one of which says so.
fn is_flight(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let mut header = bytes.split(|byte| matches!(byte, b'\n' | b'\r')).map(<[u8]>::trim_ascii);
    header.by_ref().take_while(|line| line.is_empty() || line.starts_with(b"#")).any(|line| {
        line.trim_ascii_start().get(1..).is_some_and(|key| key.trim_ascii().starts_with(b"pylon-flight"))
    })
}
