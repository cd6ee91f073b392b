//! Drafts of mappings ([`formats::import::guess`]), from files.

use std::path::Path;

pub use formats::import::guess::{Draft, guess};

use super::mapping::{Fault, MappingError};

/// Drafts a mapping of a log.
///
/// # Errors
/// [`MappingError`] for what is no table of numbers.
pub fn guess_file(log: &Path) -> Result<Draft, MappingError> {
    let in_log = |what: String| MappingError { file: log.to_path_buf(), what };
    let bytes = super::read(log).map_err(|error| in_log(error.problem.to_string()))?;
    formats::import::guess::guess_log(&bytes).map_err(|fault| match fault {
        Fault::Log(what) | Fault::Mapping(what) => in_log(what),
    })
}
