//! What the probabilities of sets of effects mean for the chosen one.

use super::{Findings, Judge};
use crate::diagnose::information::Solution;
use crate::diagnose::posterior::Posterior;
use crate::diagnose::rivals::Rivals;
use crate::diagnose::roughness::unsteadiness;
use crate::diagnose::search::Explanation;

/// A place is not reported where nothing acts with more than this probability: more probably than not.
pub(in crate::diagnose) const EMPTY: f64 = 0.5;

impl Judge<'_> {
    /// Whether a chosen coefficient is physically impossible, given its reported sigma: then it is not the
    /// effect that it looks like.
    pub(super) fn is_beyond(&self, findings: &Findings, k: usize) -> bool {
        if findings.posterior.is_none() {
            return false;
        }
        let columns = &findings.explanation.columns;
        let solution = findings.information.solve(&self.suspects.positions(columns));
        let n = columns.len();
        let unsteadiness = unsteadiness(self.candidates[columns[k]].effect(), self.has_climb_rate);
        let inflation = findings.inflation.get(k).copied().unwrap_or(1.0);
        solution.is_some_and(|solution| {
            let variance = solution.covariance[k * n + k] * inflation + unsteadiness * unsteadiness;
            let alone = Solution {
                coefficients: vec![solution.coefficients[k]],
                covariance: vec![variance],
                ..solution
            };
            !self.suspects.is_possible(&columns[k..=k], &alone)
        })
    }

    /// What could replace each chosen column, by the probabilities of sets.
    pub(super) fn rivals_by(&self, posterior: &Posterior, explanation: &Explanation) -> Vec<Rivals> {
        let information = self.suspects.information(self.problem, &explanation.fit.noise);
        let rest = |columns: &[usize]| {
            information.solve(&self.suspects.positions(columns)).map_or(0.0, |solution| solution.rest)
        };
        let chosen = &explanation.columns;
        let with_all = rest(chosen);
        let of_column = |column: &usize| {
            let others: Vec<usize> = chosen.iter().copied().filter(|other| other != column).collect();
            posterior.rivals(*column, chosen, (rest(&others) - with_all).max(0.0))
        };
        chosen.iter().map(of_column).collect()
    }

    /// The chosen column whose place is most probably empty, if that is more probable than not.
    pub(super) fn doubtful(&self, posterior: &Posterior, explanation: &Explanation) -> Option<usize> {
        let chosen = &explanation.columns;
        let empty = chosen.iter().map(|column| {
            let rivals = posterior.rivals(*column, chosen, 0.0);
            (*column, rivals.odds_of_nothing * rivals.acts.unwrap_or(0.0))
        });
        let most = empty.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (most.1 > EMPTY).then_some(most.0)
    }
}
