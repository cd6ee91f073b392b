//! Imports logs of other programs ([`formats::import`]) from files.

pub mod guess;
pub mod mapping;

use std::io;
use std::path::Path;

pub use formats::import::{
    Corrections, IMPORTERS, ImportError, Importer, OpenError, altus, clock_offset, dataflash, igc, import,
    mcap, parquet, record, signs, tlog, to_msl, ulog,
};
pub use replay::barometer;

use crate::flight::{Flight, Note, ReadError};
use crate::threads::Threads;
use crate::whole_file;

/// Imports a log.
///
/// # Errors
/// [`Problem::Io`](crate::flight::Problem::Io), [`Problem::Import`](crate::flight::Problem::Import).
pub fn import_file(path: &Path) -> Result<(Flight, Vec<Note>), ReadError> {
    import_file_corrected(path, &Corrections::default())
}

/// Imports a log and corrects the named columns; with a correction, also accepts a flight CSV.
///
/// # Errors
/// As [`import_file`]; as [`formats::import::correct_and_check`].
pub fn import_file_corrected(
    path: &Path,
    corrections: &Corrections,
) -> Result<(Flight, Vec<Note>), ReadError> {
    let log = read(path)?;
    if formats::import::is_flight(&log) {
        if corrections.is_empty() {
            return Err(ReadError::new(path, ImportError::AlreadyFlight.into()));
        }
        return formats::import::corrected(&log, corrections, &Threads)
            .map_err(|error| ReadError::new(path, error.into()));
    }
    let imported = formats::import::as_logged(&log).map_err(|error| {
        let is_table = matches!(error, ImportError::UnknownFormat) && mapping::is_table(&log);
        if is_table { ImportError::Table { file: path.display().to_string() } } else { error }
    });
    // The checks need memory of their own, and the log's bytes are no longer needed.
    drop(log);
    imported
        .and_then(|(mut flight, mut notes)| {
            formats::import::correct_and_check(&mut flight, &mut notes, corrections)?;
            Ok((flight, notes))
        })
        .map_err(|error| ReadError::new(path, error.into()))
}

/// Reads a flight from its CSV, or from any log that can be imported.
///
/// # Errors
/// [`Problem::Io`](crate::flight::Problem::Io); as [`formats::import::open`].
pub fn open(path: &Path) -> Result<(Flight, Vec<Note>), ReadError> {
    let bytes = read(path)?;
    formats::import::open(&bytes, &path.display().to_string(), &Threads)
        .map_err(|error| ReadError::new(path, error.into()))
}

/// The format of a file that [`open`] reads, in its user's terms.
///
/// # Errors
/// [`Problem::Io`](crate::flight::Problem::Io).
pub fn format_name(path: &Path) -> Result<&'static str, ReadError> {
    Ok(formats::import::format_name(&read(path)?))
}

/// Whether [`open`] can read a file: a flight CSV or a log, detected from its content.
///
/// # Errors
/// [`Problem::Io`](crate::flight::Problem::Io).
pub fn is_known(path: &Path) -> Result<bool, ReadError> {
    Ok(formats::import::is_known(&read(path)?))
}

fn read(path: &Path) -> Result<Vec<u8>, ReadError> {
    whole_file::read(path).map_err(|error| {
        let said = match error.kind() {
            io::ErrorKind::IsADirectory => {
                Some("it is a folder, expected one file (diagnose, report, ladder and add take folders)")
            }
            io::ErrorKind::NotFound => Some("there is no such file or folder"),
            _ => None,
        };
        let error = match said {
            Some(said) => io::Error::new(error.kind(), said),
            None => error,
        };
        ReadError::new(path, error.into())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const CSV: &str = "# pylon-flight: 1\ntime_s,gps_alt_m,baro_alt_m\n0,1,2\n";

    #[test]
    fn a_file_is_what_is_in_it_whatever_its_name() {
        let directory = tempfile::tempdir().unwrap();
        let log = directory.path().join("log.txt");
        std::fs::write(&log, "AXXXABC\nHFDTE010124\nB1000004600000N00700000EA0050000560\n").unwrap();
        assert_eq!(open(&log).unwrap().0.rows(), 1);
        assert_eq!(import_file(&log).unwrap().0.rows(), 1);

        let csv = directory.path().join("flight.igc");
        std::fs::write(&csv, CSV).unwrap();
        assert_eq!(open(&csv).unwrap().0.rows(), 1);
        let error = import_file(&csv).unwrap_err().to_string();
        assert!(error.ends_with("flight.igc: it is a flight already, expected a log of another program"));
        let error = open(&directory.path().join("none")).unwrap_err().to_string();
        assert!(error.contains("cannot be read"), "{error}");
    }
}
