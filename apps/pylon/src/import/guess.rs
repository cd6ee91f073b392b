//! Drafts mappings ([`formats::import::guess`]) from files.

use std::path::Path;

pub use formats::import::guess::{Draft, guess};

use super::mapping::{Fault, MappedError};

/// Drafts a mapping of a log.
///
/// # Errors
/// [`MappedError`] for a file that is not a table of numbers.
pub fn guess_file(log: &Path) -> Result<Draft, MappedError> {
    let file = || log.to_path_buf();
    formats::import::guess::guess_log(&super::read(log)?).map_err(|fault| match fault {
        Fault::Log(problem) => MappedError::Log { file: file(), problem },
        Fault::Mapping(problem) => MappedError::Mapping { file: file(), problem },
    })
}
