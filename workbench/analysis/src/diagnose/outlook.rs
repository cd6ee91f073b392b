//! What a planned flight would show: how certain each effect's coefficient would be, and what would be left
//! of each set.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::name::Name;

/// What the flights show now, and what they would show with the planned one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Outlook {
    /// Every effect whose signals the flights have, those that were found first.
    pub effects: Vec<EffectOutlook>,
    /// Every set of effects that the flights cannot tell apart.
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
    /// The coefficient from these flights, estimated together with the effects that were found; null where
    /// they do not show it.
    pub coefficient: Option<f64>,
    /// One sigma of the coefficient now, as in the diagnosis; null where the flights do not show it.
    pub sigma_now: Option<f64>,
    /// One sigma with the planned flight; null where that does not show it either.
    pub sigma_then: Option<f64>,
    /// The largest physically possible coefficient, either way.
    pub largest: f64,
    /// Whether the flights would have shown a coefficient of that size.
    pub is_seen_now: bool,
    /// Whether the flights together with the planned one would.
    pub is_seen_then: bool,
    /// The probability that they would.
    pub detection_then: f64,
    /// Whether the plan has the effect's signals. An effect by formula may need a column that no simulation
    /// has.
    pub is_planned: bool,
}

/// A set of effects of which one acts, or perhaps none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SetOutlook {
    /// The effects of the set, the most probable first.
    pub members: Vec<MemberOutlook>,
    /// The probability now that none of them acts; null where that is below 5 %.
    pub nothing: Option<f64>,
    /// The probability that the set would no longer be reported, if none of them acts; null where that is
    /// below 5 %.
    pub cleared: Option<f64>,
    /// The probability that the planned flight resolves the set: that the effect that acts is then
    /// identified, or that the set is no longer reported if none does.
    pub resolved: f64,
}

/// An effect of a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct MemberOutlook {
    /// Its id.
    pub effect: Name,
    /// The probability now that this effect is the one that acts. Those of the set and of nothing add up to
    /// one.
    pub probability: f64,
    /// The probability that it would be given with the planned flight, if it is the one that acts: the median
    /// over that flight's noise. Null for an effect whose signal the flights lack.
    pub probability_then: Option<f64>,
    /// How many of the set, including this effect, would then still have a probability of 5 % or more.
    pub left: Option<usize>,
    /// By how many sigmas the planned flight would distinguish it from the most similar of the others, or
    /// from nothing.
    pub sigmas: Option<f64>,
    /// The probability that it would be identified, if it is the one that acts.
    pub identified: Option<f64>,
}
