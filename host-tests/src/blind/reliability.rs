//! Whether the probabilities reported in these trials are right.

use kf_core::effect::EffectId;

use super::draw::Kind;
use super::trial::Trial;
use crate::reliability::diagram;

/// The effects of flights in which only the catalogue's effects act, by the reported probability of each: of
/// an identified effect, and of those in a set.
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
