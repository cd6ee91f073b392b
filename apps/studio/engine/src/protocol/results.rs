//! The results of the command line's commands, in their own types.

use analysis::batch::Batch;
use analysis::compare::Comparison;
use analysis::diagnose::Diagnosis;
use analysis::learn::{Addition, Ladder};
use serde::{Deserialize, Serialize};

use super::{Headline, ModelText, Times, TimesByFlight};

/// Compares a model with a flight: `pylon compare`.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct CompareRequest {
    /// The flight.
    pub flight: String,
    /// The model.
    pub model: ModelText,
    /// The user's times for it.
    pub times: Times,
}

/// A comparison.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Compared {
    /// What `pylon compare --json` prints. A value that is not finite is null.
    pub comparison: Comparison,
    /// The result in one sentence.
    pub headline: Headline,
}

/// Finds which effect a model lacks: `pylon diagnose`.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct DiagnoseRequest {
    /// The flights to learn from: one, or several together.
    pub flights: Vec<String>,
    /// The held-out flights; if there are none, stretches of the flights are held out in turn.
    pub hold_outs: Vec<String>,
    /// The model.
    pub model: ModelText,
    /// The user's times for them.
    pub times: TimesByFlight,
}

/// A diagnosis.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Diagnosed {
    /// What `pylon diagnose --json` prints for all flights together. A value that is not finite is null.
    pub diagnosis: Diagnosis,
    /// For several flights: each flight's own result, by vehicle, and which flights do not belong with the
    /// others.
    pub batch: Option<Batch>,
    /// The result in one sentence.
    pub headline: Headline,
}

/// Learns an effect's coefficient and makes the model's next revision: `pylon add`.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct AddRequest {
    /// The effect's id.
    pub effect: String,
    /// The flights to learn from.
    pub flights: Vec<String>,
    /// The held-out flights.
    pub hold_outs: Vec<String>,
    /// The current model.
    pub model: ModelText,
    /// The user's times for them.
    pub times: TimesByFlight,
    /// Whether the filter is to estimate the coefficient in captive flight.
    pub estimate: bool,
    /// Time constant, seconds; null: the best of a grid.
    pub time_constant_s: Option<f64>,
    /// `launch` or `start`; null: whichever fits best.
    pub since: Option<String>,
    /// The date to record, as 2026-01-31.
    pub date: String,
}

/// An effect added.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Added {
    /// What `pylon add --json` prints. If it has `concerns`, the command line would not write it without
    /// `--force`.
    pub addition: Addition,
    /// The model with it: the next revision, under the same name.
    pub model: ModelText,
    /// What was learned and how the error falls, in one sentence.
    pub headline: Headline,
    /// Every revision of that model on the flights, those to learn from first: the answer to a
    /// [`LadderRequest`]. Null if a flight cannot be calibrated.
    pub ladder: Option<Ladder>,
}

/// Flies every revision of a model over flights: `pylon ladder`. The answer is what `pylon ladder --json`
/// prints.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct LadderRequest {
    /// The flights.
    pub flights: Vec<String>,
    /// The model.
    pub model: ModelText,
    /// The user's times for them.
    pub times: TimesByFlight,
}

/// Makes a file of a result. Its bytes come with the answer and are those that the command line writes.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ExportRequest {
    /// The result to export.
    pub export: Exports,
}

/// A result that can be exported.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "what", rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Exports {
    /// `pylon compare --json`.
    Compare(CompareRequest),
    /// `pylon diagnose --json`.
    Diagnose(DiagnoseRequest),
    /// `pylon ladder --json`.
    Ladder(LadderRequest),
    /// The flight as Pylon's own CSV: `pylon import`.
    Flight {
        /// The flight.
        flight: String,
    },
}

/// A file, whose bytes come with the answer.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Exported {
    /// A name for it.
    pub name: String,
    /// Its media type.
    pub media: String,
}
