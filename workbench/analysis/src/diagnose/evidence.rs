//! How well a coefficient predicts data that it was not learned from, as a likelihood.
//!
//! The flights are whitened by the noise that was fitted together with the effect, so that the reference's
//! wander, the sensors' own wander and the white noise are each weighted correctly. Biases, the effects that
//! the model already has and the other effects are projected out. With a coefficient c, twice the log
//! likelihood of some blocks gains `c (2 s - c i)` over c = 0, where s is their score (the whitened regressor
//! times the whitened residual) and i their information (its square). Their own least-squares coefficient is
//! `s / i`.

use kf_core::sensor::SENSORS;
use nalgebra::{DMatrix, DVector};

use super::held_out::{FOLDS, fold};
use super::long_run;
use super::noise::Noise;
use super::problem::Problem;
use super::series::Series;
use super::whitener::whiten;

/// A regressor whose projection keeps less than this share of its square does not vary by itself.
const COLLINEAR: f64 = 1e-10;

/// The evidence of some blocks about one coefficient.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evidence {
    /// Whitened regressor times whitened residual, 1 / unit of the coefficient.
    pub score: f64,
    /// Square of the whitened regressor, 1 / unit of the coefficient squared.
    pub information: f64,
    /// Variance of the score: the information, times how much larger the residual's autocorrelation or the
    /// coefficient's spread over the learning flights make it.
    pub variance: f64,
}

impl Evidence {
    /// The evidence of both together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            score: self.score + other.score,
            information: self.information + other.information,
            variance: self.variance + other.variance,
        }
    }
}

/// Evidence of the learning flights, divided into the parts that are held out in turn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Folds {
    /// Captive flight, which is never held out.
    pub captive: Evidence,
    /// The stretches of free flight.
    pub stretches: Vec<Evidence>,
}

/// The columns of an effect and of the others fitted with it, and their noise.
pub(crate) struct Fitted<'a> {
    pub(crate) noise: &'a Noise,
    pub(crate) others: &'a [usize],
    pub(crate) column: usize,
    /// The score's variance divided by the information, from the learning flights, at least 1.
    pub(crate) inflation: f64,
}

/// Evidence of whole flights.
pub(crate) fn of_flights(problem: &Problem<'_>, fitted: &Fitted<'_>) -> Evidence {
    let mut sum = Evidence::default();
    for flight in problem.flights {
        for block in of_blocks(problem, flight, fitted) {
            sum = sum.and(block);
        }
    }
    sum
}

/// Evidence of the stretches that [`super::held_out::manoeuvres`] leaves out.
pub(crate) fn of_folds(problem: &Problem<'_>, fitted: &Fitted<'_>) -> Folds {
    let mut folds = Folds { stretches: vec![Evidence::default(); FOLDS], ..Folds::default() };
    for flight in problem.flights {
        for (block, evidence) in of_blocks(problem, flight, fitted).into_iter().enumerate() {
            let slot = match fold(flight, block) {
                Some(at) => &mut folds.stretches[at],
                None => &mut folds.captive,
            };
            *slot = slot.and(evidence);
        }
    }
    folds
}

/// Evidence of every block of a flight.
fn of_blocks(problem: &Problem<'_>, flight: &Series, fitted: &Fitted<'_>) -> Vec<Evidence> {
    let picks: Vec<usize> = fitted.others.iter().copied().chain([fitted.column]).collect();
    let columns = problem.columns(flight, &picks);
    let width = columns.len();
    let mut rows: Vec<f64> = Vec::new();
    let mut blocks: Vec<usize> = Vec::new();
    whiten(flight, fitted.noise, &columns, &|_| true, &mut |block, _, row| {
        rows.extend_from_slice(row);
        blocks.push(block);
    });
    // The priors of the known effects, as additional readings of them.
    for (k, known) in problem.known.iter().enumerate() {
        rows.extend((0..width).map(|at| if at == 1 + SENSORS + k { 1.0 / known.sigma } else { 0.0 }));
    }
    let matrix = DMatrix::from_row_slice(rows.len() / width, width, &rows);
    let mut of_block = vec![Evidence::default(); flight.len()];
    let beside = basis(&matrix, 1..width - 1);
    let Some(alone) = left_of(&matrix, width - 1, &beside) else { return of_block };
    let Some(unexplained) = left_of(&matrix, 0, &beside) else { return of_block };
    let information = alone.norm_squared();
    let rest = &unexplained - &alone * (alone.dot(&unexplained) / information);
    let mut noise = vec![0.0; flight.len()];
    for row in 0..matrix.nrows() {
        // The readings of known effects belong to no block. They are added to the first, which is never held
        // out if any of the flight is captive.
        let at = blocks.get(row).copied().unwrap_or(0);
        if let Some(evidence) = of_block.get_mut(at) {
            evidence.score += alone[row] * unexplained[row];
            evidence.information += alone[row] * alone[row];
            noise[at] += alone[row] * rest[row];
        }
    }
    let inflation = (long_run::variance(&noise, flight.block_s) / information).max(fitted.inflation);
    for evidence in &mut of_block {
        evidence.variance = inflation * evidence.information;
    }
    of_block
}

