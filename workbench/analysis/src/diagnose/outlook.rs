//! What a planned flight would tell: how sure each effect's coefficient would be, and what would be left of
//! each set.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::name::Name;

/// What the flights tell now, and what they would tell with the planned one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Outlook {
    /// Every effect that the flights have the signals of, those that were found first.
    pub effects: Vec<EffectOutlook>,
    /// Every set of effects that the flights can't tell apart.
    pub sets: Vec<SetOutlook>,
}

/// One effect's coefficient.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct EffectOutlook {
    /// Its id.
    pub effect: Name,
    /// The sensor that it acts on; `gps` for the reference.
    pub sensor: Name,
    /// Unit of the coefficient.
    pub unit: Name,
    /// Whether it was found to act.
    pub is_found: bool,
    /// The coefficient as the flights have it, beside the effects that were found; null where they do not
    /// show it.
    pub coefficient: Option<f64>,
    /// One sigma of it now, as the diagnosis has it; null where the flights do not show it.
    pub sigma_now: Option<f64>,
    /// One sigma with the planned flight; null where that does not show it either.
    pub sigma_then: Option<f64>,
    /// The largest coefficient that nature makes, either way.
    pub largest: f64,
    /// Whether the flights would have shown it at that size.
    pub is_seen_now: bool,
    /// Whether the flights and the planned one would.
    pub is_seen_then: bool,
    /// Whether the plan has its signals. One by formula may need a column that no simulation has.
    pub is_planned: bool,
}

/// Effects of which one acts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SetOutlook {
    /// Its effects, the most probable first.
    pub members: Vec<MemberOutlook>,
}

/// An effect of a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct MemberOutlook {
    /// Its id.
    pub effect: Name,
    /// The probability that it is the one that acts, now.
    pub probability: f64,
    /// The probability that it would be given with the planned flight, if it is the one: the median over that
    /// flight's noise. Null for one whose signal the flights lack.
    pub probability_then: Option<f64>,
    /// How many of the set, itself among them, would then still have a probability of 5 % or more.
    pub left: Option<usize>,
    /// By how many sigmas the planned flight would tell it from the one of the others that is most like it.
    pub sigmas: Option<f64>,
}
