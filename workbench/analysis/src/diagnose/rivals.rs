//! Which candidates could replace an explanation's effects, and how probable each of them is.

use std::collections::BTreeMap;

use kf_core::effect::EffectId;

use super::coefficient_prior::CoefficientPrior;
use super::information::{Information, Solution};
use super::noise::Noise;
use super::physical_range::stands_in;
use super::problem::{NoiseFit, Problem};
use super::search::{Explanation, Search};
use super::series::BySensor;
use super::shape_error;
use super::suspects::Suspects;
use super::weigher::{INCLUSION, POWER};

/// A pair of candidates is considered where its remainder is smaller than the chosen effect's by this, in
/// squares under the chosen noise.
const CLEARLY_BETTER: f64 = 10.0;
/// Maximum number of pairs, the best ones, that get a noise fit of their own.
const PAIRS: usize = 3;
/// A candidate whose remainder exceeds the chosen one's by more squares than this, and by more than
/// [`HOPELESS`] of what the chosen one explains, is judged under the chosen one's noise: its odds are then
/// below one in a hundred wherever the power is a tenth or more. That saves most of the time. What a noise
/// fit of its own would gain has been checked on the development seeds only.
const FAR: f64 = 100.0;
/// Share of what the chosen effect explains, see [`FAR`].
const HOPELESS: f64 = 0.7;

/// The candidates that could act in place of a chosen one.
#[derive(Clone, Debug, PartialEq)]
pub struct Rivals {
    /// The chosen column.
    pub column: usize,
    /// Columns of other effects that explain as much, the most probable first.
    pub others: Vec<usize>,
    /// Odds of each of the others against the chosen one's effect.
    pub odds: Vec<f64>,
    /// Squares that the chosen column explains and the other chosen ones do not.
    pub explained: f64,
    /// The probability that the chosen column's effect acts, where sets of effects have probabilities
    /// ([`super::posterior`]).
    pub acts: Option<f64>,
    /// Odds of nothing acting in this place against the chosen one's effect.
    pub odds_of_nothing: f64,
    /// Whether the chosen effect is larger than physically possible, and so stands in for another one
    /// ([`stands_in`]).
    pub is_stand_in: bool,
    /// Whether a dynamic pressure may be a part of an angle of attack (`judge/lift.rs`).
    pub is_part_of_lift: bool,
    /// Whether the evidence was too little for the search to choose the effect (`judge/weak.rs`). It is not
    /// identified then, however improbable the others are.
    pub is_weak: bool,
}

impl Rivals {
    /// Adds another column, if its effect is not there yet.
    pub fn add(&mut self, column: usize, odds: f64) {
        self.others.push(column);
        self.odds.push(odds);
    }
}

/// Finds the rivals of every chosen column; `inflation` is the factor by which the variance of each
/// coefficient exceeds that of its fit.
pub fn rivals(
    search: &mut Search<'_>,
    suspects: &Suspects<'_>,
    problem: &Problem<'_>,
    chosen: &Explanation,
    inflation: &[f64],
) -> Vec<Rivals> {
    let information = suspects.information(problem, &chosen.fit.noise);
    let weights = problem.weight_of_white(&chosen.fit.noise);
    let Some(best) = information.solve(&suspects.positions(&chosen.columns)) else { return Vec::new() };
    let mut all = Vec::new();
    for (k, column) in chosen.columns.iter().enumerate() {
        let without: Vec<usize> = chosen.columns.iter().copied().filter(|other| other != column).collect();
        let kept = suspects.positions(&without);
        let explained = information.solve(&kept).map_or(0.0, |solution| solution.rest - best.rest);
        let place = Place {
            suspects,
            problem,
            chosen,
            information: &information,
            weights: &weights,
            column: *column,
            without: &without,
            best_rest: best.rest,
            explained,
            power: POWER.min(1.0 / inflation.get(k).copied().unwrap_or(1.0)),
            is_stand_in: stands_in(
                suspects.candidate(*column).effect(),
                best.coefficients[k],
                best.covariance[k * best.coefficients.len() + k].sqrt(),
            ),
        };
        all.push(place.rivals(search));
    }
    all
}

/// The place of one chosen column.
struct Place<'a> {
    suspects: &'a Suspects<'a>,
    problem: &'a Problem<'a>,
    chosen: &'a Explanation,
    information: &'a Information,
    weights: &'a BySensor,
    column: usize,
    without: &'a [usize],
    best_rest: f64,
    explained: f64,
    /// The power of the likelihood where shapes have no errors.
    power: f64,
    is_stand_in: bool,
}

/// Another effect in the place of a chosen one.
struct Nearest {
    /// Its best column.
    column: usize,
    /// The set with it, ascending.
    set: Vec<usize>,
    /// Squares by which its remainder exceeds the chosen one's, under the chosen one's noise.
    behind: f64,
    /// Whether a noise fit of its own would not help it.
    is_hopeless: bool,
}

