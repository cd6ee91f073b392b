//! The uncertainty of a coefficient beyond that of the noise.
//!
//! An interval is to contain the true coefficient as often as it says. The fit's variance assumes that its
//! columns are exact and that nothing else acts. What may be wrong about that is added, each as a variance:
//! the share of the coefficient that is uncertain because a signal is only roughly known ([`scale`]); the air's
//! unsteadiness; other time constants and signal errors of the same effect. Where the climb rate is measured, also errors of
//! the effects' shapes ([`shape_error`]), constant errors of the accelerations ([`offset_acceleration`]), and
//! effects that were not chosen but may act. Without it, sets of effects are averaged elsewhere
//! (`posterior.rs`).

use super::{Findings, Judge, with};
use crate::diagnose::offset_acceleration;
use crate::diagnose::rivals::price;
use crate::diagnose::roughness::{scale, unsteadiness};
use crate::diagnose::shape_error;
use crate::diagnose::weigher::POWER;

/// Variance over a step of the grid of time constants, all of which are equally probable, in squared steps.
const WITHIN_STEP: f64 = 1.0 / 12.0;

/// The share of the shapes' bound that counts. The bound is reached by an error that lies exactly along the
/// column; one that is a mixture of two shapes has half of its squares there. On the development seeds, half
/// of the bound covers 93 % of the second family's coefficients and 98 % of the first's; all of it, 93 % and
/// 100 % (docs/blind-trials.md).
const OF_THE_BOUND: f64 = 0.5;

/// The variance of a coefficient beyond that of the noise, in its unit squared.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::diagnose) struct BeyondNoise {
    /// What further flights of the same vehicle leave as it is.
    pub(in crate::diagnose) lasting: f64,
    /// What is another error in every part of every flight, so that further flights reduce it as they reduce
    /// the noise.
    pub(in crate::diagnose) passing: f64,
}

impl BeyondNoise {
    pub(in crate::diagnose) fn sum(self) -> f64 {
        self.lasting + self.passing
    }
}

impl Judge<'_> {
    /// The variance of a column's coefficient beside the chosen columns of other effects, beyond that of the
    /// noise.
    pub(in crate::diagnose) fn beyond_noise(&self, findings: &Findings, column: usize) -> BeyondNoise {
        let others = findings.explanation.columns.iter().copied();
        let others: Vec<usize> = others.filter(|other| !self.suspects.same_effect(*other, column)).collect();
        let Some(coefficient) = self.coefficient(findings, &others, column) else {
            return BeyondNoise::default();
        };
        let effect = self.candidates[column].effect();
        let unsteadiness = unsteadiness(effect, self.has_climb_rate);
        let lasting = (scale(self.epochs, effect) * coefficient).powi(2)
            + unsteadiness * unsteadiness
            + self.of_its_columns(findings, &others, column);
        let passing = if self.has_climb_rate {
            self.of_shapes(findings, &others, column)
                + self.of_effects_not_chosen(findings, &others, column, coefficient)
        } else {
            0.0
        };
        BeyondNoise { lasting, passing }
    }

    /// A column's coefficient together with these; `None` where they cannot be told apart.
    fn coefficient(&self, findings: &Findings, others: &[usize], column: usize) -> Option<f64> {
        let picks: Vec<usize> = others.iter().copied().chain([column]).collect();
        findings.information.solve(&self.suspects.positions(&picks))?.coefficients.last().copied()
    }

    /// Errors of the shapes, and constant errors of the accelerations.
    fn of_shapes(&self, findings: &Findings, others: &[usize], column: usize) -> f64 {
        let noise = &findings.explanation.fit.noise;
        let picks: Vec<usize> = others.iter().copied().chain([column]).collect();
        let of_shapes =
            shape_error::variance_of_coefficient(self.problem, self.suspects, noise, column, others);
        let of_accelerations =
            findings.information.solve(&self.suspects.positions(&picks)).and_then(|solution| {
                let effects = picks.iter().map(|column| self.candidates[*column].effect());
                let effects: Vec<_> = effects.zip(solution.coefficients).collect();
                offset_acceleration::variance(self.problem, noise, &picks, &effects)
            });
        // Columns that cannot be told apart have no coefficient, and get no interval.
        OF_THE_BOUND * of_shapes.unwrap_or(0.0) + of_accelerations.unwrap_or(0.0)
    }

    /// Other columns of the same effect, each as probable as it fits well, with the coefficient that it would
    /// have; and that the true time constant lies between those of the grid.
    fn of_its_columns(&self, findings: &Findings, others: &[usize], column: usize) -> f64 {
        let regressor = &self.candidates[column].regressor;
        let own = self.suspects.usable().iter().copied();
        let fits: Vec<(usize, f64, f64)> = own
            .filter(|other| self.suspects.same_effect(*other, column))
            .filter_map(|own| {
                let set: Vec<usize> = others.iter().copied().chain([own]).collect();
                let solution = findings.information.solve(&self.suspects.positions(&set))?;
                let is_possible = own == column || self.suspects.is_possible(&set, &solution);
                is_possible.then_some((own, *solution.coefficients.last()?, solution.rest))
            })
            .collect();
        let Some((_, coefficient, rest)) = fits.iter().copied().find(|(own, ..)| *own == column) else {
            return 0.0;
        };
        let weight = |other_rest: f64| libm::exp(-0.5 * POWER * (other_rest - rest).max(0.0));
        let total: f64 = fits.iter().map(|(.., rest)| weight(*rest)).sum();
        let spread = fits.iter().map(|(_, value, rest)| weight(*rest) * (value - coefficient).powi(2));
        let mut variance = spread.sum::<f64>() / total;
        // The next longer and the next shorter time constant of the same clock.
        let grid = fits.iter().filter_map(|(own, value, _)| {
            let other = &self.candidates[*own].regressor;
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
    fn of_effects_not_chosen(
        &self,
        findings: &Findings,
        others: &[usize],
        column: usize,
        coefficient: f64,
    ) -> f64 {
        let chosen = with(others, column);
        let subject = self.candidates[column].sensor();
        let is_on_it = |other: usize| {
            let sensor = self.candidates[other].sensor();
            sensor.is_none() || subject.is_none() || sensor == subject
        };
        let Some(before) = findings.information.solve(&self.suspects.positions(&chosen)) else { return 0.0 };
        let noise = &findings.explanation.fit.noise;
        let (mut moved, mut total) = (0.0, 1.0);
        for other in self.additional(&findings.information, &chosen, is_on_it) {
            let at = |wanted: usize| other.set.iter().position(|column| *column == wanted);
            let (Some(own), Some(added)) = (at(column), at(other.column)) else { continue };
            // Where the two cannot be told apart, the coefficient says nothing of the other effect.
            let Some(of_shapes) =
                shape_error::variance(self.problem, self.suspects, noise, &chosen, &[other.column])
            else {
                continue;
            };
            let gain = (before.rest - other.solution.rest).max(0.0);
            let effect = self.candidates[other.column].effect();
            let odds = libm::exp(
                0.5 * gain / (1.0 / POWER + of_shapes)
                    + price(effect, &other.solution, added)
                    + libm::log(other.share),
            );
            moved += odds * (other.solution.coefficients[own] - coefficient).powi(2);
            total += odds;
        }
        moved / total
    }
}
