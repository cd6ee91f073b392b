//! The uncertainty of a coefficient beyond that of the noise.
//!
//! An interval is to contain the true coefficient as often as it says. The fit's variance assumes that its
//! columns are exact and that nothing else acts. What may be wrong about that is added, each as a variance:
//! the share of the coefficient that is uncertain because a signal is only roughly known ([`scale`]); the
//! air's unsteadiness; other time constants and signal errors of the same effect; noise in its signals. Where
//! the climb rate is measured, also errors of the effects' shapes ([`shape_error`]), a constant error of the
//! forward acceleration ([`offset_acceleration`]), and effects that were not chosen but may act. Without it,
//! sets of effects are averaged elsewhere (`posterior.rs`).

use super::{Findings, Judge};
use crate::diagnose::information::Solution;
use crate::diagnose::offset_acceleration;
use crate::diagnose::rivals::price;
use crate::diagnose::roughness::{scale, unsteadiness};
use crate::diagnose::shape_error::{self, ByOrigin};
use crate::diagnose::weigher::POWER;

/// Variance over a step of the grid of time constants, all of which are equally probable, in squared steps.
const WITHIN_STEP: f64 = 1.0 / 12.0;

/// The share of the shapes' bound that counts. The bound is reached by an error that lies exactly along the
/// column; one that is a mixture of two shapes has half of its squares there. On the development seeds, half
/// of the bound covers 93 % of the second family's coefficients and 98 % of the first's; all of it, 93 % and
/// 100 % (docs/blind-trials-history.md).
const OF_THE_BOUND: f64 = 0.5;

/// The variance of a coefficient beyond that of the noise, in its unit squared.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::diagnose) struct BeyondNoise {
    /// What further flights of the same vehicle leave as it is.
    pub(in crate::diagnose) lasting: f64,
    /// What is another error in every part of every flight, so that further flights reduce it as they reduce
    /// the noise.
    pub(in crate::diagnose) passing: f64,
    /// What the noise of its signals may have hidden of it: the coefficient is larger by it, never smaller. A
    /// flight that shows more reduces it.
    pub(in crate::diagnose) hidden: f64,
    /// The part of the sum that is a share of the coefficient itself. It vanishes where the effect does not
    /// act, so it is no reason to doubt that the effect acts.
    pub(in crate::diagnose) relative: f64,
}

impl BeyondNoise {
    pub(in crate::diagnose) fn sum(self) -> f64 {
        self.lasting + self.passing + self.hidden
    }
}

/// The largest share of a column's squares that counts as noise. In an aircraft that hardly manoeuvres, what
/// bends the climb rate is partly its own motion, so a larger estimate is not trusted.
const MOST_NOISE: f64 = 0.5;

/// A column beside the chosen columns of other effects.
struct Own<'a> {
    column: usize,
    /// The chosen columns of other effects, followed by this one.
    columns: &'a [usize],
    /// Their fit.
    fit: &'a Solution,
}

impl Own<'_> {
    fn coefficient(&self) -> f64 {
        self.fit.coefficients.last().copied().unwrap_or(0.0)
    }
}

