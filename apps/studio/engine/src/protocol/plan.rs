//! Planning the next flight: what would be flown, and what it would tell.

use analysis::diagnose::Outlook;
use serde::{Deserialize, Serialize};

use super::{ModelText, TimesByFlight};

/// What can be flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum PlannedManoeuvre {
    /// Faster and slower than cruise by the amount, m/s, at constant altitude.
    SpeedSweep,
    /// Climbs and descents at a path of the amount, degrees, level between them.
    Climbs,
    /// Pull-ups and push-overs, up to the amount as a load factor and down by as much below one.
    PullUps,
    /// Level turns to both sides at a bank of the amount, degrees.
    Turns,
    /// Straight and level; it has no amount.
    Level,
    /// One long climb at a path of the amount, degrees, level, and back down.
    LongClimb,
    /// Straight legs with acceleration and braking by the amount, m/s, each turned by 90 degrees from the
    /// last.
    Legs,
}

/// A part of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct PlannedLeg {
    /// What is flown.
    pub manoeuvre: PlannedManoeuvre,
    /// How much of it, in the unit that the offer says.
    pub amount: f64,
    /// How long each of its stretches is held, seconds.
    pub duration_s: f64,
    /// How often it is flown.
    pub times: u32,
}

/// A flight that is planned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FlightPlan {
    /// True airspeed of straight and level flight, m/s.
    pub speed_mps: f64,
    /// Altitude at which it begins, m above mean sea level.
    pub altitude_m: f64,
    /// How long it flies straight and level before, for the calibration, seconds.
    pub calibration_s: f64,
    /// What is flown after that.
    pub legs: Vec<PlannedLeg>,
}

/// Plans a flight, simulates it, and says what it would tell with the flights that there are.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct PlanRequest {
    /// The flights to learn from.
    pub flights: Vec<String>,
    /// The flights to judge by.
    pub hold_outs: Vec<String>,
    /// The model.
    pub model: ModelText,
    /// What the user says of their times.
    pub times: TimesByFlight,
    /// The plan; null: the one that Pylon suggests, with what each manoeuvre would tell by itself.
    pub plan: Option<FlightPlan>,
}

/// What a manoeuvre by itself would tell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Gain {
    /// The probability that it would give the effect of a set that acts, the mean over the sets; null where
    /// there is no set.
    pub tells_apart: Option<f64>,
    /// Effects that it would show and that no flight has.
    pub shows: u32,
    /// What an effect's interval would shrink to, as a share: the mean over the effects that the flights
    /// show.
    pub narrows_to: f64,
}

/// A manoeuvre that can be chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Offer {
    /// It, as it is suggested.
    pub leg: PlannedLeg,
    /// What the amount is: `m/s`, `deg`, `g`; empty where there is none.
    pub unit: String,
    /// The least amount.
    pub least: f64,
    /// The largest.
    pub most: f64,
    /// What it would tell by itself; null where that was not asked, or it cannot be flown there.
    pub gain: Option<Gain>,
}

/// One segment, as the scenario has it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct PlannedSegment {
    /// `straight`, `climb`, `dive`, `level_off`, `pull_up`, `turn`, `accelerate`, `decelerate`.
    pub manoeuvre: String,
    /// From when, seconds after the calibration.
    pub from_s: f64,
    /// How long, seconds.
    pub duration_s: f64,
    /// The airspeed to hold, m/s.
    pub airspeed_mps: f64,
    /// The path to fly, degrees above the horizon, where it has one.
    pub flight_path_deg: Option<f64>,
    /// The bank, degrees, positive to the right, where it has one.
    pub bank_deg: Option<f64>,
    /// The load factor's limit, where it has one.
    pub load_factor: Option<f64>,
    /// Altitude at its end as simulated, m above mean sea level.
    pub altitude_then_m: f64,
}

/// The least and the greatest of what the simulated flight reaches.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Reached {
    /// True airspeed, m/s.
    pub airspeed_mps: [f64; 2],
    /// Altitude, m above mean sea level.
    pub altitude_m: [f64; 2],
    /// Load factor.
    pub load_factor: [f64; 2],
    /// Farthest from where it begins, m.
    pub distance_m: f64,
}

/// A planned flight.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Planned {
    /// The plan.
    pub plan: FlightPlan,
    /// What it would tell.
    pub outlook: Outlook,
    /// It as a scenario: what `pylon simulate` takes, and what was simulated here.
    pub scenario: String,
    /// Its segments, for the flight card.
    pub segments: Vec<PlannedSegment>,
    /// What it reaches.
    pub reached: Reached,
    /// How long it takes, calibration included, seconds.
    pub duration_s: f64,
    /// What can be chosen, the best first where their gains were asked for.
    pub offers: Vec<Offer>,
    /// What the user should know of it.
    pub remarks: Vec<String>,
}
