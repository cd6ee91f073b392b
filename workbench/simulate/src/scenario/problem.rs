//! Errors in a scenario.

use thiserror::Error;

use super::plan::Manoeuvre;

/// An error in a scenario; displayed as one line, without the file's name.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ScenarioProblem {
    /// It is not TOML, or has keys that no scenario has.
    #[error("{hint}")]
    Syntax {
        /// TOML's message in one line, with the key that an unknown one may be a misspelling of.
        hint: String,
        /// TOML's error.
        source: Box<toml::de::Error>,
    },
    /// A text that must be one line.
    #[error("{keys} {is}: expected one line")]
    NotOneLine {
        /// The key, or the keys.
        keys: &'static str,
        /// What it is instead.
        is: &'static str,
    },
    /// A number outside its range.
    #[error("`{key}` is {value}: expected {expected}")]
    Number {
        /// The key.
        key: String,
        /// Its value.
        value: f64,
        /// What was expected.
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
    /// A path whose direction is wrong (up instead of down, or down instead of up) or missing.
    #[error("`{at}`: a {name} needs `flight_path_deg` {side} 0", name = manoeuvre.name())]
    WrongWay {
        /// Where.
        at: String,
        /// The manoeuvre.
        manoeuvre: Manoeuvre,
        /// `below` or `above`.
        side: &'static str,
    },
}

/// What is expected of a number.
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
    /// Within a range, its ends included.
    #[error("{0} to {1}")]
    Between(f64, f64),
    /// At most the rate of the rows.
    #[error("at most the rows' {0} Hz")]
    RowRate(f64),
}
