//! How probable each set of effects is, where the climb rate is not measured.
//!
//! The weight of a set is its marginal likelihood: the noise is fitted again with the set, its coefficients
//! are integrated out in closed form over their priors ([`CoefficientPrior`]), and time constants over the
//! grid. Sets are considered as in Occam's window (Madigan and Raftery, "Model selection and accounting for
//! model uncertainty in graphical models using Occam's window", Journal of the American Statistical
//! Association 89, 1994): starting from the best one, those with one effect more, one less or another one, as
//! long as their weight is close to the best.
//!
//! The noise is not a Gauss-Markov process and the formulas are not exact, so the likelihood is raised to a
//! power below one (Miller and Dunson, "Robust Bayesian inference via coarsening", Journal of the American
//! Statistical Association 114, 2019). Sets are compared with the best one pair by pair, each pair with a
//! power of its own ([`Weigher::ahead`]). With these powers the probabilities are right about as often as they
//! state, on the development half of `docs/blind-trials.md`.
//!
//! A pressure altitude differs from the height in proportion to the air's deviation from the standard
//! temperature. So each set includes a scale, with a prior of one kelvin where the set has no scale effect.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use kf_core::effect::EffectId;
use kf_core::sensor::Sensor;

use super::coefficient_prior::CoefficientPrior;
use super::information::Information;
use super::problem::{NoiseFit, Problem};
use super::repeatability::{inflation, repeatability};
use super::rivals::Rivals;
use super::roughness::unsteadiness;
use super::search::{Explanation, MOST_EFFECTS, Search};
use super::shape_error;
use super::suspects::Suspects;
use crate::progress::{Cancelled, Progress, step};

/// The power of the likelihood where formulas are exact: by the reliability diagram of `cargo xtask real-trials
/// --half development`.
pub const POWER: f64 = 0.7;
/// The share (squares) of what the effects explain that errors of formulas and signals may make.
pub const SHAPE: f64 = 0.01;
/// Prior probability that an effect acts.
pub(super) const INCLUSION: f64 = 0.1;
/// Sets are considered while their weight is at most this far (natural logarithm) below that of the best one:
/// 0.2 %.
const WINDOW: f64 = 6.0;
/// Number of sets whose noise is fitted in a round, and number of rounds.
const REFITTED: usize = 3;
const ROUNDS: usize = 6;

/// A noise, and the normal equations of all usable columns under it.
struct Basis {
    fit: NoiseFit,
    information: Information,
}

/// A set of effects.
#[derive(Clone)]
struct Weighed {
    /// Its columns without the scale, ascending, each effect's most probable one.
    bare: Vec<usize>,
    /// Whether a scale effect is in it, too.
    has_scale: bool,
    basis: Rc<Basis>,
    /// Natural logarithm of the likelihood.
    likelihood: f64,
    /// Natural logarithm of its weight with [`POWER`], up to a constant.
    log_weight: f64,
}

/// Probabilities of sets of effects.
#[derive(Clone, Debug, Default)]
pub struct Posterior {
    /// Sets with their probabilities, the most probable first.
    sets: Vec<(Vec<usize>, f64)>,
    effects: BTreeMap<usize, EffectId>,
}

