//! Whether the probabilities of these trials are right.

use kf_core::effect::EffectId;

use super::draw::Kind;
use super::trial::Trial;
use crate::reliability::diagram;

/// The effects of flights in which nothing but the catalogue acts, by the probability that was said of each:
/// of one that is identified, and of those of a set.
#[must_use]
pub fn reliability(trials: &[Trial]) -> String {
    let mut said: Vec<(f64, bool)> = Vec::new();
    for trial in trials {
        if matches!(trial.case.kind, Kind::Outside(..) | Kind::SmoothedGps(_)) {
            continue;
        }
        for candidate in trial.diagnosis.sensors.values().flat_map(|sensor| &sensor.candidates) {
            if let (Some(effect), Some(probability)) =
                (EffectId::from_name(&candidate.effect), candidate.probability)
            {
                said.push((probability, trial.truth.iter().any(|(acts, _)| *acts == effect.name())));
            }
        }
    }
    diagram(&said)
}
