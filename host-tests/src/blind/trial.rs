//! One trial: fly, diagnose, compare with the truth.

use model::Model;
use pylon::diagnose::{Diagnosis, NamedReplay, OneOf, SensorDiagnosis, Verdict, diagnose};
use pylon::replay::Replay;
use pylon::simulate::scenario::{Effect, EffectId};

use super::advised::{Advised, advised};
use super::draw::{Case, Kind};
use super::flight::{Flown, fly};
use super::improvement::{Improvement, improvement};
use super::intervals::Deviation;

/// Result of a trial.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The case drawn.
    pub case: Case,
    /// Names of the injected effects, and their rms in free flight over the residual's noise, the strongest
    /// first.
    pub truth: Vec<(&'static str, f64)>,
    /// The diagnosis.
    pub diagnosis: Diagnosis,
    /// Deviations of the identified effects' coefficients from the truth.
    pub deviations: Vec<Deviation>,
    /// Effect of adding the identified effects on another flight of the same aircraft; `None` where none was
    /// injected or none identified.
    pub improvement: Option<Improvement>,
    /// What came of the plan that was advised for the sets, if it was to be flown.
    pub advised: Option<Advised>,
}

impl Trial {
    /// Ids of the identified effects.
    #[must_use]
    pub fn identified(&self) -> Vec<&'static str> {
        self.diagnosis
            .missing()
            .filter_map(kf_core::effect::EffectId::from_name)
            .map(kf_core::effect::EffectId::name)
            .collect()
    }

    /// Whether an effect is identified that does not act.
    #[must_use]
    pub fn is_wrong(&self) -> bool {
        self.identified().iter().any(|id| !self.truth.iter().any(|(true_id, _)| true_id == id))
    }

    /// Whether an effect is identified, or in a set that can't be distinguished.
    #[must_use]
    pub fn holds(&self, id: &str) -> bool {
        self.diagnosis.missing().chain(self.diagnosis.suspects()).any(|said| said == id)
    }

    /// The sets that the diagnosis reports. One that concerns several sensors is one set.
    #[must_use]
    pub fn sets(&self) -> Vec<OneOf<'_>> {
        let mut found: Vec<OneOf<'_>> =
            self.diagnosis.sensors.values().flat_map(SensorDiagnosis::sets).collect();
        found.sort_by_key(|set| set.effects);
        found.dedup_by_key(|set| set.effects);
        found
    }

    /// Whether one of a set's effects acts.
    #[must_use]
    pub fn has_cause(&self, set: &OneOf<'_>) -> bool {
        self.truth.iter().any(|(id, _)| set.effects.iter().any(|own| own == id))
    }

    /// Whether one of a set's effects acts, or none acts and the set says that this is possible.
    #[must_use]
    pub fn has_truth(&self, set: &OneOf<'_>) -> bool {
        let is_null = matches!(self.case.kind, Kind::Null | Kind::Glitch(_));
        self.has_cause(set) || is_null && set.nothing.is_some()
    }

    /// For each set with the probability of nothing: the probability that one of its effects acts, and whether
    /// one does.
    #[must_use]
    pub fn perhaps(&self) -> Vec<(f64, bool)> {
        let sets = self.sets().into_iter().filter(|set| set.nothing.is_some());
        sets.map(|set| (set.probabilities.iter().sum(), self.has_cause(&set))).collect()
    }

    /// Whether the flight has the signals that an effect needs.
    #[must_use]
    pub fn could_test(&self, id: &str) -> bool {
        !self.diagnosis.untested.iter().any(|untested| untested.effect == id)
    }

    /// Whether any sensor has this verdict.
    #[must_use]
    pub fn has_verdict(&self, verdict: Verdict) -> bool {
        self.diagnosis.sensors.values().any(|sensor| sensor.verdict == verdict)
    }
}

/// Runs a case, and flies the plan that is advised for its sets if `flies_advice`.
///
/// # Errors
/// If the aircraft can't fly the plan.
pub fn run(case: Case, flies_advice: bool) -> anyhow::Result<Trial> {
    let Flown { flight, effects, noise_m } = fly(&case, 0)?;
    let model = Model::default();
    let replay = Replay::new(&flight, &model, None)?;
    let named = NamedReplay::new(format!("blind {}", case.seed), replay);
    let diagnosis = diagnose(&[named], &[], &mut || ());
    let mut truth: Vec<(&'static str, f64)> =
        effects.iter().map(|(effect, size_m)| (effect.id.name(), size_m / noise_m)).collect();
    if let Kind::SmoothedGps(_) = case.kind {
        // For slow motions, a low pass acts as a delay.
        truth.push((EffectId::GpsLatency.name(), 0.0));
    }
    let mut deviations = Vec::new();
    for sensor in diagnosis.sensors.values() {
        for candidate in &sensor.candidates {
            let injected = effects.iter().find(|(effect, _)| effect.id.name() == candidate.effect);
            if let (true, Some((effect, _))) = (sensor.missing.contains(&candidate.effect), injected) {
                deviations.push(Deviation {
                    effect: effect.id.name(),
                    truth: effect.coefficient,
                    error: candidate.coefficient - effect.coefficient,
                    sigma: candidate.sigma,
                });
            }
        }
    }
    let mut trial = Trial { case, truth, diagnosis, deviations, improvement: None, advised: None };
    if flies_advice && trial.diagnosis.suspects().next().is_some() {
        let acting: Vec<&str> = trial.truth.iter().map(|(id, _)| *id).collect();
        trial.advised = advised(&trial.case, &flight, &acting)?;
    }
    let identified = trial.identified();
    if !identified.is_empty() && !effects.is_empty() {
        let next = fly(&trial.case, 1)?.flight;
        let injected: Vec<Effect> = effects.into_iter().map(|(effect, _)| effect).collect();
        trial.improvement = Some(improvement(&flight, &next, &identified, &injected)?);
    }
    Ok(trial)
}
