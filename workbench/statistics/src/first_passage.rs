//! How often, and how soon, a moving average of a residual exceeds a threshold.

use super::distributions::{normal_above, normal_quantile};

use super::ResidualModel;
use super::draw_set::DrawSet;

/// Number of drawn paths and their step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resolution {
    /// Number of paths.
    pub(super) paths: u64,
    /// Largest number of steps before and after an excursion.
    pub(super) largest_radius: u64,
    /// Steps in a window, when the window sets the step.
    pub(super) steps_per_window: u64,
}

impl Resolution {
    /// For reported figures: a rate to some 5 %.
    pub(super) const FINE: Self = Self { paths: 128, largest_radius: 384, steps_per_window: 96 };
    /// For a search: a rate to some 20 %, hence a threshold to 1 or 2 %.
    pub(super) const COARSE: Self = Self { paths: 32, largest_radius: 192, steps_per_window: 48 };
}

/// Fewest steps in a window, when slow components set the step.
const FEWEST_STEPS_PER_WINDOW: u64 = 8;
/// Least share of the moving average's variance for a component to determine how long excursions last.
const SIGNIFICANT_SHARE: f64 = 0.05;
/// Expected overshoot of a Gaussian random walk over a barrier, in standard deviations of a step:
/// -zeta(1/2) / sqrt(2 pi). Siegmund, "Sequential Analysis" (1985), eq. 10.21.
const OVERSHOOT: f64 = 0.582_597_157_939_010_7;
/// Seed of every draw, combined with the set's: the same residual gives the same answer.
const SEED: u64 = 0x0070_796c_6f6e;

/// Draws of a moving average around a moment at which it is beyond a threshold.
///
/// The rate of excursions of a stationary process is the share of time spent beyond the threshold
/// over the mean length of an excursion. Given that a Gaussian process is at `z` now, its path is a
/// free path plus `rho(lag) (z - free path now)`, so that excursions of any rarity can be drawn
/// directly: rate = P(beyond) E[1 / steps beyond around now | beyond now] a step.
/// Source: Aldous, "Probability Approximations via the Poisson Clumping Heuristic" (1989), section A.7.
#[derive(Clone, Debug)]
pub(super) struct Excursions {
    paths: Vec<Vec<f64>>,
    correlation: Vec<f64>,
    sigma_m: f64,
    step_s: f64,
    barrier_shift: f64,
}

impl Excursions {
    /// Draws paths of the moving average over `window` samples.
    pub(super) fn draw(
        model: &ResidualModel,
        window: u64,
        resolution: Resolution,
        draws: DrawSet,
    ) -> Option<Self> {
        Self::draw_in(model, Steps::choose(model, window, resolution), resolution.paths, draws)
    }

    fn draw_in(model: &ResidualModel, steps: Steps, count: u64, draws: DrawSet) -> Option<Self> {
        let window = steps.in_window * steps.samples;
        let covariance = |lag: u64| model.moving_average_autocovariance(window, lag * steps.samples);
        let variance = covariance(0);
        if variance <= 0.0 {
            return None;
        }
        let sigma_m = variance.sqrt();
        let correlation: Vec<f64> = (0..=steps.radius).map(|lag| covariance(lag) / variance).collect();
        let paths = (0..count)
            .map(|index| {
                let blocks = model.simulate(steps.samples, draws.seed(SEED ^ (index << 24)));
                let averages = MovingAverage::new(blocks, steps.in_window);
                averages.take(2 * steps.radius as usize + 1).map(|average| average / sigma_m).collect()
            })
            .collect();
        let fine = model.moving_average_autocovariance(window, 1) / variance;
        let barrier_shift = steps.barrier_shift(fine, covariance(1) / variance, covariance(2) / variance);
        let step_s = steps.samples as f64 * model.sample_interval_s;
        Some(Self { paths, correlation, sigma_m, step_s, barrier_shift })
    }