/// Weighs the sets around the one that a search found.
///
/// # Errors
/// [`Cancelled`] when `progress` requests it.
pub fn posterior(
    search: &mut Search<'_>,
    suspects: &Suspects<'_>,
    problem: &Problem<'_>,
    found: &Explanation,
    progress: &mut Progress<'_>,
) -> Result<Posterior, Cancelled> {
    let effect = |column: usize| suspects.candidate(column).effect();
    let scale = suspects.usable().iter().copied().find(|column| effect(*column) == EffectId::BaroScale);
    let flies = |sensor: &&Sensor| {
        sensor.flies_free() && problem.flights.iter().any(|flight| flight.has(sensor.index()))
    };
    let is_alone = Sensor::ALL.iter().filter(flies).count() < 2;
    let mut weigher = Weigher { suspects, problem, scale, is_alone, inflation: BTreeMap::new() };
    let mut sets: BTreeMap<Vec<EffectId>, Weighed> = BTreeMap::new();
    let mut refitted: BTreeSet<Vec<EffectId>> = BTreeSet::new();
    let mut start: Vec<usize> = Vec::new();
    for column in found.columns.iter().copied().filter(|column| Some(*column) != scale) {
        if !weigher.has_like(&start, column) {
            start.push(column);
        }
    }
    let basis = weigher.basis(search, &start, &found.fit.values);
    step(progress)?;
    refitted.insert(weigher.effects(&start));
    let mut best: Option<Weighed> = None;
    for (effects, weighed) in weigher.weigh(&basis, &start) {
        best = Some(weigher.heavier(best, &weighed));
        sets.insert(effects, weighed);
    }
    let Some(mut best) = best else { return Ok(Posterior::default()) };
    for _ in 0..ROUNDS {
        // First all sets around the best one under its noise, then the nearest ones with their own.
        let mut near: Vec<(f64, Vec<usize>)> = Vec::new();
        for columns in weigher.around(&best) {
            for (effects, weighed) in weigher.weigh(&best.basis, &columns) {
                if refitted.contains(&weigher.effects(&weighed.bare)) {
                    continue;
                }
                let ahead = weigher.ahead(&weighed, &best);
                if ahead > -WINDOW {
                    near.push((ahead, weighed.bare.clone()));
                }
                let slot = sets.entry(effects).or_insert_with(|| weighed.clone());
                if weighed.log_weight > slot.log_weight {
                    *slot = weighed;
                }
            }
        }
        near.sort_by(|a, b| b.0.total_cmp(&a.0));
        // The nearest of each set of effects.
        let mut nearest: Vec<(Vec<EffectId>, Vec<usize>)> = Vec::new();
        for (_, columns) in near {
            let effects = weigher.effects(&columns);
            if nearest.len() < REFITTED && nearest.iter().all(|(others, _)| *others != effects) {
                nearest.push((effects, columns));
            }
        }
        let count = nearest.len();
        let with_scale: Vec<_> = nearest.iter().map(|(_, columns)| weigher.with_scale(columns)).collect();
        let values = best.basis.fit.values.clone();
        search.look_at(&with_scale, &values);
        let before = weigher.effects(&best.bare);
        let mut next = best.clone();
        for (effects, columns) in nearest {
            let basis = weigher.basis(search, &columns, &values);
            step(progress)?;
            for (effects, weighed) in weigher.weigh(&basis, &columns) {
                next = weigher.heavier(Some(next), &weighed);
                sets.insert(effects, weighed);
            }
            refitted.insert(effects);
        }
        best = next;
        if weigher.effects(&best.bare) != before || count == REFITTED {
            continue;
        }
        // Of the best set's effects, those that differ from part to part of the flights are evidence of less:
        // another set may now be the best one.
        let columns = weigher.columns(&best);
        let noise = &best.basis.fit.noise;
        let factors = inflation(problem, noise, &columns, &repeatability(problem, noise, &columns));
        step(progress)?;
        for (column, factor) in columns.iter().zip(factors) {
            let slot = weigher.inflation.entry(effect(*column)).or_insert(1.0);
            *slot = slot.max(factor);
        }
        let now = sets.values().fold(best.clone(), |most, set| weigher.heavier(Some(most), set));
        if weigher.effects(&weigher.columns(&now)) == weigher.effects(&columns) {
            break;
        }
        best = now;
    }
    Ok(weigher.normalised(&sets, &best))
}

struct Weigher<'a> {
    suspects: &'a Suspects<'a>,
    problem: &'a Problem<'a>,
    /// The scale's column.
    scale: Option<usize>,
    /// Whether at most one sensor flies free.
    is_alone: bool,
    /// For effects of the best set, the factor by which the variance of their coefficient exceeds that of the
    /// fit.
    inflation: BTreeMap<EffectId, f64>,
}

