//! Why a model cannot be used.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::formula::FormulaError;

/// A model that cannot be used. Displays as one line; a formula is shown with carets under the place.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The file could not be read.
    #[error("cannot be read: {0}")]
    Io(#[source] io::Error),
    /// The text is not a model's TOML.
    #[error("row {row}, column {column}: {message}")]
    Syntax {
        /// Line, from 1.
        row: usize,
        /// Character in the line, from 1.
        column: usize,
        /// What is wrong and what was expected, in one line, with the nearest key to an unknown one.
        message: String,
        /// The parser's original error.
        source: Box<toml::de::Error>,
    },
    /// An effect that the catalogue does not have.
    #[error("row {row}: no effect '{id}' in the catalogue; nearest: {nearest}")]
    UnknownEffect {
        /// Line, from 1.
        row: usize,
        /// The id.
        id: String,
        /// The nearest ids.
        nearest: String,
    },
    /// An invalid formula.
    #[error("row {row}: the regressor of effect_definition {id}: {error}")]
    Formula {
        /// Line, from 1.
        row: usize,
        /// The definition's id.
        id: String,
        /// What is wrong, and where.
        #[source]
        error: Box<FormulaError>,
    },
    /// An invalid definition id.
    #[error(
        "row {row}: effect_definition id '{id}', expected two words of small letters, digits and _ with a point between and no more than 40 of them, such as baro.flap_wash"
    )]
    DefinitionId {
        /// Line, from 1.
        row: usize,
        /// The id.
        id: String,
    },
    /// An id that is already used.
    #[error("row {row}: effect_definition '{id}' has the id of {with}: choose another id")]
    DefinitionClash {
        /// Line, from 1.
        row: usize,
        /// The id.
        id: String,
        /// The present owner of the id.
        with: &'static str,
    },
    /// A definition on something that is not a sensor.
    #[error("row {row}: on = '{on}' is not a sensor; nearest: {nearest}")]
    DefinitionOn {
        /// Line, from 1.
        row: usize,
        /// The value of `on`.
        on: String,
        /// The nearest valid values.
        nearest: String,
    },
    /// Definitions that refer to each other in a circle.
    #[error("row {row}: the definitions {path} refer to each other in a circle: write one of them out")]
    Cycle {
        /// Line, from 1.
        row: usize,
        /// The ids, from the first back to a repeated one.
        path: String,
    },
    /// A learned coefficient whose formula has changed.
    #[error(
        "row {row}: the coefficient of {id} was learned for another formula ({found}) than effect_definition {id} has now ({now}): \
         learn it again (remove this [[effect]], then pylon add {id} --model MODEL.toml --from FLIGHT), or restore the old definition"
    )]
    OtherFormula {
        /// Line, from 1.
        row: usize,
        /// The effect.
        id: &'static str,
        /// The fingerprint written beside the coefficient.
        found: String,
        /// The definition's fingerprint.
        now: String,
    },
    /// A learned coefficient without the fingerprint of its formula.
    #[error(
        "row {row}: the coefficient of {id} was learned, but its formula is not recorded: learn it again with pylon add, or, if \
         it was learned with the present definition, add formula = \"{now}\""
    )]
    NoFormula {
        /// Line, from 1.
        row: usize,
        /// The effect.
        id: &'static str,
        /// The definition's fingerprint.
        now: String,
    },
    /// A formula with signals that a flight computer does not have.
    #[error(
        "effect {id} reads {signals}, which the flight computer does not have: measure it there, or remove the effect from the model that flies"
    )]
    NotOnBoard {
        /// The effect.
        id: &'static str,
        /// The missing signals.
        signals: String,
    },
    /// Formulas whose memory does not fit.
    #[error(
        "the effects by formula store {found} numbers; with {estimated} estimated effects a restart keeps at most {most}: use fewer integrals, means and delays, or estimate fewer effects"
    )]
    FormulaWords {
        /// Numbers that they remember.
        found: usize,
        /// Largest number possible.
        most: usize,
        /// Effects that are states.
        estimated: usize,
    },
    /// A value that is invalid for its key.
    #[error("{key} is {found}, expected {expected}")]
    Value {
        /// The key, with its tables.
        key: String,
        /// The value.
        found: String,
        /// The valid values.
        expected: &'static str,
    },
    /// A key without effect because of another.
    #[error("{key} has no effect while {because}; remove one of them")]
    NoEffect {
        /// The key.
        key: &'static str,
        /// The reason.
        because: &'static str,
    },
    /// An effect that occurs twice.
    #[error("effect {id} occurs twice, expected once")]
    Twice {
        /// The id.
        id: &'static str,
    },
    /// Two revisions with the same number.
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
    /// More effects than the estimator can hold.
    #[error("{found} {kind} effects, expected at most {most}")]
    TooMany {
        /// Estimated or constant.
        kind: &'static str,
        /// Number of effects.
        found: usize,
        /// Largest number possible.
        most: usize,
    },
    /// The caller's number of estimated effects differs from the model's.
    #[error("the model estimates {found} effects, the mission is made for {wanted}")]
    Effects {
        /// Number in the mission.
        wanted: usize,
        /// Number in the model.
        found: usize,
    },
    /// Any of these, in a file.
    #[error("{}: {error}", file.display())]
    InFile {
        /// The file.
        file: PathBuf,
        /// The error.
        #[source]
        error: Box<ModelError>,
    },
}
