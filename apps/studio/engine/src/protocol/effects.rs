//! The catalogue of effects.

use serde::{Deserialize, Serialize};

/// Asks for the catalogue.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct EffectsRequest {}

/// An effect, explained.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct EffectGuide {
    /// Its id.
    pub effect: String,
    /// What it acts on: a sensor, or `gps`.
    pub subject: String,
    /// The field's usual name for it.
    pub title: String,
    /// Description in one sentence.
    pub what: String,
    /// The formula that the coefficient is multiplied by, metres per unit of the coefficient.
    pub formula: String,
    /// Unit of the coefficient; `1` for a number.
    pub unit: String,
    /// The plausible range of the coefficient.
    pub plausible: [f64; 2],
    /// Where that range comes from.
    pub source: String,
    /// What it looks like in a flight.
    pub looks_like: String,
    /// The columns that it needs.
    pub needs: Vec<String>,
    /// Whether it has a time constant.
    pub has_time_constant: bool,
}
