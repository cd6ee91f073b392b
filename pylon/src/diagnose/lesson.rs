//! What one effect's coefficient is learned from: the flights' block means, the noise that goes with
//! them, and the terms that must be estimated beside it.

use kf_core::effect::{Clock, EffectId, Regressor};

use super::candidates::Candidate;
use super::diagnosis::{CandidateFacts, Diagnosis};
use super::evidence::{self, Evidence, Fitted, Folds};
use super::judge::{Findings, Judge};
use super::noise::Noise;
use super::roughness::scale;
use super::search::{Explanation, Search};
use super::series::Series;
use super::work::{NamedReplay, work};

/// The effect whose coefficient is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// Which.
    pub effect: EffectId,
    /// Its time constant, seconds; `None`: that of the grid that fits best.
    pub time_constant_s: Option<f32>,
    /// Where its clock starts; `None`: whichever fits best.
    pub since: Option<Clock>,
}

impl Wish {
    /// Leaves only what is wished for of the effect's candidates, with these time constants if there are any.
    pub(super) fn narrow(&self, candidates: &mut Vec<Candidate>, time_constants_s: &[f32]) {
        // The core has a lag in the catalogue's own shape only.
        candidates.retain(|candidate| candidate.effect() != self.effect || candidate.smoothing_s == 0.0);
        if !self.effect.has_time_constant() {
            return;
        }
        let is_other = |candidate: &Candidate| {
            candidate.effect() == self.effect
                && self.since.is_some_and(|since| candidate.regressor.since != since)
        };
        candidates.retain(|candidate| !is_other(candidate));
        if time_constants_s.is_empty() {
            return;
        }
        let mut own: Vec<Candidate> =
            candidates.iter().copied().filter(|candidate| candidate.effect() == self.effect).collect();
        own.dedup_by_key(|candidate| candidate.regressor.since);
        // In their place: the search takes an effect's columns for neighbours.
        let at = candidates.iter().position(|candidate| candidate.effect() == self.effect).unwrap_or(0);
        candidates.retain(|candidate| candidate.effect() != self.effect);
        let with = |candidate: Candidate, time_constant_s| Candidate {
            regressor: Regressor { time_constant_s, ..candidate.regressor },
            ..candidate
        };
        let new = own.iter().flat_map(|own| time_constants_s.iter().map(|time_s| with(*own, *time_s)));
        candidates.splice(at..at, new);
    }
}

/// A term of the residual: an effect with its column in every [`Series`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// The effect and the constants of its regressor.
    pub regressor: Regressor,
    /// Its column.
    pub column: usize,
    /// What the model knows of its coefficient, as a sigma about what was taken off already; `None`: nothing.
    pub known_sigma: Option<f64>,
}

/// A column that is no effect, with a coefficient of each flight's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nuisance {
    /// Its column.
    pub column: usize,
    /// What is believed of its coefficient, as a sigma about zero.
    pub sigma: f64,
}

/// What an effect's coefficient is learned from.
#[derive(Clone, Debug)]
pub struct Lesson {
    /// The flights' block means.
    pub flights: Vec<Series>,
    /// The noise fitted beside the terms.
    pub noise: Noise,
    /// The effect first; then what else acts, and what the model has already.
    pub terms: Vec<Term>,
    /// The wind's share of the airspeed, north and east, where a flight has the speed over ground only.
    pub wind: Option<[Nuisance; 2]>,
    /// By how much the coefficient's variance is larger than a fit with this noise says: the spread over
    /// the parts of the flights, and the autocorrelation that is left.
    pub inflation: f64,
    /// The share of the coefficient that is unsure beside its noise: signals have scale errors of their own.
    pub scale: f64,
    /// What the diagnosis itself makes of the coefficient, in f64, and the held-out errors.
    pub facts: CandidateFacts,
    /// What the flights' own stretches say of the coefficient.
    pub folds: Folds,
    /// What the held-out flights say of it, if there are any.
    pub held_out: Option<Evidence>,
}

