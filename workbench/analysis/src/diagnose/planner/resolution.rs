//! What a planned flight would make of a set of effects that the flights cannot tell apart.
//!
//! Each effect in turn is assumed to act, with the time constants and the coefficients that it may have by the
//! flights: a plan that only suffices for the size that happened to be fitted promises too much. The planned
//! flight's readings are then those that this effect causes, and the likelihoods of the others over all flights
//! are the expected ones; noise scatters them about these values, so that the probabilities are medians. Of two
//! effects that differ by `d` sigmas on the planned flight, the difference of the squares scatters by `2 d`:
//! from that follows how probable it is that the one that acts is identified. Another effect is judged by
//! whichever of its time constants fits all flights best, as in the diagnosis.
//! Likelihoods are weighted as in the diagnosis, less the more the effects explain: formulas and signals are
//! not quite right.

use statistics::normal_above;

use super::super::excitation::detection;
use super::super::information::{Information, Solution};
use super::super::judge::probable::EMPTY;
use super::super::judge::{IDENTIFIED, SUSPECT};
use super::super::outlook::{MemberOutlook, SetOutlook};
use super::super::physical_range::{Bounds, is_consistent, is_possible};
use super::{Planner, Set, Suspect};

impl Planner {
    pub(super) fn set(&self, set: &Set, flown: &Information) -> SetOutlook {
        let members: Vec<MemberOutlook> = set
            .members
            .iter()
            .map(|Suspect { effect, probability, column }| {
                let would = column.and_then(|column| self.if_it_acts(set, column, flown));
                MemberOutlook {
                    effect: effect.name().into(),
                    probability: *probability,
                    probability_then: would.as_ref().map(|would| would.probability),
                    left: would.as_ref().map(|would| would.left),
                    sigmas: would.as_ref().map(|would| would.sigmas),
                    identified: would.map(|would| would.identified),
                }
            })
            .collect();
        let of_members = members.iter().map(|member| member.probability * member.identified.unwrap_or(0.0));
        let cleared = set.nothing.map(|_| self.if_nothing_acts(set, flown));
        let of_nothing = set.nothing.unwrap_or(0.0) * cleared.unwrap_or(0.0);
        let resolved = of_members.sum::<f64>() + of_nothing;
        SetOutlook { members, nothing: set.nothing, cleared, resolved }
    }

    /// Columns of the effects found elsewhere, without those of this column's effect.
    fn beside(&self, set: &Set, column: usize) -> Vec<usize> {
        let effect = self.candidates[column].effect();
        let found = self.found.iter().copied().filter(|found| *found != set.column);
        found.filter(|other| self.candidates[*other].effect() != effect).collect()
    }

    /// The fits of each column of this column's effect, with those beside it: another time constant, or another
    /// shape of a delay. They must be physically possible, but for this column itself: the diagnosis reported it,
    /// and it may stand in for another effect.
    fn fits(
        &self,
        of: &Information,
        beside: &[usize],
        column: usize,
    ) -> impl Iterator<Item = (usize, Solution)> {
        let fit = move |other: usize| {
            let columns = [beside, &[other]].concat();
            let solution = of.solve(&self.positions(&columns))?;
            let bounds: Vec<Bounds> = columns.iter().map(|column| self.bounds[*column]).collect();
            let may_act =
                other == column || is_possible(&bounds, &solution) && is_consistent(&bounds, &solution);
            may_act.then_some((other, solution))
        };
        self.alike(column).filter_map(fit)
    }

