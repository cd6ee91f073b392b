//! The joint likelihood of all residuals of all flights, as a function of the effects that are assumed to act
//! and of the noise.

use executor::Executor;
use kf_core::sensor::{SENSORS, Sensor};
use nalgebra::DMatrix;

use super::information::{Information, own_coefficients, own_factor};
use super::noise::{Noise, NoisePrior};
use super::quasi_newton::{Function, minimise};
use super::score::score;
use super::series::{BySensor, Series};
use super::whitener::{LANES, whiten, whiten_by_groups};

/// Gain in twice the log likelihood below which the noise's fit stops iterating.
const GAIN: f64 = 0.02;

/// An effect that the model already has: its coefficient is known to some sigma, and its remainder is
/// estimated together with everything else, flight by flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Its column.
    pub column: usize,
    /// Sigma of its coefficient.
    pub sigma: f64,
}

/// Flights and the prior of their noise.
pub struct Problem<'a> {
    /// The flights; all have the same columns.
    pub flights: &'a [Series],
    /// The noise's prior.
    pub prior: NoisePrior,
    /// The effects that the model already has.
    pub known: Vec<Known>,
    /// Runs the work of a fit.
    executor: &'a dyn Executor,
    /// The column of each sensor's bias, as long as the longest flight.
    ones: [Vec<BySensor>; SENSORS],
}

/// The most probable noise given that certain effects act.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseFit {
    /// The parameters, as the prior defines them.
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
    /// Number of whitened readings.
    pub rows: usize,
    /// Sum of the logarithms of the innovations' variances.
    pub log_determinant: f64,
}

impl<'a> Problem<'a> {
    /// A problem with these flights.
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

    /// Number of columns that every flight has for itself: biases, and the remainders of known effects.
    #[must_use]
    pub const fn own(&self) -> usize {
        SENSORS + self.known.len()
    }

    /// Whether at most one sensor is in free flight: its movement against the reference may then be the
    /// reference's own.
    #[must_use]
    pub fn is_alone(&self) -> bool {
        let flies = |sensor: &&Sensor| {
            sensor.flies_free() && self.flights.iter().any(|flight| flight.has(sensor.index()))
        };
        Sensor::ALL.iter().filter(flies).count() < 2
    }

    /// The columns of a flight in the whitener's order: residual, its own, regressors.
    pub fn columns<'b>(&'b self, flight: &'b Series, picks: &[usize]) -> Vec<&'b [BySensor]> {
        let residual = std::iter::once(flight.residual_m.as_slice());
        let ones = self.ones.iter().map(Vec::as_slice);
        let known = self.known.iter().map(|known| known.column);
        let regressors = known.chain(picks.iter().copied()).map(|column| flight.columns[column].as_slice());
        residual.chain(ones).chain(regressors).collect()
    }

    /// Normal equations of one flight, with only the blocks that `used` selects.
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
        // The upper triangle, in square tiles of one group by one group.
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

    /// The priors of the known effects' coefficients, as additional readings of them.
    pub fn add_prior(&self, products: &mut DMatrix<f64>) {
        for (k, known) in self.known.iter().enumerate() {
            let at = 1 + SENSORS + k;
            products[(at, at)] += 1.0 / (known.sigma * known.sigma);
        }
    }

    /// Normal equations of some columns under a noise, with the flights' own columns projected out.
    #[must_use]
    pub fn information(&self, noise: &Noise, picks: &[usize]) -> Information {
        let mut information = Information::new(1 + picks.len());
        for flight in self.flights {
            let one = self.products(flight, noise, &self.columns(flight, picks), &|_| true);
            information.add_flight(&one.products, self.own(), one.rows, one.log_determinant);
        }
        information
    }

    /// What one square metre of white noise in the block means of a sensor adds to the sum of squares under a
    /// given noise. Used for the noise of regressors.
    #[must_use]
    pub fn weight_of_white(&self, noise: &Noise) -> BySensor {
        std::array::from_fn(|sensor| {
            self.weight_of_signs(noise, |sign| std::array::from_fn(|i| if i == sensor { sign } else { 0.0 }))
        })
    }

    /// The same for white noise that is in all sensors' block means alike, as the noise of a receiver is. The
    /// reference's own noise explains part of it.
    #[must_use]
    pub fn weight_of_shared_white(&self, noise: &Noise) -> f64 {
        self.weight_of_signs(noise, |sign| [sign; SENSORS])
    }

