//! `pylon effects --json`.

use std::borrow::Cow;

use analysis::name::Name;
use kf_core::effect::EffectId;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::VERSION;
use crate::effect_guide::explanation;

/// Effects of the catalogue, some or all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EffectsResult {
    /// Version of these keys.
    pub version: u32,
    /// The effects, in the catalogue's order.
    pub effects: Vec<EffectExplained>,
}

/// An effect of the catalogue.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EffectExplained {
    /// Its id.
    pub effect: Name,
    /// What it acts on: a sensor, or `gps`.
    pub on: Name,
    /// Description.
    pub what: String,
    /// The regressor, metres per unit of the coefficient.
    pub regressor: String,
    /// Unit of the coefficient; `1` for a pure number.
    pub unit: Name,
    /// Least and largest plausible coefficient.
    pub plausible: [f64; 2],
    /// Where that range comes from.
    pub source: String,
    /// The columns that the regressor needs.
    pub needs: Vec<Name>,
    /// What it looks like in a flight.
    pub looks_like: String,
}

impl EffectsResult {
    /// Explains these effects.
    #[must_use]
    pub fn new(effects: &[EffectId]) -> Self {
        let explained = effects.iter().filter_map(|effect| {
            let text = explanation(*effect)?;
            Some(EffectExplained {
                effect: effect.name().into(),
                on: effect.subject().name().into(),
                what: text.what.to_owned(),
                regressor: text.formula.to_owned(),
                unit: effect.unit().into(),
                plausible: effect.plausible().map(f64::from),
                source: text.source.to_owned(),
                needs: effect.needs().iter().copied().map(Cow::from).collect(),
                looks_like: text.looks_like.to_owned(),
            })
        });
        Self { version: VERSION, effects: explained.collect() }
    }
}
