//! Models.

use serde::{Deserialize, Serialize};

/// A model, as its file is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ModelText {
    /// What results call it: a file's name, or a preset's.
    pub name: String,
    /// Its TOML. An empty one is the default model.
    pub text: String,
}

/// Asks what is in a model. An error is the file's own: line, key, what was expected.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ModelRequest {
    /// The model.
    pub model: ModelText,
}

/// What is in a model.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ModelFacts {
    /// The effects that it accounts for, in its order.
    pub effects: Vec<TermFacts>,
    /// Its revisions, oldest first.
    pub revisions: Vec<RevisionFacts>,
    /// What in it is unlikely.
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
    /// Time constant of its regressor, seconds, where it has one.
    pub time_constant_s: Option<f64>,
    /// When that regressor's clock starts: `launch` or `start`.
    pub since: Option<String>,
    /// What it was learned from.
    pub learned_from: Option<String>,
    /// The day.
    pub date: Option<String>,
}

/// A revision of a model.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct RevisionFacts {
    /// Its number.
    pub number: u32,
    /// The effect that it added or learned anew.
    pub effect: Option<String>,
    /// The day.
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
    /// What it is, in one sentence.
    pub about: String,
}
