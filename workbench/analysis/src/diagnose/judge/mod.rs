//! The verdicts.

mod additional;
mod advise;
mod facts;
pub(super) mod interval;
mod learning_problem;
mod lift;
pub(super) mod probable;
mod pruning;
mod sensor;
mod weak;

use std::collections::BTreeMap;

use kf_core::effect::EffectId;
use kf_core::sensor::Sensor;

use super::candidates::Candidate;
use super::diagnosis::{Diagnosis, SensorDiagnosis, Verdict};
use super::epochs::Epochs;
use super::excitation::{Excitation, excitation};
use super::information::Information;
use super::posterior::{Posterior, posterior};
use super::problem::Problem;
use super::repeatability::{Repeatability, repeatability};
use super::rivals::{Rivals, rivals};
use super::roughness::lacks_airspeed;
use super::search::{Explanation, Search};
use super::simplicity::simpler;
use super::suspects::{Suspects, White};
use crate::progress::{Cancelled, Progress, step};

/// A coefficient whose parts differ by more than this, in mean squares relative to the expected ones, comes
/// from a wrong formula. Only where sets have no probabilities.
const UNEVEN: f64 = 5.0;

/// Effects that look alike by the laws of flight, so that one replaces the other when the other's signal was
/// not recorded. Lift makes the load factor the product of the angle of attack and the dynamic pressure;
/// thrust and the angle of attack follow the airspeed; a sensor's temperature follows its warming up, and
/// slowly the time; a steady vibration is a bias. A dynamic pressure may be a part of an angle of attack only
/// beside its other part (`lift.rs`).
const STAND_INS: [(EffectId, EffectId); 7] = [
    (EffectId::BaroAngleOfAttack, EffectId::BaroDynamicPressure),
    (EffectId::BaroPropwash, EffectId::BaroDynamicPressure),
    (EffectId::BaroAcceleration, EffectId::BaroAngleOfAttack),
    (EffectId::BaroWarmUp, EffectId::BaroTemperature),
    (EffectId::BaroDrift, EffectId::BaroTemperature),
    (EffectId::ImuAccelBias, EffectId::ImuVibration),
    (EffectId::BaroDynamicPressure, EffectId::BaroAngleOfAttack),
];

/// Whether a set is a load factor and an angle of attack alone. No flight separates them where the load
/// factor fits better: it is measured at once, and a vane with a delay.
pub(super) fn is_lift(set: &[EffectId]) -> bool {
    set.len() == 2
        && [EffectId::BaroAcceleration, EffectId::BaroAngleOfAttack].iter().all(|effect| set.contains(effect))
}

/// The least probability at which an effect is a suspect: odds of 19 to 1.
pub(super) const SUSPECT: f64 = 0.05;

/// The probability from which on an effect is identified: all others together are less than one suspect. Of
/// the effects reported with 95 to 99 %, 45 of 48 act; of those reported with more, all but one in a hundred
/// (docs/blind-trials-history.md).
pub(super) const IDENTIFIED: f64 = 0.95;

pub(crate) struct Judge<'a> {
    pub(crate) problem: &'a Problem<'a>,
    pub(crate) held: Option<&'a Problem<'a>>,
    pub(super) candidates: &'a [Candidate],
    pub(crate) suspects: &'a Suspects<'a>,
    pub(super) epochs: &'a [Epochs],
    /// Whether the climb rate is measured.
    pub(super) has_climb_rate: bool,
}

/// What may act in one place.
pub(super) struct Set {
    /// Effects with their probabilities, the most probable first.
    pub(super) effects: Vec<(EffectId, f64)>,
    /// Effects that are too improbable to be listed, with their probabilities; none beside an identified one.
    pub(super) unlisted: Vec<(EffectId, f64)>,
    /// The probability that none acts, from [`SUSPECT`] on, and wherever the evidence was too little to choose
    /// one.
    pub(super) nothing: Option<f64>,
    /// Whether the first effect is identified; there is no other one then.
    pub(super) is_identified: bool,
}