/// Orthonormal columns that span the same space as those of a matrix; linearly dependent ones are left out.
fn basis(matrix: &DMatrix<f64>, columns: std::ops::Range<usize>) -> Vec<DVector<f64>> {
    let mut basis = Vec::new();
    for column in columns {
        if let Some(left) = left_of(matrix, column, &basis) {
            basis.push(left.normalize());
        }
    }
    basis
}

/// The part of a column that is orthogonal to a basis, if there is any.
fn left_of(matrix: &DMatrix<f64>, column: usize, basis: &[DVector<f64>]) -> Option<DVector<f64>> {
    let own = matrix.column(column);
    let mut left = own.clone_owned();
    // Twice is enough (Giraud, Langou and Rozloznik, "The loss of orthogonality in the Gram-Schmidt
    // orthogonalization process", Computers and Mathematics with Applications 50, 2005).
    for direction in basis.iter().chain(basis) {
        left -= direction * direction.dot(&left);
    }
    (left.norm_squared() > COLLINEAR * own.norm_squared()).then_some(left)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::noise::{GaussMarkov, NoisePrior, SensorNoise};
    use super::super::problem::Known;
    use super::*;

    const NOISE: Noise = {
        let sensor = SensorNoise {
            wander: GaussMarkov { sigma_m: 0.7, time_s: 9.0 },
            captive_white_m: 0.3,
            free_white_m: 0.4,
            free_flight_factor: 1.0,
        };
        Noise {
            reference: GaussMarkov { sigma_m: 2.0, time_s: 40.0 },
            slow: GaussMarkov { sigma_m: 1.0, time_s: 300.0 },
            fix_sigma_m: 0.3,
            sensors: [sensor; SENSORS],
        }
    };

    fn flight() -> Series {
        let mut series = Series {
            block_s: 1.0,
            full_block: [10.0; SENSORS],
            columns: vec![Arc::default(); 3],
            ..Series::default()
        };
        for k in 0..120_u32 {
            let t = f64::from(k);
            let rough = |i: u32| f64::from((k * 37 + i * 11) % 19) / 6.0 - 1.5;
            let columns = [t.sin() * 3.0, (t / 7.0).cos(), f64::from(k > 50) * (t / 5.0).sin()];
            series.time_s.push(t);
            series.fixes.push(5.0);
            series.free.push(k > 40);
            series.readings.push([10; SENSORS]);
            series.residual_m.push([f64::NAN, rough(1), 4.0 + 0.8 * columns[0] - columns[1] + rough(2)]);
            for (all, column) in series.columns.iter_mut().zip(columns) {
                Arc::make_mut(all).push([0.0, 0.0, column]);
            }
        }
        series
    }

    /// Score over information is the coefficient of the normal equations, and the gain is that of their sums
    /// of squares: with another effect included, a known one with its prior, and biases.
    #[test]
    fn the_gain_is_the_likelihoods() {
        let flights = [flight()];
        let model = model::Model::default();
        let prior = NoisePrior::new(&flights, &model.reference, &model.sensors);
        let problem = Problem::new(&flights, prior, vec![Known { column: 2, sigma: 0.3 }], &executor::Inline);
        let fitted = Fitted { noise: &NOISE, others: &[1], column: 0, inflation: 1.0 };
        let evidence = of_flights(&problem, &fitted);
        let information = problem.information(&NOISE, &[1, 0]);
        let (with, without) = (information.solve(&[0, 1]).unwrap(), information.solve(&[0]).unwrap());
        let coefficient = evidence.score / evidence.information;
        assert!((coefficient - with.coefficients[1]).abs() < 1e-9, "{evidence:?} {with:?}");
        assert!((1.0 / evidence.information - with.covariance[3]).abs() < 1e-9);
        let gain = coefficient * (2.0 * evidence.score - coefficient * evidence.information);
        assert!((gain - (without.rest - with.rest)).abs() < 1e-6, "{gain}");

        // No block is in two stretches or in none.
        let folds = of_folds(&problem, &fitted);
        let sum = folds.stretches.iter().fold(folds.captive, |sum, part| sum.and(*part));
        assert!((sum.score - evidence.score).abs() < 1e-9 * evidence.score.abs());
        assert!(
            folds.stretches.iter().all(|part| part.information > 0.0 && part.variance >= part.information)
        );
    }

    #[test]
    fn a_regressor_that_is_a_bias_says_nothing() {
        let mut flights = [flight()];
        Arc::make_mut(&mut flights[0].columns[0]).fill([0.0, 0.0, 7.0]);
        let model = model::Model::default();
        let prior = NoisePrior::new(&flights, &model.reference, &model.sensors);
        let problem = Problem::new(&flights, prior, Vec::new(), &executor::Inline);
        let fitted = Fitted { noise: &NOISE, others: &[], column: 0, inflation: 1.0 };
        assert_eq!(of_flights(&problem, &fitted), Evidence::default());
    }
}
