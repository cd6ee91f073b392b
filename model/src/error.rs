//! Why a model cannot be used.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::formula::FormulaError;

/// A model that cannot be used; displays as one line, but for a formula, which is shown with carets under the
/// place.
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
        /// What is wrong, and what was expected, in one line and with the key that is nearest to an unknown
        /// one.
        message: String,
        /// The same, as the parser says it.
        source: Box<toml::de::Error>,
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
    /// A formula that is none.
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
    /// An id that no definition can have.
    #[error(
        "row {row}: effect_definition id '{id}', expected two words of small letters, digits and _ with a point between and no more than 40 of them, such as baro.flap_wash"
    )]
    DefinitionId {
        /// Line, from 1.
        row: usize,
        /// The id.
        id: String,
    },
    /// An id that is taken.
    #[error("row {row}: effect_definition '{id}' has the id of {with}: give it another")]
    DefinitionClash {
        /// Line, from 1.
        row: usize,
        /// The id.
        id: String,
        /// What has it already.
        with: &'static str,
    },
    /// A definition on what is no sensor.
    #[error("row {row}: on = '{on}' is not a sensor; nearest: {nearest}")]
    DefinitionOn {
        /// Line, from 1.
        row: usize,
        /// What it says.
        on: String,
        /// What it may mean.
        nearest: String,
    },
    /// Definitions that are made of each other.
    #[error("row {row}: the definitions {path} refer to each other in a circle: write one of them out")]
    Cycle {
        /// Line, from 1.
        row: usize,
        /// The ids, from the first back to one of them.
        path: String,
    },
    /// A learned coefficient of a formula that has changed.
    #[error(
        "row {row}: the coefficient of {id} was learned for another formula ({found}) than effect_definition {id} has now ({now}): \
         learn it again (remove this [[effect]], then pylon add {id} --model MODEL.toml --from FLIGHT), or bring the old definition back"
    )]
    OtherFormula {
        /// Line, from 1.
        row: usize,
        /// The effect.
        id: &'static str,
        /// The fingerprint that is written beside the coefficient.
        found: String,
        /// The definition's.
        now: String,
    },
    /// A learned coefficient that does not say of which formula.
    #[error(
        "row {row}: the coefficient of {id} was learned, and does not say for which formula: learn it again with pylon add, or, if \
         it is one of the definition as it stands, add formula = \"{now}\""
    )]
    NoFormula {
        /// Line, from 1.
        row: usize,
        /// The effect.
        id: &'static str,
        /// The definition's fingerprint.
        now: String,
    },
    /// A formula of signals that a flight computer does not have.
    #[error(
        "effect {id} reads {signals}, which the flight computer does not have: measure it there, or leave the effect out of the model that flies"
    )]
    NotOnBoard {
        /// The effect.
        id: &'static str,
        /// What it lacks.
        signals: String,
    },
    /// Formulas that remember more than there is room for.
    #[error(
        "the effects by formula remember {found} numbers; with {estimated} estimated effects a restart keeps {most}: use fewer integrals, means and delays, or estimate fewer effects"
    )]
    FormulaWords {
        /// How many.
        found: usize,
        /// How many there can be.
        most: usize,
        /// Effects that are states.
        estimated: usize,
    },
    /// A value that its key cannot have.
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
    #[error("effect {id} occurs twice, expected once")]
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
        #[source]
        error: Box<ModelError>,
    },
}
