//! Which effects act: the set of columns with the most probable explanation, with the noise fitted again for
//! every set that is tried.

use std::collections::BTreeMap;

use super::information::Information;
use super::problem::{NoiseFit, Problem};
use super::suspects::Suspects;
use crate::progress::{Cancelled, Progress, step};

/// Maximum number of effects that are searched for at once.
pub const MOST_EFFECTS: usize = 5;
/// Number of sets kept at every size while subsets are enumerated.
pub(super) const BEAM: usize = 12;
/// Number of subsets proposed in one round.
const PROPOSALS: usize = 5;
/// Number of neighbours of the best set proposed for every change of it.
const NEIGHBOURS: usize = 3;
const ROUNDS: usize = 8;
/// A set of effects and its noise.
#[derive(Clone, Debug)]
pub struct Explanation {
    /// Columns of the candidates, ascending.
    pub columns: Vec<usize>,
    /// The noise fitted with these columns.
    pub fit: NoiseFit,
}

/// The noise fitted with each set of columns that was tried.
pub type Seen = BTreeMap<Vec<usize>, NoiseFit>;

/// The search and the sets that it has tried.
pub struct Search<'a> {
    problem: &'a Problem<'a>,
    suspects: &'a Suspects<'a>,
    seen: Seen,
}

impl<'a> Search<'a> {
    /// A search among the suspects.
    #[must_use]
    pub const fn new(problem: &'a Problem<'a>, suspects: &'a Suspects<'a>) -> Self {
        Self { problem, suspects, seen: BTreeMap::new() }
    }

    /// A search that continues where another one of the same problem ended.
    #[must_use]
    pub const fn resumed(problem: &'a Problem<'a>, suspects: &'a Suspects<'a>, seen: Seen) -> Self {
        Self { problem, suspects, seen }
    }

    /// The sets that it has tried.
    #[must_use]
    pub fn into_seen(self) -> Seen {
        self.seen
    }

    /// The noise fitted with a set of columns.
    pub fn fit(&mut self, columns: &[usize], start: &[f64]) -> NoiseFit {
        match self.seen.get(columns) {
            Some(fit) => fit.clone(),
            None => self.fit_again(columns, start),
        }
    }

    /// Fits the noise of those sets that were not tried yet, in parallel.
    pub fn look_at(&mut self, sets: &[Vec<usize>], start: &[f64]) {
        let mut new: Vec<Vec<usize>> =
            sets.iter().filter(|set| !self.seen.contains_key(*set)).cloned().collect();
        new.sort();
        new.dedup();
        let fits = self.problem.fit_noises(&new, start);
        self.seen.extend(new.into_iter().zip(fits));
    }

    /// The better of the noise known for a set of columns and a fit from another start.
    fn fit_again(&mut self, columns: &[usize], start: &[f64]) -> NoiseFit {
        let fit = self.problem.fit_noise(&self.problem.prior, columns, start);
        let known =
            self.seen.get(columns).filter(|known| known.twice_log_posterior >= fit.twice_log_posterior);
        let best = known.cloned().unwrap_or(fit);
        self.seen.insert(columns.to_vec(), best.clone());
        best
    }

    fn score(&self, columns: &[usize], fit: &NoiseFit) -> f64 {
        self.suspects.penalty() * columns.len() as f64 - fit.twice_log_posterior
    }

    /// Searches for the most probable set.
    ///
    /// # Errors
    /// [`Cancelled`] when `progress` requests it.
    pub fn run(&mut self, progress: &mut Progress<'_>) -> Result<Explanation, Cancelled> {
        let start = self.problem.prior.means();
        let mut best = Explanation { columns: Vec::new(), fit: self.fit(&[], &start) };
        // Under the null's noise a slow effect looks like wander; under the prior's noise it stands out.
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
            for some in proposals.chunks(self.problem.width()) {
                self.look_at(some, &best.fit.values);
                for _ in some {
                    step(progress)?;
                }
            }
            for columns in std::mem::take(&mut proposals) {
                let fit = self.fit(&columns, &best.fit.values);
                if self.score(&columns, &fit) < self.score(&next.columns, &next.fit) {
                    next = Explanation { columns, fit };
                }
            }
            if next.columns == best.columns {
                // The smaller sets may have ended in a worse maximum of their likelihood: start from the best
                // one's noise.
                for left_out in &best.columns {
                    let columns: Vec<usize> =
                        best.columns.iter().copied().filter(|column| column != left_out).collect();
                    let fit = self.fit_again(&columns, &best.fit.values);
                    step(progress)?;
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
        Ok(best)
    }

    /// A set near the most probable one, from which another search continues: the better of the empty set and
    /// of the best one under the prior's noise.
    ///
    /// # Errors
    /// [`Cancelled`] when `progress` requests it.
    pub fn start(&mut self, progress: &mut Progress<'_>) -> Result<Explanation, Cancelled> {
        let start = self.problem.prior.means();
        let none = Explanation { columns: Vec::new(), fit: self.fit(&[], &start) };
        step(progress)?;
        let prior_noise = NoiseFit {
            noise: self.problem.prior.noise(&start),
            values: start,
            twice_log_posterior: f64::NEG_INFINITY,
        };
        let Some(columns) = self.proposals(&prior_noise, &[]).into_iter().next() else { return Ok(none) };
        let fit = self.fit(&columns, &none.fit.values);
        step(progress)?;
        let is_better = self.score(&columns, &fit) < self.score(&[], &none.fit);
        Ok(if is_better { Explanation { columns, fit } } else { none })
    }

    /// Sets worth a noise fit of their own: the best subsets under this noise, and the neighbours of a set.
    fn proposals(&self, fit: &NoiseFit, near: &[usize]) -> Vec<Vec<usize>> {
        let information = self.suspects.information(self.problem, &fit.noise);
        let mut sets: Vec<(f64, Vec<usize>)> = Vec::new();
        let mut level = vec![Vec::new()];
        for _ in 0..MOST_EFFECTS {
            let mut next = extended(self.suspects, &information, &level);
            next.truncate(BEAM);
            sets.extend(next.iter().cloned());
            level = next.into_iter().map(|(_, set)| set).collect();
        }
        sets.sort_by(|a, b| a.0.total_cmp(&b.0));
        sets.truncate(PROPOSALS);

        let best = |set: &[usize]| {
            extended(self.suspects, &information, &[set.to_vec()]).into_iter().take(NEIGHBOURS)
        };
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
}

/// The sets with one more column of another effect, the best first.
pub(super) fn extended(
    suspects: &Suspects<'_>,
    information: &Information,
    sets: &[Vec<usize>],
) -> Vec<(f64, Vec<usize>)> {
    let mut found: Vec<(f64, Vec<usize>)> = Vec::new();
    for set in sets {
        for column in suspects.usable() {
            let effect = suspects.candidate(*column).effect();
            if set.iter().any(|other| suspects.candidate(*other).effect() == effect) {
                continue;
            }
            let mut larger = set.clone();
            larger.push(*column);
            larger.sort_unstable();
            if found.iter().any(|(_, seen)| *seen == larger) {
                continue;
            }
            let at: Vec<usize> = larger.iter().filter_map(|column| suspects.position(*column)).collect();
            if let Some(solution) = information.solve(&at)
                && suspects.may_act(&larger, &solution)
            {
                found.push((solution.rest + suspects.penalty() * larger.len() as f64, larger));
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}