    /// Rate of excursions beyond `+-threshold_m`, per second.
    pub(super) fn rate_per_s(&self, threshold_m: f64) -> f64 {
        let barrier = threshold_m / self.sigma_m - self.barrier_shift;
        let beyond = normal_above(barrier);
        if beyond < f64::MIN_POSITIVE {
            return 0.0;
        }
        let centre = self.correlation.len() - 1;
        let count = self.paths.len() as f64;
        let mut inverse_lengths = 0.0;
        for (index, path) in self.paths.iter().enumerate() {
            // Evenly spaced quantiles of the tail have less variance than independent draws.
            let height = -normal_quantile(beyond * (index as f64 + 0.5) / count);
            let lift = height - path[centre];
            let above = path
                .iter()
                .enumerate()
                .filter(|(at, free)| **free + self.correlation[at.abs_diff(centre)] * lift > barrier);
            inverse_lengths += 1.0 / above.count().max(1) as f64;
        }
        2.0 * beyond * inverse_lengths / count / self.step_s
    }
}

/// Step and length of the drawn moving average.
#[derive(Clone, Copy, Debug)]
struct Steps {
    samples: u64,
    in_window: u64,
    radius: u64,
}

impl Steps {
    /// Chosen fine enough for the window and long enough for an excursion.
    fn choose(model: &ResidualModel, window: u64, resolution: Resolution) -> Self {
        let window = window.max(1);
        let slow = model.components.iter().filter(|part| {
            let alone = ResidualModel { white_variance_m2: 0.0, components: vec![**part], ..model.clone() };
            alone.variance_of_mean(window) > SIGNIFICANT_SHARE * model.variance_of_mean(window)
        });
        let slowest = slow.map(|part| part.time_s / model.sample_interval_s).fold(0.0, f64::max);
        let radius_samples = window.max((2.0 * slowest) as u64);
        let coarsest = (window / FEWEST_STEPS_PER_WINDOW).max(1);
        let samples = (window / resolution.steps_per_window)
            .max(radius_samples.div_ceil(resolution.largest_radius))
            .clamp(1, coarsest);
        let radius = radius_samples.div_ceil(samples).clamp(1, resolution.largest_radius);
        Self { samples, in_window: (window as f64 / samples as f64).round().max(1.0) as u64, radius }
    }

    /// How much lower, in sigmas, the barrier of the coarse path must be for it to be passed as often as the
    /// fine path passes the true one. The correlations are those one sample, one step and two steps apart. A
    /// rough path (increments grow with the root of time) is corrected for its overshoot; a smooth one
    /// (increments grow with time) needs no correction.
    fn barrier_shift(self, sample: f64, step: f64, two_steps: f64) -> f64 {
        let increment = |correlation: f64| (2.0 * (1.0 - correlation)).max(0.0).sqrt();
        if self.samples == 1 || increment(step) == 0.0 {
            return 0.0;
        }
        let growth = 2.0 * libm::log2(increment(two_steps) / increment(step));
        let roughness = (2.0 - growth).clamp(0.0, 1.0);
        OVERSHOOT * roughness * (increment(step) - increment(sample))
    }
}

/// Moving average of an endless series; the first average is over a full window.
struct MovingAverage<I> {
    series: I,
    window: Vec<f64>,
    oldest: usize,
    sum: f64,
}

impl<I: Iterator<Item = f64>> MovingAverage<I> {
    fn new(mut series: I, length: u64) -> Self {
        let window: Vec<f64> = series.by_ref().take(length as usize).collect();
        let sum = window.iter().sum();
        Self { series, window, oldest: 0, sum }
    }
}

impl<I: Iterator<Item = f64>> Iterator for MovingAverage<I> {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        let average = self.sum / self.window.len() as f64;
        let new = self.series.next()?;
        self.sum += new - self.window[self.oldest];
        self.window[self.oldest] = new;
        self.oldest = (self.oldest + 1) % self.window.len();
        Some(average)
    }
}

/// Times at which a moving average first exceeds a threshold, from `count` draws.
#[derive(Clone, Debug)]
pub(super) struct Passages {
    /// Times of the draws that exceeded it, seconds, in ascending order.
    pub(super) times_s: Vec<f64>,
    /// Number of draws.
    pub(super) draws: usize,
}

