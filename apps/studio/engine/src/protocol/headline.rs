//! A result in one sentence.

use serde::Serialize;

/// How good the result is, which determines its look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Tone {
    /// Good, or better than before.
    Good,
    /// Something is missing or undetermined.
    Caution,
    /// A sensor is untrustworthy, or an error is unexplained.
    Bad,
}

/// A result in one plain sentence, with the number that matters.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Headline {
    /// The sentence.
    pub sentence: String,
    /// How good the result is.
    pub tone: Tone,
    /// The effect that the sentence names, if any; Add would add this one.
    pub effect: Option<String>,
}
