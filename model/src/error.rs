//! Why a model can not be used.

use std::path::PathBuf;

use thiserror::Error;

/// A model that can not be used; displays as one line.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The file could not be read.
    #[error("can not be read: {0}")]
    Io(String),
    /// The text is not a model's TOML.
    #[error("row {row}, column {column}: {message}")]
    Syntax {
        /// Line, from 1.
        row: usize,
        /// Character in the line, from 1.
        column: usize,
        /// What is wrong, and what was expected.
        message: String,
    },
    /// An effect that the catalogue does not have.
    #[error("row {row}: no effect '{id}' in the catalogue; nearest: {nearest}")]
    UnknownEffect {
        /// Line, from 1.
        row: usize,
        /// The id.
        id: String,
        /// The ids that are nearest to it.
        nearest: String,
    },
    /// A value that its key can not have.
    #[error("{key} is {found}, expected {expected}")]
    Value {
        /// The key, with its tables.
        key: String,
        /// The value.
        found: String,
        /// What it can be.
        expected: &'static str,
    },
    /// A key that does nothing beside another.
    #[error("{key} has no effect while {because}; remove one of them")]
    NoEffect {
        /// The key.
        key: &'static str,
        /// Why.
        because: &'static str,
    },
    /// An effect that is there twice.
    #[error("effect {id} is there twice, expected once")]
    Twice {
        /// The id.
        id: &'static str,
    },
    /// Two revisions with one number.
    #[error(
        "revision {number} in row {second} clashes with the one in row {first}: give one of them another number"
    )]
    RevisionClash {
        /// Their number.
        number: u32,
        /// Line of the first, from 1.
        first: usize,
        /// Line of the second.
        second: usize,
    },
    /// More effects than the estimator holds.
    #[error("{found} {kind} effects, expected at most {most}")]
    TooMany {
        /// Estimated or constant.
        kind: &'static str,
        /// How many there are.
        found: usize,
        /// How many there can be.
        most: usize,
    },
    /// The caller's number of estimated effects is not the model's.
    #[error("the model estimates {found} effects, the mission is made for {wanted}")]
    Effects {
        /// Of the mission.
        wanted: usize,
        /// Of the model.
        found: usize,
    },
    /// Any of these, in a file.
    #[error("{}: {error}", file.display())]
    InFile {
        /// The file.
        file: PathBuf,
        /// The error.
        error: Box<ModelError>,
    },
}
