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
//! Statistical Association 114, 2019). With that power the probabilities are right as often as they state, on
//! the development half of `docs/blind-trials.md`.
//!
//! A pressure altitude differs from the height in proportion to the air's deviation from the standard
//! temperature. So each set includes a scale, with a prior of one kelvin where the set has no scale effect.

use std::collections::BTreeMap;

use kf_core::effect::EffectId;

use super::coefficient_prior::CoefficientPrior;
use super::information::Information;
use super::problem::{NoiseFit, Problem};
use super::rivals::Rivals;
use super::roughness::unsteadiness;
use super::search::{Explanation, MOST_EFFECTS, Search};
use super::suspects::Suspects;
use crate::progress::{Cancelled, Progress, step};

/// The power of the likelihood: by the reliability diagram of `cargo xtask real-trials --half development`.
pub const POWER: f64 = 0.7;
/// The share (squares) of what the effects explain that errors of formulas and signals may make. The
/// likelihood's power falls with it, so that what an effect leaves because its formula is not exact is not
/// attributed to another effect.
pub const SHAPE: f64 = 0.01;
/// Prior probability that an effect acts.
pub(super) const INCLUSION: f64 = 0.1;
/// Sets are considered while their weight is at most this far (natural logarithm) below that of the best one:
/// 0.2 %.
const WINDOW: f64 = 6.0;
/// Number of sets whose noise is fitted in a round, and number of rounds.
const REFITTED: usize = 3;
const ROUNDS: usize = 6;

/// A set of effects.
#[derive(Clone, Debug)]
struct Weighed {
    /// Its columns, ascending, each effect's most probable one.
    columns: Vec<usize>,
    /// Natural logarithm of its probability, up to a constant.
    log_weight: f64,
}

/// Probabilities of sets of effects.
#[derive(Clone, Debug)]
pub struct Posterior {
    /// Sets with their probabilities, the most probable first.
    sets: Vec<(Vec<usize>, f64)>,
    effects: BTreeMap<usize, EffectId>,
}