impl Weigher<'_> {
    fn effects(&self, columns: &[usize]) -> Vec<EffectId> {
        let mut effects: Vec<EffectId> =
            columns.iter().map(|column| self.suspects.candidate(*column).effect()).collect();
        effects.sort_unstable();
        effects
    }

    /// Whether a set has a column's effect, or one that is the same with the other sign: with one sensor
    /// against the receiver, a late barometer is an early receiver, and a barometer that warms up is a
    /// receiver that converges. Both together would only cancel each other.
    fn has_like(&self, set: &[usize], column: usize) -> bool {
        let effect = |column: usize| match self.suspects.candidate(column).effect() {
            EffectId::GpsConvergence if self.is_alone => EffectId::BaroWarmUp,
            EffectId::GpsLatency if self.is_alone => EffectId::BaroLag,
            effect => effect,
        };
        set.iter().any(|other| effect(*other) == effect(column))
    }

    /// The columns, and the scale's column.
    fn with_scale(&self, columns: &[usize]) -> Vec<usize> {
        let mut all: Vec<usize> = columns.iter().copied().chain(self.scale).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The noise fitted with these columns and the scale.
    fn basis(&self, search: &mut Search<'_>, columns: &[usize], start: &[f64]) -> Rc<Basis> {
        let fit = search.fit(&self.with_scale(columns), start);
        let information = self.suspects.information(self.problem, &fit.noise);
        Rc::new(Basis { fit, information })
    }

    /// A set's columns, the scale's among them if it is an effect.
    fn columns(&self, set: &Weighed) -> Vec<usize> {
        if set.has_scale { self.with_scale(&set.bare) } else { set.bare.clone() }
    }

    /// The more probable of two sets.
    fn heavier(&self, best: Option<Weighed>, other: &Weighed) -> Weighed {
        match best {
            Some(best) if self.ahead(other, &best) <= 0.0 => best,
            _ => other.clone(),
        }
    }

    /// The logarithm of a set's odds against another one.
    ///
    /// If the one of lower likelihood is right, the errors of its effects' shapes may be what makes the other
    /// one likelier; so the power of the likelihood falls with the variance that they leave in the direction
    /// in which both differ ([`shape_error`]), and is no larger than the other one's coefficients there are
    /// certain ([`inflation`]). A large fast effect thus takes nothing from the evidence for a slow one. For a
    /// set that is far behind, an upper bound is returned.
    fn ahead(&self, set: &Weighed, other: &Weighed) -> f64 {
        let at = |power: f64| match (self.log_weight(set, power), self.log_weight(other, power)) {
            (Some(of_set), Some(of_other)) => of_set - of_other,
            _ => f64::NEG_INFINITY,
        };
        let (worse, better) = if set.likelihood < other.likelihood { (set, other) } else { (other, set) };
        let kept = self.columns(worse);
        let added: Vec<usize> =
            self.columns(better).into_iter().filter(|column| !self.has_like(&kept, *column)).collect();
        let inflation = added
            .iter()
            .filter_map(|column| self.inflation.get(&self.suspects.candidate(*column).effect()).copied());
        let base = inflation.fold(1.0 / POWER, f64::max);
        let (whole, information) = (at(1.0 / base), &worse.basis.information);
        // Nothing acts whose shape could be wrong, or both sets have the same effects.
        if kept.is_empty() || added.is_empty() {
            return whole;
        }
        let rest = information.solve(&self.suspects.positions(&kept)).map_or(0.0, |solution| solution.rest);
        // Errors leave most where both differ in one half of the flight only.
        let most = 0.5 * SHAPE * (information.total() - rest).max(0.0);
        let least = at(1.0 / (base + most));
        if whole.max(least) < -2.0 * WINDOW {
            return whole.max(least);
        }
        let noise = &worse.basis.fit.noise;
        let of_shapes = shape_error::variance(self.problem, self.suspects, noise, &kept, &added);
        at(1.0 / (base + of_shapes.map_or(most, |of_shapes| of_shapes.min(most))))
    }

    /// Sets with one effect less, one more or another one, all without the scale.
    fn around(&self, best: &Weighed) -> Vec<Vec<usize>> {
        let effect = |column: usize| self.suspects.candidate(column).effect();
        let information = &best.basis.information;
        let mut bases = vec![best.bare.clone()];
        for left_out in &best.bare {
            bases.push(best.bare.iter().copied().filter(|column| column != left_out).collect());
        }
        let mut around = bases.clone();
        around.push(Vec::new());
        for base in &bases {
            if base.len() >= MOST_EFFECTS {
                continue;
            }
            // For each effect, the column that fits best.
            let mut of_effect: BTreeMap<EffectId, (f64, Vec<usize>)> = BTreeMap::new();
            for column in self.suspects.usable().iter().copied() {
                if self.has_like(base, column) || Some(column) == self.scale {
                    continue;
                }
                let mut set = base.clone();
                set.push(column);
                set.sort_unstable();
                let positions = self.suspects.positions(&self.with_scale(&set));
                let Some(solution) = information.solve(&positions) else { continue };
                let slot = of_effect.entry(effect(column)).or_insert((f64::INFINITY, Vec::new()));
                if solution.rest < slot.0 {
                    *slot = (solution.rest, set);
                }
            }
            around.extend(of_effect.into_values().map(|(_, set)| set));
        }
        around
    }

    /// A set of columns under a noise, with the air's scale alone and with a scale effect.
    fn weigh(&self, basis: &Rc<Basis>, columns: &[usize]) -> Vec<(Vec<EffectId>, Weighed)> {
        let mut weighed = Vec::new();
        for has_scale in [false, true] {
            if has_scale && (self.scale.is_none() || columns.len() >= MOST_EFFECTS) {
                continue;
            }
            let Some((likelihood, _)) = self.of_columns(basis, columns, has_scale, POWER) else { continue };
            let basis = Rc::clone(basis);
            let mut set = Weighed { bare: columns.to_vec(), has_scale, basis, likelihood, log_weight: 0.0 };
            let Some(log_weight) = self.log_weight(&set, POWER) else { continue };
            set.log_weight = log_weight;
            weighed.push((self.effects(&self.columns(&set)), set));
        }
        weighed
    }

    /// The logarithm of a set's weight with that power of the likelihood: the mean over the grids of time
    /// constants, one effect after the other.
    fn log_weight(&self, set: &Weighed, power: f64) -> Option<f64> {
        let (_, log_weight) = self.of_columns(&set.basis, &set.bare, set.has_scale, power)?;
        let mut sum = log_weight;
        for (k, column) in set.bare.iter().enumerate() {
            let grid =
                self.suspects.usable().iter().filter(|other| self.suspects.same_effect(**other, *column));
            let mut count = 0_u32;
            let mut share = 0.0;
            for other in grid {
                count += 1;
                let mut columns = set.bare.clone();
                columns[k] = *other;
                if let Some((_, weight)) = self.of_columns(&set.basis, &columns, set.has_scale, power) {
                    share += libm::exp((weight - log_weight).min(0.0));
                }
            }
            sum += libm::log(share / f64::from(count.max(1)));
        }
        Some(sum)
    }

    /// The logarithms of the likelihood and of the weight of these columns.
    fn of_columns(
        &self,
        basis: &Basis,
        columns: &[usize],
        has_scale: bool,
        power: f64,
    ) -> Option<(f64, f64)> {
        let Basis { fit, information } = basis;
        let all = self.with_scale(columns);
        let positions = self.suspects.positions(&all);
        let of_air = unsteadiness(EffectId::BaroScale, false) * power.sqrt();
        let believed: Vec<f64> = all
            .iter()
            .map(|column| if Some(*column) == self.scale && !has_scale { of_air } else { f64::INFINITY })
            .collect();
        let solution = information.solve_with_prior(&positions, &believed)?;
        let noise = self.problem.prior.log_density(&fit.values);
        let likelihood = 0.5 * information.twice_log_determinant() - 0.5 * solution.rest + noise;
        let n = all.len();
        let mut weight = power * likelihood;
        // The determinant of the covariance, tempered as the likelihood is.
        weight +=
            0.5 * solution.log_determinant + 0.5 * n as f64 * libm::log(2.0 * std::f64::consts::PI / power);
        for (k, column) in all.iter().enumerate() {
            let variance = solution.covariance[k * n + k] / power;
            let effect = self.suspects.candidate(*column).effect();
            if Some(*column) == self.scale && !has_scale {
                let own = unsteadiness(effect, false);
                weight -= libm::log(own * (2.0 * std::f64::consts::PI).sqrt());
            } else {
                let unsteady = unsteadiness(effect, false);
                let rough = self.suspects.scale(*column) * solution.coefficients[k];
                let prior = CoefficientPrior::of(effect, self.suspects.range(*column));
                weight += prior
                    .log_density(solution.coefficients[k], variance + unsteady * unsteady + rough * rough);
                weight += libm::log(INCLUSION / (1.0 - INCLUSION));
            }
        }
        Some((likelihood, weight))
    }

    fn normalised(&self, sets: &BTreeMap<Vec<EffectId>, Weighed>, best: &Weighed) -> Posterior {
        let weights: Vec<(Vec<usize>, f64)> =
            sets.values().map(|set| (self.columns(set), libm::exp(self.ahead(set, best)))).collect();
        let total: f64 = weights.iter().map(|(_, weight)| weight).sum();
        let mut found: Vec<(Vec<usize>, f64)> =
            weights.into_iter().map(|(columns, weight)| (columns, weight / total)).collect();
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        let usable = self.suspects.usable().iter();
        let effects = usable.map(|column| (*column, self.suspects.candidate(*column).effect())).collect();
        Posterior { sets: found, effects }
    }
}

