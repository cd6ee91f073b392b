//! Evidence against an effect that was learned.

use kf_core::effect::EffectId;
use model::Effect;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::diagnose::{Diagnosis, HeldOutVerdict, SensorDiagnosis, Verdict};

/// A coefficient within this many sigmas of zero is treated as absent.
const SIGNIFICANT_SIGMAS: f64 = 3.0;

/// The data on which the errors before and after were computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum JudgedOn {
    /// The held-out flights, by the mission; if one of them has nothing to calibrate on, all of them about
    /// biases fitted to them.
    HeldOutFlights,
    /// Stretches of the learning flights, each predicted from the rest.
    HeldOutManoeuvres,
}

/// The evidence against an effect; `wanted` is its name in the diagnosis.
pub(super) fn concerns(
    diagnosis: &Diagnosis,
    wanted: EffectId,
    effect: &Effect,
    sigma_to_zero: f64,
    judged_on: JudgedOn,
    judged_m: [Option<f64>; 2],
    verdict: &HeldOutVerdict,
) -> Vec<String> {
    let mut concerns = Vec::new();
    let term = &effect.term;
    let name = wanted.name();
    let sigmas = f64::from(term.coefficient.abs()) / sigma_to_zero;
    if sigmas < SIGNIFICANT_SIGMAS || sigmas.is_nan() {
        let is_identified =
            diagnosis.sensors.values().any(|sensor| sensor.missing.iter().any(|other| other == name));
        let what = if is_identified {
            "these flights show that it acts, but not how large it is"
        } else {
            "these flights can't identify it"
        };
        concerns.push(format!(
            "{what}: the coefficient {} is within {SIGNIFICANT_SIGMAS} sigma ({}) of zero",
            term.coefficient,
            super::addition::rounded(sigma_to_zero, sigma_to_zero)
        ));
    }
    let mut sets = diagnosis.sensors.values().flat_map(SensorDiagnosis::sets);
    if let Some(set) = sets.find(|set| set.effects.iter().any(|other| other == name)) {
        let others: Vec<&str> =
            set.effects.iter().map(|other| &**other).filter(|other| *other != name).collect();
        let why = if others.is_empty() {
            "they can't show whether it acts".to_owned()
        } else {
            format!("they can't distinguish it from {}", others.join(", "))
        };
        concerns.push(format!("these flights can't identify it: {why} (see `pylon diagnose`)"));
    }
    if verdict.is_worse {
        let [before, after] =
            judged_m.map(|rms_m| rms_m.map_or_else(|| "-".to_owned(), |m| format!("{m:.3}")));
        concerns.push(format!(
            "the held-out {} are less likely with it, beyond chance: twice the log likelihood changes by {:.1}, chance is \
             {:.1} (1 sigma); raw rms {before} m before, {after} m after",
            held_out_name(judged_on),
            verdict.gain,
            verdict.gain_sigma
        ));
    }
    concerns
}

/// Name of the held-out data, in the plural.
pub(super) const fn held_out_name(judged_on: JudgedOn) -> &'static str {
    match judged_on {
        JudgedOn::HeldOutFlights => "flights",
        JudgedOn::HeldOutManoeuvres => "manoeuvres",
    }
}

/// What a test that cannot decide leaves open.
pub(super) fn undecided(judged_on: JudgedOn, verdict: &HeldOutVerdict) -> Option<String> {
    (!verdict.can_tell && !verdict.is_worse).then(|| {
        format!(
            "the held-out {} can't show whether it acts there: it would change them by less than chance",
            held_out_name(judged_on)
        )
    })
}

/// What the user should know from a diagnosis besides the concerns.
pub(super) fn doubts(diagnosis: &Diagnosis, effect: EffectId) -> Vec<String> {
    let mut doubts = Vec::new();
    let subject = effect.subject().name();
    if let Some(sensor) = diagnosis.sensors.get(subject) {
        if sensor.verdict == Verdict::UnknownEffect {
            doubts.push(format!("nothing in the catalogue explains all of {subject}'s misfit: this effect may stand in for another"));
        }
        let others: Vec<&str> =
            sensor.missing.iter().map(|other| &**other).filter(|other| *other != effect.name()).collect();
        if !others.is_empty() {
            doubts.push(format!("the model lacks {} as well", others.join(", ")));
        }
    }
    doubts
}
