//! One sensor's verdict, from the places at which effects were found and from what none of them explains.
//!
//! | strongest place | remainder | verdict |
//! |---|---|---|
//! | any, or none | much | unknown effect |
//! | one effect | little | identified |
//! | several effects, or one or none | little | indistinguishable |
//! | an impossible effect | little | unknown effect |
//! | none | little | no significant misfit, or insufficient excitation |

use kf_core::sensor::Sensor;

use super::super::diagnosis::{SensorDiagnosis, Verdict};
use super::super::roughness::lacks_airspeed;
use super::super::unknown;
use super::{Findings, Judge, Set};
use crate::name::Name;

/// The unexplained remainder decides the verdict when it is more than this share of what was explained.
const REST: f64 = 0.25;

/// What the chosen effects mean for one sensor.
#[derive(Default)]
struct Places {
    /// The largest: its size, metres, and its verdict.
    strongest: Option<(f64, Verdict)>,
    /// Evidence that all of them explain together.
    explained: f64,
    /// The effects that stand alone, the largest first.
    missing: Vec<Name>,
    /// The effects that do not, with their probabilities.
    sets: Vec<(Vec<Name>, Vec<f64>)>,
    /// For each of these sets, the probability that nothing acts, if it is not small.
    nothing: Vec<Option<f64>>,
}

impl Places {
    fn add(&mut self, set: &Set) {
        let effects = set.effects.iter();
        // Two places that may be the same effects are one set.
        let names: Vec<&str> = effects.clone().map(|(effect, _)| effect.name()).collect();
        let is_same = |(other, _): &(Vec<Name>, Vec<f64>)| {
            other.len() == names.len() && names.iter().all(|name| other.iter().any(|own| **own == **name))
        };
        if set.effects.len() > 1 && self.sets.iter().any(is_same) {
            return;
        }
        self.sets.push(effects.map(|(effect, odds)| (Name::from(effect.name()), *odds)).unzip());
        self.nothing.push(set.nothing);
    }
}

/// What no effect explains on one sensor.
#[derive(Default)]
struct Remainder {
    /// Its evidence.
    evidence: f64,
    /// Whether a signal that is in no effect explains more than the effects.
    is_better: bool,
    /// Its size, metres.
    size_m: f64,
}

impl Remainder {
    /// Whether it is too much for the explained part to be the cause. Wind makes a formula that lacks the
    /// airspeed more wrong than a signal can be right by chance.
    fn is_much(&self, explained: f64, lacks_airspeed: bool) -> bool {
        if lacks_airspeed {
            self.evidence > explained
        } else {
            self.is_better || self.evidence > REST * explained
        }
    }
}