impl Passages {
    /// Draws healthy residuals, adds `signal` (metres, the fault's own moving average, by seconds since it
    /// began) and records when `|average| > threshold_m` for the first time.
    ///
    /// Draws whose healthy residual is already beyond the threshold when the fault begins are left out.
    pub(super) fn draw(
        model: &ResidualModel,
        window: u64,
        threshold_m: f64,
        horizon_s: f64,
        count: usize,
        draws: DrawSet,
        signal: impl Fn(f64) -> f64,
    ) -> Self {
        let steps = Steps::choose(model, window, Resolution::FINE);
        let step_s = steps.samples as f64 * model.sample_interval_s;
        let longest = (horizon_s / step_s).ceil() as usize;
        let mut times_s = Vec::new();
        let mut drawn = 0;
        for index in 0..count as u64 {
            let blocks = model.simulate(steps.samples, draws.seed(SEED ^ (index << 24) ^ 1));
            let mut averages = MovingAverage::new(blocks, steps.in_window);
            if averages.next().is_none_or(|average| average.abs() > threshold_m) {
                continue;
            }
            drawn += 1;
            let passed = averages.take(longest).enumerate().find_map(|(index, average)| {
                let after_s = (index + 1) as f64 * step_s;
                ((average + signal(after_s)).abs() > threshold_m).then_some(after_s)
            });
            times_s.extend(passed);
        }
        times_s.sort_by(f64::total_cmp);
        Self { times_s, draws: drawn }
    }

    /// The time by which this share of the draws had exceeded the threshold; `None` if fewer ever did.
    pub(super) fn quantile_s(&self, share: f64) -> Option<f64> {
        let rank = (share * self.draws as f64).ceil() as usize;
        self.times_s.get(rank.max(1) - 1).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Component, Moments};

    const MANY: Resolution = Resolution { paths: 512, ..Resolution::FINE };

    fn model(white: f64, components: &[(f64, f64)]) -> ResidualModel {
        ResidualModel {
            sample_interval_s: 0.02,
            white_variance_m2: white,
            components: components
                .iter()
                .map(|&(time_s, variance_m2)| Component { time_s, variance_m2 })
                .collect(),
            longest_lag_s: 100.0,
        }
    }

    /// Rate of excursions by direct counting: one begins when the average is beyond the threshold after
    /// `apart` samples that were not.
    fn watched_rate_per_s(
        model: &ResidualModel,
        window: u64,
        threshold_m: f64,
        apart: u64,
        samples: usize,
    ) -> (f64, f64) {
        let averages = MovingAverage::new(model.simulate(1, 99), window);
        let (mut quiet, mut excursions) = (0_u64, 0.0);
        for average in averages.take(samples) {
            if average.abs() > threshold_m {
                excursions += f64::from(u8::from(quiet >= apart));
                quiet = 0;
            } else {
                quiet += 1;
            }
        }
        let time_s = samples as f64 * model.sample_interval_s;
        (excursions / time_s, f64::sqrt(excursions) / time_s)
    }

    #[test]
    fn drawn_rates_agree_with_watched_ones() {
        for (name, model, window) in [
            ("white, rough average", model(4.0, &[]), 100),
            ("white, long window", model(4.0, &[]), 500),
            ("mixed", model(1.0, &[(0.5, 1.0)]), 100),
            ("slow", model(0.3, &[(4.0, 1.0)]), 50),
        ] {
            for sigmas in [2.0, 3.0] {
                let threshold_m = sigmas * model.variance_of_mean(window).sqrt();
                let drawn = Excursions::draw(&model, window, MANY, DrawSet::default())
                    .unwrap()
                    .rate_per_s(threshold_m);
                let (watched, error) = watched_rate_per_s(&model, window, threshold_m, 2 * window, 6_000_000);
                // The two definitions of "one excursion" differ by the few that are close together: 5 % at 3
                // sigmas, more where excursions are not rare.
                let bound = 4.0 * error + watched * if sigmas > 2.5 { 0.05 } else { 0.3 };
                assert!((drawn - watched).abs() < bound, "{name} {sigmas}: {drawn} {watched} +- {error}");
            }
        }
    }

