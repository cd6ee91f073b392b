//! Imports logs of other programs as flights.
//!
//! Formats are detected from content, never from the name. An importer converts what it finds to
//! [`flight_data`]'s units and axes, and reports in [`Note`]s what it inferred, left out or could not read.

mod airspeed;
#[cfg(feature = "altus")]
pub mod altus;
pub use replay::barometer;
pub mod clock_offset;
mod damage;
#[cfg(feature = "dataflash")]
pub mod dataflash;
mod error;
mod fixes;
mod foreign;
mod gaps;
mod gps_time;
#[cfg(feature = "table")]
pub mod guess;
#[cfg(feature = "igc")]
pub mod igc;
mod leap;
#[cfg(feature = "table")]
pub mod mapping;
#[cfg(feature = "mcap")]
pub mod mcap;
mod own_header;
#[cfg(feature = "parquet")]
pub mod parquet;
pub mod quantity;
mod receivers;
#[cfg(feature = "record")]
pub mod record;
pub mod signs;
mod stamps;
mod table;
#[cfg(test)]
mod testing;
#[cfg(feature = "tlog")]
pub mod tlog;
pub mod to_msl;
#[cfg(feature = "ulog")]
pub mod ulog;
mod unit_check;
mod velocity;
mod words;

use executor::Executor;
use flight_data::{CsvProblem, Flight, Note};
use replay::steps;

pub use error::{ImportError, OpenError};

/// One kind of log.
pub trait Importer: Sync {
    /// The kind's name for the user.
    fn name(&self) -> &'static str;

    /// Whether these bytes look like the beginning of such a log. The check is cheap, and never accepts a
    /// flight's CSV.
    fn recognises(&self, log: &[u8]) -> bool;

    /// The flight in the log.
    ///
    /// # Errors
    /// [`ImportError`] if nothing useful is left after everything unreadable.
    fn import(&self, log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError>;
}

/// Every importer. The ones with the most reliable detection come first. The record comes before the tlog:
/// its frames have a checksum of 32 bits, while a MAVLink frame, whose checksum has 16, may be found in any
/// long file.
pub static IMPORTERS: &[&dyn Importer] = &[
    #[cfg(feature = "ulog")]
    &ulog::Ulog,
    #[cfg(feature = "mcap")]
    &mcap::Mcap,
    #[cfg(feature = "parquet")]
    &parquet::Parquet,
    #[cfg(feature = "altus")]
    &altus::Altus,
    #[cfg(feature = "dataflash")]
    &dataflash::DataFlash,
    #[cfg(feature = "dataflash")]
    &dataflash::DataFlashText,
    #[cfg(feature = "igc")]
    &igc::Igc,
    #[cfg(feature = "record")]
    &record::Record,
    #[cfg(feature = "tlog")]
    &tlog::Tlog,
];

/// Imports a log from its bytes.
///
/// # Errors
/// [`ImportError`].
pub fn import(log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError> {
    let (mut flight, mut notes) = as_logged(log)?;
    correct_and_check(&mut flight, &mut notes, &Corrections::default())?;
    Ok((flight, notes))
}

/// A user's corrections of a log, by column name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Corrections {
    /// Velocities whose sign is reversed.
    pub turned: Vec<String>,
    /// Altitudes above the ellipsoid that are converted to mean sea level.
    pub to_msl: Vec<to_msl::ToMsl>,
}

impl Corrections {
    /// Whether there are no corrections.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.turned.is_empty() && self.to_msl.is_empty()
    }
}

/// Corrects columns, by their names, and reports contradictions between columns.
///
/// # Errors
/// [`ImportError::NothingToTurn`] for a column that the flight does not have; else as [`to_msl::to_msl`].
pub fn correct_and_check(
    flight: &mut Flight,
    notes: &mut Vec<Note>,
    corrections: &Corrections,
) -> Result<(), ImportError> {
    corrections.to_msl.iter().try_for_each(|conversion| to_msl::to_msl(flight, conversion))?;
    for name in &corrections.turned {
        if !signs::turn(flight, name) {
            return Err(ImportError::NothingToTurn { name: name.clone() });
        }
    }
    notes.extend(gaps::note(flight));
    notes.extend(signs::notes(flight));
    notes.extend(unit_check::notes(flight));
    notes.extend(barometer::notes(flight));
    notes.extend(steps::notes(flight));
    Ok(())
}

/// Imports a log without the steps of [`correct_and_check`]: these checks need memory of their own, but not
/// the log.
///
/// # Errors
/// As [`import`].
pub fn as_logged(log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError> {
    if log.is_empty() {
        return Err(ImportError::Empty);
    }
    match IMPORTERS.iter().find(|importer| importer.recognises(log)) {
        Some(importer) => importer.import(log),
        #[cfg(feature = "parquet")]
        None if parquet::is_cut(log) => Err(ImportError::Parquet(parquet::ParquetError::Cut)),
        None if is_matlab(log) => Err(ImportError::Matlab),
        None if is_utf16(log) => Err(ImportError::Utf16),
        None => {
            let packed = || archive(log).map(|kind| ImportError::Packed { kind });
            let known = foreign::without_receiver(log).map(|what| ImportError::WithoutReceiver { what });
            Err(known.or_else(packed).unwrap_or(ImportError::UnknownFormat))
        }
    }
}

/// The kind of archive, by its first bytes.
fn archive(log: &[u8]) -> Option<&'static str> {
    const KINDS: [(&[u8], &str); 4] = [
        (b"PK\x03\x04", "ZIP archive"),
        (b"\x1f\x8b", "gzip archive"),
        (b"7z\xbc\xaf\x27\x1c", "7-Zip archive"),
        (b"BZh", "bzip2 archive"),
    ];
    KINDS.iter().find(|(magic, _)| log.starts_with(magic)).map(|(_, kind)| *kind)
}