    /// The sum of squares of a column of random signs, made into one for each sensor.
    fn weight_of_signs(&self, noise: &Noise, by_sensor: impl Fn(f64) -> BySensor) -> f64 {
        let mut weight = 0.0;
        for flight in self.flights {
            // A sequence of signs without a period serves as white noise.
            let mut state = 0x2545_f491_4f6c_dd1d_u64;
            let column: Vec<BySensor> = (0..flight.len())
                .map(|_| {
                    state ^= state << 13;
                    state ^= state >> 7;
                    state ^= state << 17;
                    by_sensor(if state >> 63 == 0 { 1.0 } else { -1.0 })
                })
                .collect();
            whiten(flight, noise, &[&column], &|_| true, &mut |_, _, row| weight += row[0] * row[0]);
        }
        weight
    }

    /// The noise of several sets of columns from one start, in parallel.
    #[must_use]
    pub fn fit_noises(&self, sets: &[Vec<usize>], start: &[f64]) -> Vec<NoiseFit> {
        executor::map(self.executor, sets.iter().map(|picks| || self.fit_noise(&self.prior, picks, start)))
    }

    /// How many noises are fitted at a time.
    #[must_use]
    pub fn width(&self) -> usize {
        self.executor.width().max(1)
    }

    /// Finds the most probable noise given that the effects of these columns act.
    #[must_use]
    pub fn fit_noise(&self, prior: &NoisePrior, picks: &[usize], start: &[f64]) -> NoiseFit {
        let likelihood = Likelihood { problem: self, prior, picks };
        let minimum = minimise(&likelihood, start, GAIN);
        NoiseFit { noise: prior.noise(&minimum.at), values: minimum.at, twice_log_posterior: -minimum.value }
    }
}

/// Minus twice the log posterior of the noise's parameters, with the effects of some columns.
struct Likelihood<'a> {
    problem: &'a Problem<'a>,
    prior: &'a NoisePrior,
    picks: &'a [usize],
}

impl Function for Likelihood<'_> {
    /// Each flight's normal equations and the common coefficients; `None` where they cannot be told apart.
    type Left = Option<(Vec<DMatrix<f64>>, Vec<f64>)>;

    fn value(&self, values: &[f64]) -> (f64, Self::Left) {
        let noise = self.prior.noise(values);
        let mut information = Information::new(1 + self.picks.len());
        let mut flights = Vec::new();
        for flight in self.problem.flights {
            let one =
                self.problem.products(flight, &noise, &self.problem.columns(flight, self.picks), &|_| true);
            information.add_flight(&one.products, self.problem.own(), one.rows, one.log_determinant);
            flights.push(one.products);
        }
        let all: Vec<usize> = (0..self.picks.len()).collect();
        let Some(solution) = information.solve(&all) else { return (f64::INFINITY, None) };
        let value =
            solution.rest - information.twice_log_determinant() - 2.0 * self.prior.log_density(values);
        (value, Some((flights, solution.coefficients)))
    }

    /// The coefficients minimise the squares, so the derivative with respect to them is zero: the slope of
    /// the squares is that of the remainder. The own columns' normal equations `B` add the slope of
    /// `log |B|`, the sum of squares of `L^-1` times them, with `B = L L'`.
    fn slope(&self, values: &[f64], left: &Self::Left) -> Vec<f64> {
        let mut slope: Vec<f64> =
            self.prior.log_density_slope(values).into_iter().map(|slope| -2.0 * slope).collect();
        let Some((flights, common)) = left else { return slope };
        let noise = self.prior.noise(values);
        let own = self.problem.own();
        for (flight, products) in self.problem.flights.iter().zip(flights) {
            let columns = self.problem.columns(flight, self.picks);
            let coefficients = own_coefficients(products, own, common);
            let mut rest = vec![1.0];
            rest.extend(coefficients.iter().chain(common).map(|value| -value));
            let mut fixed = vec![combined(&columns, &rest)];
            if let Some((present, factor)) = own_factor(products, own) {
                // Cholesky's factor has a positive diagonal.
                let mut inverse = DMatrix::identity(present.len(), present.len());
                factor.l_dirty().solve_lower_triangular_mut(&mut inverse);
                for row in inverse.row_iter() {
                    let mut shares = vec![0.0; 1 + own];
                    for (at, share) in present.iter().zip(row.iter()) {
                        shares[*at] = *share;
                    }
                    fixed.push(combined(&columns, &shares));
                }
            }
            let fixed: Vec<&[BySensor]> = fixed.iter().map(Vec::as_slice).collect();
            let of_noise = score(flight, &noise, &fixed);
            for (sum, new) in slope.iter_mut().zip(self.prior.slope(values, &of_noise)) {
                *sum += new;
            }
        }
        slope
    }
}