impl Set {
    /// Whether it names an effect of a sensor (`None`: of the reference).
    fn concerns(&self, subject: Option<Sensor>) -> bool {
        let name = subject.map_or("gps", Sensor::name);
        self.effects.iter().any(|(effect, _)| effect.subject().name() == name)
    }
}

/// What the verdicts of all sensors rest on.
#[derive(Clone, Debug)]
pub(super) struct Findings {
    pub(super) explanation: Explanation,
    pub(super) information: Information,
    pub(super) white: White,
    pub(super) rivals: Vec<Rivals>,
    /// What may act on sensors for which nothing was chosen, where the climb rate is measured.
    pub(super) weak: Vec<Rivals>,
    pub(super) repeat: Vec<Repeatability>,
    /// The factor by which the variance of each chosen coefficient exceeds that of its fit.
    pub(super) inflation: Vec<f64>,
    /// Probabilities of sets of effects, where the climb rate is not measured.
    pub(super) posterior: Option<Posterior>,
}

impl Findings {
    /// Whether a coefficient is so much the same in all parts of the flights that its formula can be right.
    /// Sets with probabilities need no such limit: there, what an uneven coefficient explains counts less
    /// ([`super::weigher`]).
    fn is_even(&self, at: usize) -> bool {
        self.posterior.is_some() || self.repeat.get(at).is_none_or(|repeat| repeat.unevenness < UNEVEN)
    }
}