impl Judge<'_> {
    /// One sensor's diagnosis (`None`: the reference), and the size of its misfit, metres.
    pub(super) fn sensor(&self, findings: &Findings, subject: Option<Sensor>) -> (SensorDiagnosis, f64) {
        let mut diagnosis = SensorDiagnosis::default();
        let places = self.places(findings, subject);
        let remainder = match subject.filter(|sensor| sensor.flies_free()) {
            Some(sensor) => self.remainder(findings, sensor, places.explained, &mut diagnosis),
            None => Remainder::default(),
        };
        // With one sensor against the receiver, what the receiver's effects explain counts as explained on it
        // too.
        let explained = if findings.posterior.is_some() && subject.is_some() && self.problem.is_alone() {
            findings.rivals.iter().map(|rivals| rivals.explained).sum()
        } else {
            places.explained
        };
        let is_unknown = remainder.is_much(explained, self.lacks_airspeed_for(findings, subject));
        diagnosis.verdict = match places.strongest {
            _ if is_unknown => Verdict::UnknownEffect,
            Some((_, verdict)) => verdict,
            None => self.quiet(findings, subject),
        };
        // For an unknown effect, the chosen one may only be the most similar to what really acts.
        if !is_unknown {
            diagnosis.missing = places.missing;
            (diagnosis.indistinguishable, diagnosis.probabilities) = places.sets.into_iter().unzip();
            diagnosis.nothing = places.nothing;
        }
        diagnosis.advice = self.advise(findings, subject, &diagnosis);
        diagnosis.candidates = self.candidate_facts(findings, subject);
        if findings.posterior.is_none() {
            // A place whose verdict is an unknown effect, or nothing, has no probability.
            let is_reported = |effect: &Name| {
                diagnosis.missing.contains(effect)
                    || diagnosis.indistinguishable.iter().any(|set| set.contains(effect))
            };
            for candidate in &mut diagnosis.candidates {
                candidate.probability = candidate.probability.filter(|_| is_reported(&candidate.effect));
            }
        }
        let size_m = places.strongest.map_or(0.0, |(size_m, _)| size_m.max(0.0));
        (diagnosis, size_m.max(remainder.size_m))
    }

    fn places(&self, findings: &Findings, subject: Option<Sensor>) -> Places {
        let mut places = Places::default();
        let mut sized: Vec<(f64, usize)> = Vec::new();
        // A smaller misfit may be the remainder of a larger one that no effect can cause.
        let beyond = (0..findings.rivals.len()).filter(|k| self.is_beyond(findings, *k));
        let explained_beyond = beyond.map(|k| findings.rivals[k].explained).fold(0.0, f64::max);
        for (k, rivals) in findings.rivals.iter().enumerate() {
            let set = self.set(rivals);
            if !set.concerns(subject) {
                continue;
            }
            let size_m = self.size_m(findings, rivals.column);
            places.explained += rivals.explained;
            let can_be_an_effect =
                findings.is_even(k) && rivals.explained >= explained_beyond && !self.is_beyond(findings, k);
            let verdict = if !can_be_an_effect {
                Verdict::UnknownEffect
            } else if set.is_identified {
                sized.push((size_m, k));
                Verdict::Identified
            } else {
                places.add(&set);
                Verdict::Indistinguishable
            };
            if places.strongest.is_none_or(|(size, _)| size_m > size) {
                places.strongest = Some((size_m, verdict));
            }
        }
        if places.strongest.is_none() {
            for rivals in &findings.weak {
                let set = self.set(rivals);
                if !set.concerns(subject) {
                    continue;
                }
                let size_m = self.size_m(findings, rivals.column);
                places.explained += rivals.explained;
                places.strongest = Some((size_m, Verdict::Indistinguishable));
                places.add(&set);
            }
        }
        sized.sort_by(|a, b| b.0.total_cmp(&a.0));
        let effect = |k: usize| self.candidates[findings.rivals[k].column].effect();
        places.missing = sized.iter().map(|(_, k)| effect(*k).name().into()).collect();
        places
    }

    /// What no effect explains on a sensor in free flight. The diagnosis records which signals it follows,
    /// and by how much the sensor is noisier in free flight.
    fn remainder(
        &self,
        findings: &Findings,
        sensor: Sensor,
        explained: f64,
        diagnosis: &mut SensorDiagnosis,
    ) -> Remainder {
        let explanation = &findings.explanation;
        let own: Vec<usize> = self.columns_on(Some(sensor));
        let found = unknown::unexplained(
            self.problem,
            self.epochs,
            &explanation.fit,
            &explanation.columns,
            &own,
            explained,
            sensor.index(),
            unknown::Doubts { is_alone: self.problem.is_alone(), has_climb_rate: self.has_climb_rate },
        );
        let mut remainder = Remainder { is_better: found.is_better, ..Remainder::default() };
        if let Some(first) = found.follows.first() {
            remainder.evidence = first.evidence;
            remainder.size_m = first.size_m;
        }
        diagnosis.follows = found.follows;
        let noise = &explanation.fit.noise.sensors[sensor.index()];
        if self.epochs.iter().any(|epochs| epochs.series.has_both_phases()) {
            diagnosis.free_flight_factor = Some(noise.free_flight_factor);
        }
        let excess = unknown::free_flight_excess(
            self.problem,
            &explanation.fit,
            &explanation.columns,
            sensor.index(),
            self.regressors_noise_m2(findings, sensor),
        );
        // A receiver is noisier in the air than on the ground, too.
        if let Some(excess) = excess.filter(|_| !self.problem.is_alone()) {
            remainder.evidence += excess;
            let wander_m = noise.free_flight_factor * noise.wander.sigma_m;
            remainder.size_m = remainder.size_m.max(wander_m).max(noise.free_white_m);
        }
        remainder
    }

    /// The verdict of a sensor that shows nothing.
    fn quiet(&self, findings: &Findings, subject: Option<Sensor>) -> Verdict {
        if subject.is_none() || self.excitation(findings, subject).is_enough() {
            Verdict::NoSignificantMisfit
        } else {
            Verdict::InsufficientExcitation
        }
    }

    /// Whether an effect chosen on a sensor is computed from an airspeed that was not measured.
    fn lacks_airspeed_for(&self, findings: &Findings, subject: Option<Sensor>) -> bool {
        findings.explanation.columns.iter().any(|column| {
            let candidate = &self.candidates[*column];
            candidate.sensor() == subject && lacks_airspeed(self.epochs, candidate.effect())
        })
    }
}
