//! A flight ([`flight_data`]) and its files.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

pub use flight_data::{
    AltitudeDatum, Channel, Column, CsvProblem, Flight, FlightError, Header, MAX_TIME_S, Note, to_writer,
    unit_slip,
};

use crate::import::{ImportError, OpenError};
use crate::output_file::{OutputError, write_atomically};
use crate::threads::Threads;
use crate::whole_file;

pub use crate::import::open;

/// A flight that could not be read; displays as one line.
#[derive(Debug, Error)]
#[error("{}: {problem}", file.display())]
pub struct ReadError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong with it.
    pub problem: Problem,
}

impl ReadError {
    /// The problem, in that file.
    #[must_use]
    pub fn new(file: &Path, problem: Problem) -> Self {
        Self { file: file.to_path_buf(), problem }
    }
}

/// What is wrong with a file that should hold a flight.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Problem {
    /// The file could not be opened or read.
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// It is no flight CSV, or one with an error in it.
    #[error(transparent)]
    Csv(#[from] CsvProblem),
    /// A log of another format that could not be imported.
    #[error(transparent)]
    Import(#[from] ImportError),
}

impl From<OpenError> for Problem {
    fn from(error: OpenError) -> Self {
        match error {
            OpenError::Csv(problem) => Self::Csv(problem),
            OpenError::Import(problem) => Self::Import(problem),
        }
    }
}

/// Reads a flight from a CSV file, with notes on anything unusual but readable.
///
/// # Errors
/// The first deviation from the format of [`flight_data`], with file, row and column.
pub fn read(path: &Path) -> Result<(Flight, Vec<Note>), ReadError> {
    let text = whole_file::read(path).map_err(|error| ReadError::new(path, error.into()))?;
    parse(&text).map_err(|problem| ReadError::new(path, problem.into()))
}

/// Reads a flight from the text of a CSV file, in as many threads as there are cores.
///
/// # Errors
/// As [`flight_data::parse`].
pub fn parse(text: &[u8]) -> Result<(Flight, Vec<Note>), CsvProblem> {
    flight_data::parse_with(text, &Threads)
}

/// Writes a flight to a CSV file, completely or not at all.
///
/// # Errors
/// [`OutputError`], also for a flight that no CSV file can hold ([`FlightError`] inside).
pub fn write(path: &Path, flight: &Flight) -> Result<(), OutputError> {
    write_atomically(path, |out| to_writer(out, flight))
}
