//! Effects of the user's own, by formula, and laws that are searched for.

use analysis::discover::Discovery;
use serde::{Deserialize, Serialize};

use super::{ModelText, Numbers, Signal, Times, TimesByFlight};

/// Checks an effect by formula as an `[[effect_definition]]` of a model, and fits it to a flight.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FormulaRequest {
    /// The model as it is.
    pub model: ModelText,
    /// Its id; null: one that is made of what it acts on and what it reads.
    pub id: Option<String>,
    /// What it acts on: a sensor, `gps`, or `every sensor`.
    pub on: String,
    /// The formula.
    pub regressor: String,
    /// The largest plausible coefficient, either way; null: three times the one that fits, as
    /// `pylon discover` has it.
    pub largest: Option<f64>,
    /// What it is, in words; may be empty.
    pub about: String,
    /// The flight to fit it to.
    pub flight: String,
    /// What the user says of its times.
    pub times: Times,
    /// The error that it is to explain.
    pub error: Signal,
    /// From when on the error counts, seconds; null: from its first value.
    pub from_s: Option<f64>,
}

/// What is wrong with a formula, and where.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FormulaProblem {
    /// What, in words.
    pub message: String,
    /// Where in the formula it begins, in UTF-16 units, as JavaScript counts.
    pub from: u32,
    /// Where it ends.
    pub to: u32,
}

/// A formula that was checked: either `problem` or `definition` is there.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FormulaChecked {
    /// Why it cannot be used.
    pub problem: Option<FormulaProblem>,
    /// It as a definition.
    pub definition: Option<Defined>,
}

/// An effect by formula that can be used.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Defined {
    /// Its id.
    pub effect: String,
    /// Unit of its coefficient; `1` for a number.
    pub unit: String,
    /// The largest plausible coefficient, either way.
    pub largest: f64,
    /// The coefficient that fits the error by least squares, with a constant beside it. The filter, the other
    /// effects and the noise's colour are not in it: it is for the eye. `add` learns the coefficient that
    /// counts.
    pub coefficient: f64,
    /// Share of the error's variance that it explains there, from 0 to 1.
    pub explained: f64,
    /// What the formula says, metres per unit of the coefficient: means over blocks of the flight.
    pub x: Numbers,
    /// The error's mean over each of these blocks, m.
    pub y: Numbers,
    /// The model with the definition; nothing is learned yet.
    pub model: ModelText,
}

/// Searches for laws that the recorded signals obey: `pylon discover`.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct DiscoverRequest {
    /// The flights to learn from.
    pub flights: Vec<String>,
    /// The flights to judge by.
    pub hold_outs: Vec<String>,
    /// The model.
    pub model: ModelText,
    /// What the user says of their times.
    pub times: TimesByFlight,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Discovered {
    /// What `pylon discover --json` prints.
    pub discovery: Discovery,
    /// An id for each law, as `pylon discover --write` makes it.
    pub ids: Vec<String>,
    /// In words, where no law is proposed: why.
    pub why_none: Option<String>,
}
