//! A result in one sentence.

use serde::Serialize;

/// How good the news is; what it is drawn as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Tone {
    /// All is well, or got better.
    Good,
    /// Something is missing or cannot be told.
    Caution,
    /// A sensor is not to be trusted, or nothing explains it.
    Bad,
}

/// A result in one plain sentence, with the number that matters.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Headline {
    /// The sentence.
    pub sentence: String,
    /// How good the news is.
    pub tone: Tone,
    /// The effect that it names, if it names one: what Add would add.
    pub effect: Option<String>,
}