/// A combination of the first columns.
#[must_use]
pub fn combined(columns: &[&[BySensor]], shares: &[f64]) -> Vec<BySensor> {
    let length = columns.first().map_or(0, |column| column.len());
    let mut sum = vec![[0.0; SENSORS]; length];
    for (column, share) in columns.iter().zip(shares).filter(|(_, share)| **share != 0.0) {
        for (sum, values) in sum.iter_mut().zip(*column) {
            for (sum, value) in sum.iter_mut().zip(values) {
                *sum += share * value;
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use model::Model;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Two sensors, the second one with gaps, captive for a third, and three regressors of any shape.
    fn flight(seed: u64) -> Series {
        let mut series = Series {
            block_s: 1.0,
            full_block: [10.0; SENSORS],
            columns: vec![Arc::default(); 3],
            ..Series::default()
        };
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut next = || random.random_range(-0.5..0.5);
        let mut level = 0.0;
        for block in 0..90_u32 {
            level += next();
            series.time_s.push(f64::from(block) + if block > 40 { 2.5 } else { 0.0 });
            series.fixes.push(f64::from(1 + block % 5));
            series.free.push(block >= 30);
            series.readings.push([0, 4 + block % 7, 10]);
            let gap = block % 11 == 3;
            series.residual_m.push([
                f64::NAN,
                if gap { f64::NAN } else { level + next() },
                level + 2.0 * next(),
            ]);
            for column in &mut series.columns {
                Arc::make_mut(column).push([0.0, next() + f64::from(block) / 60.0, 2.0 * next()]);
            }
        }
        series
    }

    /// The slope is that of the value: two flights, a known effect, two picks, every parameter of the noise.
    /// Differences of 1e-4 either way have errors of that step squared; 1e-5 of the largest slope is far more
    /// than these.
    #[test]
    fn the_slope_is_that_of_the_likelihood() {
        let flights = [flight(1), flight(7)];
        let model = Model::default();
        for prior in [
            NoisePrior::new(&flights, &model.reference, &model.sensors),
            NoisePrior::new(&flights, &model.reference, &model.sensors).with_slow_wander(),
        ] {
            let known = vec![Known { column: 2, sigma: 0.7 }];
            let problem = Problem::new(&flights, prior.clone(), known, &executor::Inline);
            let likelihood = Likelihood { problem: &problem, prior: &prior, picks: &[0, 1] };
            let at: Vec<f64> =
                prior.means().iter().enumerate().map(|(k, mean)| mean + 0.3 - 0.1 * (k % 5) as f64).collect();
            let (_, left) = likelihood.value(&at);
            let slope = likelihood.slope(&at, &left);
            let largest = slope.iter().fold(0.0_f64, |largest, slope| largest.max(slope.abs()));
            for (k, slope) in slope.iter().enumerate() {
                let moved = |by: f64| {
                    let mut moved = at.clone();
                    moved[k] += by;
                    likelihood.value(&moved).0
                };
                let difference = (moved(1e-4) - moved(-1e-4)) / 2e-4;
                assert!(
                    (slope - difference).abs() < 1e-5 * largest,
                    "{k}: {slope}, differences {difference}"
                );
            }
        }
    }

    /// Picks that cannot be told apart have no likelihood, and only the prior's slope.
    #[test]
    fn columns_that_cannot_be_told_apart_have_no_likelihood() {
        let mut twice = flight(1);
        twice.columns[1] = Arc::clone(&twice.columns[0]);
        let flights = [twice];
        let model = Model::default();
        let prior = NoisePrior::new(&flights, &model.reference, &model.sensors);
        let problem = Problem::new(&flights, prior.clone(), Vec::new(), &executor::Inline);
        let likelihood = Likelihood { problem: &problem, prior: &prior, picks: &[0, 1] };
        let means = prior.means();
        let (value, left) = likelihood.value(&means);
        assert!(value == f64::INFINITY && left.is_none());
        assert!(likelihood.slope(&means, &left).iter().all(|slope| *slope == 0.0));
    }
}