    /// The columns of this column's effect.
    fn alike(&self, column: usize) -> impl Iterator<Item = usize> + use<'_> {
        let effect = self.candidates[column].effect();
        self.columns.iter().copied().filter(move |other| self.candidates[*other].effect() == effect)
    }

    /// What would be found with the planned flight if this member of a set is the one that acts: the mean over
    /// what its time constant and its coefficient may be.
    fn if_it_acts(&self, set: &Set, truth: usize, flown: &Information) -> Option<Would> {
        let beside = self.beside(set, truth);
        let now = |(column, solution): (usize, Solution)| {
            let power = self.tempering.power(column, self.information.total() - solution.rest);
            let log_likelihood = worth(power, &solution);
            Version { column, solution, power, log_likelihood }
        };
        let versions: Vec<Version> = self.fits(&self.information, &beside, truth).map(now).collect();
        let best = versions.iter().map(|one| one.log_likelihood).fold(f64::NEG_INFINITY, f64::max);
        let mut mean = Would { probability: 0.0, left: 0, sigmas: 0.0, identified: 0.0 };
        let (mut weights, mut heaviest) = (0.0, 0.0);
        for Version { column, solution, power, log_likelihood } in &versions {
            let likelihood = libm::exp(log_likelihood - best);
            // As the diagnosis lists no suspect that is less probable.
            if likelihood < SUSPECT {
                continue;
            }
            for (deviation, weight) in COEFFICIENTS {
                let weight = weight * likelihood;
                let acting = shifted(solution, deviation / power.sqrt());
                let would = self.if_it_acts_so(set, &beside, *column, &acting, flown)?;
                weights += weight;
                mean.probability += weight * would.probability;
                mean.identified += weight * would.identified;
                if weight > heaviest {
                    heaviest = weight;
                    (mean.left, mean.sigmas) = (would.left, would.sigmas);
                }
            }
        }
        mean.probability /= weights;
        mean.identified /= weights;
        (weights > 0.0).then_some(mean)
    }

    /// The same, if this column acts with the last of these coefficients, and those beside it with the others.
    fn if_it_acts_so(
        &self,
        set: &Set,
        beside: &[usize],
        truth: usize,
        coefficients: &[f64],
        flown: &Information,
    ) -> Option<Would> {
        let acting = self.positions(&[beside, &[truth]].concat());
        let truth_now = self.information.solve(&acting)?;
        let both = self.information.plus(&flown.with_response(&acting, coefficients));
        let truth_then = both.solve(&acting)?;
        let power_now = self.tempering.power(truth, self.information.total() - truth_now.rest);
        let power_then = self.tempering.power(truth, both.total() - truth_then.rest);
        let of_truth = worth(power_then, &truth_then) - worth(power_now, &truth_now);
        // The column of an effect that fits best.
        let best = |of: &Information, power: f64, column: usize| {
            let fits = self.fits(of, beside, column);
            let worths = fits.map(|(_, solution)| (worth(power, &solution), solution.rest));
            worths.max_by(|(one, _), (other, _)| one.total_cmp(other))
        };
        let other = |probability: f64, column: usize| {
            let (now, rest_now) = best(&self.information, power_now, column)?;
            let (then, rest_then) = best(&both, power_then, column)?;
            let gain = then - now - of_truth;
            let squares = (rest_then - truth_then.rest) - (rest_now - truth_now.rest);
            Some(Other::new(probability, gain, squares, power_then))
        };
        let is_truth = |column: usize| self.alike(column).any(|alike| alike == truth);
        let mut others = Vec::new();
        let mut own = 0.0;
        for Suspect { effect, probability, column } in set.suspects() {
            if column.is_some_and(is_truth) {
                own = *probability;
                continue;
            }
            let by_itself = column.and_then(|column| other(*probability, column));
            // What it would look like: the one that acts, or another one.
            let alike = set.stand_ins.iter().filter(|(_, hidden)| hidden == effect).map(|(seen, _)| *seen);
            let as_another = alike.filter_map(|seen| {
                let suspect = set.suspects().find(|suspect| suspect.effect == seen)?;
                let column = suspect.column?;
                if is_truth(column) {
                    Some(Other::unchanged(suspect.probability))
                } else {
                    other(suspect.probability, column)
                }
            });
            let heaviest = by_itself
                .into_iter()
                .chain(as_another)
                .max_by(|one, another| one.weight(0.0).total_cmp(&another.weight(0.0)));
            others.push(heaviest.unwrap_or_else(|| Other::unchanged(*probability)));
        }
        let without = self.positions(beside);
        let (none_now, none_then) = (self.information.solve(&without)?, both.solve(&without)?);
        let shown = (none_then.rest - truth_then.rest).max(0.0);
        if let Some(nothing) = set.nothing {
            let gain = -0.5 * power_then * none_then.rest + 0.5 * power_now * none_now.rest - of_truth;
            let squares = shown - (none_now.rest - truth_now.rest);
            others.push(Other::new(nothing, gain, squares, power_then));
        }
        let total = own + others.iter().map(|other| other.weight(0.0)).sum::<f64>();
        let is_suspect = |weight: f64| weight / total >= SUSPECT;
        // Nothing is no member.
        let effects = others.len() - usize::from(set.nothing.is_some());
        let left = others[..effects].iter().filter(|other| is_suspect(other.weight(0.0))).count();
        let least = others.iter().map(|other| other.sigmas).fold(f64::INFINITY, f64::min);
        Some(Would {
            probability: own / total,
            left: left + usize::from(is_suspect(own)),
            sigmas: least,
            identified: identified(own, &others).min(detection(shown.sqrt(), self.penalty)),
        })
    }

    /// The probability that the set is no longer reported, if none of its effects acts: that nothing is then
    /// more probable than they are. An effect that fitted by chance explains, with the planned flight, only as
    /// much less as its coefficient becomes more certain.
    fn if_nothing_acts(&self, set: &Set, flown: &Information) -> f64 {
        let nothing = set.nothing.unwrap_or(0.0);
        let odds = |scatter: f64| -> f64 {
            let of_member = |Suspect { probability, column, .. }: &Suspect| {
                let gain = column.and_then(|column| self.chance(set, column, flown, scatter));
                probability / nothing * libm::exp(gain.unwrap_or(0.0))
            };
            set.members.iter().map(of_member).sum()
        };
        // Nothing has a probability of at least EMPTY where these odds are at most this.
        let limit = (1.0 - EMPTY) / EMPTY;
        probability_below(|scatter| odds(scatter) <= limit)
    }

    /// The gain in log odds of an effect that does not act, where the planned flight's noise is this many
    /// sigmas in its favour.
    fn chance(&self, set: &Set, column: usize, flown: &Information, scatter: f64) -> Option<f64> {
        let beside = self.beside(set, column);
        let (with, without) =
            (self.positions(&[beside.as_slice(), &[column]].concat()), self.positions(&beside));
        let now = self.information.solve(&with)?;
        let without_now = self.information.solve(&without)?;
        let then = self.information.plus(flown).solve(&with)?;
        let share = then.covariance.last()? / now.covariance.last()?;
        let power = self.tempering.power(column, self.information.total() - now.rest);
        let shown = (without_now.rest - now.rest).max(0.0);
        Some(gain_by_chance(shown, share, power, scatter))
    }
}