/// A set and its noise; the set's columns exclude the scale's.
#[derive(Clone)]
struct Looked {
    columns: Vec<usize>,
    fit: NoiseFit,
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
    let mut weigher = Weigher { suspects, problem, scale, power: POWER };
    let mut sets: BTreeMap<Vec<EffectId>, Weighed> = BTreeMap::new();
    let mut refitted: BTreeMap<Vec<EffectId>, Looked> = BTreeMap::new();
    let start: Vec<usize> = found.columns.iter().copied().filter(|column| Some(*column) != scale).collect();
    let mut best = weigher.look(search, &start, &found.fit.values);
    step(progress)?;
    weigher.temper(&best);
    let mut best_weight = f64::NEG_INFINITY;
    for _ in 0..ROUNDS {
        // First all sets around the best one under its noise, then the nearest ones with their own.
        let information = suspects.information(problem, &best.fit.noise);
        refitted.insert(weigher.effects(&best.columns), best.clone());
        let around = weigher.around(&information, &best);
        for (effects, weighed) in weigher.weigh(&information, &best.columns, &best.fit) {
            best_weight = best_weight.max(weighed.log_weight);
            sets.insert(effects, weighed);
        }
        let mut near: Vec<(f64, Vec<usize>)> = Vec::new();
        for columns in around {
            for (effects, weighed) in weigher.weigh(&information, &columns, &best.fit) {
                let bare: Vec<usize> =
                    weighed.columns.iter().copied().filter(|column| Some(*column) != scale).collect();
                let is_known = refitted.contains_key(&weigher.effects(&bare));
                if !is_known && weighed.log_weight > best_weight - WINDOW {
                    near.push((weighed.log_weight, bare));
                }
                if !is_known {
                    let slot = sets.entry(effects).or_insert_with(|| weighed.clone());
                    if weighed.log_weight > slot.log_weight {
                        *slot = weighed;
                    }
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
        search.look_at(&with_scale, &best.fit.values);
        let mut next: Option<(f64, Looked)> = None;
        for (effects, columns) in nearest {
            let looked = weigher.look(search, &columns, &best.fit.values);
            step(progress)?;
            let information = suspects.information(problem, &looked.fit.noise);
            let mut most = f64::NEG_INFINITY;
            for (effects, weighed) in weigher.weigh(&information, &columns, &looked.fit) {
                most = most.max(weighed.log_weight);
                sets.insert(effects, weighed);
            }
            refitted.insert(effects, looked.clone());
            if most > best_weight && next.as_ref().is_none_or(|(weight, _)| most > *weight) {
                next = Some((most, looked));
            }
        }
        match next {
            Some((weight, looked)) => {
                best = looked;
                best_weight = weight;
            }
            None if count < REFITTED => break,
            None => {}
        }
    }
    Ok(weigher.normalised(sets))
}

struct Weigher<'a> {
    suspects: &'a Suspects<'a>,
    problem: &'a Problem<'a>,
    /// The scale's column.
    scale: Option<usize>,
    power: f64,
}

impl Weigher<'_> {
    fn effects(&self, columns: &[usize]) -> Vec<EffectId> {
        let mut effects: Vec<EffectId> =
            columns.iter().map(|column| self.suspects.candidate(*column).effect()).collect();
        effects.sort_unstable();
        effects
    }

    /// The columns, and the scale's column.
    fn with_scale(&self, columns: &[usize]) -> Vec<usize> {
        let mut all: Vec<usize> = columns.iter().copied().chain(self.scale).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    fn look(&self, search: &mut Search<'_>, columns: &[usize], start: &[f64]) -> Looked {
        let fit = search.fit(&self.with_scale(columns), start);
        Looked { columns: columns.to_vec(), fit }
    }

    /// Lowers the power of the likelihood, the more the effects explain.
    fn temper(&mut self, best: &Looked) {
        let information = self.suspects.information(self.problem, &best.fit.noise);
        let rest = |columns: &[usize]| {
            information.solve(&self.suspects.positions(columns)).map_or(0.0, |solution| solution.rest)
        };
        let explained = (information.total() - rest(&self.with_scale(&best.columns))).max(0.0);
        self.power = 1.0 / (1.0 / POWER + 0.5 * SHAPE * explained);
    }

    /// Sets with one effect less, one more or another one, all without the scale.
    fn around(&self, information: &Information, best: &Looked) -> Vec<Vec<usize>> {
        let effect = |column: usize| self.suspects.candidate(column).effect();
        let mut bases = vec![best.columns.clone()];
        for left_out in &best.columns {
            bases.push(best.columns.iter().copied().filter(|column| column != left_out).collect());
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
                let is_there = base.iter().any(|other| effect(*other) == effect(column));
                if is_there || Some(column) == self.scale {
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

    /// The weight of a set of columns under a noise, with the air's scale alone and with a scale effect.
    fn weigh(
        &self,
        information: &Information,
        columns: &[usize],
        fit: &NoiseFit,
    ) -> Vec<(Vec<EffectId>, Weighed)> {
        let mut weighed = Vec::new();
        for has_scale in [false, true] {
            if has_scale && (self.scale.is_none() || columns.len() >= MOST_EFFECTS) {
                continue;
            }
            let mut set = columns.to_vec();
            if has_scale {
                set = self.with_scale(columns);
            }
            if let Some(log_weight) = self.log_weight(information, columns, fit, has_scale) {
                let of_grid = self.of_time_constants(information, columns, fit, has_scale, log_weight);
                weighed.push((self.effects(&set), Weighed { columns: set, log_weight: of_grid }));
            }
        }
        weighed
    }

    /// The mean over the grids of time constants, one effect after the other.
    fn of_time_constants(
        &self,
        information: &Information,
        columns: &[usize],
        fit: &NoiseFit,
        has_scale: bool,
        log_weight: f64,
    ) -> f64 {
        let mut sum = log_weight;
        for (k, column) in columns.iter().enumerate() {
            let grid =
                self.suspects.usable().iter().filter(|other| self.suspects.same_effect(**other, *column));
            let mut count = 0_u32;
            let mut share = 0.0;
            for other in grid {
                count += 1;
                let mut set = columns.to_vec();
                set[k] = *other;
                if let Some(weight) = self.log_weight(information, &set, fit, has_scale) {
                    share += libm::exp((weight - log_weight).min(0.0));
                }
            }
            sum += libm::log(share / f64::from(count.max(1)));
        }
        sum
    }

    fn log_weight(
        &self,
        information: &Information,
        columns: &[usize],
        fit: &NoiseFit,
        has_scale: bool,
    ) -> Option<f64> {
        let all = self.with_scale(columns);
        let positions = self.suspects.positions(&all);
        let of_air = unsteadiness(EffectId::BaroScale, false) * self.power.sqrt();
        let believed: Vec<f64> = all
            .iter()
            .map(|column| if Some(*column) == self.scale && !has_scale { of_air } else { f64::INFINITY })
            .collect();
        let solution = information.solve_with_prior(&positions, &believed)?;
        let noise = self.problem.prior.log_density(&fit.values);
        let likelihood = 0.5 * information.twice_log_determinant() - 0.5 * solution.rest + noise;
        let n = all.len();
        let mut weight = self.power * likelihood;
        // The determinant of the covariance, tempered as the likelihood is.
        weight += 0.5 * solution.log_determinant
            + 0.5 * n as f64 * libm::log(2.0 * std::f64::consts::PI / self.power);
        for (k, column) in all.iter().enumerate() {
            let variance = solution.covariance[k * n + k] / self.power;
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
        Some(weight)
    }

    fn normalised(self, sets: BTreeMap<Vec<EffectId>, Weighed>) -> Posterior {
        let best = sets.values().map(|set| set.log_weight).fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = sets.values().map(|set| libm::exp(set.log_weight - best)).sum();
        let mut found: Vec<(Vec<usize>, f64)> =
            sets.into_values().map(|set| (set.columns, libm::exp(set.log_weight - best) / total)).collect();
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
        let weigher = Weigher { suspects: &suspects, problem: &problem, scale: None, power: POWER };
        let solution = information.solve(&suspects.positions(&[0])).unwrap();
        let weight = weigher.log_weight(&information, &[0], &fit, false).unwrap();
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
        let weigher = Weigher { suspects: &suspects, problem: &problem, scale: Some(0), power: POWER };
        let [of_air, of_effect] =
            [false, true].map(|has_scale| weigher.log_weight(&information, &[], &fit, has_scale).unwrap());
        assert!(of_effect > of_air + 50.0, "{of_effect} {of_air}");
        // Both are weighed, the set with the scale as one more effect.
        let weighed = weigher.weigh(&information, &[], &fit);
        let sets: Vec<Vec<usize>> = weighed.iter().map(|(_, weighed)| weighed.columns.clone()).collect();
        assert_eq!(sets, [vec![], vec![0]]);
    }
}
