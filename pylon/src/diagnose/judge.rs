//! From flights to verdicts.

use std::collections::BTreeMap;

use kf_core::effect::EffectId;
use kf_core::sensor::{SENSORS, Sensor};
use statrs::distribution::{ContinuousCDF as _, Normal};

use super::advice;
use super::candidates::{Candidate, catalogue};
use super::diagnosis::{
    CandidateFacts, DiagnosedFlight, Diagnosis, NoiseFacts, SensorDiagnosis, Untested, Verdict,
};
use super::epochs::{Epochs, epochs};
use super::excitation::excitation;
use super::held_out::{self, HeldOut};
use super::information::Information;
use super::lesson::{Lesson, Wish};
use super::long_run;
use super::manoeuvres::Trim;
use super::noise::NoisePrior;
use super::problem::{Known, Problem};
use super::repeatability::{Repeatability, repeatability};
use super::rivals::{Rivals, rivals};
use super::search::{Explanation, Search};
use super::series::Series;
use super::signals;
use super::unknown;
use crate::replay::Replay;

/// Corrected for the number of effects tried, a chosen effect must be less likely than this to be chance.
const SIGNIFICANT: f64 = 0.01;
/// A coefficient whose parts differ by more than this, in mean squares of what they should, comes from a
/// wrong formula.
const UNEVEN: f64 = 5.0;
/// An effect without which held-out errors shrink below this share of themselves does not repeat.
const HARMFUL: f64 = 0.95;
/// The share of a coefficient that is unsure beside its noise: signals are measured with delays and scale
/// errors of their own.
const SCALE: f64 = 0.02;
/// The same where a regressor is integrated twice from what accelerometers and attitudes say.
const SCALE_INTEGRATED: f64 = 0.05;
/// The same where the airspeed is not measured and the speed over ground stands in: wind.
const SCALE_WITHOUT_AIRSPEED: f64 = 0.2;
/// Effects are cancelling each other when each is so many times larger than their sum.
const CANCELLING: f64 = 2.5;
/// What remains unexplained makes the verdict when it is more than this share of what was explained.
const REST: f64 = 0.25;

/// A flight ready to be replayed, and what the user calls it.
pub struct NamedReplay<'a> {
    /// The file.
    pub file: String,
    /// The flight, the model and the calibration.
    pub replay: Replay<'a>,
}

/// Finds what the model lacks; all replays have the same model. `progress` is called once a fit.
#[must_use]
pub fn diagnose(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    progress: &mut dyn FnMut(),
) -> Diagnosis {
    work(flights, hold_outs, None, progress).0
}

/// A diagnosis, and what one effect's coefficient is learned from.
pub(super) fn work(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    wish: Option<Wish>,
    progress: &mut dyn FnMut(),
) -> (Diagnosis, Option<Lesson>) {
    let Some(first) = flights.first() else { return (Diagnosis::default(), None) };
    let model = first.replay.model();
    let mut candidates = catalogue();
    if let Some(wish) = wish {
        wish.narrow(&mut candidates);
    }
    let known_ids: Vec<EffectId> = model.effects.iter().map(|effect| effect.term.regressor.id).collect();
    candidates.retain(|candidate| !known_ids.contains(&candidate.effect()));
    let tried = candidates.len();
    let mut known = Vec::new();
    for effect in model.effects.iter().filter(|effect| effect.term.sigma > 0.0) {
        known.push(Known { column: candidates.len(), sigma: f64::from(effect.term.sigma) });
        candidates.push(Candidate { regressor: effect.term.regressor });
    }
    let prepare = |named: &NamedReplay<'_>| epochs(&named.replay, &candidates);
    let mut epochs: Vec<Epochs> = flights.iter().map(prepare).collect();
    let mut held: Vec<Epochs> = hold_outs.iter().map(prepare).collect();
    let wind = wind(&mut epochs, &mut held);
    let held: Vec<Series> = held.into_iter().map(|epochs| epochs.series).collect();
    let series: Vec<Series> = epochs.iter().map(|epochs| epochs.series.clone()).collect();

    let available = |column: usize| epochs.iter().all(|epochs| epochs.available[column]);
    known.retain(|known| available(known.column));
    known.extend(wind);
    let prior = NoisePrior::new(&series, &model.reference, &model.sensors);
    let problem = Problem::new(&series, prior.clone(), known.clone());
    let held_problem = Problem::new(&held, prior.clone(), known);
    let tried: Vec<usize> = (0..tried).filter(|column| available(*column)).collect();
    let first_look = problem.information(&prior.noise(&prior.means()), &tried);
    let usable: Vec<usize> = tried
        .iter()
        .enumerate()
        .filter(|(position, _)| first_look.is_excited(*position))
        .map(|(_, column)| *column)
        .collect();

    let mut column_noise_m2 = vec![0.0_f64; candidates.len()];
    for epochs in &epochs {
        for (most, noise_m2) in column_noise_m2.iter_mut().zip(&epochs.column_noise_m2) {
            *most = most.max(*noise_m2);
        }
    }
    let is_rough: Vec<bool> =
        candidates.iter().map(|candidate| is_rough(&epochs, candidate.effect())).collect();
    let mut search = Search::new(&problem, &candidates, usable, &column_noise_m2, &is_rough);
    let explanation = search.run(progress);
    let judge = Judge {
        problem: &problem,
        held: (!held.is_empty()).then_some(&held_problem),
        candidates: &candidates,
        epochs: &epochs,
    };
    let (mut diagnosis, findings) = judge.verdicts(&mut search, explanation, progress);
    diagnosis.flights = flights.iter().zip(&epochs).map(|(named, epochs)| facts(named, epochs)).collect();
    diagnosis.hold_outs = hold_outs.iter().map(|named| named.file.clone()).collect();
    diagnosis.untested = untested(&candidates, &epochs);
    let lesson = wish.and_then(|wish| judge.lesson(&mut search, findings, wish.effect));
    (diagnosis, lesson)
}