impl Posterior {
    /// The columns of the most probable set.
    #[must_use]
    pub fn best(&self) -> Vec<usize> {
        self.sets.first().map_or_else(Vec::new, |(columns, _)| columns.clone())
    }

    /// The probability that an effect acts.
    #[must_use]
    pub fn inclusion(&self, effect: EffectId) -> f64 {
        self.share(|set| self.has(set, effect))
    }

    /// What could replace a column of the most probable set: another effect, with its share of the sets that
    /// contain it but not the column's effect; and the probability that the place is empty.
    #[must_use]
    pub fn rivals(&self, column: usize, chosen: &[usize], explained: f64) -> Rivals {
        let own = self.effects.get(&column).copied();
        let lacks_own = |set: &[usize]| own.is_none_or(|own| !self.has(set, own));
        let is_chosen = |effect: EffectId| self.has(chosen, effect);
        let mut columns: BTreeMap<EffectId, (f64, usize)> = BTreeMap::new();
        for (set, probability) in self.sets.iter().filter(|(set, _)| lacks_own(set)) {
            for other in set {
                if let Some(effect) = self.effects.get(other).copied().filter(|effect| !is_chosen(*effect)) {
                    columns.entry(effect).or_insert((0.0, *other)).0 += probability;
                }
            }
        }
        let acts = own.map_or(0.0, |own| self.inclusion(own)).max(f64::MIN_POSITIVE);
        let mut found: Vec<(f64, usize)> = columns.into_values().collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let empty =
            self.share(|set| lacks_own(set) && set.iter().all(|other| self.has(chosen, self.effects[other])));
        let mut rivals = Rivals {
            column,
            others: Vec::new(),
            odds: Vec::new(),
            explained,
            acts: Some(acts),
            empty,
            is_stand_in: false,
        };
        for (probability, other) in found {
            rivals.add(other, probability / acts);
        }
        rivals
    }