    #[test]
    fn coarse_paths_pass_their_shifted_barrier_as_often_as_fine_ones() {
        let model = model(4.0, &[]);
        let rate = |samples: u64| {
            let steps = Steps { samples, in_window: 960 / samples, radius: 960 / samples };
            let threshold_m = 4.0 * model.variance_of_mean(960).sqrt();
            Excursions::draw_in(&model, steps, 1_024, DrawSet::default()).unwrap().rate_per_s(threshold_m)
        };
        // 1,024 draws give a rate to some 3 %. Unshifted, the coarse rate is 36 % too low.
        let ratio = rate(40) / rate(2);
        assert!((ratio - 1.0).abs() < 0.12, "{ratio}");
    }

    #[test]
    fn rare_excursions_of_a_smooth_process_follow_rice() {
        // A long average of a slow process is nearly differentiable: Rice's formula, from the exact
        // curvature of its autocovariance at the sample interval.
        let model = model(0.0, &[(2.0, 1.0)]);
        let window = 400;
        let excursions = Excursions::draw(&model, window, MANY, DrawSet::default()).unwrap();
        let variance = model.variance_of_mean(window);
        let slope = 2.0 * (variance - model.moving_average_autocovariance(window, 1)) / (0.02 * 0.02);
        for sigmas in [4.0_f64, 5.0] {
            let rice = (slope / variance).sqrt() / std::f64::consts::PI * (-0.5 * sigmas * sigmas).exp();
            let drawn = excursions.rate_per_s(sigmas * variance.sqrt());
            // Crossings cluster (the path is rough below the window's scale), so Rice is an upper bound.
            assert!(drawn < 1.05 * rice && drawn > 0.5 * rice, "{sigmas}: {drawn} {rice}");
        }
    }

    #[test]
    fn independent_samples_pass_as_often_as_their_tail_says() {
        let model = model(9.0, &[]);
        let rate = Excursions::draw(&model, 1, MANY, DrawSet::default()).unwrap().rate_per_s(3.0 * 4.0);
        let expected = 2.0 * normal_above(4.0) / 0.02;
        assert!((rate / expected - 1.0).abs() < 0.01, "{rate} {expected}");
    }

    #[test]
    fn passage_of_a_large_step_takes_its_share_of_the_window() {
        let model = model(1e-6, &[]);
        let fault = |after_s: f64| 10.0 * (after_s / 2.0).min(1.0);
        let passages = Passages::draw(&model, 100, 4.0, 10.0, 64, DrawSet::default(), fault);
        assert_eq!(passages.draws, 64);
        assert!((passages.quantile_s(0.5).unwrap() - 0.8).abs() <= 0.04, "{:?}", passages.quantile_s(0.5));
        assert_eq!(
            Passages::draw(&model, 100, 11.0, 10.0, 64, DrawSet::default(), fault).quantile_s(0.5),
            None
        );
    }

    #[test]
    fn passage_times_agree_with_a_sample_by_sample_draw() {
        let model = model(4.0, &[(0.5, 1.0)]);
        let (window, threshold_m) = (200_u64, 3.0);
        let fault = |after_s: f64| 0.5 * after_s;
        let passages = Passages::draw(&model, window, threshold_m, 60.0, 4_000, DrawSet::default(), fault);
        let mut watched = Moments::default();
        for seed in 0..4_000 {
            let averages = MovingAverage::new(model.simulate(1, 10_000 + seed), window);
            let first = averages.skip(1).enumerate().find_map(|(index, average)| {
                let after_s = (index + 1) as f64 * 0.02;
                ((average + fault(after_s)).abs() > threshold_m).then_some(after_s)
            });
            watched.push(first.unwrap());
        }
        let drawn: f64 = passages.times_s.iter().sum::<f64>() / passages.times_s.len() as f64;
        let error = watched.standard_deviation().unwrap() * (2.0_f64 / 4_000.0).sqrt();
        // Half a step of discretisation besides the draws' own error.
        assert!((drawn - watched.mean().unwrap()).abs() < 4.0 * error + 0.04, "{drawn} {watched:?}");
    }
}