/// Sigma of what the wind adds to the barometer per m/s over ground where the airspeed is not measured: a port
/// that reads a third of the dynamic pressure, in 10 m/s of wind.
const WIND_M_PER_MPS: f64 = 0.3;

/// Where a flight has no airspeed, the two columns that its square lacks.
///
/// With the velocity v over ground and the wind w the airspeed's square is `|v|^2 - 2 v.w + |w|^2`: to the
/// squared speed over ground that stands in for it belong the two components of v, with a coefficient of each
/// flight's own. Load factor and angle of attack would have to do for them otherwise.
fn wind(epochs: &mut [Epochs], held: &mut [Epochs]) -> Vec<Known> {
    let lacks = |epochs: &Epochs| epochs.signals.iter().all(|block| !block[0].is_finite());
    if !epochs.iter().any(&lacks) {
        return Vec::new();
    }
    let mut known = Vec::new();
    for signal in signals::GROUND_VELOCITY {
        for epochs in epochs.iter_mut().chain(held.iter_mut()) {
            let is_needed = lacks(epochs);
            let component = epochs.signals.iter().map(|block| {
                let value = if is_needed && block[signal].is_finite() { block[signal] } else { 0.0 };
                std::array::from_fn(|i| if i == Sensor::Baro.index() { value } else { 0.0 })
            });
            let component = component.collect();
            epochs.series.columns.push(component);
        }
        let column = epochs.first().map_or(0, |epochs| epochs.series.columns.len() - 1);
        known.push(Known { column, sigma: WIND_M_PER_MPS });
    }
    known
}

/// Whether an effect's regressor is known only to some ten per cent: the airspeed is not measured, or it is
/// integrated twice from specific forces and attitudes, whose small errors grow.
fn is_rough(epochs: &[Epochs], effect: EffectId) -> bool {
    let is_integrated = matches!(
        effect,
        EffectId::ImuAccelScale | EffectId::ImuTilt | EffectId::ImuGyroBias | EffectId::ImuVibration
    );
    // A receiver that is late often filters as well, which is a delay for slow motions only.
    let is_filter = effect == EffectId::GpsLatency;
    is_integrated || is_filter || lacks_airspeed(epochs, effect)
}

/// Whether an effect is made of the airspeed and a flight has it not measured.
fn lacks_airspeed(epochs: &[Epochs], effect: EffectId) -> bool {
    effect.needs().contains(&"tas_mps")
        && epochs.iter().any(|epochs| epochs.signals.iter().all(|block| !block[0].is_finite()))
}

fn facts(named: &NamedReplay<'_>, epochs: &Epochs) -> DiagnosedFlight {
    DiagnosedFlight {
        file: named.file.clone(),
        calibration: named.replay.source().to_string(),
        blocks: epochs.series.len(),
        block_s: epochs.series.block_s,
        glitches_s: epochs.glitches_s.clone(),
        unreferenced_readings: epochs.unreferenced,
    }
}

/// Effects on sensors that the flights have, whose signals they have not.
fn untested(candidates: &[Candidate], epochs: &[Epochs]) -> Vec<Untested> {
    let mut untested: Vec<Untested> = Vec::new();
    for (column, candidate) in candidates.iter().enumerate() {
        let has_sensor =
            candidate.sensor().is_none_or(|sensor| epochs.iter().any(|e| e.series.has(sensor.index())));
        let is_missing = epochs.iter().any(|epochs| !epochs.available[column]);
        let effect = candidate.effect();
        if has_sensor && is_missing && !untested.iter().any(|other| other.effect == effect.name()) {
            untested.push(Untested { effect: effect.name(), needs: effect.needs().to_vec() });
        }
    }
    untested
}