    fn has(&self, set: &[usize], effect: EffectId) -> bool {
        set.iter().any(|column| self.effects.get(column) == Some(&effect))
    }

    fn share(&self, of: impl Fn(&[usize]) -> bool) -> f64 {
        self.sets.iter().filter(|(set, _)| of(set)).map(|(_, probability)| probability).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::small_problems::{NOISE, Small, problem, sine};
    use super::*;

    /// Sets of columns of three effects: a lag with two columns, a scale and a drift with one each.
    fn posterior() -> Posterior {
        let effects = [
            (1, EffectId::BaroLag),
            (2, EffectId::BaroLag),
            (5, EffectId::BaroScale),
            (8, EffectId::BaroDrift),
        ];
        Posterior {
            sets: vec![
                (vec![2], 0.5),
                (vec![5], 0.2),
                (vec![1, 8], 0.15),
                (vec![5, 8], 0.1),
                (Vec::new(), 0.05),
            ],
            effects: effects.into_iter().collect(),
        }
    }

    /// The best set is the first; an effect acts with the probability of all sets that contain any of its
    /// columns.
    #[test]
    fn an_effect_acts_in_the_sets_that_have_it() {
        let found = posterior();
        assert_eq!(found.best(), [2]);
        for (effect, wanted) in
            [(EffectId::BaroLag, 0.65), (EffectId::BaroScale, 0.3), (EffectId::BaroDrift, 0.25)]
        {
            assert!((found.inclusion(effect) - wanted).abs() < 1e-12, "{}", effect.name());
        }
        assert_eq!(found.inclusion(EffectId::GpsLatency), 0.0);
    }

    /// Of the sets without the lag, a scale is in those of 0.3 and a drift in one of 0.1; nothing is in the
    /// set of 0.05.
    #[test]
    fn rivals_share_the_sets_without_the_chosen() {
        let rivals = posterior().rivals(2, &[2], 7.0);
        assert_eq!((rivals.column, rivals.explained), (2, 7.0));
        assert!(
            (rivals.acts.unwrap() - 0.65).abs() < 1e-12 && (rivals.empty - 0.05).abs() < 1e-12,
            "{rivals:?}"
        );
        assert_eq!(rivals.others, [5, 8]);
        let wanted = [0.3 / 0.65, 0.1 / 0.65];
        assert!(
            rivals.odds.iter().zip(wanted).all(|(odds, wanted)| (odds - wanted).abs() < 1e-12),
            "{rivals:?}"
        );
        // For a chosen drift, only the scale is a rival.
        assert_eq!(posterior().rivals(2, &[2, 8], 7.0).others, [5]);
    }

    /// A flight in which a sine acts on the barometer with a coefficient of two, as the regressor of an
    /// effect whose formula has this relative error.
    fn acted_on(id: EffectId, rough: f64) -> Small {
        let mut small =
            Small::new(400, 1).candidate(id, |block| sine(0, block)).error(|block| 2.0 * sine(0, block));
        small.bounds[0].scale = rough;
        small
    }

    /// The weight of the set with this effect alone, its coefficient, and the variance used.
    fn weight_of(id: EffectId, rough: f64) -> (f64, f64, f64) {
        let small = acted_on(id, rough);
        let (flights, suspects) = ([small.series.clone()], small.suspects());
        let problem = problem(&flights);
        let information = suspects.information(&problem, &NOISE);
        let fit = NoiseFit { values: problem.prior.means(), noise: NOISE, twice_log_posterior: 0.0 };
        let weigher = Weigher {
            suspects: &suspects,
            problem: &problem,
            scale: None,
            is_alone: true,
            inflation: BTreeMap::new(),
        };
        let solution = information.solve(&suspects.positions(&[0])).unwrap();
        let basis = Basis { fit, information };
        let (_, weight) = weigher.of_columns(&basis, &[0], false, POWER).unwrap();
        (weight, solution.coefficients[0], solution.covariance[0] / POWER)
    }

    /// A coefficient is compared with its prior at its full uncertainty: its variance, the share that its
    /// formula makes wrong, and its unsteadiness. Nothing else of a weight depends on these.
    #[test]
    fn a_coefficient_counts_as_sure_as_it_is() {
        let (lag, coefficient, variance) = weight_of(EffectId::BaroLag, 0.0);
        let belief = |id| CoefficientPrior::of(id, [-10.0, 10.0]);
        for rough in [0.05, 0.5] {
            let wanted = belief(EffectId::BaroLag)
                .log_density(coefficient, variance + (rough * coefficient).powi(2))
                - belief(EffectId::BaroLag).log_density(coefficient, variance);
            let found = weight_of(EffectId::BaroLag, rough).0 - lag;
            assert!((found - wanted).abs() < 1e-6 && wanted != 0.0, "{rough} {found} {wanted}");
        }
        let unsteady = unsteadiness(EffectId::BaroScale, false);
        let wanted = belief(EffectId::BaroScale).log_density(coefficient, variance + unsteady * unsteady)
            - belief(EffectId::BaroLag).log_density(coefficient, variance);
        let found = weight_of(EffectId::BaroScale, 0.0).0 - lag;
        assert!((found - wanted).abs() < 1e-6, "{found} {wanted}");
    }

    /// A scale of two is more than the air causes: as an effect it explains what the air alone does not.
    #[test]
    fn a_large_scale_is_an_effect_and_not_the_air() {
        let small = acted_on(EffectId::BaroScale, 0.0);
        let (flights, suspects) = ([small.series.clone()], small.suspects());
        let problem = problem(&flights);
        let information = suspects.information(&problem, &NOISE);
        let fit = NoiseFit { values: problem.prior.means(), noise: NOISE, twice_log_posterior: 0.0 };
        let weigher = Weigher {
            suspects: &suspects,
            problem: &problem,
            scale: Some(0),
            is_alone: true,
            inflation: BTreeMap::new(),
        };
        // Both are weighed, the set with the scale as one more effect.
        let weighed = weigher.weigh(&Rc::new(Basis { fit, information }), &[]);
        let [(_, of_air), (_, of_effect)] = weighed.as_slice() else { panic!("{}", weighed.len()) };
        assert!(weigher.ahead(of_effect, of_air) > 50.0, "{}", weigher.ahead(of_effect, of_air));
        let sets: Vec<Vec<usize>> = weighed.iter().map(|(_, set)| weigher.columns(set)).collect();
        assert_eq!(sets, [vec![], vec![0]]);
    }

    /// A fast lag of 10 m beside a slow drift, the drift in column 1.
    fn lag_and_drift() -> Small {
        let slow = |block: usize| block as f64 / 400.0 - 0.5;
        let lag = |block: usize| sine(0, block);
        let small = Small::new(400, 2).candidate(EffectId::BaroLag, lag);
        let small = small.candidate(EffectId::BaroDrift, slow);
        small.error(|block| 10.0 * lag(block) + 6.0 * slow(block))
    }

    /// The logarithm of the odds of the lag with the drift against the lag alone, and against the drift
    /// alone, with that inflation of the drift's variance.
    fn odds_of_both(inflation: f64) -> [f64; 2] {
        let small = lag_and_drift();
        let (flights, suspects) = ([small.series.clone()], small.suspects());
        let problem = problem(&flights);
        let information = suspects.information(&problem, &NOISE);
        let fit = NoiseFit { values: problem.prior.means(), noise: NOISE, twice_log_posterior: 0.0 };
        let basis = Rc::new(Basis { fit, information });
        let inflation = BTreeMap::from([(EffectId::BaroDrift, inflation)]);
        let weigher =
            Weigher { suspects: &suspects, problem: &problem, scale: None, is_alone: true, inflation };
        let set = |columns: &[usize]| weigher.weigh(&basis, columns).remove(0).1;
        let both = set(&[0, 1]);
        [set(&[0]), set(&[1])].map(|other| {
            let (ahead, behind) = (weigher.ahead(&both, &other), weigher.ahead(&other, &both));
            // Of a set that is hopelessly behind, only an upper bound of the odds is known.
            assert!((ahead + behind).abs() < 1e-9 || behind < -2.0 * WINDOW, "{ahead} {behind}");
            ahead
        })
    }

    /// The errors of the lag's shape are fast, so they cannot be the slow drift, however much the lag
    /// explains: the evidence for the drift beside it nearly has the power that it would have alone. If the
    /// power fell with all that the lag explains, these odds would be less than even.
    #[test]
    fn a_slow_effect_counts_beside_a_large_fast_one() {
        let [drift, lag] = odds_of_both(1.0);
        assert!(drift > 5.0, "{drift}");
        assert!(lag > 100.0, "{lag}");
    }

    /// A coefficient that differs from one part of a flight to the next is evidence of less.
    #[test]
    fn an_inflated_coefficient_counts_less() {
        let [sure, _] = odds_of_both(1.0);
        let [unsure, of_lag] = odds_of_both(6.0);
        assert!(unsure < 0.5 * sure, "{unsure} {sure}");
        assert!((of_lag - odds_of_both(1.0)[1]).abs() < 1e-9);
    }

    /// With one sensor, a lag and a latency, and a warming up and a convergence, are each one error with two
    /// signs; with another one they differ.
    #[test]
    fn one_error_with_two_signs_is_in_a_set_once() {
        let effects = [
            EffectId::BaroWarmUp,
            EffectId::GpsConvergence,
            EffectId::BaroLag,
            EffectId::GpsLatency,
            EffectId::BaroDrift,
        ];
        let small = effects.iter().enumerate().fold(Small::new(60, 3), |small, (k, effect)| {
            small.candidate(*effect, move |block| sine(k, block))
        });
        let (flights, suspects) = ([small.series.clone()], small.suspects());
        let problem = problem(&flights);
        let mut weigher = Weigher {
            suspects: &suspects,
            problem: &problem,
            scale: None,
            is_alone: true,
            inflation: BTreeMap::new(),
        };
        let like = |weigher: &Weigher<'_>| -> Vec<(usize, usize)> {
            let pairs = (0..5).flat_map(|a| (0..5).map(move |b| (a, b)));
            pairs.filter(|(a, b)| a != b && weigher.has_like(&[*a], *b)).collect()
        };
        assert_eq!(like(&weigher), [(0, 1), (1, 0), (2, 3), (3, 2)]);
        assert!(weigher.has_like(&[1, 4], 4) && !weigher.has_like(&[], 4));
        weigher.is_alone = false;
        assert_eq!(like(&weigher), []);
    }
}