impl Place<'_> {
    fn rivals(&self, search: &mut Search<'_>) -> Rivals {
        // Weight of each effect: its logarithm relative to the chosen effect's, and the column it belongs to.
        let mut found: BTreeMap<EffectId, (f64, usize)> = BTreeMap::new();
        let nearest: Vec<Nearest> =
            self.others().into_iter().filter_map(|effect| self.nearest(effect)).collect();
        let near = nearest.iter().filter(|nearest| !nearest.is_hopeless);
        search.look_at(&near.map(|nearest| nearest.set.clone()).collect::<Vec<_>>(), &self.chosen.fit.values);
        for nearest in nearest {
            let log_weight = self.log_weight(search, &nearest);
            found.insert(self.effect(nearest.column), (log_weight, nearest.column));
        }
        for (log_weight, pair) in self.pairs(search) {
            for column in pair {
                let slot = found.entry(self.effect(column)).or_insert((log_weight, column));
                if log_weight > slot.0 {
                    *slot = (log_weight, column);
                }
            }
        }
        let mut found: Vec<(f64, usize)> =
            found.into_values().map(|(log_weight, column)| (libm::exp(log_weight), column)).collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut rivals = Rivals {
            column: self.column,
            others: Vec::new(),
            odds: Vec::new(),
            explained: self.explained,
            acts: None,
            odds_of_nothing: 0.0,
            is_stand_in: self.is_stand_in,
            is_part_of_lift: false,
            is_weak: false,
        };
        let share = self.share_of_time_constants();
        for (odds, other) in found {
            rivals.add(other, odds / share);
        }
        rivals
    }

    fn effect(&self, column: usize) -> EffectId {
        self.suspects.candidate(column).effect()
    }

    /// The share of the chosen effect's time constants that fit as well as the chosen one. They are equally
    /// probable, so an effect that needs a special one is less probable: a drift is a warming up that has not
    /// yet begun to level off, and one of many time constants fits its noise better.
    fn share_of_time_constants(&self) -> f64 {
        let effect = self.effect(self.column);
        if !effect.has_time_constant() {
            return 1.0;
        }
        let own = self.suspects.usable().iter().copied().filter(|column| self.effect(*column) == effect);
        let behind = own.map(|column| {
            let set = self.with(&[column]);
            let solution = self.information.solve(&self.suspects.positions(&set));
            let possible = solution.filter(|solution| self.suspects.is_possible(&set, solution));
            possible.map_or(f64::INFINITY, |solution| solution.rest - self.best_rest)
        });
        share(behind, self.power)
    }

    /// The effects that are not chosen.
    fn others(&self) -> Vec<EffectId> {
        let is_chosen =
            |effect: &EffectId| self.chosen.columns.iter().any(|column| self.effect(*column) == *effect);
        let mut effects: Vec<EffectId> =
            self.suspects.usable().iter().map(|column| self.effect(*column)).collect();
        effects.sort_unstable();
        effects.dedup();
        effects.retain(|effect| !is_chosen(effect));
        effects
    }

    /// The best column of another effect in this place. `None` where the coefficient would be physically
    /// impossible.
    fn nearest(&self, effect: EffectId) -> Option<Nearest> {
        let mut worse: Vec<(f64, usize)> = Vec::new();
        for column in self.suspects.usable().iter().copied().filter(|column| self.effect(*column) == effect) {
            let set = self.with(&[column]);
            if let Some(solution) = self.information.solve(&self.suspects.positions(&set))
                && self.suspects.may_act(&set, &solution)
                && let Some(rest) = self.suspects.rest_but_noise(self.information, self.weights, &set)
            {
                worse.push((rest - self.best_rest, column));
            }
        }
        let (behind, column) = worse.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0))?;
        let is_hopeless = behind > HOPELESS * self.explained && behind > FAR;
        Some(Nearest { column, set: self.with(&[column]), behind, is_hopeless })
    }

    /// The weight of another effect in this place relative to the chosen column. Neither the number of time
    /// constants tried nor the range of its coefficient counts against it, because the likelihood that would
    /// compensate for it is tempered.
    fn log_weight(&self, search: &mut Search<'_>, nearest: &Nearest) -> f64 {
        let Nearest { set, behind, is_hopeless, .. } = nearest;
        let chosen = &self.chosen.fit;
        let (behind, power) = if *is_hopeless {
            (*behind, self.tempered(&chosen.noise, set, &[self.column]))
        } else {
            let fit = search.fit(set, &chosen.values);
            let behind = chosen.twice_log_posterior - fit.twice_log_posterior;
            (behind.max(0.0), self.tempered(&fit.noise, set, &[self.column]))
        };
        -0.5 * power * behind
    }

    /// The columns outside this place plus these, ascending.
    fn with(&self, columns: &[usize]) -> Vec<usize> {
        let mut set: Vec<usize> = self.without.iter().copied().chain(columns.iter().copied()).collect();
        set.sort_unstable();
        set
    }

    /// The power of the likelihood of a set with further columns against that set alone, if the set is right.
    /// Zero where the two cannot be told apart: their likelihoods then differ by rounding.
    fn tempered(&self, noise: &Noise, set: &[usize], further: &[usize]) -> f64 {
        let Some(of_shapes) = shape_error::variance(self.problem, self.suspects, noise, set, further) else {
            return 0.0;
        };
        1.0 / (1.0 / self.power + of_shapes)
    }

    /// Two candidates that together fit better than the chosen one are not a worse explanation for being two.
    /// But the second must pay as every effect does: for its inclusion, and for the prior of its coefficient.
    /// Where the chosen one with one of them is worth that too, the pair is compared with these two. The pair
    /// is not a better explanation here either: the search has weighed it, and a set that lists one of the
    /// two alone must not displace the chosen one.
    fn pairs(&self, search: &mut Search<'_>) -> Vec<(f64, [usize; 2])> {
        let others = self.others();
        let usable: Vec<usize> = self
            .suspects
            .usable()
            .iter()
            .copied()
            .filter(|column| others.contains(&self.effect(*column)))
            .collect();
        let mut better: Vec<(f64, [usize; 2], Solution)> = Vec::new();
        for (k, a) in usable.iter().enumerate() {
            for b in &usable[k + 1..] {
                if self.suspects.same_effect(*a, *b) {
                    continue;
                }
                let set: Vec<usize> = self.without.iter().copied().chain([*a, *b]).collect();
                if let Some(solution) = self.information.solve(&self.suspects.positions(&set))
                    && solution.rest < self.best_rest - CLEARLY_BETTER
                    && self.suspects.may_act(&set, &solution)
                {
                    better.push((solution.rest, [*a, *b], solution));
                }
            }
        }
        better.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut pairs: Vec<(f64, [usize; 2])> = Vec::new();
        for (_, pair, solution) in better {
            let is_known = |other: &[usize; 2]| (0..2).all(|k| self.suspects.same_effect(other[k], pair[k]));
            if pairs.len() == PAIRS || pairs.iter().any(|(_, other)| is_known(other)) {
                continue;
            }
            pairs.push((self.of_pair(search, pair, &solution), pair));
        }
        pairs
    }

    /// The weight of a pair with that solution (the pair's coefficients last) relative to the chosen column.
    fn of_pair(&self, search: &mut Search<'_>, pair: [usize; 2], solution: &Solution) -> f64 {
        let chosen = &self.chosen.fit;
        let set = self.with(&pair);
        let fit = search.fit(&set, &chosen.values);
        // The chosen one with one of the pair, if that is worth it.
        let mut beside: Option<(f64, usize, NoiseFit)> = None;
        for column in pair {
            let columns = self.with(&[self.column, column]);
            let Some(solution) = self.information.solve(&self.suspects.positions(&columns)) else { continue };
            if !self.suspects.is_possible(&columns, &solution) {
                continue;
            }
            let fit = search.fit(&columns, &chosen.values);
            let ahead = fit.twice_log_posterior - chosen.twice_log_posterior;
            let at = columns.iter().position(|other| *other == column).unwrap_or_default();
            let worth = 0.5 * self.tempered(&chosen.noise, &self.chosen.columns, &[column]) * ahead
                + price(self.effect(column), &solution, at);
            if worth > beside.as_ref().map_or(0.0, |(most, ..)| *most) {
                beside = Some((worth, column, fit));
            }
        }
        let (against, right, further, price) = match &beside {
            Some((_, column, with)) => {
                let further = pair.iter().copied().filter(|other| other != column).collect();
                (with, self.with(&[self.column, *column]), further, 0.0)
            }
            None => {
                let n = set.len();
                let price = price(self.effect(pair[0]), solution, n - 2).max(price(
                    self.effect(pair[1]),
                    solution,
                    n - 1,
                ));
                (chosen, self.chosen.columns.clone(), pair.to_vec(), price)
            }
        };
        let ahead = fit.twice_log_posterior - against.twice_log_posterior;
        let power = if ahead > 0.0 {
            self.tempered(&against.noise, &right, &further)
        } else {
            self.tempered(&fit.noise, &set, &[self.column])
        };
        (0.5 * power * ahead + price).min(0.0)
    }
}

/// The share of an effect's columns that fit as well as the best one, from the squares by which each is behind
/// it.
#[must_use]
pub fn share(behind: impl Iterator<Item = f64>, power: f64) -> f64 {
    let weights: Vec<f64> = behind.map(|squares| libm::exp(-0.5 * power * squares.max(0.0))).collect();
    weights.iter().sum::<f64>() / weights.len() as f64
}

/// The price of an effect (the logarithm of its prior odds and of Occam's factor), whose coefficient is at
/// this position of a solution.
#[must_use]
pub fn price(effect: EffectId, solution: &Solution, at: usize) -> f64 {
    let n = solution.coefficients.len();
    let variance = solution.covariance[at * n + at];
    let prior = CoefficientPrior::of(effect, effect.plausible().map(f64::from));
    prior.log_density(solution.coefficients[at], variance)
        + 0.5 * libm::log(2.0 * std::f64::consts::PI * variance)
        + libm::log(INCLUSION / (1.0 - INCLUSION))
}