/// Effects that look alike by the laws of flight, so that the one stands in for the other when its own
/// signal was not recorded: lift makes the load factor of the angle of attack times the dynamic pressure;
/// a sensor's temperature follows its warming up, and slowly the time; a steady vibration is a bias.
const STAND_INS: [(EffectId, EffectId); 4] = [
    (EffectId::BaroAcceleration, EffectId::BaroAngleOfAttack),
    (EffectId::BaroWarmUp, EffectId::BaroTemperature),
    (EffectId::BaroDrift, EffectId::BaroTemperature),
    (EffectId::ImuAccelBias, EffectId::ImuVibration),
];

pub(super) struct Judge<'a> {
    pub(super) problem: &'a Problem<'a>,
    held: Option<&'a Problem<'a>>,
    pub(super) candidates: &'a [Candidate],
    pub(super) epochs: &'a [Epochs],
}

/// What the verdicts of all sensors rest on.
pub(super) struct Findings {
    pub(super) explanation: Explanation,
    pub(super) information: Information,
    pub(super) rivals: Vec<Rivals>,
    pub(super) repeat: Vec<Repeatability>,
    /// By how much the variance of each chosen coefficient is larger than its fit's.
    pub(super) inflation: Vec<f64>,
}

impl Findings {
    fn is_even(&self, at: usize) -> bool {
        self.repeat.get(at).is_none_or(|repeat| repeat.unevenness < UNEVEN)
    }
}

