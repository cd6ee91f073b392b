//! A stochastic model of a residual, fitted to its autocovariance.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::standard_normal::standard_normal;

use super::Autocovariance;

/// Ratio of neighbouring correlation times of the grid: three to a decade.
const GRID_RATIO: f64 = 2.154_434_690_031_884;
/// Largest number of sweeps of the non-negative least squares.
const SWEEPS: usize = 5_000;
/// Weight of lag 0, so that the model's variance is the residual's.
const VARIANCE_WEIGHT: f64 = 100.0;
/// Components below this share of the variance are treated as noise of the fit.
const SMALLEST_SHARE: f64 = 1e-4;

/// A first-order Gauss-Markov process.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Component {
    /// Correlation time, seconds.
    pub time_s: f64,
    /// Variance, square metres.
    pub variance_m2: f64,
}

/// White noise plus first-order Gauss-Markov processes, sampled at a fixed interval.
///
/// Non-negative variances make it a valid process whatever the data. It cannot represent an oscillating
/// autocovariance, which is replaced by the nearest monotone one. Values are Gaussian.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ResidualModel {
    /// Time between samples, seconds.
    pub sample_interval_s: f64,
    /// Variance of the white part, square metres.
    pub white_variance_m2: f64,
    /// The correlated parts.
    pub components: Vec<Component>,
    /// Longest lag that the data cover, seconds.
    pub longest_lag_s: f64,
}

impl ResidualModel {
    /// Fits the variances of components on a grid of correlation times by non-negative least squares.
    ///
    /// The sample mean was removed before the autocovariance was measured, which lowers every lag by that
    /// mean's variance; the fit includes the model's own prediction of it. `None` if the autocovariance has
    /// no lag beyond 0.
    #[must_use]
    pub fn fit(autocovariance: &Autocovariance, sample_interval_s: f64) -> Option<Self> {
        let lags = autocovariance.lags();
        let n = autocovariance.count() as f64;
        let longest = lags.last().filter(|lag| lag.samples > 0)?.samples as f64;
        let mut times = Vec::new();
        let mut time = 1.0;
        while time <= 2.0 * longest {
            times.push(time);
            time *= GRID_RATIO;
        }
        let atom = |atom: usize, lag: f64| match atom.checked_sub(1) {
            None => f64::from(u8::from(lag == 0.0)) - 1.0 / n,
            Some(index) => {
                let phi = libm::exp(-1.0 / times[index]);
                libm::pow(phi, lag) - mean_variance(phi, n)
            }
        };
        let atoms = times.len() + 1;
        let mut normal = vec![vec![0.0; atoms]; atoms];
        let mut right = vec![0.0; atoms];
        for lag in lags {
            let weight = if lag.samples == 0 { VARIANCE_WEIGHT } else { 1.0 };
            let row: Vec<f64> = (0..atoms).map(|index| atom(index, lag.samples as f64)).collect();
            for (i, &left) in row.iter().enumerate() {
                right[i] += weight * left * lag.covariance;
                for (j, &other) in row.iter().enumerate() {
                    normal[i][j] += weight * left * other;
                }
            }
        }
        let variances = non_negative_least_squares(&normal, &right);
        let total: f64 = variances.iter().sum();
        let components =
            times.iter().zip(&variances[1..]).filter(|(_, variance)| **variance > SMALLEST_SHARE * total);
        Some(Self {
            sample_interval_s,
            white_variance_m2: variances[0],
            components: components
                .map(|(time, &variance_m2)| Component { time_s: time * sample_interval_s, variance_m2 })
                .collect(),
            longest_lag_s: longest * sample_interval_s,
        })
    }

    /// Variance of one sample, square metres.
    #[must_use]
    pub fn variance(&self) -> f64 {
        self.white_variance_m2 + self.components.iter().map(|part| part.variance_m2).sum::<f64>()
    }

    fn phi(&self, component: &Component) -> f64 {
        libm::exp(-self.sample_interval_s / component.time_s)
    }

