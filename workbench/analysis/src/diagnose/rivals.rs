//! Which candidates could stand in an explanation's place, and how probable each of them is.

use super::information::{Information, Solution};
use super::problem::Problem;
use super::search::{Explanation, Search};
use super::series::BySensor;
use super::simplicity::ROUGH_SHAPE;
use super::suspects::Suspects;

/// A candidate stands in for another where it explains all but this share of what the other explains
/// (squares). Regressors are made of measured signals, aligned to some hundredths of a second, by formulas that leave
/// terms out: their shape is known to some 15 to 20 %, and no statistics make it better.
pub const SHAPE: f64 = 0.03;
/// Twice the log likelihood by which it must be worse to be excluded: odds of 150 to 1.
const CLEARLY_WORSE: f64 = 10.0;

/// The candidates that could act in place of one that was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Rivals {
    /// The chosen column.
    pub column: usize,
    /// Columns of other effects that explain as much, the most probable first.
    pub others: Vec<usize>,
    /// Odds of each of the others against the chosen one's effect.
    pub odds: Vec<f64>,
    /// Squares that the chosen column explains and the others chosen do not.
    pub explained: f64,
    /// The probability that the chosen column's effect acts, where sets of effects have one ([`super::posterior`]).
    pub acts: Option<f64>,
    /// The probability that nothing acts in this place.
    pub empty: f64,
}

impl Rivals {
    /// Takes another column in, if its effect is not there yet.
    pub fn add(&mut self, column: usize, odds: f64) {
        self.others.push(column);
        self.odds.push(odds);
    }
}

/// A candidate in the place of a chosen one.
struct Stand {
    column: usize,
    /// Natural logarithm of its posterior probability but for a constant that all of one place share.
    log_weight: f64,
    /// Whether it can't be excluded; of the chosen effect's own columns, whether it is the chosen one.
    is_rival: bool,
}

/// Finds the rivals of every chosen column.
pub fn rivals(
    search: &mut Search<'_>,
    suspects: &Suspects<'_>,
    problem: &Problem<'_>,
    chosen: &Explanation,
) -> Vec<Rivals> {
    let information = suspects.information(problem, &chosen.fit.noise);
    let weights = problem.weight_of_white(&chosen.fit.noise);
    let at = suspects.positions(&chosen.columns);
    let Some(best) = information.solve(&at) else { return Vec::new() };
    let is_rough = chosen.columns.iter().any(|column| suspects.is_rough(*column));
    let explained_by_all = (information.total() - best.rest).max(0.0);
    let mut all = Vec::new();
    for column in &chosen.columns {
        let without: Vec<usize> = chosen.columns.iter().copied().filter(|other| other != column).collect();
        let kept = suspects.positions(&without);
        let explained = information.solve(&kept).map_or(0.0, |solution| solution.rest - best.rest);
        let place = Place {
            suspects,
            chosen,
            information: &information,
            weights: &weights,
            without: &without,
            best_rest: best.rest,
            explained,
            is_rough,
            explained_by_all,
        };
        let mut stands: Vec<Stand> = Vec::new();
        for other in suspects.usable().iter().copied() {
            let is_beside = without.iter().any(|column| suspects.same_effect(*column, other));
            if !is_beside && let Some(stand) = place.stand(search, other, other == *column) {
                stands.push(stand);
            }
        }
        place.add_pairs(&mut stands);
        all.push(place.rivals(*column, &stands));
    }
    all
}

/// The place of one chosen column.
struct Place<'a> {
    suspects: &'a Suspects<'a>,
    chosen: &'a Explanation,
    information: &'a Information,
    weights: &'a BySensor,
    without: &'a [usize],
    best_rest: f64,
    explained: f64,
    /// Whether a chosen regressor is only roughly known.
    is_rough: bool,
    /// Squares that all chosen columns explain together.
    explained_by_all: f64,
}

