//! Why an effect cannot be added.

use model::ModelError;
use replay::ReplayError;
use thiserror::Error;

use super::document::DocumentError;
use super::filter::LearnError;
use crate::progress::Cancelled;

/// Why an effect cannot be added at all.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AddError {
    /// A flight has not got what the regressor is made of.
    #[error("{file}: {effect} can't be learned, the flight has no {}", columns.join(", "))]
    Lacks {
        /// The flight.
        file: String,
        /// The effect.
        effect: &'static str,
        /// The columns that it needs and the flight lacks.
        columns: Vec<&'static str>,
    },
    /// The flights say nothing of it.
    #[error(
        "{effect} can't be learned: what it acts on has no reading, or its regressor does not move or has gaps, in {files}; \
         `pylon diagnose` says what to fly"
    )]
    NotExcited {
        /// The effect.
        effect: &'static str,
        /// The flights.
        files: String,
    },
    /// The caller wanted no more.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The filter refused.
    #[error(transparent)]
    Learn(#[from] LearnError),
    /// The text cannot be changed.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// It is no model, or would not be one with the effect.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A flight cannot be flown.
    #[error("{file}: {error}")]
    Replay {
        /// The flight.
        file: String,
        /// Why.
        #[source]
        error: ReplayError,
    },
}