    /// Variance of the mean of `samples` consecutive samples, square metres.
    #[must_use]
    pub fn variance_of_mean(&self, samples: u64) -> f64 {
        let n = samples.max(1) as f64;
        let correlated =
            self.components.iter().map(|part| part.variance_m2 * mean_variance(self.phi(part), n));
        self.white_variance_m2 / n + correlated.sum::<f64>()
    }

    /// Autocovariance of the moving average over `window` samples at a lag of `lag` samples.
    #[must_use]
    pub fn moving_average_autocovariance(&self, window: u64, lag: u64) -> f64 {
        // Covariance of overlapping sums, from the variances of the sums that bound them.
        let sum_variance = |count: u64| {
            if count == 0 { 0.0 } else { (count as f64).powi(2) * self.variance_of_mean(count) }
        };
        let bounds =
            sum_variance(window + lag) + sum_variance(window.abs_diff(lag)) - 2.0 * sum_variance(lag);
        0.5 * bounds / (window as f64).powi(2)
    }

    /// Draws an endless sequence of means of `samples_per_step` consecutive samples of the process.
    ///
    /// The white part and each component have their own stream of the seed's random numbers: how small one
    /// is, or whether the fit has it at all, does not change what the others draw.
    #[must_use]
    pub fn simulate(&self, samples_per_step: u64, seed: u64) -> Simulation {
        let white = ChaCha8Rng::seed_from_u64(seed);
        let parts = self
            .components
            .iter()
            .zip(self.streams())
            .map(|(part, stream)| {
                let mut generator = white.clone();
                generator.set_stream(stream);
                Part::new(self.phi(part), part.variance_m2, samples_per_step, generator)
            })
            .collect();
        let white_sigma = (self.white_variance_m2 / samples_per_step.max(1) as f64).sqrt();
        Simulation { white, white_sigma, parts }
    }

    /// A stream number for each component, from its correlation time: the nearest of the fit's grid, and the
    /// number of earlier components with the same one. The white part's is 0.
    fn streams(&self) -> Vec<u64> {
        let nearest: Vec<i64> = self
            .components
            .iter()
            .map(|part| {
                libm::round(libm::log(part.time_s / self.sample_interval_s) / libm::log(GRID_RATIO)) as i64
            })
            .collect();
        let before =
            |index: usize| nearest[..index].iter().filter(|other| **other == nearest[index]).count() as u64;
        nearest.iter().enumerate().map(|(index, time)| ((*time as u64) << 8) + 1 + before(index)).collect()
    }
}

/// Variance of the mean of `n` samples of a unit AR(1) process (Priestley, "Spectral Analysis and
/// Time Series", eq. 5.3.5).
fn mean_variance(phi: f64, n: f64) -> f64 {
    (n * (1.0 - phi * phi) - 2.0 * phi * (1.0 - libm::pow(phi, n))) / (n * n * (1.0 - phi).powi(2))
}

/// Minimises `x' A x / 2 - b' x` over `x >= 0` by coordinate descent; `A` is positive semidefinite.
///
/// Source: Franc, Hlavac, Navara, "Sequential coordinate-wise algorithm for the non-negative least
/// squares problem", CAIP 2005.
fn non_negative_least_squares(normal: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let mut solution = vec![0.0; right.len()];
    for _ in 0..SWEEPS {
        let mut largest_step = 0.0_f64;
        for index in 0..right.len() {
            let curvature = normal[index][index];
            if curvature <= 0.0 {
                continue;
            }
            let product: f64 = normal[index].iter().zip(&solution).map(|(a, x)| a * x).sum();
            let updated = f64::max(solution[index] + (right[index] - product) / curvature, 0.0);
            largest_step = largest_step.max((updated - solution[index]).abs());
            solution[index] = updated;
        }
        let size: f64 = solution.iter().sum();
        if largest_step <= 1e-9 * size {
            break;
        }
    }
    solution
}

/// One Gauss-Markov part, stepped over many samples at once: the state at the step's end and the
/// mean over the step are drawn jointly, so no step is too coarse.
#[derive(Clone, Debug)]
struct Part {
    state: f64,
    state_gain: f64,
    mean_gain: f64,
    state_sigma: f64,
    shared_sigma: f64,
    /// `None` for a step of one sample, which is its own mean.
    own_sigma: Option<f64>,
    generator: ChaCha8Rng,
}