impl Place<'_> {
    /// A candidate in this place; `None` where nature does not allow what it would have to be.
    fn stand(&self, search: &mut Search<'_>, other: usize, is_chosen: bool) -> Option<Stand> {
        let mut set = self.without.to_vec();
        set.push(other);
        let solution = self.information.solve(&self.suspects.positions(&set))?;
        if !is_chosen && !self.suspects.is_possible(&set, &solution) {
            return None;
        }
        let mut worse = self.suspects.rest_but_noise(self.information, self.weights, &set)? - self.best_rest;
        let shape = if self.suspects.is_rough(other) { ROUGH_SHAPE } else { SHAPE };
        let mut is_rival = worse < shape * self.explained || worse < CLEARLY_WORSE;
        // Its own noise may suit it better; what that can gain is less than what is missing by far if
        // it explains next to nothing.
        let is_hopeless = worse > 0.7 * self.explained && worse > 10.0 * CLEARLY_WORSE;
        if !is_rival && !is_hopeless {
            set.sort_unstable();
            let fit = search.fit(&set, &self.chosen.fit.values);
            let behind = self.chosen.fit.twice_log_posterior - fit.twice_log_posterior;
            is_rival = behind < CLEARLY_WORSE;
            worse = worse.min(behind);
        }
        Some(Stand { column: other, log_weight: self.log_weight(other, worse, &solution), is_rival })
    }

    /// Logarithm of the marginal likelihood with a uniform prior over what nature allows (Laplace's method), for a regressor
    /// whose shape is known but for a share of its square: of what true effects explain, theirs and those beside them, as
    /// much is left in the mean as that share of it, beside the one that chance leaves.
    fn log_weight(&self, column: usize, worse: f64, solution: &Solution) -> f64 {
        let shape = if self.is_rough || self.suspects.is_rough(column) { ROUGH_SHAPE } else { SHAPE };
        let left = 1.0 + 0.5 * shape * self.explained_by_all;
        let [least, most] = self.suspects.range(column);
        let sigma = solution.covariance.last().map_or(f64::INFINITY, |variance| variance.sqrt());
        let occam = libm::log((sigma / (most - least)).min(1.0));
        -0.5 * worse.max(0.0) / left + occam
    }

    /// Two candidates that together fit better than the chosen one does are no worse an explanation for
    /// being two, unless the chosen one is there too; but the second must pay as every effect does. Nor are they a better one here: the
    /// search has weighed them, and a set that lists one of the two alone must not push out the chosen one.
    fn add_pairs(&self, stands: &mut Vec<Stand>) {
        let chosen = &self.chosen.columns;
        let usable: Vec<usize> = self
            .suspects
            .usable()
            .iter()
            .copied()
            .filter(|other| !chosen.iter().any(|column| self.suspects.same_effect(*column, *other)))
            .collect();
        let own = stands.iter().filter(|stand| chosen.contains(&stand.column));
        let of_chosen = own.map(|stand| stand.log_weight).fold(f64::NEG_INFINITY, f64::max);
        for (k, a) in usable.iter().enumerate() {
            for b in &usable[k + 1..] {
                if self.suspects.same_effect(*a, *b) {
                    continue;
                }
                let set: Vec<usize> = self.without.iter().copied().chain([*a, *b]).collect();
                if let Some(solution) = self.information.solve(&self.suspects.positions(&set))
                    && solution.rest < self.best_rest - CLEARLY_WORSE
                    && self.suspects.is_possible(&set, &solution)
                {
                    let worse = solution.rest - self.best_rest + self.suspects.penalty();
                    let log_weight = of_chosen - 0.5 * worse.max(0.0);
                    for column in [*a, *b] {
                        stands.push(Stand { column, log_weight, is_rival: true });
                    }
                }
            }
        }
    }

    /// The other effects that can't be excluded, with their odds.
    fn rivals(&self, column: usize, stands: &[Stand]) -> Rivals {
        // An effect's time constants are as probable as each other beforehand; a pair's weight is each of the two's.
        let best = |column: usize| {
            let own = || stands.iter().filter(|stand| self.suspects.same_effect(stand.column, column));
            let best = own().max_by(|a, b| a.log_weight.total_cmp(&b.log_weight))?;
            let columns = self
                .suspects
                .usable()
                .iter()
                .filter(|other| self.suspects.same_effect(**other, column))
                .count();
            let sum: f64 = own().map(|stand| libm::exp(stand.log_weight - best.log_weight)).sum();
            Some((best.column, best.log_weight + libm::log((sum / columns.max(1) as f64).min(1.0))))
        };
        let of_chosen = best(column).map_or(0.0, |(_, log_weight)| log_weight);
        let mut found: Vec<(f64, usize)> = Vec::new();
        for stand in stands.iter().filter(|stand| stand.is_rival) {
            let is_known = found.iter().any(|(_, seen)| self.suspects.same_effect(*seen, stand.column));
            if self.suspects.same_effect(stand.column, column) || is_known {
                continue;
            }
            if let Some((best, log_weight)) = best(stand.column) {
                found.push((libm::exp(log_weight - of_chosen), best));
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut rivals = Rivals {
            column,
            others: Vec::new(),
            odds: Vec::new(),
            explained: self.explained,
            acts: None,
            empty: 0.0,
        };
        for (odds, other) in found {
            rivals.add(other, odds);
        }
        rivals
    }
}
