//! Any table of numbers as a flight, by a mapping file that says which column is what.
//!
//! The format is in docs/workbench.md. A value is the cell times `scale` plus `offset`, in `unit`; `held` columns repeat a sample in
//! every row until the next one.

mod apply;
pub(super) mod cell;
mod document;
pub mod table;

#[cfg(feature = "parquet")]
use super::parquet;
pub use super::quantity;
use flight_data::{Flight, Note};

pub(super) use apply::{EPOCH_S, changes, middle, past_midnight};
pub use document::Mapping;
pub use table::{Cells, Layout, LoggedTable, MOST_COLUMNS};

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
    if table.layout.is_none() && mapping.says_layout() {
        return Err(Fault::Mapping(
            "[file] says how a text is laid out, expected no [file]: the log is Parquet, which says it itself".to_owned(),
        ));
    }
    apply::apply(&table, mapping, name)
}

/// Whether a log is a table that a mapping can be drafted for.
#[must_use]
pub fn is_table(log: &[u8]) -> bool {
    #[cfg(feature = "parquet")]
    if parquet::is_parquet(log) {
        return true;
    }
    Layout::find(log).is_some()
}

/// The table in a log; of a text with the layout that is made of the one found.
///
/// # Errors
/// [`Fault::Log`] for what is neither Parquet nor text; whatever `layout` refuses.
pub fn table(
    log: &[u8],
    layout: impl Fn(Option<Layout>) -> Result<Layout, Fault>,
) -> Result<LoggedTable, Fault> {
    if log.is_empty() {
        return Err(Fault::Log("an empty file: nothing was recorded".to_owned()));
    }
    #[cfg(feature = "parquet")]
    if parquet::is_parquet(log) {
        return parquet::table(log).map_err(|error| Fault::Log(error.to_string()));
    }
    if super::is_utf16(log) {
        return Err(Fault::Log(super::ImportError::Utf16.to_string()));
    }
    if log.get(..4_096).unwrap_or(log).contains(&0) {
        return Err(Fault::Log(
            "it is not text, expected a table of numbers as text (CSV) or Parquet; a log of a known program needs no mapping".to_owned(),
        ));
    }
    Ok(LoggedTable::read(log, layout(Layout::find(log))?))
}