impl Part {
    fn new(phi: f64, variance: f64, samples: u64, mut generator: ChaCha8Rng) -> Self {
        let n = samples.max(1);
        let driving = variance * (1.0 - phi * phi);
        let (mut state_variance, mut sum_variance, mut covariance) = (0.0, 0.0, 0.0);
        let mut power = 1.0;
        for _ in 0..n {
            let reach = (1.0 - power * phi) / (1.0 - phi);
            state_variance += driving * power * power;
            sum_variance += driving * reach * reach;
            covariance += driving * power * reach;
            power *= phi;
        }
        let count = n as f64;
        let state_sigma = f64::sqrt(state_variance);
        let shared_sigma = if state_sigma > 0.0 { covariance / state_sigma / count } else { 0.0 };
        let own = sum_variance / (count * count) - shared_sigma * shared_sigma;
        let start = standard_normal(&mut generator);
        Self {
            state: start * variance.sqrt(),
            state_gain: power,
            mean_gain: phi * (1.0 - power) / (1.0 - phi) / count,
            state_sigma,
            shared_sigma,
            own_sigma: (n > 1).then(|| own.max(0.0).sqrt()),
            generator,
        }
    }
}

/// An endless draw of a [`ResidualModel`]; see [`ResidualModel::simulate`].
#[derive(Clone, Debug)]
pub struct Simulation {
    white: ChaCha8Rng,
    white_sigma: f64,
    parts: Vec<Part>,
}

impl Iterator for Simulation {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        let mut mean = self.white_sigma * standard_normal(&mut self.white);
        for part in &mut self.parts {
            let shared = standard_normal(&mut part.generator);
            mean += part.mean_gain * part.state + part.shared_sigma * shared;
            if let Some(own_sigma) = part.own_sigma {
                mean += own_sigma * standard_normal(&mut part.generator);
            }
            part.state = part.state_gain * part.state + part.state_sigma * shared;
        }
        Some(mean)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::{Correlator, Moments};

    /// A unit-variance AR(1) sequence, by its definition.
    pub fn first_order(phi: f64, count: usize, seed: u64) -> Vec<f64> {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        let mut state = standard_normal(&mut generator);
        let driving = (1.0 - phi * phi).sqrt();
        (0..count)
            .map(|_| {
                let now = state;
                let noise = standard_normal(&mut generator);
                state = phi * state + driving * noise;
                now
            })
            .collect()
    }

    fn example() -> ResidualModel {
        ResidualModel {
            sample_interval_s: 0.02,
            white_variance_m2: 4.0,
            components: vec![
                Component { time_s: 0.2, variance_m2: 1.0 },
                Component { time_s: 3.0, variance_m2: 2.0 },
            ],
            longest_lag_s: 100.0,
        }
    }

    #[test]
    fn simulated_steps_have_the_variances_of_the_theory() {
        let model = example();
        for samples in [1, 7, 50] {
            let steps = 60_000;
            let mut single = Moments::default();
            let mut paired = Moments::default();
            let mut simulation = model.simulate(samples, 5);
            for _ in 0..steps {
                let (first, second) = (simulation.next().unwrap(), simulation.next().unwrap());
                single.push(first);
                paired.push(0.5 * (first + second));
            }
            // Effective number of steps: the slowest part stays correlated for 2 * 3 s.
            let independent = (2.0 * steps as f64 * samples as f64 * 0.02 / 6.0).min(steps as f64);
            let sigma = (2.0 / independent).sqrt();
            for (got, expected) in
                [(single, model.variance_of_mean(samples)), (paired, model.variance_of_mean(2 * samples))]
            {
                let got = got.variance().unwrap();
                assert!((got / expected - 1.0).abs() < 4.0 * sigma, "{samples}: {got} {expected}");
            }
        }
    }

