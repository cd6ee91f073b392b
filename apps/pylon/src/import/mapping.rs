//! Tables of numbers by a mapping ([`formats::import::mapping`]), from files.

use std::fs;
use std::path::{Path, PathBuf};

use thiserror::Error;

pub use formats::import::mapping::{Fault, Layout, LoggedTable, Mapping, import, is_table, quantity, table};

use super::Corrections;
use crate::flight::{Flight, Note};

/// Why a log could not be read by a mapping, or no mapping be drafted; displays as one line.
#[derive(Debug, Error)]
#[error("{}: {what}", file.display())]
pub struct MappingError {
    /// The log or the mapping.
    pub file: PathBuf,
    /// What is wrong with it.
    pub what: String,
}

/// Imports a table by a mapping file.
///
/// # Errors
/// [`MappingError`], which names the file that is wrong.
pub fn import_file(
    log: &Path,
    mapping: &Path,
    corrections: &Corrections,
) -> Result<(Flight, Vec<Note>), MappingError> {
    let in_log = |what: String| MappingError { file: log.to_path_buf(), what };
    let in_mapping = |what: String| MappingError { file: mapping.to_path_buf(), what };
    let text =
        fs::read_to_string(mapping).map_err(|error| in_mapping(format!("can not be read: {error}")))?;
    let parsed = Mapping::parse(&text).map_err(in_mapping)?;
    let bytes = super::read(log).map_err(|error| in_log(error.problem.to_string()))?;
    let name = mapping.file_name().unwrap_or_default().to_string_lossy().replace(char::is_control, " ");
    let (mut flight, mut notes) = import(&bytes, &parsed, &name).map_err(|fault| match fault {
        Fault::Log(what) => in_log(what),
        Fault::Mapping(what) => in_mapping(what),
    })?;
    formats::import::correct_and_check(&mut flight, &mut notes, corrections)
        .map_err(|error| in_log(error.to_string()))?;
    Ok((flight, notes))
}
