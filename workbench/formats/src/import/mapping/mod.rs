//! Reads any table of numbers as a flight, by a mapping file that gives the meaning of the columns.
//!
//! The format is in docs/workbench.md. A value is the cell times `scale` plus `offset`, in `unit`; `held`
//! columns repeat a sample in every row until the next one.

mod apply;
pub(super) mod cell;
mod document;
mod error;
pub mod table;

use super::ImportError;
#[cfg(feature = "parquet")]
use super::parquet;
pub use super::quantity;
use flight_data::{Flight, Note};

pub(super) use apply::{EPOCH_S, changes, middle, past_midnight};
pub use document::Mapping;
pub use error::{ColumnError, Fault, MappingError, SignalError, TableError};
pub use table::{Cells, Layout, LoggedTable, MOST_COLUMNS};

/// Imports a table from its bytes by the mapping named `name`.
///
/// # Errors
/// [`Fault`].
pub fn import(log: &[u8], mapping: &Mapping, name: &str) -> Result<(Flight, Vec<Note>), Fault> {
    let table = table(log, |found| Ok(mapping.layout(found)?))?;
    if table.layout.is_none() && mapping.says_layout() {
        return Err(MappingError::LayoutOfParquet.into());
    }
    apply::apply(&table, mapping, name)
}

/// Whether a log is a table for which a mapping can be drafted.
#[must_use]
pub fn is_table(log: &[u8]) -> bool {
    #[cfg(feature = "parquet")]
    if parquet::is_parquet(log) {
        return true;
    }
    Layout::find(log).is_some()
}

/// The table in a log; text is read with the layout that `layout` makes of the detected one.
///
/// # Errors
/// [`Fault::Log`] for a log that is neither Parquet nor text; errors of `layout`.
pub fn table(
    log: &[u8],
    layout: impl Fn(Option<Layout>) -> Result<Layout, Fault>,
) -> Result<LoggedTable, Fault> {
    if log.is_empty() {
        return Err(TableError::from(ImportError::Empty).into());
    }
    #[cfg(feature = "parquet")]
    if parquet::is_parquet(log) {
        return parquet::table(log).map_err(|error| TableError::from(ImportError::from(error)).into());
    }
    if super::is_utf16(log) {
        return Err(TableError::from(ImportError::Utf16).into());
    }
    if log.get(..4_096).unwrap_or(log).contains(&0) {
        return Err(TableError::NotText.into());
    }
    Ok(LoggedTable::read(log, layout(Layout::find(log))?))
}