/// A diagnosis of flights with a model that lacks the effect, and what the effect's coefficient is to be
/// learned from; no lesson where the flights lack its signals ([`Diagnosis::untested`]) or its regressor
/// does not move in them.
#[must_use]
pub fn study(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    wish: Wish,
    progress: &mut dyn FnMut(),
) -> (Diagnosis, Option<Lesson>) {
    let wished: Vec<f32> = wish.time_constant_s.into_iter().collect();
    let coarse = work(flights, hold_outs, Some((wish, &wished)), progress);
    let fitted = coarse.1.as_ref().and_then(|lesson| lesson.terms.first()).map(|term| term.regressor);
    match fitted.filter(|_| wished.is_empty() && wish.effect.has_time_constant()) {
        Some(Regressor { time_constant_s, since, .. }) => {
            let fine = FINER.map(|factor| factor * time_constant_s);
            let there = Wish { since: Some(since), ..wish };
            work(flights, hold_outs, Some((there, &fine)), progress)
        }
        None => coarse,
    }
}

/// Time constants between those of the diagnosis' grid, as factors: a tenth apart an exponential differs by less than
/// a hundredth of its size.
const FINER: [f32; 11] = [0.57, 0.64, 0.72, 0.8, 0.9, 1.0, 1.1, 1.22, 1.36, 1.52, 1.7];

impl Judge<'_> {
    /// The lesson for an effect. Whatever the diagnosis found to act stays beside it, but for what this
    /// effect could stand in the place of.
    pub(super) fn lesson(
        &self,
        search: &mut Search<'_>,
        findings: Findings,
        effect: EffectId,
    ) -> Option<Lesson> {
        let is_wished = |column: &usize| self.candidates[*column].effect() == effect;
        let found = findings.explanation.columns.iter().copied().find(is_wished);
        let (findings, column) = match found {
            Some(column) => (findings, column),
            None => self.beside_the_others(search, findings, &is_wished)?,
        };
        let columns = &findings.explanation.columns;
        let others: Vec<usize> = columns.iter().copied().filter(|other| *other != column).collect();
        let facts = self.candidate(search, &findings, column, &others, columns)?;
        let at = columns.iter().position(|chosen| *chosen == column)?;
        let term = |column: usize, known_sigma| Term {
            regressor: self.candidates[column].regressor,
            column,
            known_sigma,
        };
        // What has a column but is no effect is the wind's.
        let (effects, wind): (Vec<_>, Vec<_>) =
            self.problem.known.iter().copied().partition(|known| known.column < self.candidates.len());
        let known = effects.into_iter().map(|known| term(known.column, Some(known.sigma)));
        let wind: Vec<Nuisance> =
            wind.into_iter().map(|known| Nuisance { column: known.column, sigma: known.sigma }).collect();
        let noise = findings.explanation.fit.noise;
        let inflation = findings.inflation.get(at).copied().unwrap_or(1.0);
        let fitted = Fitted { noise: &noise, others: &others, column, inflation };
        let folds = evidence::of_folds(self.problem, &fitted);
        let held_out = self.held.map(|held| evidence::of_flights(held, &fitted));
        let free = std::iter::once(column).chain(others.iter().copied()).map(|column| term(column, None));
        Some(Lesson {
            flights: self.problem.flights.to_vec(),
            noise,
            terms: free.chain(known).collect(),
            wind: wind.try_into().ok(),
            inflation,
            scale: scale(self.epochs, effect),
            facts,
            folds,
            held_out,
        })
    }

    /// The findings with the best column of a wished effect that was not chosen, and that column.
    fn beside_the_others(
        &self,
        search: &mut Search<'_>,
        findings: Findings,
        is_wished: &dyn Fn(&usize) -> bool,
    ) -> Option<(Findings, usize)> {
        let replaced = |column: &usize| {
            findings
                .rivals
                .iter()
                .any(|rivals| rivals.column == *column && rivals.others.iter().any(is_wished))
        };
        let others: Vec<usize> =
            findings.explanation.columns.iter().copied().filter(|column| !replaced(column)).collect();
        let wished: Vec<usize> = search.usable().iter().copied().filter(is_wished).collect();
        let fits = wished.into_iter().map(|column| {
            let mut columns = others.clone();
            columns.push(column);
            columns.sort_unstable();
            let fit = search.fit(&columns, &findings.explanation.fit.values);
            (Explanation { columns, fit }, column)
        });
        let (explanation, column) =
            fits.max_by(|a, b| a.0.fit.twice_log_posterior.total_cmp(&b.0.fit.twice_log_posterior))?;
        let repeat =
            super::repeatability::repeatability(self.problem, &explanation.fit.noise, &explanation.columns);
        let inflation = self.inflation(&explanation, &repeat);
        let information = search.information(&explanation.fit);
        Some((Findings { explanation, information, rivals: Vec::new(), repeat, inflation }, column))
    }
}