    /// A component without variance does not change what the others draw, and two with the same correlation
    /// time are independent of each other.
    #[test]
    fn components_draw_by_themselves() {
        let model = example();
        let mut more = model.clone();
        more.components.insert(1, Component { time_s: 0.7, variance_m2: 0.0 });
        for samples in [1, 7] {
            let draws = |model: &ResidualModel| model.simulate(samples, 3).take(1_000).collect::<Vec<f64>>();
            assert!(draws(&model) == draws(&more), "{samples}");
        }
        let part = Component { time_s: 1.0, variance_m2: 1.0 };
        let twice = ResidualModel { white_variance_m2: 0.0, components: vec![part; 2], ..model };
        let mut moments = Moments::default();
        (0..10_000).for_each(|seed| moments.push(twice.simulate(1, seed).next().unwrap()));
        let variance = moments.variance().unwrap();
        assert!((variance / 2.0 - 1.0).abs() < 4.0 * (2.0 / 10_000.0_f64).sqrt(), "{variance}");
    }

    #[test]
    fn moving_average_autocovariance_is_the_double_sum() {
        let model = example();
        let autocovariance = |lag: i64| {
            let white = if lag == 0 { model.white_variance_m2 } else { 0.0 };
            let lag_s = lag.abs() as f64 * model.sample_interval_s;
            white + model.components.iter().map(|c| c.variance_m2 * (-lag_s / c.time_s).exp()).sum::<f64>()
        };
        for (window, lag) in [(1_i64, 0_i64), (1, 3), (10, 0), (10, 4), (10, 25)] {
            let mut sum = 0.0;
            for i in 0..window {
                for j in 0..window {
                    sum += autocovariance(lag + i - j);
                }
            }
            let expected = sum / (window * window) as f64;
            let got = model.moving_average_autocovariance(window as u64, lag as u64);
            assert!((got - expected).abs() < 1e-9, "{window} {lag}: {got} {expected}");
        }
    }

    fn fitted(model: &ResidualModel, seconds: f64, seed: u64) -> ResidualModel {
        let mut correlator = Correlator::default();
        let count = (seconds / model.sample_interval_s) as usize;
        model.simulate(1, seed).take(count).for_each(|value| correlator.push(value));
        ResidualModel::fit(&correlator.autocovariance().unwrap(), model.sample_interval_s).unwrap()
    }

    #[test]
    fn fit_recovers_what_a_moving_average_would_see() {
        let model = example();
        let fit = fitted(&model, 3_600.0, 8);
        for window_s in [0.02, 0.2, 1.0, 5.0, 20.0] {
            let samples = (window_s / model.sample_interval_s) as u64;
            let ratio = (fit.variance_of_mean(samples) / model.variance_of_mean(samples)).sqrt();
            // An hour holds 600 independent values of the slowest part: 2.9 % in sigma, more for
            // windows that average most of it away.
            assert!((ratio - 1.0).abs() < 4.0 * 0.029, "{window_s}: {ratio}");
        }
        assert!((fit.white_variance_m2 - 4.0).abs() < 0.3, "{fit:?}");
    }

    #[test]
    fn fit_of_short_records_is_not_biased_by_their_mean() {
        let model = ResidualModel {
            sample_interval_s: 0.1,
            white_variance_m2: 1.0,
            components: vec![Component { time_s: 5.0, variance_m2: 4.0 }],
            longest_lag_s: 0.0,
        };
        let mut ratios = Moments::default();
        for seed in 0..200 {
            ratios.push(fitted(&model, 70.0, seed).variance_of_mean(50) / model.variance_of_mean(50));
        }
        let error = ratios.standard_deviation().unwrap() / (200.0_f64).sqrt();
        // Without the mean's term the fit gives 0.77 here.
        assert!((ratios.mean().unwrap() - 1.0).abs() < 4.0 * error + 0.05, "{ratios:?} +- {error}");
    }

    #[test]
    fn white_noise_fits_as_white() {
        let model = ResidualModel {
            sample_interval_s: 1.0,
            white_variance_m2: 9.0,
            components: vec![],
            longest_lag_s: 0.0,
        };
        let fit = fitted(&model, 20_000.0, 4);
        assert!((fit.variance() / 9.0 - 1.0).abs() < 4.0 * (2.0 / 20_000.0_f64).sqrt());
        assert!(fit.white_variance_m2 / fit.variance() > 0.97, "{fit:?}");
    }
}
