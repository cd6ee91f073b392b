//! Imports tables of numbers by a mapping ([`formats::import::mapping`]), from files.

use std::fs;
use std::path::{Path, PathBuf};

use thiserror::Error;

pub use formats::import::mapping::{
    Fault, Layout, LoggedTable, Mapping, MappingError, TableError, import, is_table, quantity, table,
};

use super::{Corrections, ImportError};
use crate::flight::{Flight, Note, Problem, ReadError};

/// Why a log could not be read by a mapping, or a mapping not be drafted; displays as one line.
#[derive(Debug, Error)]
pub enum MappedError {
    /// The log cannot be read, or a velocity in it cannot be inverted.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The log is not a usable table.
    #[error("{}: {problem}", file.display())]
    Log {
        /// The log.
        file: PathBuf,
        /// What is wrong with it.
        #[source]
        problem: TableError,
    },
    /// The mapping is wrong, in itself or for this log.
    #[error("{}: {problem}", file.display())]
    Mapping {
        /// The mapping.
        file: PathBuf,
        /// What is wrong with it.
        #[source]
        problem: MappingError,
    },
}

/// Imports a table by a mapping file.
///
/// # Errors
/// [`MappedError`], which names the faulty file.
pub fn import_file(
    log: &Path,
    mapping: &Path,
    corrections: &Corrections,
) -> Result<(Flight, Vec<Note>), MappedError> {
    let in_mapping = |problem| MappedError::Mapping { file: mapping.to_path_buf(), problem };
    let text = fs::read_to_string(mapping).map_err(|error| ReadError::new(mapping, Problem::Io(error)))?;
    let parsed = Mapping::parse(&text).map_err(in_mapping)?;
    let bytes = super::read(log)?;
    let name = mapping.file_name().unwrap_or_default().to_string_lossy().replace(char::is_control, " ");
    let (mut flight, mut notes) = import(&bytes, &parsed, &name).map_err(|fault| match fault {
        Fault::Log(problem) => MappedError::Log { file: log.to_path_buf(), problem },
        Fault::Mapping(problem) => in_mapping(problem),
    })?;
    formats::import::correct_and_check(&mut flight, &mut notes, corrections)
        .map_err(|error: ImportError| ReadError::new(log, error.into()))?;
    Ok((flight, notes))
}
