//! The user's own effects, by formula, and the search for laws.

use analysis::discover::Discovery;
use serde::{Deserialize, Serialize};

use super::{ModelText, Numbers, Signal, Times, TimesByFlight};

/// Checks an effect by formula as an `[[effect_definition]]` of a model, and fits it to a flight.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FormulaRequest {
    /// The current model.
    pub model: ModelText,
    /// Its id; null: made from what it acts on and what it reads.
    pub id: Option<String>,
    /// What it acts on: a sensor, `gps`, or `every sensor`.
    pub on: String,
    /// The formula.
    pub regressor: String,
    /// The largest plausible coefficient, of either sign; null: three times the fitted one, as in
    /// `pylon discover`.
    pub largest: Option<f64>,
    /// Description; may be empty.
    pub about: String,
    /// The flight to fit it to.
    pub flight: String,
    /// The user's times for it.
    pub times: Times,
    /// The error to be explained.
    pub error: Signal,
    /// Start of the error that is used, seconds; null: its first value.
    pub from_s: Option<f64>,
}

/// An error in a formula, and its position.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FormulaProblem {
    /// The error message.
    pub message: String,
    /// Where it begins in the formula, in UTF-16 units, as JavaScript counts.
    pub from: u32,
    /// Where it ends.
    pub to: u32,
}

/// A checked formula: has either `problem` or `definition`.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FormulaChecked {
    /// Why it cannot be used.
    pub problem: Option<FormulaProblem>,
    /// The formula as a definition.
    pub definition: Option<Defined>,
}

/// A usable effect by formula.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Defined {
    /// Its id.
    pub effect: String,
    /// Unit of its coefficient; `1` for a number.
    pub unit: String,
    /// The largest plausible coefficient, of either sign.
    pub largest: f64,
    /// The coefficient that fits the error by least squares, together with a constant. It ignores the filter,
    /// the other effects and the noise's colour, and is for display only. `add` learns the coefficient for
    /// the model.
    pub coefficient: f64,
    /// Share of the error's variance that it explains, from 0 to 1.
    pub explained: f64,
    /// The formula's value, metres per unit of the coefficient: means over blocks of the flight.
    pub x: Numbers,
    /// The error's mean over each of these blocks, m.
    pub y: Numbers,
    /// The model with the definition, whose coefficient is not learned yet.
    pub model: ModelText,
}

/// Searches for laws that the recorded signals obey: `pylon discover`.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct DiscoverRequest {
    /// The flights to learn from.
    pub flights: Vec<String>,
    /// The held-out flights.
    pub hold_outs: Vec<String>,
    /// The model.
    pub model: ModelText,
    /// The user's times for them.
    pub times: TimesByFlight,
}

/// The laws found.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Discovered {
    /// What `pylon discover --json` prints.
    pub discovery: Discovery,
    /// An id for each law, as `pylon discover --write` makes it.
    pub ids: Vec<String>,
    /// Why no law is proposed, if none is.
    pub why_none: Option<String>,
}
