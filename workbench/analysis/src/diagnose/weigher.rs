//! How probable one set of effects is beside another, where the climb rate is not measured.
//!
//! The weight of a set is its marginal likelihood under a noise: its coefficients are integrated out in closed
//! form over their priors ([`CoefficientPrior`]), and time constants over the grid.
//!
//! The noise is not a Gauss-Markov process and the formulas are not exact, so the likelihood is raised to a
//! power below one (Miller and Dunson, "Robust Bayesian inference via coarsening", Journal of the American
//! Statistical Association 114, 2019). Every pair of sets is compared with a power of its own
//! ([`Weigher::ahead`]). With these powers the probabilities are right about as often as they state, on the
//! development half of `docs/blind-trials.md`.
//!
//! A pressure altitude differs from the height in proportion to the air's deviation from the standard
//! temperature. So each set includes a scale, with a prior of one kelvin where the set has no scale effect.

use std::collections::BTreeMap;
use std::rc::Rc;

use kf_core::effect::EffectId;

use super::coefficient_prior::CoefficientPrior;
use super::information::Information;
use super::problem::{NoiseFit, Problem};
use super::repeatability::{inflation, repeatability};
use super::roughness::unsteadiness;
use super::search::{MOST_EFFECTS, Search};
use super::shape_error;
use super::suspects::Suspects;

/// The power of the likelihood where formulas are exact: by the reliability diagram of
/// `cargo xtask real-trials --half development`.
pub const POWER: f64 = 0.7;
/// The share (squares) of what the effects explain that errors of formulas and signals may make.
pub const SHAPE: f64 = 0.01;
/// Prior probability that an effect acts.
pub(super) const INCLUSION: f64 = 0.1;
/// Sets are considered while their weight is at most this far (natural logarithm) below that of the best one:
/// 0.2 %.
pub(super) const WINDOW: f64 = 6.0;

/// A noise, and the normal equations of all usable columns under it.
pub struct Basis {
    /// The noise.
    pub fit: NoiseFit,
    information: Information,
}

/// A set of effects.
#[derive(Clone)]
pub struct Weighed {
    /// Its columns without the scale, ascending, each effect's most probable one.
    pub bare: Vec<usize>,
    /// Whether a scale effect is in it, too.
    has_scale: bool,
    /// The noise that it was weighed under.
    pub basis: Rc<Basis>,
    /// Natural logarithm of the likelihood.
    likelihood: f64,
    /// Natural logarithm of its weight with [`POWER`], up to a constant.
    pub log_weight: f64,
}

/// Weighs sets of effects, and compares them.
pub struct Weigher<'a> {
    suspects: &'a Suspects<'a>,
    problem: &'a Problem<'a>,
    /// The scale's column.
    scale: Option<usize>,
    /// Whether at most one sensor flies free.
    is_alone: bool,
    /// For effects of the best sets, the factor by which the variance of their coefficient exceeds that of the
    /// fit.
    inflation: BTreeMap<EffectId, f64>,
}

impl<'a> Weigher<'a> {
    /// A weigher of sets of the suspects.
    #[must_use]
    pub fn new(suspects: &'a Suspects<'a>, problem: &'a Problem<'a>) -> Self {
        let is_scale = |column: &usize| suspects.candidate(*column).effect() == EffectId::BaroScale;
        let scale = suspects.usable().iter().copied().find(is_scale);
        Self { suspects, problem, scale, is_alone: problem.is_alone(), inflation: BTreeMap::new() }
    }

    /// The effect of every usable column.
    #[must_use]
    pub fn all_effects(&self) -> BTreeMap<usize, EffectId> {
        let usable = self.suspects.usable().iter();
        usable.map(|column| (*column, self.suspects.candidate(*column).effect())).collect()
    }