impl Judge<'_> {
    fn verdicts(
        &self,
        search: &mut Search<'_>,
        mut explanation: Explanation,
        progress: &mut dyn FnMut(),
    ) -> (Diagnosis, Findings) {
        // The weakest goes while it may be chance, and several effects while fewer explain as much; the
        // others are fitted anew.
        loop {
            let without = |left_out: usize| -> Vec<usize> {
                explanation.columns.iter().copied().filter(|column| *column != left_out).collect()
            };
            let columns = if let Some(simpler) = search.simpler(&explanation) {
                simpler
            } else if let Some(weakest) = self.weakest(search, &explanation) {
                without(weakest)
            } else if let Some(harmful) = self.harmful(&explanation) {
                without(harmful)
            } else {
                break;
            };
            let fit = search.fit(&columns, &explanation.fit.values);
            progress();
            explanation = Explanation { columns, fit };
        }
        let mut rivals = rivals(search, self.problem, &explanation);
        self.merge_cancelling(search, &explanation, &mut rivals);
        let repeat = repeatability(self.problem, &explanation.fit.noise, &explanation.columns);
        let inflation = self.inflation(&explanation, &repeat);
        let information = search.information(&explanation.fit);
        let findings = Findings { explanation, information, rivals, repeat, inflation };

        let mut diagnosis = Diagnosis { noise: self.noise_facts(&findings), ..Diagnosis::default() };
        let mut largest = 0.0;
        let mut worst = Verdict::NoSignificantMisfit;
        for subject in [Some(Sensor::ImuSlave), Some(Sensor::Baro), None] {
            if subject.is_some_and(|sensor| !self.epochs.iter().any(|e| e.series.has(sensor.index()))) {
                continue;
            }
            let (sensor, misfit_m) = self.sensor(search, &findings, subject);
            progress();
            if misfit_m > largest && sensor.verdict >= Verdict::Identified {
                largest = misfit_m;
                diagnosis.verdict = sensor.verdict;
            }
            if sensor.verdict < Verdict::Identified && subject.is_some() {
                worst = worst.max(sensor.verdict);
            }
            diagnosis.sensors.insert(subject.map_or("gps", Sensor::name), sensor);
        }
        if diagnosis.verdict < Verdict::Identified {
            diagnosis.verdict = worst;
        }
        (diagnosis, findings)
    }

    /// Two effects that are each far larger than what they add up to are told apart by next to nothing:
    /// each becomes a rival of the other.
    fn merge_cancelling(&self, search: &Search<'_>, explanation: &Explanation, rivals: &mut [Rivals]) {
        let information = search.information(&explanation.fit);
        let Some(solution) = information.solve(&search.positions(&explanation.columns)) else { return };
        let terms: Vec<(usize, f64)> =
            explanation.columns.iter().copied().zip(solution.coefficients).collect();
        let largest = |sensor: usize| {
            let on: Vec<&(usize, f64)> = terms
                .iter()
                .filter(|(column, _)| {
                    self.candidates[*column].sensor().is_none_or(|own| own.index() == sensor)
                })
                .collect();
            let together_m = self.made_m(&on, sensor);
            on.into_iter()
                .filter(|term| self.made_m(&[*term], sensor) > CANCELLING * together_m)
                .map(|(column, _)| *column)
                .collect::<Vec<usize>>()
        };
        for sensor in Sensor::ALL {
            let cancelling = largest(sensor.index());
            for rival in rivals.iter_mut().filter(|rival| cancelling.contains(&rival.column)) {
                let others = cancelling.iter().filter(|column| **column != rival.column);
                rival.others.extend(others);
            }
        }
    }

    /// What some columns with their coefficients make of a sensor's residual in free flight, rms about the
    /// captive mean, metres.
    fn made_m(&self, terms: &[&(usize, f64)], sensor: usize) -> f64 {
        let mut sum = 0.0;
        let mut count = 0_u32;
        for epochs in self.epochs {
            let series = &epochs.series;
            let made = |block: usize| -> f64 {
                terms.iter().map(|(column, value)| value * series.columns[*column][block][sensor]).sum()
            };
            let of = |free: bool| {
                (0..series.len()).filter(move |b| series.free[*b] == free && series.readings[*b][sensor] > 0)
            };
            let captive = of(false).count();
            let base = if captive > 0 { of(false).map(made).sum::<f64>() / captive as f64 } else { 0.0 };
            for block in of(true) {
                sum += (made(block) - base).powi(2);
                count += 1;
            }
        }
        (sum / f64::from(count.max(1))).sqrt()
    }

    /// The effect among several without which the others predict held-out manoeuvres clearly better.
    fn harmful(&self, explanation: &Explanation) -> Option<usize> {
        if explanation.columns.len() < 2 {
            return None;
        }
        let noise = &explanation.fit.noise;
        let rms_m = |columns: &[usize]| held_out::manoeuvres(self.problem, noise, columns).rms_all_m();
        let with_all = rms_m(&explanation.columns)?;
        let without = explanation.columns.iter().filter_map(|left_out| {
            let columns: Vec<usize> =
                explanation.columns.iter().copied().filter(|column| column != left_out).collect();
            Some((*left_out, rms_m(&columns)?))
        });
        let best = without.min_by(|a, b| a.1.total_cmp(&b.1))?;
        (best.1 < HARMFUL * with_all).then_some(best.0)
    }

    /// The larger of what the spread over the parts and what the residual's autocorrelation say.
    pub(super) fn inflation(&self, explanation: &Explanation, repeat: &[Repeatability]) -> Vec<f64> {
        let long_run = long_run::inflation(self.problem, &explanation.fit.noise, &explanation.columns);
        let repeat = repeat.iter().map(|repeat| repeat.inflation).chain(std::iter::repeat(1.0));
        long_run.iter().zip(repeat).map(|(a, b)| a.max(b)).collect()
    }

    /// The chosen column that is most likely to be chance, if it may be.
    fn weakest(&self, search: &Search<'_>, explanation: &Explanation) -> Option<usize> {
        let information = search.information(&explanation.fit);
        let repeat = repeatability(self.problem, &explanation.fit.noise, &explanation.columns);
        let solution = information.solve(&search.positions(&explanation.columns))?;
        let n = explanation.columns.len();
        let inflation = self.inflation(explanation, &repeat);
        let chances = explanation.columns.iter().enumerate().map(|(k, column)| {
            let variance = solution.covariance[k * n + k] * inflation[k];
            (*column, self.chance(search, solution.coefficients[k], variance))
        });
        let worst = chances.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (worst.1 > SIGNIFICANT).then_some(worst.0)
    }

    /// Two-sided chance of a coefficient as large, times the number of effects tried.
    fn chance(&self, search: &Search<'_>, coefficient: f64, variance: f64) -> f64 {
        let mut effects: Vec<EffectId> =
            search.usable().iter().map(|column| self.candidates[*column].effect()).collect();
        effects.dedup();
        let Ok(normal) = Normal::new(0.0, 1.0) else { return 1.0 };
        let alone = 2.0 * normal.cdf(-(coefficient.abs() / variance.sqrt()));
        (alone * effects.len() as f64).min(1.0)
    }

    /// One sensor's diagnosis (`None`: the reference), and the size of its misfit, metres.
    fn sensor(
        &self,
        search: &Search<'_>,
        findings: &Findings,
        subject: Option<Sensor>,
    ) -> (SensorDiagnosis, f64) {
        let mut diagnosis = SensorDiagnosis::default();
        let explanation = &findings.explanation;
        let mut misfit_m: f64 = 0.0;
        let mut explained = 0.0;
        let mut uneven = false;
        let mut strongest: Option<(f64, Verdict)> = None;
        let mut sized: Vec<(f64, usize)> = Vec::new();
        for (k, rivals) in findings.rivals.iter().enumerate() {
            let set = self.set(rivals);
            let concerns =
                set.iter().any(|effect| effect.subject().name() == subject.map_or("gps", Sensor::name));
            if !concerns {
                continue;
            }
            let size_m = self.size_m(search, findings, k);
            misfit_m = misfit_m.max(size_m);
            explained += rivals.explained;
            let verdict = match set.as_slice() {
                _ if !findings.is_even(k) => {
                    uneven = true;
                    Verdict::UnknownEffect
                }
                [only] => {
                    sized.push((size_m, k));
                    let _ = only;
                    Verdict::Identified
                }
                more => {
                    diagnosis.indistinguishable.push(more.iter().map(|effect| effect.name()).collect());
                    Verdict::Indistinguishable
                }
            };
            if strongest.is_none_or(|(size, _)| size_m > size) {
                strongest = Some((size_m, verdict));
            }
        }
        sized.sort_by(|a, b| b.0.total_cmp(&a.0));
        diagnosis.missing =
            sized.iter().map(|(_, k)| self.candidates[findings.rivals[*k].column].effect().name()).collect();

        let mut unexplained = 0.0;
        let mut is_better = false;
        if let Some(sensor) = subject.filter(|sensor| sensor.flies_free()) {
            let own: Vec<usize> = self.columns_on(search, Some(sensor));
            let found = unknown::unexplained(
                self.problem,
                self.epochs,
                &explanation.fit,
                &explanation.columns,
                &own,
                explained,
                sensor.index(),
            );
            is_better = found.is_better;
            diagnosis.follows = found.follows;
            if let Some(first) = diagnosis.follows.first() {
                unexplained = first.evidence;
                misfit_m = misfit_m.max(first.size_m);
            }
            let excess = unknown::free_flight_excess(
                self.problem,
                &explanation.fit,
                &explanation.columns,
                sensor.index(),
                self.regressors_noise_m2(search, findings, sensor),
            );
            let noise = &explanation.fit.noise.sensors[sensor.index()];
            if self.epochs.iter().any(|epochs| epochs.series.has_both_phases()) {
                diagnosis.free_flight_factor = Some(noise.free_flight_factor);
            }
            if let Some(excess) = excess {
                unexplained += excess;
                misfit_m =
                    misfit_m.max(noise.free_flight_factor * noise.wander.sigma_m).max(noise.free_white_m);
            }
        }
        // Wind makes a formula that lacks the airspeed wrong by more than a signal may be right by chance.
        let lacks_airspeed = self.lacks_airspeed_for(findings, subject);
        let is_unknown = if lacks_airspeed {
            unexplained > explained
        } else {
            is_better || unexplained > REST * explained
        };
        diagnosis.verdict = match strongest {
            Some((_, verdict)) if !is_unknown => verdict,
            _ if is_unknown || uneven => Verdict::UnknownEffect,
            _ => self.quiet(search, findings, subject),
        };
        if is_unknown {
            // What was chosen may be no more than the nearest likeness of what really acts.
            diagnosis.indistinguishable.clear();
            diagnosis.missing.clear();
        }
        diagnosis.advice = self.advise(search, findings, subject, &diagnosis);
        diagnosis.candidates = self.candidate_facts(search, findings, subject);
        (diagnosis, misfit_m)
    }

    /// The effects of a set that can't be told apart: the chosen one, its rivals, and those that lack
    /// their signal and would look like one of them.
    fn set(&self, rivals: &Rivals) -> Vec<EffectId> {
        let mut set = vec![self.candidates[rivals.column].effect()];
        set.extend(rivals.others.iter().map(|other| self.candidates[*other].effect()));
        for (seen, hidden) in STAND_INS {
            let is_hidden = self.candidates.iter().enumerate().any(|(column, candidate)| {
                candidate.effect() == hidden && self.epochs.iter().any(|epochs| !epochs.available[column])
            });
            if is_hidden && set.contains(&seen) && !set.contains(&hidden) {
                set.push(hidden);
            }
        }
        set
    }

    /// The verdict of a sensor that shows nothing.
    fn quiet(&self, search: &Search<'_>, findings: &Findings, subject: Option<Sensor>) -> Verdict {
        if subject.is_none() || self.excitation(search, findings, subject).is_enough() {
            Verdict::NoSignificantMisfit
        } else {
            Verdict::InsufficientExcitation
        }
    }

    fn excitation(
        &self,
        search: &Search<'_>,
        findings: &Findings,
        subject: Option<Sensor>,
    ) -> super::excitation::Excitation {
        let columns: Vec<(usize, usize)> = self
            .one_an_effect(search, findings, subject)
            .into_iter()
            .filter_map(|column| Some((column, search.position(column)?)))
            .collect();
        let chosen = search.positions(&findings.explanation.columns);
        let mut excitation = excitation(&findings.information, self.candidates, &columns, &chosen);
        // Effects whose regressor does not move at all.
        for (column, candidate) in self.candidates.iter().enumerate() {
            let is_own = candidate.sensor() == subject && search.position(column).is_none();
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
    fn columns_on(&self, search: &Search<'_>, subject: Option<Sensor>) -> Vec<usize> {
        search
            .usable()
            .iter()
            .copied()
            .filter(|column| {
                let sensor = self.candidates[*column].sensor();
                sensor == subject || (subject.is_some() && sensor.is_none())
            })
            .collect()
    }

    /// Of each effect on the subject the column that fits best beside what was chosen.
    fn one_an_effect(&self, search: &Search<'_>, findings: &Findings, subject: Option<Sensor>) -> Vec<usize> {
        let mut best: BTreeMap<EffectId, (f64, usize)> = BTreeMap::new();
        for column in search.usable() {
            let candidate = &self.candidates[*column];
            if candidate.sensor() != subject {
                continue;
            }
            let is_chosen = findings.explanation.columns.contains(column);
            let rest = if is_chosen {
                f64::NEG_INFINITY
            } else {
                let picks = self.beside(search, findings, *column);
                findings.information.solve(&picks).map_or(f64::INFINITY, |solution| solution.rest)
            };
            let slot = best.entry(candidate.effect()).or_insert((rest, *column));
            if rest < slot.0 {
                *slot = (rest, *column);
            }
        }
        best.into_values().map(|(_, column)| column).collect()
    }

    /// Positions of the chosen columns of other effects, and last of this one.
    pub(super) fn beside(&self, search: &Search<'_>, findings: &Findings, column: usize) -> Vec<usize> {
        let others = findings.explanation.columns.iter().filter(|other| !search.same_effect(**other, column));
        let picks: Vec<usize> = others.copied().chain([column]).collect();
        search.positions(&picks)
    }

    /// How much of the residual a chosen effect makes in free flight, rms, metres.
    fn size_m(&self, search: &Search<'_>, findings: &Findings, k: usize) -> f64 {
        let columns = &findings.explanation.columns;
        let solution = findings.information.solve(&search.positions(columns));
        let coefficient = solution.map_or(0.0, |solution| solution.coefficients[k]);
        coefficient.abs() * self.spread_m(columns[k]).0
    }

    /// Spread (about its captive value where there is one) and range of a column in free flight.
    fn spread_m(&self, column: usize) -> (f64, [f64; 2]) {
        let mut sum = 0.0;
        let mut count = 0_u32;
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        let sensor = self.candidates[column].sensor();
        let sign = if sensor.is_none() { -1.0 } else { 1.0 };
        for epochs in self.epochs {
            let series = &epochs.series;
            let value = |block: usize| {
                let by_sensor = (0..SENSORS).find(|i| {
                    series.readings[block][*i] > 0 && sensor.is_none_or(|sensor| sensor.index() == *i)
                });
                by_sensor.map(|i| sign * series.columns[column][block][i])
            };
            let captive: Vec<f64> =
                (0..series.len()).filter(|block| !series.free[*block]).filter_map(value).collect();
            let free: Vec<f64> =
                (0..series.len()).filter(|block| series.free[*block]).filter_map(value).collect();
            let base = if captive.is_empty() { &free } else { &captive };
            let origin = base.iter().sum::<f64>() / base.len().max(1) as f64;
            for value in free {
                sum += (value - origin) * (value - origin);
                count += 1;
                range = [range[0].min(value), range[1].max(value)];
            }
        }
        ((sum / f64::from(count.max(1))).sqrt(), range)
    }

    fn candidate_facts(
        &self,
        search: &Search<'_>,
        findings: &Findings,
        subject: Option<Sensor>,
    ) -> Vec<CandidateFacts> {
        let explanation = &findings.explanation;
        // Chosen effects are listed in the order in which they count, each on top of those before it.
        let mut chosen: Vec<(f64, usize)> =
            (0..explanation.columns.len()).map(|k| (self.size_m(search, findings, k), k)).collect();
        chosen.sort_by(|a, b| b.0.total_cmp(&a.0));
        let chosen: Vec<usize> = chosen.into_iter().map(|(_, k)| explanation.columns[k]).collect();
        let mut facts = Vec::new();
        for (k, column) in chosen.iter().enumerate() {
            if self.candidates[*column].sensor() == subject {
                let fact = self.candidate(search, findings, *column, &chosen[..k], &chosen[..=k]);
                facts.extend(fact);
            }
        }
        let mut others = Vec::new();
        for column in self.one_an_effect(search, findings, subject) {
            if !chosen.iter().any(|other| search.same_effect(*other, column)) {
                let with: Vec<usize> = chosen.iter().copied().chain([column]).collect();
                others.extend(self.candidate(search, findings, column, &chosen, &with));
            }
        }
        others.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
        facts.append(&mut others);
        facts
    }

    pub(super) fn candidate(
        &self,
        search: &Search<'_>,
        findings: &Findings,
        column: usize,
        without: &[usize],
        with: &[usize],
    ) -> Option<CandidateFacts> {
        let candidate = &self.candidates[column];
        let picks = self.beside(search, findings, column);
        let solution = findings.information.solve(&picks)?;
        let n = picks.len();
        let coefficient = *solution.coefficients.last()?;
        let at = findings.explanation.columns.iter().position(|chosen| *chosen == column);
        let inflation = at.and_then(|at| findings.inflation.get(at)).copied().unwrap_or(1.0);
        let scale = self.scale(candidate.effect());
        let variance = solution.covariance[n * n - 1] * inflation;
        let sigma = (variance + (scale * coefficient) * (scale * coefficient)).sqrt();
        let rms = |errors: HeldOut| match candidate.sensor() {
            Some(sensor) => errors.rms_m(sensor.index()),
            None => errors.rms_all_m(),
        };
        let noise = &findings.explanation.fit.noise;
        let held_out = |picks: &[usize]| match self.held {
            Some(held) => held_out::flights(self.problem, held, noise, picks),
            None => held_out::manoeuvres(self.problem, noise, picks),
        };
        let (spread_m, envelope_m) = self.spread_m(column);
        let effect = candidate.effect();
        let has_time = effect.has_time_constant();
        Some(CandidateFacts {
            effect: effect.name(),
            coefficient,
            sigma,
            unit: effect.unit(),
            p_value: self.chance(search, coefficient, variance),
            rms_before_m: rms(held_out(without)),
            rms_after_m: rms(held_out(with)),
            chosen: at.is_some(),
            time_constant_s: has_time.then(|| f64::from(candidate.regressor.time_constant_s)),
            since: has_time.then(|| candidate.regressor.since.name()),
            size_m: coefficient.abs() * spread_m,
            envelope_m,
        })
    }

    /// The share of an effect's coefficient that is unsure beside its noise.
    pub(super) fn scale(&self, effect: EffectId) -> f64 {
        if lacks_airspeed(self.epochs, effect) {
            SCALE_WITHOUT_AIRSPEED
        } else if is_rough(self.epochs, effect) {
            SCALE_INTEGRATED
        } else {
            SCALE
        }
    }

    /// Variance of the noise that the regressors of the effects found bring to a sensor's blocks, m^2.
    fn regressors_noise_m2(&self, search: &Search<'_>, findings: &Findings, sensor: Sensor) -> f64 {
        let columns = &findings.explanation.columns;
        let solution = findings.information.solve(&search.positions(columns));
        let coefficients = solution.map(|solution| solution.coefficients).unwrap_or_default();
        let own = columns
            .iter()
            .zip(coefficients)
            .filter(|(column, _)| self.candidates[**column].sensor().is_none_or(|other| other == sensor));
        own.map(|(column, coefficient)| coefficient * coefficient * search.column_noise_m2(*column)).sum()
    }

    /// Whether an effect chosen on a sensor is made of an airspeed that was not measured.
    fn lacks_airspeed_for(&self, findings: &Findings, subject: Option<Sensor>) -> bool {
        findings.explanation.columns.iter().any(|column| {
            let candidate = &self.candidates[*column];
            candidate.sensor() == subject && lacks_airspeed(self.epochs, candidate.effect())
        })
    }

    fn trim(&self) -> Trim {
        let mean = |signal: usize| {
            let values = self.epochs.iter().flat_map(|e| e.signals.iter()).map(|block| block[signal]);
            let known: Vec<f64> = values.filter(|value| value.is_finite()).collect();
            (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
        };
        Trim {
            speed_mps: mean(0).or(mean(18)).filter(|speed| *speed > 5.0).unwrap_or(40.0),
            altitude_m: mean(2).unwrap_or(1000.0),
            angle_of_attack_rad: mean(8).filter(|angle| angle.abs() > 0.005).unwrap_or(0.05),
        }
    }

    fn advise(
        &self,
        search: &Search<'_>,
        findings: &Findings,
        subject: Option<Sensor>,
        diagnosis: &SensorDiagnosis,
    ) -> String {
        let noise = &findings.explanation.fit.noise;
        let trim = self.trim();
        match diagnosis.verdict {
            Verdict::NoSignificantMisfit => String::new(),
            Verdict::Identified => {
                let first = diagnosis.missing.first().copied().unwrap_or_default();
                format!("Add {first} to the model (pylon add {first}) and check it on another flight.")
            }
            Verdict::Indistinguishable => self.advise_separation(search, findings, subject, &trim),
            Verdict::InsufficientExcitation => {
                let unseen = self.excitation(search, findings, subject).unseen;
                let names: Vec<&str> =
                    unseen.iter().take(4).map(|column| self.candidates[*column].effect().name()).collect();
                let found = advice::to_see(self.problem, noise, self.candidates, &unseen, &trim);
                found.map_or_else(String::new, |advice| {
                    format!("This flight could not show {} ... Fly {}.", names.join(", "), advice.manoeuvre)
                })
            }
            Verdict::UnknownEffect => match diagnosis.follows.first() {
                Some(first) => format!(
                    "Nothing in the catalogue explains this sensor. Its residual follows {} (lag {:.0} s): look for a cause there.",
                    first.signal, first.lag_s
                ),
                None => "Nothing in the catalogue explains this sensor, and its residual follows no recorded signal: look at the installation, and record more signals.".to_owned(),
            },
        }
    }

    fn advise_separation(
        &self,
        search: &Search<'_>,
        findings: &Findings,
        subject: Option<Sensor>,
        trim: &Trim,
    ) -> String {
        let name = subject.map_or("gps", Sensor::name);
        let explanation = &findings.explanation;
        for (k, rivals) in findings.rivals.iter().enumerate() {
            let set = self.set(rivals);
            if set.len() < 2 || !set.iter().any(|effect| effect.subject().name() == name) {
                continue;
            }
            let columns: Vec<usize> =
                std::iter::once(rivals.column).chain(rivals.others.iter().copied()).collect();
            let hidden: Vec<&str> = set
                .iter()
                .filter(|effect| !columns.iter().any(|column| self.candidates[*column].effect() == **effect))
                .flat_map(|effect| effect.needs().iter().copied())
                .collect();
            let record = if hidden.is_empty() {
                String::new()
            } else {
                format!(" Record {} as well.", hidden.join(" and "))
            };
            let chosen = &explanation.columns;
            let sizes: Option<Vec<f64>> = columns
                .iter()
                .map(|column| {
                    let others = chosen.iter().copied().filter(|other| *other != chosen[k]);
                    let picks: Vec<usize> = others.chain([*column]).collect();
                    findings.information.solve(&search.positions(&picks))?.coefficients.last().copied()
                })
                .collect();
            let shared = rivals.others.first().and_then(|other| {
                let others = chosen.iter().copied().filter(|c| *c != chosen[k]).collect::<Vec<_>>();
                findings.information.shared(
                    search.position(rivals.column)?,
                    search.position(*other)?,
                    &search.positions(&others),
                )
            });
            let why = shared.map_or_else(String::new, |shared| {
                format!(" Their regressors are correlated by {:.3} on these flights.", shared.sqrt())
            });
            let found = sizes.filter(|_| columns.len() > 1).and_then(|sizes| {
                advice::to_separate(
                    self.problem,
                    &explanation.fit.noise,
                    self.candidates,
                    &columns,
                    &sizes,
                    trim,
                )
            });
            let names: Vec<&str> = set.iter().map(|effect| effect.name()).collect();
            let fly = found.map_or_else(String::new, |advice| {
                if advice.sigmas >= 3.0 {
                    format!(
                        " To separate them fly {} (they would differ by {:.0} sigma).",
                        advice.manoeuvre, advice.sigmas
                    )
                } else if advice.sigmas >= 0.5 {
                    format!(
                        " No manoeuvre separates them well; the best is {} ({:.1} sigma).",
                        advice.manoeuvre, advice.sigmas
                    )
                } else {
                    " No manoeuvre separates them.".to_owned()
                }
            });
            // What one sensor alone shows may be its own or the reference's.
            let is_of_reference = |effect: &&EffectId| effect.subject().name() == "gps";
            let sensors = Sensor::ALL.iter().filter(|s| self.epochs.iter().any(|e| e.series.has(s.index())));
            let other = if sensors.count() == 1 && set.iter().any(|effect| is_of_reference(&effect)) {
                " Record another altitude sensor: an error that both show is the reference's."
            } else {
                ""
            };
            return format!("One of {} acts.{why}{fly}{other}{record}", names.join(", "));
        }
        String::new()
    }

    fn noise_facts(&self, findings: &Findings) -> NoiseFacts {
        let noise = &findings.explanation.fit.noise;
        let sensors = Sensor::ALL.into_iter().filter(|s| self.epochs.iter().any(|e| e.series.has(s.index())));
        NoiseFacts {
            reference_wander_m: noise.reference.sigma_m,
            reference_time_s: noise.reference.time_s,
            fix_sigma_m: noise.fix_sigma_m,
            sensor_wander: sensors
                .map(|sensor| {
                    let wander = noise.sensors[sensor.index()].wander;
                    (sensor.name(), (wander.sigma_m, wander.time_s))
                })
                .collect(),
        }
    }
}
