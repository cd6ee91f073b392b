//! What is wrong with a scenario.

use thiserror::Error;

use super::plan::Manoeuvre;

/// What is wrong with a scenario; displays as one line, without the file's name.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ScenarioProblem {
    /// It is not TOML, or not of a scenario's keys.
    #[error("{hint}")]
    Syntax {
        /// What TOML says in one line, with the key that an unknown one may be a slip of.
        hint: String,
        /// What TOML says.
        source: Box<toml::de::Error>,
    },
    /// A text that has to be one line.
    #[error("{keys} {is}: expected one line")]
    NotOneLine {
        /// The key, or the keys.
        keys: &'static str,
        /// What it is instead.
        is: &'static str,
    },
    /// A number outside of its range.
    #[error("`{key}` is {value}: expected {expected}")]
    Number {
        /// The key.
        key: String,
        /// Its value.
        value: f64,
        /// What it has to be.
        expected: Expected,
    },
    /// A key that belongs to something else.
    #[error("`{at}`: {what} has no `{key}`")]
    NotOf {
        /// Where.
        at: String,
        /// What has no such key.
        what: String,
        /// The key.
        key: &'static str,
    },
    /// A key that is missing.
    #[error("`{at}`: {what} needs `{key}`")]
    Missing {
        /// Where.
        at: String,
        /// What needs it.
        what: String,
        /// The key.
        key: &'static str,
    },
    /// A path that goes up where it has to go down, or down where it has to go up, or is missing.
    #[error("`{at}`: a {name} needs `flight_path_deg` {side} 0", name = manoeuvre.name())]
    WrongWay {
        /// Where.
        at: String,
        /// What.
        manoeuvre: Manoeuvre,
        /// `below` or `above`.
        side: &'static str,
    },
}

/// What a number has to be.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Expected {
    /// Neither infinite nor NaN.
    #[error("a finite number")]
    Finite,
    /// More than zero.
    #[error("a number above 0")]
    Positive,
    /// Not less than zero.
    #[error("0 or more")]
    NotNegative,
    /// In a range, its ends included.
    #[error("{0} to {1}")]
    Between(f64, f64),
    /// Not more often than there are rows.
    #[error("at most the rows' {0} Hz")]
    RowRate(f64),
}
