//! The joint likelihood of all residuals of all flights, as a function of the effects that are taken
//! to act and of the noise.

use executor::Executor;
use kf_core::sensor::SENSORS;
use nalgebra::DMatrix;

use super::information::Information;
use super::noise::{Noise, NoisePrior};
use super::quasi_newton::minimise;
use super::series::{BySensor, Series};
use super::whitener::{LANES, whiten, whiten_by_groups};

/// Twice the log likelihood that an iteration of the noise's fit must gain to go on.
const GAIN: f64 = 0.02;

/// An effect that the model has already: its coefficient is known to some sigma, and what is left of it
/// is estimated beside everything else, flight by flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Its column.
    pub column: usize,
    /// Sigma of its coefficient.
    pub sigma: f64,
}

/// Flights and what is believed of their noise.
pub struct Problem<'a> {
    /// The flights; all have the same columns.
    pub flights: &'a [Series],
    /// The noise's prior.
    pub prior: NoisePrior,
    /// The effects that the model has already.
    pub known: Vec<Known>,
    /// Who does the work of a fit.
    executor: &'a dyn Executor,
    /// The column of each sensor's bias, as long as the longest flight.
    ones: [Vec<BySensor>; SENSORS],
}

/// The most probable noise given that certain effects act.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseFit {
    /// The parameters, of the prior's meaning.
    pub values: Vec<f64>,
    /// The noise.
    pub noise: Noise,
    /// Twice the log posterior, up to a constant that all fits of the same data share.
    pub twice_log_posterior: f64,
}

/// Which blocks of a flight are used.
pub type Used<'a> = dyn Fn(usize) -> bool + 'a;

/// Normal equations of one flight: the residual, its own columns, the picks.
#[derive(Clone, Debug)]
pub struct FlightProducts {
    /// Products of the whitened columns.
    pub products: DMatrix<f64>,
    /// Whitened readings.
    pub rows: usize,
    /// Sum of the logarithms of the innovations' variances.
    pub log_determinant: f64,
}

impl<'a> Problem<'a> {
    /// A problem of some flights.
    #[must_use]
    pub fn new(
        flights: &'a [Series],
        prior: NoisePrior,
        known: Vec<Known>,
        executor: &'a dyn Executor,
    ) -> Self {
        let longest = flights.iter().map(Series::len).max().unwrap_or(0);
        let ones = std::array::from_fn(|i| {
            let mut one = [0.0; SENSORS];
            one[i] = 1.0;
            vec![one; longest]
        });
        Self { flights, prior, known, executor, ones }
    }

    /// Number of columns that every flight has for itself: biases, and what is left of known effects.
    #[must_use]
    pub const fn own(&self) -> usize {
        SENSORS + self.known.len()
    }

    /// The columns of a flight as the whitener takes them: residual, its own, regressors.
    pub fn columns<'b>(&'b self, flight: &'b Series, picks: &[usize]) -> Vec<&'b [BySensor]> {
        let residual = std::iter::once(flight.residual_m.as_slice());
        let ones = self.ones.iter().map(Vec::as_slice);
        let known = self.known.iter().map(|known| known.column);
        let regressors = known.chain(picks.iter().copied()).map(|column| flight.columns[column].as_slice());
        residual.chain(ones).chain(regressors).collect()
    }

    /// Normal equations of one flight, those blocks only that `used` says.
    #[must_use]
    pub fn products(
        &self,
        flight: &Series,
        noise: &Noise,
        columns: &[&[BySensor]],
        used: &Used<'_>,
    ) -> FlightProducts {
        let width = columns.len();
        let groups = width.div_ceil(LANES);
        // The upper triangle in squares of a group by a group.
        let mut tiles = vec![[[0.0; LANES]; LANES]; groups * groups];
        let mut rows = 0;
        let log_determinant = whiten_by_groups(flight, noise, columns, used, &mut |_, _, row| {
            rows += 1;
            for (k, (tiles, left)) in tiles.chunks_exact_mut(groups).zip(row).enumerate() {
                for (tile, right) in tiles.iter_mut().zip(row).skip(k) {
                    for (tile, left) in tile.iter_mut().zip(left) {
                        for (product, right) in tile.iter_mut().zip(right) {
                            *product += left * right;
                        }
                    }
                }
            }
        });
        let mut products = DMatrix::from_fn(width, width, |r, c| {
            let (r, c) = (r.min(c), r.max(c));
            tiles[(r / LANES) * groups + c / LANES][r % LANES][c % LANES]
        });
        self.add_prior(&mut products);
        FlightProducts { products, rows, log_determinant }
    }

    /// What is believed of the known effects' coefficients, as further readings of them.
    pub fn add_prior(&self, products: &mut DMatrix<f64>) {
        for (k, known) in self.known.iter().enumerate() {
            let at = 1 + SENSORS + k;
            products[(at, at)] += 1.0 / (known.sigma * known.sigma);
        }
    }

    /// Normal equations of some columns under a noise, the flights' own columns projected out.
    #[must_use]
    pub fn information(&self, noise: &Noise, picks: &[usize]) -> Information {
        let mut information = Information::new(1 + picks.len());
        for flight in self.flights {
            let one = self.products(flight, noise, &self.columns(flight, picks), &|_| true);
            information.add_flight(&one.products, self.own(), one.rows, one.log_determinant);
        }
        information
    }

    /// What one square metre of white noise in the block means of a sensor adds to the sum of squares under
    /// a noise; for the noise of regressors.
    #[must_use]
    pub fn weight_of_white(&self, noise: &Noise) -> BySensor {
        let mut weights = [0.0; SENSORS];
        for flight in self.flights {
            // A sequence of signs without a period does for white noise.
            let mut state = 0x2545_f491_4f6c_dd1d_u64;
            let signs: Vec<f64> = (0..flight.len())
                .map(|_| {
                    state ^= state << 13;
                    state ^= state >> 7;
                    state ^= state << 17;
                    if state >> 63 == 0 { 1.0 } else { -1.0 }
                })
                .collect();
            for (sensor, weight) in weights.iter_mut().enumerate() {
                let column: Vec<BySensor> = signs
                    .iter()
                    .map(|sign| std::array::from_fn(|i| if i == sensor { *sign } else { 0.0 }))
                    .collect();
                whiten(flight, noise, &[&column], &|_| true, &mut |_, _, row| *weight += row[0] * row[0]);
            }
        }
        weights
    }

    /// Finds the most probable noise given that the effects of these columns act.
    #[must_use]
    pub fn fit_noise(&self, prior: &NoisePrior, picks: &[usize], start: &[f64]) -> NoiseFit {
        let all: Vec<usize> = (0..picks.len()).collect();
        let objective = |values: &[f64]| -> f64 {
            let noise = prior.noise(values);
            let likelihood =
                self.information(&noise, picks).twice_log_likelihood(&all).unwrap_or(f64::NEG_INFINITY);
            -likelihood - 2.0 * prior.log_density(values)
        };
        let minimum = minimise(&objective, start, GAIN, self.executor);
        NoiseFit { noise: prior.noise(&minimum.at), values: minimum.at, twice_log_posterior: -minimum.value }
    }
}
