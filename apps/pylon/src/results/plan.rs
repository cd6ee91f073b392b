//! JSON result of `pylon plan`.

use analysis::diagnose::{Diagnosis, Outlook};
use planning::shortest::{Aim, Shortest};
use planning::{Circumstances, FlightPlan, PlannedSegment, Reached};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::VERSION;
use crate::diagnose::text::headline;

/// `pylon plan --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlanResult {
    /// Version of these keys.
    pub version: u32,
    /// The model.
    pub model: String,
    /// The scenario's file; null if none was asked for.
    pub file: Option<String>,
    /// What the diagnosis of the flights says.
    pub headline: String,
    /// The diagnosis's advice on what these flights leave open: what to fly or to record.
    pub advice: Vec<String>,
    /// What the plan is for.
    pub aim: Aim,
    /// Whether it resolves every set, or shows every effect, with a probability of 90 %.
    pub is_enough: bool,
    /// The plan.
    pub plan: FlightPlan,
    /// Its segments.
    pub segments: Vec<PlannedSegment>,
    /// The ranges that the simulated flight reaches.
    pub reached: Reached,
    /// Its duration including the calibration, seconds.
    pub duration_s: f64,
    /// What it would show, together with the flights.
    pub outlook: Outlook,
    /// Remarks for the user.
    pub remarks: Vec<String>,
}

impl PlanResult {
    /// The result of a search for the flights of this diagnosis.
    #[must_use]
    pub fn new(diagnosis: &Diagnosis, found: &Shortest, around: &Circumstances) -> Self {
        let open = diagnosis.sensors.values().filter(|sensor| sensor.sets().next().is_some());
        let mut advice: Vec<String> = open.map(|sensor| sensor.advice.clone()).collect();
        advice.sort();
        advice.dedup();
        Self {
            version: VERSION,
            model: diagnosis.model.clone(),
            file: None,
            headline: headline(diagnosis),
            advice,
            aim: found.aim,
            is_enough: found.is_enough(),
            plan: found.plan.clone(),
            segments: found.flown.segments(&found.plan),
            reached: found.flown.reached(),
            duration_s: found.flown.scenario.duration_s(),
            outlook: found.flown.outlook.clone(),
            remarks: around.remarks(),
        }
    }
}
