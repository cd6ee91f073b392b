//! Which effects act: the set of columns with the most probable explanation, the noise fitted anew for
//! every set that is looked at.

use std::collections::BTreeMap;

use kf_core::sensor::Sensor;

use super::candidates::Candidate;
use super::information::Information;
use super::problem::{NoiseFit, Problem};
use super::series::BySensor;

/// Most effects that are looked for at once.
pub const MOST_EFFECTS: usize = 5;
/// Sets kept at every size while subsets are looked through.
const BEAM: usize = 12;
/// Subsets proposed in one round.
const PROPOSALS: usize = 5;
/// The share (squares) of what a set explains that a smaller one may leave. Measured signals, their
/// delays and the terms that a formula leaves out make its shape wrong by some 14 %.
const SHAPE: f64 = 0.02;
/// The same where a regressor is only roughly known.
pub const ROUGH_SHAPE: f64 = 0.1;
/// A coefficient so many times beyond its plausible range explains nothing.
const IMPOSSIBLE: f64 = 100.0;
/// Neighbours of the best set proposed for every change of it.
const NEIGHBOURS: usize = 3;
const ROUNDS: usize = 8;
/// What an effect must gain in twice the log likelihood beyond what the best of so many candidates gains
/// by chance (which is 2 ln of their number). 16 is a chance of 1 in 10,000 for one of them, which leaves room for
/// noise that is not quite what the likelihood takes it for.
const EVIDENCE: f64 = 16.0;

/// A set of effects with the noise that goes with it.
#[derive(Clone, Debug)]
pub struct Explanation {
    /// Columns of the candidates, ascending.
    pub columns: Vec<usize>,
    /// The noise that goes with them.
    pub fit: NoiseFit,
}

/// The search and what it has looked at.
pub struct Search<'a> {
    problem: &'a Problem<'a>,
    candidates: &'a [Candidate],
    usable: Vec<usize>,
    /// Variance of the noise in each candidate's block means.
    column_noise_m2: &'a [f64],
    /// Candidates whose regressor is only roughly known.
    is_rough: &'a [bool],
    penalty: f64,
    seen: BTreeMap<Vec<usize>, NoiseFit>,
}

impl<'a> Search<'a> {
    /// A search among the candidates whose columns are in `usable`.
    #[must_use]
    pub fn new(
        problem: &'a Problem<'a>,
        candidates: &'a [Candidate],
        usable: Vec<usize>,
        column_noise_m2: &'a [f64],
        is_rough: &'a [bool],
    ) -> Self {
        let mut effects: Vec<_> = usable.iter().map(|column| candidates[*column].effect()).collect();
        effects.dedup();
        let penalty = 2.0 * (effects.len().max(1) as f64).ln() + EVIDENCE;
        Self { problem, candidates, usable, column_noise_m2, is_rough, penalty, seen: BTreeMap::new() }
    }

    /// The candidates' columns that take part.
    #[must_use]
    pub fn usable(&self) -> &[usize] {
        &self.usable
    }

    /// The noise fitted beside a set of columns.
    pub fn fit(&mut self, columns: &[usize], start: &[f64]) -> NoiseFit {
        match self.seen.get(columns) {
            Some(fit) => fit.clone(),
            None => self.fit_again(columns, start),
        }
    }

    /// The better of the noise known for a set of columns and of a fit from another start.
    fn fit_again(&mut self, columns: &[usize], start: &[f64]) -> NoiseFit {
        let fit = self.problem.fit_noise(&self.problem.prior, columns, start);
        let known =
            self.seen.get(columns).filter(|known| known.twice_log_posterior >= fit.twice_log_posterior);
        let best = known.cloned().unwrap_or(fit);
        self.seen.insert(columns.to_vec(), best.clone());
        best
    }

    /// Normal equations of all usable columns under a noise.
    #[must_use]
    pub fn information(&self, fit: &NoiseFit) -> Information {
        self.problem.information(&fit.noise, &self.usable)
    }

    fn score(&self, columns: &[usize], fit: &NoiseFit) -> f64 {
        self.penalty * columns.len() as f64 - fit.twice_log_posterior
    }