    /// The effects of columns, ascending.
    #[must_use]
    pub fn effects(&self, columns: &[usize]) -> Vec<EffectId> {
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

    /// The columns without the scale's, each error once.
    #[must_use]
    pub fn without_scale(&self, columns: &[usize]) -> Vec<usize> {
        let mut bare = Vec::new();
        for column in columns.iter().copied().filter(|column| Some(*column) != self.scale) {
            if !self.has_like(&bare, column) {
                bare.push(column);
            }
        }
        bare
    }

    /// The columns, and the scale's column.
    #[must_use]
    pub fn with_scale(&self, columns: &[usize]) -> Vec<usize> {
        let mut all: Vec<usize> = columns.iter().copied().chain(self.scale).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The noise fitted with these columns and the scale.
    pub fn basis(&self, search: &mut Search<'_>, columns: &[usize], start: &[f64]) -> Rc<Basis> {
        let fit = search.fit(&self.with_scale(columns), start);
        let information = self.suspects.information(self.problem, &fit.noise);
        Rc::new(Basis { fit, information })
    }

    /// A set's columns, the scale's among them if it is an effect.
    #[must_use]
    pub fn columns(&self, set: &Weighed) -> Vec<usize> {
        if set.has_scale { self.with_scale(&set.bare) } else { set.bare.clone() }
    }

    /// The more probable of two sets.
    #[must_use]
    pub fn heavier(&self, best: Option<Weighed>, other: &Weighed) -> Weighed {
        match best {
            Some(best) if self.ahead(other, &best) <= 0.0 => best,
            _ => other.clone(),
        }
    }

    /// From now on, the effects of a set count as evidence only as far as their coefficients are the same in
    /// all parts of the flights.
    pub fn discount(&mut self, set: &Weighed) {
        let (columns, noise) = (self.columns(set), &set.basis.fit.noise);
        let repeat = repeatability(self.problem, noise, &columns);
        for (column, factor) in columns.iter().zip(inflation(self.problem, noise, &columns, &repeat)) {
            let slot = self.inflation.entry(self.suspects.candidate(*column).effect()).or_insert(1.0);
            *slot = slot.max(factor);
        }
    }

    /// The logarithm of a set's odds against another one.
    ///
    /// If the one of lower likelihood is right, the errors of its effects' shapes may be what makes the other
    /// one likelier; so the power of the likelihood falls with the variance that they leave in the direction
    /// in which both differ ([`shape_error`]). A large fast effect thus takes nothing from the evidence for a
    /// slow one. Nor is the power larger than the variance of a fit is beside that of its coefficient
    /// ([`inflation`]). For a set that is far behind, an upper bound is returned.
    #[must_use]
    pub fn ahead(&self, set: &Weighed, other: &Weighed) -> f64 {
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
        // As much as errors would leave if both sets differed in two parts of the flight only. Without this
        // limit more effects are missed and more are wrong ("A power for each pair of sets" in
        // docs/blind-trials-history.md).
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
    #[must_use]
    pub fn around(&self, best: &Weighed) -> Vec<Vec<usize>> {
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
    #[must_use]
    pub fn weigh(&self, basis: &Rc<Basis>, columns: &[usize]) -> Vec<(Vec<EffectId>, Weighed)> {
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
}

#[cfg(test)]
mod tests {
    use super::super::small_problems::{NOISE, Small, problem, sine};
    use super::*;

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
        // The scale, too, is weighed as an effect here and not as the air's.
        let weigher = Weigher { scale: None, ..Weigher::new(&suspects, &problem) };
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
        let weigher = Weigher::new(&suspects, &problem);
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
        let weigher = Weigher { inflation, ..Weigher::new(&suspects, &problem) };
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

    /// The logarithm of the odds of an effect against none, before and after its evidence is discounted, where
    /// it acts in the first blocks only.
    fn discounted(acts_until: usize) -> [f64; 2] {
        let acts = |block: usize| if block < acts_until { 1.0 } else { 0.0 };
        let small = Small::new(400, 4).candidate(EffectId::BaroLag, |block| sine(0, block));
        let small = small.error(|block| acts(block) * sine(0, block));
        let (flights, suspects) = ([small.series.clone()], small.suspects());
        let problem = problem(&flights);
        let information = suspects.information(&problem, &NOISE);
        let fit = NoiseFit { values: problem.prior.means(), noise: NOISE, twice_log_posterior: 0.0 };
        let basis = Rc::new(Basis { fit, information });
        let mut weigher = Weigher::new(&suspects, &problem);
        let [none, lag] = [&[][..], &[0]].map(|columns| weigher.weigh(&basis, columns).remove(0).1);
        let before = weigher.ahead(&lag, &none);
        weigher.discount(&lag);
        [before, weigher.ahead(&lag, &none)]
    }

    /// What acts in a quarter of a flight does not repeat in the rest of it; what acts in all of it does.
    #[test]
    fn what_does_not_repeat_is_discounted() {
        let [before, after] = discounted(100);
        assert!(before > 3.0 && after < 0.5 * before, "{before} {after}");
        let [before, after] = discounted(400);
        assert!(before > 3.0 && (after - before).abs() < 1e-9, "{before} {after}");
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
        let mut weigher = Weigher::new(&suspects, &problem);
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
