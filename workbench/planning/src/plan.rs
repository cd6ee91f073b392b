//! A plan and its parts, as they are given and reported.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A manoeuvre that can be planned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum PlannedManoeuvre {
    /// Faster and slower than cruise by the amount, m/s, at constant altitude.
    SpeedSweep,
    /// Climbs and descents at a flight-path angle of the amount, degrees, with level flight between them.
    Climbs,
    /// Pull-ups to the amount as a load factor, and push-overs as far below one as that is above it.
    PullUps,
    /// Level turns in both directions at a bank of the amount, degrees.
    Turns,
    /// Straight and level; it has no amount.
    Level,
    /// One long climb at a flight-path angle of the amount, degrees, level, and back down.
    LongClimb,
    /// Straight legs with acceleration and braking by the amount, m/s, each turned by 90 degrees from the
    /// last.
    Legs,
}

/// A part of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct PlannedLeg {
    /// The manoeuvre.
    pub manoeuvre: PlannedManoeuvre,
    /// Its amount, in the unit given in the offer.
    pub amount: f64,
    /// Duration of each of its stretches, seconds.
    pub duration_s: f64,
    /// Number of repetitions.
    pub times: u32,
}

/// A planned flight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FlightPlan {
    /// True airspeed of straight and level flight, m/s.
    pub speed_mps: f64,
    /// Altitude at its start, m above mean sea level.
    pub altitude_m: f64,
    /// Straight and level flight at the start, for the calibration, seconds.
    pub calibration_s: f64,
    /// The manoeuvres after that.
    pub legs: Vec<PlannedLeg>,
}

/// What a manoeuvre by itself would add.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Gain {
    /// The probability that it would resolve a set, averaged over the sets; null without a set.
    pub tells_apart: Option<f64>,
    /// Number of effects that it would show and that no flight shows yet.
    pub shows: u32,
    /// The share to which an effect's interval would shrink, averaged over the effects that the flights show.
    pub narrows_to: f64,
}

/// A manoeuvre on offer.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Offer {
    /// The manoeuvre with suggested values.
    pub leg: PlannedLeg,
    /// Unit of the amount: `m/s`, `deg`, `g`; empty if there is no amount.
    pub unit: String,
    /// The least amount.
    pub least: f64,
    /// The largest amount.
    pub most: f64,
    /// What it would add by itself; null if that was not asked for, or it cannot be flown here.
    pub gain: Option<Gain>,
}

/// One segment of the scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct PlannedSegment {
    /// What to do, as a pilot reads it.
    pub words: String,
    /// Start, seconds after the calibration.
    pub from_s: f64,
    /// Duration, seconds.
    pub duration_s: f64,
    /// Simulated altitude at its end, m above mean sea level.
    pub altitude_then_m: f64,
}

/// The least and the greatest values that the simulated flight reaches.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Reached {
    /// True airspeed, m/s.
    pub airspeed_mps: [f64; 2],
    /// Altitude, m above mean sea level.
    pub altitude_m: [f64; 2],
    /// Load factor.
    pub load_factor: [f64; 2],
    /// Largest distance from its start, m.
    pub distance_m: f64,
}
