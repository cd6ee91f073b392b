//! What the coefficient of an effect is learned from, by what was found beside it.

use kf_core::effect::EffectId;

use super::{Findings, Judge};
use crate::diagnose::evidence::{self, Fitted};
use crate::diagnose::learning_problem::{LearningProblem, Nuisance, Term};
use crate::diagnose::repeatability::repeatability;
use crate::diagnose::roughness::{scale, unsteadiness};
use crate::diagnose::search::{Explanation, Search};

impl Judge<'_> {
    /// The problem for an effect. Whatever the diagnosis found to act stays beside it, but for what this
    /// effect could stand in the place of.
    pub(in crate::diagnose) fn problem(
        &self,
        search: &mut Search<'_>,
        findings: Findings,
        effect: EffectId,
    ) -> Option<LearningProblem> {
        let is_wanted = |column: &usize| self.candidates[*column].effect() == effect;
        let found = findings.explanation.columns.iter().copied().find(is_wanted);
        let (findings, column) = match found {
            Some(column) => (findings, column),
            None => self.beside_the_others(search, findings, effect)?,
        };
        let columns = &findings.explanation.columns;
        let others: Vec<usize> = columns.iter().copied().filter(|other| *other != column).collect();
        let facts = self.candidate(&findings, column, &others, columns)?;
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
        Some(LearningProblem {
            flights: self.problem.flights.to_vec(),
            noise,
            terms: free.chain(known).collect(),
            wind: wind.try_into().ok(),
            inflation,
            scale: scale(self.epochs, effect),
            unsteadiness: unsteadiness(effect, self.has_climb_rate),
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
        effect: EffectId,
    ) -> Option<(Findings, usize)> {
        let is_wanted = |column: &usize| self.candidates[*column].effect() == effect;
        let replaced = |column: &usize| {
            let of_column = findings.rivals.iter().filter(|rivals| rivals.column == *column);
            of_column.flat_map(|rivals| self.set(rivals)).any(|(other, _)| other == effect)
        };
        let others: Vec<usize> =
            findings.explanation.columns.iter().copied().filter(|column| !replaced(column)).collect();
        let wanted: Vec<usize> = self.suspects.usable().iter().copied().filter(is_wanted).collect();
        let fits = wanted.into_iter().map(|column| {
            let mut columns = others.clone();
            columns.push(column);
            columns.sort_unstable();
            let fit = search.fit(&columns, &findings.explanation.fit.values);
            (Explanation { columns, fit }, column)
        });
        let (explanation, column) =
            fits.max_by(|a, b| a.0.fit.twice_log_posterior.total_cmp(&b.0.fit.twice_log_posterior))?;
        let repeat = repeatability(self.problem, &explanation.fit.noise, &explanation.columns);
        let inflation = self.inflation(&explanation, &repeat);
        let information = self.suspects.information(self.problem, &explanation.fit.noise);
        let rivals = Vec::new();
        let posterior = findings.posterior;
        Some((Findings { explanation, information, rivals, repeat, inflation, posterior }, column))
    }
}
