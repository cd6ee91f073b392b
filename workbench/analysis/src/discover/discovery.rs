//! What a search for laws found: the keys of `pylon discover --json`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::picture::Picture;
use crate::diagnose::Verdict;
use crate::name::Name;

/// What was found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Discovery {
    /// Version of what these keys mean: a new one where a key changes its meaning or goes.
    pub version: u32,
    /// The laws, the most probable first; none where no law of the grammar explains the rest, or nothing is
    /// left to explain.
    pub laws: Vec<FoundLaw>,
    /// How probable it is that none of the laws that were looked at acts.
    pub none: f64,
    /// What the catalogue explains: the effects that stood beside every law.
    pub catalogue: Vec<Name>,
    /// The diagnosis' verdict over all sensors.
    pub verdict: Verdict,
    /// The most probable law that was not proposed, and why, where none was.
    pub rejected: Option<Rejected>,
    /// The signals that were searched.
    pub signals: Vec<String>,
    /// Of these, columns of no known unit: they count as plain numbers.
    pub without_unit: Vec<String>,
    /// Columns that a formula cannot name, which were left out.
    pub unnamed: Vec<String>,
    /// Laws that were scored.
    pub scored: u64,
    /// Laws that the noise was fitted anew for.
    pub fitted: u64,
    /// The model's name: a preset or a file.
    pub model: String,
    /// The flights learned from.
    pub flights: Vec<String>,
    /// The flights held out, if any; without, stretches of the flights are held out in turn.
    pub hold_outs: Vec<String>,
    /// What was remarkable about the input.
    pub warnings: Vec<String>,
}

impl Discovery {
    /// The version that is written.
    pub const VERSION: u32 = 1;
}

/// Why a law was not proposed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum Why {
    /// It does not pay for its length and for the size of the search.
    NotEnoughEvidence,
    /// What was held out does not become more likely by it.
    HeldOut,
    /// An effect of the catalogue explains as much.
    Catalogue,
    /// It is what the formulas of the effects found may miss.
    Shape,
    /// It is too long for a formula that flies.
    NoFormula,
}

/// A law that was not proposed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Rejected {
    /// What it acts on.
    pub on: Name,
    /// The law.
    pub regressor: String,
    /// Why not.
    pub why: Why,
    /// The effect of the catalogue that explains as much, if that is why.
    pub effect: Option<Name>,
}

/// A law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FoundLaw {
    /// What it acts on: a sensor, or `gps`.
    pub on: Name,
    /// The law, as an effect definition takes it.
    pub regressor: String,
    /// Unit of the coefficient.
    pub unit: String,
    /// The coefficient.
    pub coefficient: f64,
    /// One sigma of it.
    pub sigma: f64,
    /// How probable it is that this law acts, among all that were looked at and none.
    pub probability: f64,
    /// The same of it and all that are equal to it on these flights.
    pub probability_with_equals: f64,
    /// Root mean square of the held-out errors without it, m.
    pub rms_before_m: Option<f64>,
    /// With it, m; neither is there where most of the error would be the coefficient's own.
    pub rms_after_m: Option<f64>,
    /// What it takes to say it, bits.
    pub bits: f64,
    /// What it gains in twice the log likelihood.
    pub evidence: f64,
    /// What the held-out flights, or else the stretches held out in turn, gain by it in twice the log
    /// likelihood.
    pub held_out_gain: f64,
    /// How much of the residual it makes in free flight, rms, m.
    pub size_m: f64,
    /// Effects that were found without the law and that it takes the place of.
    pub instead_of: Vec<Name>,
    /// Laws and effects that it cannot be told from on these flights, with the correlation of both.
    pub equal_to: Vec<Equal>,
    /// What to fly to tell it from these, in words; empty where nothing is known that would.
    pub advice: String,
    /// What it looks like on the flights; not in the JSON.
    #[serde(skip)]
    pub picture: Picture,
}

/// What a law is equal to on these flights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Equal {
    /// The law, or the id of the catalogue's effect.
    pub law: String,
    /// Magnitude of the correlation of both whitened columns.
    pub correlation: f64,
    /// How probable it is, for a law.
    pub probability: Option<f64>,
}
