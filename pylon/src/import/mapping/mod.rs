//! Any table of numbers as a flight, by a mapping file that says which column is what.
//!
//! The format is in docs/workbench.md. A value is the cell times `scale` plus `offset`, in `unit`; `held` columns repeat a sample in
//! every row until the next one.

mod apply;
mod cell;
mod document;
mod error;
pub mod quantity;
pub mod table;

use std::fs;
use std::path::Path;

use crate::flight::{Flight, Note};

pub(super) use apply::{EPOCH_S, changes, middle, past_midnight};
pub use document::Mapping;
pub use error::MappingError;
pub use table::{Layout, TextTable};

/// Imports a table by a mapping file.
///
/// # Errors
/// [`MappingError`], which names the file that is wrong.
pub fn import_file(
    log: &Path,
    mapping: &Path,
    turned: &[String],
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
    super::turn_and_check(&mut flight, &mut notes, turned).map_err(|error| in_log(error.to_string()))?;
    Ok((flight, notes))
}

/// What is wrong, and where.
#[derive(Debug)]
pub enum Fault {
    /// With the log.
    Log(String),
    /// With the mapping.
    Mapping(String),
}

/// Imports a table from its bytes by a mapping of that name.
///
/// # Errors
/// [`Fault`].
pub fn import(log: &[u8], mapping: &Mapping, name: &str) -> Result<(Flight, Vec<Note>), Fault> {
    let table = table(log, |found| mapping.layout(found).map_err(Fault::Mapping))?;
    apply::apply(&table, mapping, name)
}

/// The table in a log, with the layout that is made of the one found.
///
/// # Errors
/// [`Fault::Log`] for what is no text; whatever `layout` refuses.
pub fn table(
    log: &[u8],
    layout: impl Fn(Option<Layout>) -> Result<Layout, Fault>,
) -> Result<TextTable, Fault> {
    if log.is_empty() {
        return Err(Fault::Log("an empty file: nothing was recorded".to_owned()));
    }
    if super::is_utf16(log) {
        return Err(Fault::Log(super::ImportError::Utf16.to_string()));
    }
    if log.get(..4_096).unwrap_or(log).contains(&0) {
        return Err(Fault::Log(
            "it is not text, expected a table of numbers as text (CSV); a log of a known program needs no mapping".to_owned(),
        ));
    }
    Ok(TextTable::read(log, layout(Layout::find(log))?))
}