    /// Looks for the most probable set.
    pub fn run(&mut self, progress: &mut dyn FnMut()) -> Explanation {
        let start = self.problem.prior.means();
        let mut best = Explanation { columns: Vec::new(), fit: self.fit(&[], &start) };
        // Under the null's noise a slow effect looks like wander; under the prior's it stands out.
        let prior_noise = NoiseFit {
            noise: self.problem.prior.noise(&start),
            values: start,
            twice_log_posterior: f64::NEG_INFINITY,
        };
        let mut proposals = self.proposals(&prior_noise, &best.columns);
        for _ in 0..ROUNDS {
            proposals.extend(self.proposals(&best.fit, &best.columns));
            proposals.sort();
            proposals.dedup();
            let mut next = best.clone();
            for columns in std::mem::take(&mut proposals) {
                let fit = self.fit(&columns, &best.fit.values);
                progress();
                if self.score(&columns, &fit) < self.score(&next.columns, &next.fit) {
                    next = Explanation { columns, fit };
                }
            }
            if next.columns == best.columns {
                // The smaller sets may have ended in a worse maximum of their likelihood: start where
                // the best one is.
                for left_out in &best.columns {
                    let columns: Vec<usize> =
                        best.columns.iter().copied().filter(|column| column != left_out).collect();
                    let fit = self.fit_again(&columns, &best.fit.values);
                    progress();
                    if self.score(&columns, &fit) < self.score(&next.columns, &next.fit) {
                        next = Explanation { columns, fit };
                    }
                }
                if next.columns == best.columns {
                    break;
                }
            }
            best = next;
        }
        best
    }

    /// Sets worth a fit of their own: the best subsets under this noise, and the neighbours of a set.
    fn proposals(&self, fit: &NoiseFit, near: &[usize]) -> Vec<Vec<usize>> {
        let information = self.information(fit);
        let mut sets: Vec<(f64, Vec<usize>)> = Vec::new();
        let mut level = vec![Vec::new()];
        for _ in 0..MOST_EFFECTS {
            let mut next = self.extended(&information, &level);
            next.truncate(BEAM);
            sets.extend(next.iter().cloned());
            level = next.into_iter().map(|(_, set)| set).collect();
        }
        sets.sort_by(|a, b| a.0.total_cmp(&b.0));
        sets.truncate(PROPOSALS);

        let best = |set: &[usize]| self.extended(&information, &[set.to_vec()]).into_iter().take(NEIGHBOURS);
        if near.len() < MOST_EFFECTS {
            sets.extend(best(near));
        }
        for left_out in near {
            let without: Vec<usize> = near.iter().copied().filter(|column| column != left_out).collect();
            sets.extend(best(&without));
            sets.push((0.0, without));
        }
        let mut sets: Vec<Vec<usize>> = sets.into_iter().map(|(_, set)| set).collect();
        sets.retain(|set| !self.seen.contains_key(set));
        sets
    }

