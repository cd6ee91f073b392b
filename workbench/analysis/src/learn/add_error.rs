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
    /// A flight lacks columns of the regressor.
    #[error("{file}: {effect} can't be learned, the flight has no {}", columns.join(", "))]
    Lacks {
        /// The flight.
        file: String,
        /// The effect.
        effect: &'static str,
        /// The columns that it needs and the flight lacks.
        columns: Vec<&'static str>,
    },
    /// The flights have no information about it.
    #[error(
        "{effect} can't be learned: its sensor has no reading, or its regressor does not change or has gaps, in {files}; \
         `pylon diagnose` suggests what to fly"
    )]
    NotExcited {
        /// The effect.
        effect: &'static str,
        /// The flights.
        files: String,
    },
    /// The model has the definition that this would write, with another formula.
    #[error("the model defines {id} by another formula than {regressor}; give that definition another id")]
    DefinedOtherwise {
        /// The definition's id.
        id: &'static str,
        /// Its formula.
        regressor: &'static str,
    },
    /// The caller cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The filter failed.
    #[error(transparent)]
    Learn(#[from] LearnError),
    /// The text cannot be changed.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// The text is not a model, or would not be one with the effect.
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
