//! Models.

use serde::{Deserialize, Serialize};

/// A model, as in its file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ModelText {
    /// Its name in results: a file's name, or a preset's.
    pub name: String,
    /// Its TOML. An empty text is the default model.
    pub text: String,
}

/// Asks for the contents of a model. An error is the file's own: line, key, what was expected.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ModelRequest {
    /// The model.
    pub model: ModelText,
}

/// The contents of a model.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ModelFacts {
    /// The effects that it accounts for, in the model's order.
    pub effects: Vec<TermFacts>,
    /// Its revisions, oldest first.
    pub revisions: Vec<RevisionFacts>,
    /// Warnings about unlikely values.
    pub warnings: Vec<String>,
}

/// An effect of a model.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct TermFacts {
    /// Its id.
    pub effect: String,
    /// Its coefficient.
    pub coefficient: f64,
    /// One sigma of it.
    pub sigma: f64,
    /// Unit of both.
    pub unit: String,
    /// Whether the filter estimates it in captive flight.
    pub estimate: bool,
    /// Time constant of its regressor, seconds, if it has one.
    pub time_constant_s: Option<f64>,
    /// When that regressor's clock starts: `launch` or `start`.
    pub since: Option<String>,
    /// What it was learned from.
    pub learned_from: Option<String>,
    /// The date on which it was learned.
    pub date: Option<String>,
}

/// A revision of a model.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct RevisionFacts {
    /// Its number.
    pub number: u32,
    /// The effect that it added or learned again.
    pub effect: Option<String>,
    /// The date.
    pub date: Option<String>,
}

/// Asks for the models that come with Pylon.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct PresetsRequest {}

/// A model that comes with Pylon.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Preset {
    /// The model.
    pub model: ModelText,
    /// Description in one sentence.
    pub about: String,
}