/// The gain in log odds of an effect that fitted by chance: `shown` squares now, with a variance that the
/// planned flight reduces to this share, where that flight's noise is `scatter` sigmas in its favour. It
/// grows with the scatter: a coefficient that turns its sign counts as none, since it would have to become as
/// certain the other way, which is less probable by far.
fn gain_by_chance(shown: f64, share: f64, power: f64, scatter: f64) -> f64 {
    let root = (shown * share).sqrt() + scatter * (1.0 - share).max(0.0).sqrt();
    0.5 * power * (root.max(0.0).powi(2) - shown) + 0.5 * libm::log(share)
}

/// Standard deviations of a coefficient, and their weights: the five-point Gauss-Hermite rule.
const COEFFICIENTS: [(f64, f64); 5] = [
    (-2.856_970, 0.011_257),
    (-1.355_626, 0.222_076),
    (0.0, 0.533_333),
    (1.355_626, 0.222_076),
    (2.856_970, 0.011_257),
];

/// The worth of an effect's fit, without what all of a set share.
fn worth(power: f64, solution: &Solution) -> f64 {
    let variance = solution.covariance.last().copied().unwrap_or(f64::INFINITY);
    0.5 * libm::log(variance) - 0.5 * power * solution.rest
}

/// The coefficients where the last one is this many of its standard deviations off, and the others follow.
fn shifted(solution: &Solution, deviations: f64) -> Vec<f64> {
    let n = solution.coefficients.len();
    let along = solution.covariance.chunks(n.max(1)).filter_map(<[f64]>::last);
    let last = solution.covariance.last().copied().unwrap_or(0.0).sqrt();
    let pairs = solution.coefficients.iter().zip(along);
    pairs.map(|(coefficient, covariance)| coefficient + deviations * covariance / last).collect()
}

/// An effect with one of its time constants, or shapes of a delay, in the flights.
struct Version {
    column: usize,
    solution: Solution,
    /// The power of the likelihood.
    power: f64,
    log_likelihood: f64,
}

/// What would be found.
struct Would {
    probability: f64,
    left: usize,
    sigmas: f64,
    identified: f64,
}

/// Another explanation than the one that acts.
#[derive(Clone, Copy, Debug)]
struct Other {
    /// Its probability now.
    now: f64,
    /// The expected change of the logarithm of its weight, relative to the one that acts.
    gain: f64,
    /// How many sigmas the planned flight distinguishes it by.
    sigmas: f64,
    /// The power of the likelihood.
    power: f64,
}

impl Other {
    fn new(now: f64, gain: f64, squares: f64, power: f64) -> Self {
        Self { now, gain: gain.min(0.0), sigmas: squares.max(0.0).sqrt(), power }
    }

    const fn unchanged(now: f64) -> Self {
        Self { now, gain: 0.0, sigmas: 0.0, power: 0.0 }
    }

    /// Its weight with the planned flight, where that flight's noise is this many sigmas in its favour.
    fn weight(self, scatter: f64) -> f64 {
        self.now * libm::exp(self.gain + scatter * self.power * self.sigmas)
    }
}