impl Judge<'_> {
    /// The variance of a column's coefficient beside the chosen columns of other effects, beyond that of the
    /// noise.
    pub(in crate::diagnose) fn beyond_noise(&self, findings: &Findings, column: usize) -> BeyondNoise {
        let columns = self.columns_beside(findings, column);
        let Some(fit) = findings.information.solve(&self.suspects.positions(&columns)) else {
            return BeyondNoise::default();
        };
        let own = Own { column, columns: &columns, fit: &fit };
        let effect = self.candidates[column].effect();
        let unsteadiness = unsteadiness(effect, self.has_climb_rate);
        let its_own =
            (scale(self.epochs, effect) * own.coefficient()).powi(2) + self.of_its_columns(findings, &own);
        let (shapes, not_chosen) = if self.has_climb_rate {
            (self.of_shapes(findings, &own), self.of_effects_not_chosen(findings, &own))
        } else {
            (ByOrigin::default(), 0.0)
        };
        let hidden = self.of_signal_noise(findings, &own);
        BeyondNoise {
            lasting: its_own + unsteadiness * unsteadiness,
            passing: shapes.own + shapes.others + not_chosen,
            hidden,
            relative: its_own + shapes.own + hidden,
        }
    }

    /// The noise of the column's own signals, by which the coefficient is too small: in level flight, an
    /// airspeed's or a climb rate's noise may be as large as its changes.
    fn of_signal_noise(&self, findings: &Findings, own: &Own<'_>) -> f64 {
        let noise = self.noise_share(findings, own.column, own.fit);
        (own.coefficient() * noise / (1.0 - noise)).powi(2)
    }

    /// The share of a column's squares, beside the other columns of a fit of which it is the last, that is the
    /// noise of its signals.
    pub(super) fn noise_share(&self, findings: &Findings, column: usize, fit: &Solution) -> f64 {
        let covariance = fit.covariance.last().copied().unwrap_or(0.0);
        self.suspects.attenuation(column, covariance, &findings.white).min(MOST_NOISE)
    }

    /// Errors of the shapes, and a constant error of the forward acceleration. Columns that cannot be told
    /// apart have no fit, so both variances exist.
    fn of_shapes(&self, findings: &Findings, own: &Own<'_>) -> ByOrigin {
        let noise = &findings.explanation.fit.noise;
        let of_shapes = shape_error::variance_of_coefficient(self.problem, self.suspects, noise, own.columns);
        let candidates = own.columns.iter().map(|column| &self.candidates[*column]);
        let chosen: Vec<_> = candidates.zip(own.fit.coefficients.iter().copied()).collect();
        let of_acceleration = offset_acceleration::variance(self.problem, noise, own.columns, &chosen);
        let (of_shapes, of_acceleration) =
            (of_shapes.unwrap_or_default(), of_acceleration.unwrap_or_default());
        ByOrigin {
            own: OF_THE_BOUND * of_shapes.own + of_acceleration.own,
            others: OF_THE_BOUND * of_shapes.others + of_acceleration.others,
        }
    }

    /// Other columns of the same effect, each as probable as it fits well, with the coefficient that it would
    /// have; and that the true time constant lies between those of the grid.
    fn of_its_columns(&self, findings: &Findings, own: &Own<'_>) -> f64 {
        let regressor = &self.candidates[own.column].regressor;
        let (coefficient, rest) = (own.coefficient(), own.fit.rest);
        let same = self.suspects.usable().iter().copied();
        let same = same.filter(|other| self.suspects.same_effect(*other, own.column));
        let fits: Vec<(usize, f64, f64)> = same
            .filter_map(|column| {
                if column == own.column {
                    return Some((column, coefficient, rest));
                }
                let set = self.columns_beside(findings, column);
                let fit = findings.information.solve(&self.suspects.positions(&set))?;
                let may_act = self.suspects.may_act(&set, &fit);
                may_act.then_some((column, *fit.coefficients.last()?, fit.rest))
            })
            .collect();
        let weight = |other_rest: f64| libm::exp(-0.5 * POWER * (other_rest - rest).max(0.0));
        let total: f64 = fits.iter().map(|(.., rest)| weight(*rest)).sum();
        let spread = fits.iter().map(|(_, value, rest)| weight(*rest) * (value - coefficient).powi(2));
        let mut variance = spread.sum::<f64>() / total;
        // The next longer and the next shorter time constant of the same clock.
        let grid = fits.iter().filter_map(|(column, value, _)| {
            let other = &self.candidates[*column].regressor;
            let times = f64::from(other.time_constant_s) / f64::from(regressor.time_constant_s);
            (other.since == regressor.since && times > 0.0).then(|| (libm::log(times), value - coefficient))
        });
        let grid: Vec<(f64, f64)> = grid.collect();
        let next = |sign: f64| {
            let that_side = grid.iter().filter(|(times, _)| times * sign > 0.0);
            that_side.min_by(|a, b| (a.0 * sign).total_cmp(&(b.0 * sign))).map(|(_, moved)| moved.abs())
        };
        let steps: Vec<f64> = [next(1.0), next(-1.0)].into_iter().flatten().collect();
        if !steps.is_empty() {
            let step = steps.iter().sum::<f64>() / steps.len() as f64;
            variance += WITHIN_STEP * step * step;
        }
        variance
    }

    /// Effects that were not chosen on this sensor or on the reference: how far the coefficient would move
    /// beside each, with the probability that it acts.
    fn of_effects_not_chosen(&self, findings: &Findings, own: &Own<'_>) -> f64 {
        let mut chosen = own.columns.to_vec();
        chosen.sort_unstable();
        let subject = self.candidates[own.column].sensor();
        let is_on_it = |other: usize| {
            let sensor = self.candidates[other].sensor();
            sensor.is_none() || subject.is_none() || sensor == subject
        };
        let noise = &findings.explanation.fit.noise;
        let mut moved = Vec::new();
        for other in self.additional(&findings.information, &chosen, is_on_it) {
            let at = |wanted: usize| other.set.iter().position(|column| *column == wanted);
            let (Some(of_own), Some(added)) = (at(own.column), at(other.column)) else { continue };
            // Where the two cannot be told apart, the coefficient says nothing of the other effect.
            let Some(of_shapes) =
                shape_error::variance(self.problem, self.suspects, noise, &chosen, &[other.column])
            else {
                continue;
            };
            let gain = (own.fit.rest - other.solution.rest).max(0.0);
            let effect = self.candidates[other.column].effect();
            let log_odds = 0.5 * gain / (1.0 / POWER + of_shapes)
                + price(effect, &other.solution, added)
                + libm::log(other.share);
            moved.push((log_odds, other.solution.coefficients[of_own] - own.coefficient()));
        }
        mean_square(&moved)
    }
}

/// The mean square of what the coefficient moves by beside each of some effects, of which at most one acts,
/// given the logarithms of their odds against nothing, beside which it does not move.
fn mean_square(moved: &[(f64, f64)]) -> f64 {
    // Where an effect that acts was refused, the logarithms reach thousands; their exponentials would overflow.
    let largest = moved.iter().fold(0.0, |largest: f64, (log_odds, _)| largest.max(*log_odds));
    let weight = |log_odds: f64| libm::exp(log_odds - largest);
    let total = weight(0.0) + moved.iter().map(|(log_odds, _)| weight(*log_odds)).sum::<f64>();
    moved.iter().map(|(log_odds, moved)| weight(*log_odds) * moved * moved).sum::<f64>() / total
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing moves nothing, even odds halve, and overwhelming ones leave the one effect, without overflow.
    #[test]
    fn what_may_act_counts_by_its_probability() {
        assert_eq!(mean_square(&[]), 0.0);
        assert!((mean_square(&[(0.0, 2.0)]) - 2.0).abs() < 1e-12);
        assert!((mean_square(&[(0.0, 1.0), (0.0, 2.0)]) - 5.0 / 3.0).abs() < 1e-12);
        assert!((mean_square(&[(5000.0, 3.0), (-5000.0, 7.0)]) - 9.0).abs() < 1e-12);
    }
}