    /// The sets with one more column of another effect, the best first.
    fn extended(&self, information: &Information, sets: &[Vec<usize>]) -> Vec<(f64, Vec<usize>)> {
        let mut found: Vec<(f64, Vec<usize>)> = Vec::new();
        for set in sets {
            for column in &self.usable {
                let effect = self.candidates[*column].effect();
                if set.iter().any(|other| self.candidates[*other].effect() == effect) {
                    continue;
                }
                let mut larger = set.clone();
                larger.push(*column);
                larger.sort_unstable();
                if found.iter().any(|(_, seen)| *seen == larger) {
                    continue;
                }
                let at: Vec<usize> = larger.iter().filter_map(|column| self.position(*column)).collect();
                if let Some(solution) = information.solve(&at)
                    && self.is_possible(&larger, &solution.coefficients)
                {
                    found.push((solution.rest + self.penalty * larger.len() as f64, larger));
                }
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found
    }

    /// Whether no coefficient is far out of what nature allows.
    #[must_use]
    pub fn is_possible(&self, set: &[usize], coefficients: &[f64]) -> bool {
        set.iter().zip(coefficients).all(|(column, coefficient)| {
            let bounds = self.candidates[*column].effect().plausible();
            let largest = bounds.iter().fold(0.0_f64, |most, bound| most.max(f64::from(bound.abs())));
            coefficient.abs() <= IMPOSSIBLE * largest
        })
    }

    /// A smaller set that explains all but a small share of what a set explains on the same sensors, if there
    /// is one: what the additional effects add may be the other formula's error. Effects of the reference are
    /// on every sensor, so with one of them all sensors are looked at together.
    #[must_use]
    pub fn simpler(&self, chosen: &Explanation) -> Option<Vec<usize>> {
        let information = self.information(&chosen.fit);
        let weights = self.problem.weight_of_white(&chosen.fit.noise);
        let rest = |set: &[usize]| self.rest_but_noise(&information, &weights, set);
        let best = information.solve(&self.positions(&chosen.columns))?.rest;
        let sensor = |column: &usize| self.candidates[*column].sensor();
        let is_joint = chosen.columns.iter().any(|column| sensor(column).is_none());
        let mut subjects: Vec<_> = chosen.columns.iter().map(sensor).collect();
        subjects.sort_by_key(|subject| subject.map(Sensor::index));
        subjects.dedup();
        if is_joint {
            subjects.truncate(1);
        }
        for subject in subjects {
            let is_own = |column: &usize| is_joint || sensor(column) == subject;
            let own = chosen.columns.iter().filter(|column| is_own(column)).count();
            let others: Vec<usize> = chosen.columns.iter().copied().filter(|c| !is_own(c)).collect();
            let is_rough = chosen
                .columns
                .iter()
                .any(|column| is_own(column) && self.is_rough.get(*column) == Some(&true));
            let shape = if is_rough { ROUGH_SHAPE } else { SHAPE };
            let Some(total) = rest(&others).map(|rest| rest - best) else { continue };
            let mut level = vec![others];
            for _ in 1..own {
                let next = self.extended(&information, &level);
                let first = next.first().map(|(_, set)| set.clone());
                if let Some(set) = first
                    && rest(&set).is_some_and(|rest| rest - best < (shape * total).max(self.penalty))
                {
                    return Some(set);
                }
                level = next.into_iter().take(BEAM).map(|(_, set)| set).collect();
            }
        }
        None
    }

    /// The sum of squares that a set leaves, less what the noise in its regressors must leave if it is right.
    #[must_use]
    pub fn rest_but_noise(
        &self,
        information: &Information,
        weights: &BySensor,
        set: &[usize],
    ) -> Option<f64> {
        let solution = information.solve(&self.positions(set))?;
        let noise = set.iter().zip(&solution.coefficients).map(|(column, coefficient)| {
            let weight = match self.candidates[*column].sensor() {
                Some(sensor) => weights[sensor.index()],
                None => weights.iter().sum(),
            };
            coefficient * coefficient * self.column_noise_m2[*column] * weight
        });
        Some(solution.rest - noise.sum::<f64>())
    }

    /// Where a candidate's column stands among the usable ones.
    #[must_use]
    pub fn position(&self, column: usize) -> Option<usize> {
        self.usable.iter().position(|usable| *usable == column)
    }

    /// Positions of several.
    #[must_use]
    pub fn positions(&self, columns: &[usize]) -> Vec<usize> {
        columns.iter().filter_map(|column| self.position(*column)).collect()
    }

    /// Whether a candidate's regressor is only roughly known.
    #[must_use]
    pub fn is_rough(&self, column: usize) -> bool {
        self.is_rough.get(column) == Some(&true)
    }

    /// Variance of the noise in a candidate's block means.
    #[must_use]
    pub fn column_noise_m2(&self, column: usize) -> f64 {
        self.column_noise_m2.get(column).copied().unwrap_or(0.0)
    }

    /// Whether two columns are of the same effect.
    #[must_use]
    pub fn same_effect(&self, a: usize, b: usize) -> bool {
        self.candidates[a].effect() == self.candidates[b].effect()
    }
}