/// A MAT-file of MATLAB 5 to 7, or of 7.3 ("MAT-File Format", MathWorks, chapter 1: the header's text).
fn is_matlab(log: &[u8]) -> bool {
    [&b"MATLAB 5.0 MAT-file"[..], b"MATLAB 7.3 MAT-file"].iter().any(|text| log.starts_with(text))
}

/// Text with two bytes a character, as some Windows programs save it: detected by its mark, or by zeros in
/// every other byte.
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

/// Reads a flight from the bytes of its CSV, or of any log that can be imported. A long CSV is read in as
/// many parts as the executor can do at a time. `name` is the file's, for advice in messages.
///
/// # Errors
/// As [`flight_data::parse`] for a CSV, as [`import`] for a log; [`flight_data::CsvProblem::NoVersion`] for
/// anything else.
pub fn open(bytes: &[u8], name: &str, executor: &dyn Executor) -> Result<(Flight, Vec<Note>), OpenError> {
    let is_csv = is_flight(bytes);
    if !is_csv && is_log(bytes) {
        return Ok(import(bytes)?);
    }
    if let Some(kind) = archive(bytes).filter(|_| !is_csv) {
        return Err(ImportError::Packed { kind }.into());
    }
    if is_matlab(bytes) {
        return Err(ImportError::Matlab.into());
    }
    if !is_csv && is_utf16(bytes) {
        return Err(ImportError::Utf16.into());
    }
    #[cfg(feature = "parquet")]
    if parquet::is_cut(bytes) {
        return Err(ImportError::Parquet(parquet::ParquetError::Cut).into());
    }
    if let Some(what) = foreign::without_receiver(bytes).filter(|_| !is_csv) {
        return Err(ImportError::WithoutReceiver { what }.into());
    }
    #[cfg(feature = "table")]
    if !is_csv && !has_flights_names(bytes) && mapping::is_table(bytes) {
        return Err(ImportError::Table { file: name.to_owned() }.into());
    }
    if !is_csv && !bytes.is_empty() && !is_text(bytes) {
        return Err(ImportError::UnknownFormat.into());
    }
    let (flight, mut notes) = open_csv(bytes, executor)?;
    notes.extend(gaps::note(&flight));
    notes.extend(unit_check::notes(&flight));
    notes.extend(barometer::notes(&flight));
    notes.extend(steps::notes(&flight));
    notes.extend(receivers::notes(&flight));
    Ok((flight, notes))
}

fn open_csv(bytes: &[u8], executor: &dyn Executor) -> Result<(Flight, Vec<Note>), CsvProblem> {
    let (mut flight, mut notes) = flight_data::parse_with(bytes, executor)?;
    notes.extend(leap::leave_out(&mut flight));
    notes.extend(leap::backward(&flight));
    Ok((flight, notes))
}

/// Reads a flight's CSV and corrects it.
///
/// # Errors
/// As [`flight_data::parse`] and [`correct_and_check`].
pub fn corrected(
    csv: &[u8],
    corrections: &Corrections,
    executor: &dyn Executor,
) -> Result<(Flight, Vec<Note>), OpenError> {
    let (mut flight, mut notes) = open_csv(csv, executor)?;
    correct_and_check(&mut flight, &mut notes, corrections)?;
    Ok((flight, notes))
}

/// Kind of log or flight, among those that [`open`] reads, as named for the user.
#[must_use]
pub fn format_name(bytes: &[u8]) -> &'static str {
    match IMPORTERS.iter().find(|importer| importer.recognises(bytes)) {
        Some(importer) if !is_flight(bytes) => importer.name(),
        _ => "Pylon's own CSV",
    }
}

/// Whether [`open`] can read this: a flight's CSV or a log, detected from its content.
#[must_use]
pub fn is_known(bytes: &[u8]) -> bool {
    is_flight(bytes) || is_log(bytes)
}

fn is_log(bytes: &[u8]) -> bool {
    IMPORTERS.iter().any(|importer| importer.recognises(bytes))
}

/// Whether the beginning may be text: without a zero byte, and nearly all of it UTF-8.
fn is_text(bytes: &[u8]) -> bool {
    let head = bytes.get(..4_096).unwrap_or(bytes);
    let lost =
        String::from_utf8_lossy(head).chars().filter(|letter| *letter == char::REPLACEMENT_CHARACTER).count();
    !head.contains(&0) && lost * 20 <= head.len()
}

/// Whether the beginning has the names that every flight has: then only the flight's own first line is
/// missing.
fn has_flights_names(bytes: &[u8]) -> bool {
    let head = bytes.get(..4_096).unwrap_or(bytes);
    [&b"time_s"[..], b"gps_alt_m"].iter().all(|name| memchr::memmem::find(head, name).is_some())
}

/// Whether this is a flight's CSV: it begins with header lines, one of which marks it as a flight.
#[must_use]
pub fn is_flight(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let mut header = bytes.split(|byte| matches!(byte, b'\n' | b'\r')).map(<[u8]>::trim_ascii);
    header.by_ref().take_while(|line| line.is_empty() || line.starts_with(b"#")).any(|line| {
        line.trim_ascii_start().get(1..).is_some_and(|key| key.trim_ascii().starts_with(b"pylon-flight"))
    })
}