/// The probability that what acts, now of this probability, is identified against the others.
fn identified(own: f64, others: &[Other]) -> f64 {
    probability_below(|scatter| {
        let total: f64 = others.iter().map(|other| other.weight(scatter)).sum();
        own >= IDENTIFIED * (own + total)
    })
}

/// Largest scatter considered, sigmas: beyond it a probability is not a number that differs from zero.
const SCATTER: f64 = 37.0;
/// Bisections of it: to a thousandth of a sigma.
const HALVINGS: u32 = 16;

/// The probability that a standard normal scatter is below the limit up to which something holds; it holds for
/// every smaller scatter, too.
fn probability_below(holds: impl Fn(f64) -> bool) -> f64 {
    if holds(SCATTER) {
        return 1.0;
    }
    if !holds(-SCATTER) {
        return 0.0;
    }
    let (mut low, mut high) = (-SCATTER, SCATTER);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    normal_above(-low)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two effects, equally probable now, that differ by `d` sigmas: the logarithm of their odds becomes
    /// `d^2 / 2` with a scatter of `d`, and 95 % are odds of 19.
    #[test]
    fn an_effect_is_identified_as_often_as_its_odds_scatter_above_19() {
        for d in [1.5, 3.0, 4.5] {
            let other = Other::new(0.5, -0.5 * d * d, d * d, 1.0);
            let wanted = normal_above((libm::log(19.0) - 0.5 * d * d) / d);
            assert!((identified(0.5, &[other]) - wanted).abs() < 1e-3, "{d}");
            // Half the likelihood's power halves the expected odds and their scatter.
            let half = Other::new(0.5, -0.25 * d * d, d * d, 0.5);
            let wanted = normal_above((libm::log(19.0) - 0.25 * d * d) / (0.5 * d));
            assert!((identified(0.5, &[half]) - wanted).abs() < 1e-3, "{d}");
        }
    }

    /// An effect of three sigmas that does not act, and a flight that is three times as informative: odds of
    /// two become less than one unless the new noise is that much in its favour. The limit of the root is
    /// where `root^2 = 9 - 2 ln 2 - ln 1/4`, and the root has a mean of 3/2 and a variance of 3/4.
    #[test]
    fn an_effect_by_chance_is_mostly_no_longer_reported() {
        let gain = |scatter| gain_by_chance(9.0, 0.25, 1.0, scatter);
        let cleared = probability_below(|scatter| 2.0 * libm::exp(gain(scatter)) <= 1.0);
        let wanted = normal_above((1.5 - 3.0) / 0.75_f64.sqrt());
        assert!((cleared - wanted).abs() < 1e-3, "{cleared} {wanted}");
        for scatter in [-37.0, -5.0, -1.0, 0.0, 1.0] {
            assert!(gain(scatter) <= gain(scatter + 0.5), "{scatter}");
        }
    }

    /// The moments of a standard normal, up to the fourth.
    #[test]
    fn a_coefficient_is_averaged_over_a_normal_distribution() {
        for (power, wanted) in [(0, 1.0), (1, 0.0), (2, 1.0), (3, 0.0), (4, 3.0)] {
            let moment: f64 = COEFFICIENTS.iter().map(|(at, weight)| weight * at.powi(power)).sum();
            assert!((moment - wanted).abs() < 1e-4, "{power}: {moment}");
        }
    }

    /// The conditional mean of a normal distribution: with variances of 4 and 9 and a covariance of -3, the
    /// first one falls by a third of what the last one is larger.
    #[test]
    fn the_coefficients_beside_a_larger_one_follow() {
        let solution = Solution {
            coefficients: vec![1.0, 10.0],
            covariance: vec![4.0, -3.0, -3.0, 9.0],
            log_determinant: 0.0,
            rest: 0.0,
        };
        assert_eq!(shifted(&solution, 2.0), [-1.0, 16.0]);
        assert_eq!(shifted(&solution, 0.0), [1.0, 10.0]);
    }

    #[test]
    fn what_the_plan_does_not_distinguish_is_never_identified() {
        let apart = Other::new(0.25, -50.0, 100.0, 1.0);
        assert!(identified(0.5, &[apart]) > 0.999);
        assert!(identified(0.5, &[apart, Other::unchanged(0.25)]) < 1e-12);
        // Improbable already, an indistinguishable rival keeps nothing from being identified.
        assert!(identified(0.5, &[apart, Other::unchanged(0.5 / 19.0 - 0.001)]) > 0.9);
        assert!((identified(1.0, &[]) - 1.0).abs() < f64::EPSILON);
    }
}
