//! What an effect's coefficient is learned from, given what else was found.

use kf_core::effect::EffectId;

use super::{Findings, Judge, with};
use crate::diagnose::evidence::{self, Fitted};
use crate::diagnose::learning_problem::{LearningProblem, Nuisance, Term};
use crate::diagnose::low_pass::LowPassDelay;
use crate::diagnose::noise::Noise;
use crate::diagnose::posterior::Posterior;
use crate::diagnose::repeatability::repeatability;
use crate::diagnose::search::{Explanation, Search};
use crate::diagnose::suspects::White;
use crate::progress::{Cancelled, Progress, step};

/// Maximum number of noise fits while a time constant is refined.
const REFINEMENTS: usize = 3;

impl Judge<'_> {
    /// The problem for an effect. Whatever the diagnosis found to act is kept, except what this effect could
    /// replace.
    pub(in crate::diagnose) fn problem(
        &self,
        search: &mut Search<'_>,
        findings: Findings,
        effect: EffectId,
    ) -> Option<LearningProblem> {
        let is_wanted = |column: &usize| self.candidates[*column].effect() == effect;
        let found = findings.explanation.columns.iter().copied().find(is_wanted);
        let (findings, column) = match found {
            // The flight computer has no signal but the measured one. An error of its forward acceleration is
            // another one on every flight, so the coefficient is learned without it.
            Some(column) if self.candidates[column].is_read_as_flown() => (findings, column),
            Some(column) => {
                let columns = &findings.explanation.columns;
                let others = columns.iter().copied().filter(|other| *other != column).collect();
                self.with_best(search, findings, others, effect)?
            }
            None => self.beside_the_others(search, findings, effect)?,
        };
        self.problem_of(&findings, column)
    }

    /// The problem for an effect with the best of its columns, together with every other suspect, the noise
    /// fitted from `start`. `None` if none of its columns moves or is possible.
    ///
    /// # Errors
    /// [`Cancelled`] when `progress` requests it.
    pub(in crate::diagnose) fn refined_problem(
        &self,
        search: &mut Search<'_>,
        effect: EffectId,
        start: &[f64],
        progress: &mut Progress<'_>,
    ) -> Result<Option<LearningProblem>, Cancelled> {
        let (own, others): (Vec<usize>, Vec<usize>) =
            self.suspects.usable().iter().partition(|column| self.candidates[**column].effect() == effect);
        let mut noise = self.problem.prior.noise(start);
        let mut values = start.to_vec();
        let mut found: Option<(usize, Explanation)> = None;
        // The best column depends on the noise, and the noise on the column; both settle almost at once.
        for _ in 0..REFINEMENTS {
            let Some(best) = self.best_beside(&noise, &own, &others) else { return Ok(None) };
            if found.as_ref().is_some_and(|(column, _)| *column == best) {
                break;
            }
            let columns = with(&others, best);
            let fit = search.fit(&columns, &values);
            step(progress)?;
            (noise, values) = (fit.noise, fit.values.clone());
            found = Some((best, Explanation { columns, fit }));
        }
        Ok(found
            .and_then(|(column, explanation)| self.problem_of(&self.findings_of(explanation, None), column)))
    }

    /// The column that explains most under this noise, together with the others.
    fn best_beside(&self, noise: &Noise, own: &[usize], others: &[usize]) -> Option<usize> {
        let information = self.suspects.information(self.problem, noise);
        let rests = own.iter().filter_map(|column| {
            let columns = with(others, *column);
            let solution = information.solve(&self.suspects.positions(&columns))?;
            self.suspects.may_act(&columns, &solution).then_some((*column, solution.rest))
        });
        rests.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(column, _)| column)
    }

    /// The problem with the findings' column of an effect first.
    fn problem_of(&self, findings: &Findings, column: usize) -> Option<LearningProblem> {
        let columns = &findings.explanation.columns;
        let others: Vec<usize> = columns.iter().copied().filter(|other| *other != column).collect();
        let facts = self.candidate(findings, column, &others, columns)?;
        let at = columns.iter().position(|chosen| *chosen == column)?;
        let term = |column: usize, known_sigma| Term {
            regressor: self.candidates[column].regressor,
            column,
            known_sigma,
        };
        // A column that is not an effect belongs to the wind.
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
        let beyond_noise = self.beyond_noise(findings, column);
        Some(LearningProblem {
            flights: self.problem.flights.to_vec(),
            noise,
            terms: free.chain(known).collect(),
            wind: wind.try_into().ok(),
            inflation,
            low_pass_s: LowPassDelay::time_constant_s(self.candidates[column].delay, facts.coefficient),
            beyond_noise: beyond_noise.sum(),
            relative: beyond_noise.relative,
            facts,
            folds,
            held_out,
        })
    }

    /// The findings with the best column of a requested effect that was not chosen, and that column.
    fn beside_the_others(
        &self,
        search: &mut Search<'_>,
        findings: Findings,
        effect: EffectId,
    ) -> Option<(Findings, usize)> {
        let replaced = |column: &usize| {
            let of_column = findings.rivals.iter().filter(|rivals| rivals.column == *column);
            of_column.flat_map(|rivals| self.set(rivals).effects).any(|(other, _)| other == effect)
        };
        let others =
            findings.explanation.columns.iter().copied().filter(|column| !replaced(column)).collect();
        self.with_best(search, findings, others, effect)
    }

    /// The findings with the best column of an effect that is made of the signals as they are, beside others,
    /// and that column. It has shown no shape but the catalogue's.
    fn with_best(
        &self,
        search: &mut Search<'_>,
        findings: Findings,
        others: Vec<usize>,
        effect: EffectId,
    ) -> Option<(Findings, usize)> {
        let is_wanted = |column: &usize| {
            let candidate = &self.candidates[*column];
            candidate.effect() == effect && candidate.is_catalogues()
        };
        let wanted: Vec<usize> = self.suspects.usable().iter().copied().filter(is_wanted).collect();
        let fits = wanted.into_iter().map(|column| {
            let columns = with(&others, column);
            let fit = search.fit(&columns, &findings.explanation.fit.values);
            (Explanation { columns, fit }, column)
        });
        let (explanation, column) =
            fits.max_by(|a, b| a.0.fit.twice_log_posterior.total_cmp(&b.0.fit.twice_log_posterior))?;
        Some((self.findings_of(explanation, findings.posterior), column))
    }

    /// The findings of a chosen set of columns, without a search for rivals.
    fn findings_of(&self, explanation: Explanation, posterior: Option<Posterior>) -> Findings {
        let repeat = repeatability(self.problem, &explanation.fit.noise, &explanation.columns);
        let inflation = self.inflation(&explanation, &repeat);
        let information = self.suspects.information(self.problem, &explanation.fit.noise);
        Findings {
            white: White::of(self.problem, &explanation.fit.noise),
            explanation,
            information,
            rivals: Vec::new(),
            weak: Vec::new(),
            repeat,
            inflation,
            posterior,
        }
    }
}
