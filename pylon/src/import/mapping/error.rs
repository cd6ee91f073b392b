//! Why a log could not be read by a mapping.

use std::path::PathBuf;

use thiserror::Error;

/// Why a log could not be read by a mapping, or no mapping be drafted; displays as one line.
#[derive(Debug, Error)]
#[error("{}: {what}", file.display())]
pub struct MappingError {
    /// The log or the mapping.
    pub file: PathBuf,
    /// What is wrong with it.
    pub what: String,
}