impl Judge<'_> {
    pub(super) fn verdicts(
        &self,
        search: &mut Search<'_>,
        mut explanation: Explanation,
        progress: &mut Progress<'_>,
    ) -> Result<(Diagnosis, Findings), Cancelled> {
        let posterior = if self.has_climb_rate {
            None
        } else {
            let posterior = posterior(search, self.suspects, self.problem, &explanation, progress)?;
            let columns = posterior.best();
            let fit = search.fit(&columns, &explanation.fit.values);
            explanation = Explanation { columns, fit };
            Some(posterior)
        };
        // The weakest effect is dropped while it may be chance, and several are while fewer explain as much;
        // the others are fitted again.
        loop {
            let without = |left_out: usize| -> Vec<usize> {
                explanation.columns.iter().copied().filter(|column| *column != left_out).collect()
            };
            let columns = if let Some(posterior) = &posterior {
                // From sets with probabilities, only what is most probably absent or what the held-out data
                // contradicts is dropped.
                match self.doubtful(posterior, &explanation).or_else(|| self.vetoed(&explanation)) {
                    Some(column) => without(column),
                    None => break,
                }
            } else if let Some(simpler) = simpler(self.problem, self.suspects, &explanation) {
                simpler
            } else if let Some(weakest) = self.weakest(&explanation) {
                without(weakest)
            } else if let Some(impossible) = self.impossible(&explanation) {
                without(impossible)
            } else if let Some(harmful) = self.harmful(&explanation) {
                without(harmful)
            } else {
                break;
            };
            let fit = search.fit(&columns, &explanation.fit.values);
            step(progress)?;
            explanation = Explanation { columns, fit };
        }
        let repeat = repeatability(self.problem, &explanation.fit.noise, &explanation.columns);
        let inflation = self.inflation(&explanation, &repeat);
        let rivals = if let Some(posterior) = &posterior {
            self.rivals_by(posterior, &explanation)
        } else {
            let mut rivals = rivals(search, self.suspects, self.problem, &explanation, &inflation);
            self.merge_cancelling(&explanation, &mut rivals);
            self.merge_lift(&explanation, &mut rivals);
            rivals
        };
        let information = self.suspects.information(self.problem, &explanation.fit.noise);
        let mut findings = Findings {
            white: White::of(self.problem, &explanation.fit.noise),
            explanation,
            information,
            rivals,
            weak: Vec::new(),
            repeat,
            inflation,
            posterior,
        };
        let mut sensors = self.sensors(&findings, progress)?;
        // Where something unknown acts, the fitted noise is wrong, and weak effects may only imitate it.
        if sensors.iter().all(|(_, sensor, _)| sensor.verdict != Verdict::UnknownEffect) {
            findings.weak = self.weak(search, &findings, progress)?;
            if !findings.weak.is_empty() {
                sensors = self.sensors(&findings, progress)?;
            }
        }

        let mut diagnosis = Diagnosis { noise: self.noise_facts(&findings), ..Diagnosis::default() };
        let mut largest = 0.0;
        let mut worst = Verdict::NoSignificantMisfit;
        for (subject, sensor, misfit_m) in sensors {
            if misfit_m > largest && sensor.verdict >= Verdict::Identified {
                largest = misfit_m;
                diagnosis.verdict = sensor.verdict;
            }
            if sensor.verdict < Verdict::Identified && subject.is_some() {
                worst = worst.max(sensor.verdict);
            }
            diagnosis.sensors.insert(subject.map_or("gps", Sensor::name).into(), sensor);
        }
        if diagnosis.verdict < Verdict::Identified {
            diagnosis.verdict = worst;
        }
        Ok((diagnosis, findings))
    }

    /// Every sensor's diagnosis, the reference's (`None`) last, with the size of its misfit, metres.
    fn sensors(
        &self,
        findings: &Findings,
        progress: &mut Progress<'_>,
    ) -> Result<Vec<(Option<Sensor>, SensorDiagnosis, f64)>, Cancelled> {
        let mut sensors = Vec::new();
        for subject in [Some(Sensor::ImuSlave), Some(Sensor::Baro), None] {
            if subject.is_some_and(|sensor| !self.epochs.iter().any(|e| e.series.has(sensor.index()))) {
                continue;
            }
            let (sensor, misfit_m) = self.sensor(findings, subject);
            step(progress)?;
            sensors.push((subject, sensor, misfit_m));
        }
        Ok(sensors)
    }

    /// What may act in the place of a chosen effect: the effect, its rivals, and those that lack their signal
    /// and would look like one of them, and so are as probable as it. Those below [`SUSPECT`] are not listed.
    /// Where something does act, the second one is: an error that several effects could cause is never
    /// attributed to one only because the others are improbable.
    pub(super) fn set(&self, rivals: &Rivals) -> Set {
        let own = self.candidates[rivals.column].effect();
        let mut set = vec![(own, 1.0)];
        let others = rivals.others.iter().zip(&rivals.odds);
        for (other, odds) in others.map(|(other, odds)| (self.candidates[*other].effect(), *odds)) {
            if !set.iter().any(|(effect, _)| *effect == other) {
                set.push((other, odds));
            }
        }
        for (seen, hidden) in self.stand_ins(rivals) {
            let odds = set.iter().find(|(effect, _)| *effect == seen).map(|(_, odds)| *odds);
            let at = set.iter().position(|(effect, _)| *effect == hidden);
            match (odds, at) {
                (Some(odds), None) => set.push((hidden, odds)),
                (Some(odds), Some(at)) => set[at].1 = set[at].1.max(odds),
                (None, _) => {}
            }
        }
        set.sort_by(|a, b| b.1.total_cmp(&a.1));
        let total = rivals.odds_of_nothing + set.iter().map(|(_, odds)| odds).sum::<f64>();
        for (_, odds) in &mut set {
            *odds /= total;
        }
        let nothing =
            Some(rivals.odds_of_nothing / total).filter(|nothing| rivals.is_weak || *nothing >= SUSPECT);
        let acts = rivals.acts.unwrap_or_else(|| set.first().map_or(0.0, |(_, probability)| *probability));
        if !rivals.is_weak && acts >= IDENTIFIED && set.first().is_some_and(|(effect, _)| *effect == own) {
            return Set { effects: vec![(own, acts)], unlisted: Vec::new(), nothing, is_identified: true };
        }
        let listed = set.iter().take_while(|(_, probability)| *probability >= SUSPECT).count();
        let listed = listed.max(if nothing.is_some() { 1 } else { 2 });
        let unlisted = set.split_off(listed.min(set.len()));
        Set { effects: set, unlisted, nothing, is_identified: false }
    }

    /// Pairs of effects of which the second is at least as probable as the first, because it would look like
    /// it.
    pub(super) fn stand_ins(&self, rivals: &Rivals) -> Vec<(EffectId, EffectId)> {
        let own = self.candidates[rivals.column].effect();
        let is_stand_in = |&(seen, hidden): &(EffectId, EffectId)| {
            // Without a thermometer every drift may be the temperature's. This is reported, but it is not a
            // set that a flight could resolve.
            if rivals.acts.is_some() && hidden == EffectId::BaroTemperature {
                return false;
            }
            if seen == EffectId::BaroDynamicPressure {
                return rivals.is_part_of_lift;
            }
            // The accelerometer is prompt and a vane is not. A better fit of the load factor than of the
            // angle of attack is no evidence of the cause.
            seen == EffectId::BaroAcceleration
                || (hidden == EffectId::BaroDynamicPressure && lacks_airspeed(self.epochs, hidden))
                || (rivals.is_stand_in && seen == own)
                || self.candidates.iter().enumerate().any(|(column, candidate)| {
                    candidate.effect() == hidden && self.epochs.iter().any(|epochs| !epochs.available[column])
                })
        };
        STAND_INS.into_iter().filter(is_stand_in).collect()
    }

    fn excitation(&self, findings: &Findings, subject: Option<Sensor>) -> Excitation {
        let columns: Vec<(usize, usize)> = self
            .one_an_effect(findings, subject)
            .into_iter()
            .filter_map(|column| Some((column, self.suspects.position(column)?)))
            .collect();
        let chosen = self.suspects.positions(&findings.explanation.columns);
        let mut excitation =
            excitation(&findings.information, self.candidates, &columns, &chosen, self.suspects.penalty());
        // Effects whose regressor does not move at all.
        for (column, candidate) in self.candidates.iter().enumerate() {
            let is_own = candidate.sensor() == subject && self.suspects.position(column).is_none();
            let is_available = self.epochs.iter().all(|epochs| epochs.available[column]);
            let is_known = self.problem.known.iter().any(|known| known.column == column);
            let has_other = columns.iter().any(|(c, _)| self.candidates[*c].effect() == candidate.effect());
            let is_listed =
                excitation.unseen.iter().any(|other| self.candidates[*other].effect() == candidate.effect());
            if is_own && is_available && !is_known && !has_other && !is_listed {
                excitation.unseen.push(column);
            }
        }
        excitation
    }

    /// Usable columns on a sensor.
    fn columns_on(&self, subject: Option<Sensor>) -> Vec<usize> {
        self.suspects
            .usable()
            .iter()
            .copied()
            .filter(|column| {
                let sensor = self.candidates[*column].sensor();
                sensor == subject || (subject.is_some() && sensor.is_none())
            })
            .collect()
    }

    /// For each effect on the subject, the column that fits best together with the chosen ones.
    pub(super) fn one_an_effect(&self, findings: &Findings, subject: Option<Sensor>) -> Vec<usize> {
        let mut best: BTreeMap<EffectId, (f64, usize)> = BTreeMap::new();
        for column in self.suspects.usable() {
            let candidate = &self.candidates[*column];
            if candidate.sensor() != subject {
                continue;
            }
            let is_chosen = findings.explanation.columns.contains(column);
            let rest = if is_chosen {
                f64::NEG_INFINITY
            } else {
                let picks = self.beside(findings, *column);
                findings.information.solve(&picks).map_or(f64::INFINITY, |solution| solution.rest)
            };
            let slot = best.entry(candidate.effect()).or_insert((rest, *column));
            if rest < slot.0 {
                *slot = (rest, *column);
            }
        }
        best.into_values().map(|(_, column)| column).collect()
    }

    /// The chosen columns of other effects, followed by this one.
    pub(super) fn columns_beside(&self, findings: &Findings, column: usize) -> Vec<usize> {
        let chosen = findings.explanation.columns.iter().copied();
        chosen.filter(|other| !self.suspects.same_effect(*other, column)).chain([column]).collect()
    }

    /// Their positions.
    pub(super) fn beside(&self, findings: &Findings, column: usize) -> Vec<usize> {
        self.suspects.positions(&self.columns_beside(findings, column))
    }
}

/// A set of columns plus one more, ascending.
fn with(columns: &[usize], column: usize) -> Vec<usize> {
    let mut columns = columns.to_vec();
    columns.push(column);
    columns.sort_unstable();
    columns
}
