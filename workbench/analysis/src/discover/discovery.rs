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
    /// Version of the keys' meaning. It increases where a key changes its meaning or is removed.
    pub version: u32,
    /// The laws, the most probable first; empty where no law of the grammar explains the remainder, or
    /// nothing is left to explain.
    pub laws: Vec<FoundLaw>,
    /// Probability that none of the laws considered acts.
    pub none: f64,
    /// What the catalogue explains: the effects that were estimated together with every law.
    pub catalogue: Vec<Name>,
    /// The diagnosis' verdict over all sensors.
    pub verdict: Verdict,
    /// The most probable law that was not proposed, and why, if none was proposed.
    pub rejected: Option<Rejected>,
    /// The signals that were searched.
    pub signals: Vec<String>,
    /// Those of the signals that have no known unit: they are treated as plain numbers.
    pub without_unit: Vec<String>,
    /// Columns that a formula cannot name, which were left out.
    pub unnamed: Vec<String>,
    /// Number of laws that were scored.
    pub scored: u64,
    /// Number of laws for which the noise was fitted again.
    pub fitted: u64,
    /// The model's name: a preset or a file.
    pub model: String,
    /// The flights learned from.
    pub flights: Vec<String>,
    /// The flights held out, if any. If none, stretches of the flights are held out in turn.
    pub hold_outs: Vec<String>,
    /// Anything remarkable about the input.
    pub warnings: Vec<String>,
}

impl Discovery {
    /// The version that this program writes.
    pub const VERSION: u32 = 1;
}

/// Why a law was not proposed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum Why {
    /// Its evidence does not pay for its length and for the size of the search.
    NotEnoughEvidence,
    /// It does not make the held-out data more likely.
    HeldOut,
    /// An effect of the catalogue explains as much.
    Catalogue,
    /// It may be an error of the formulas of the effects found.
    Shape,
    /// It is too long for a formula that can be flown.
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
    /// The effect of the catalogue that explains as much, if that is the reason.
    pub effect: Option<Name>,
}

/// A law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FoundLaw {
    /// What it acts on: a sensor, or `gps`.
    pub on: Name,
    /// The law, in the form of an effect definition.
    pub regressor: String,
    /// Unit of the coefficient.
    pub unit: String,
    /// The coefficient.
    pub coefficient: f64,
    /// One sigma of it.
    pub sigma: f64,
    /// Probability that this law acts, among all that were considered and none.
    pub probability: f64,
    /// The same for this law and all that are equal to it on these flights.
    pub probability_with_equals: f64,
    /// Root mean square of the held-out errors without the law, m.
    pub rms_before_m: Option<f64>,
    /// The same with the law, m. Both are absent where most of the error would come from the coefficient's
    /// own uncertainty.
    pub rms_after_m: Option<f64>,
    /// Length of the law, bits.
    pub bits: f64,
    /// What the law gains in twice the log likelihood.
    pub evidence: f64,
    /// What the law gains in twice the log likelihood on the held-out flights, or else on the stretches held
    /// out in turn.
    pub held_out_gain: f64,
    /// How much of the residual the law makes in free flight, rms, m.
    pub size_m: f64,
    /// Effects that were found without the law and that it replaces.
    pub instead_of: Vec<Name>,
    /// Laws and effects that cannot be distinguished from it on these flights, with the correlation of both.
    pub equal_to: Vec<Equal>,
    /// What to fly to distinguish it from these, in words; empty where no such manoeuvre is known.
    pub advice: String,
    /// Its picture on the flights; not in the JSON.
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
    /// Its probability, for a law.
    pub probability: Option<f64>,
}
