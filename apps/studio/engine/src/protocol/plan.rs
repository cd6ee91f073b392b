//! Planning the next flight: what it would consist of, and what it would show.

use analysis::diagnose::Outlook;
use planning::{FlightPlan, Offer, PlannedSegment, Reached};
use serde::{Deserialize, Serialize};

use super::{ModelText, TimesByFlight};

/// Plans a flight, simulates it, and reports what it would add to the existing flights.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct PlanRequest {
    /// The flights to learn from.
    pub flights: Vec<String>,
    /// The held-out flights.
    pub hold_outs: Vec<String>,
    /// The model.
    pub model: ModelText,
    /// The user's times for them.
    pub times: TimesByFlight,
    /// The plan; null: the one that Pylon suggests, with the gain of each manoeuvre by itself.
    pub plan: Option<FlightPlan>,
}

/// A planned flight.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Planned {
    /// The plan.
    pub plan: FlightPlan,
    /// What it would show.
    pub outlook: Outlook,
    /// The simulated scenario, which `pylon simulate` accepts.
    pub scenario: String,
    /// Its segments, for the flight card.
    pub segments: Vec<PlannedSegment>,
    /// The ranges that it reaches.
    pub reached: Reached,
    /// Its duration including the calibration, seconds.
    pub duration_s: f64,
    /// The manoeuvres on offer, best first if their gains were asked for.
    pub offers: Vec<Offer>,
    /// Remarks for the user.
    pub remarks: Vec<String>,
}
