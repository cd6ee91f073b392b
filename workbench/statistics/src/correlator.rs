//! Autocovariance from one sample to a quarter of the flight, in one pass and bounded memory.

use super::Moments;

/// Lags kept at each level.
const LAGS: usize = 16;
/// Values that a level collects before it processes them.
const CHUNK: usize = 256;
/// Longest lag reported, as a share of the sequence: beyond it, too few independent pairs are left.
const LONGEST_LAG_SHARE: u64 = 4;
/// The sum over autocorrelations ends at this many integrated times (Sokal's window).
const SOKAL_WINDOW: f64 = 5.0;

/// Autocovariance at lags that grow by octaves.
///
/// Level 0 sees the samples, level `l` the means of `2^l` of them; each keeps the products of its
/// last 16 values. Source: Ramirez, Sukumaran, Vorselaars, Likhtman, "Efficient on the fly
/// calculation of time correlation functions", J. Chem. Phys. 133 (2010) 154103.
#[derive(Clone, Debug, Default)]
pub struct Correlator {
    origin: Option<f64>,
    moments: Moments,
    levels: Vec<Level>,
}

/// One octave: its last `LAGS` values, followed by those not processed yet.
#[derive(Clone, Debug)]
struct Level {
    buffer: Vec<f64>,
    /// Number of leading values in the buffer that are already processed.
    done: usize,
    /// Total number of processed values.
    count: u64,
    sum: f64,
    products: [f64; LAGS],
    squares: f64,
    first: Vec<f64>,
}

impl Default for Level {
    fn default() -> Self {
        Self {
            buffer: Vec::with_capacity(LAGS + CHUNK),
            done: 0,
            count: 0,
            sum: 0.0,
            products: [0.0; LAGS],
            squares: 0.0,
            first: Vec::with_capacity(LAGS),
        }
    }
}

impl Level {
    fn work_off(&mut self) {
        for index in self.done..self.buffer.len() {
            let value = self.buffer[index];
            self.sum += value;
            self.squares += value * value;
            if self.first.len() < LAGS {
                self.first.push(value);
            }
            if index >= LAGS {
                let before = &self.buffer[index - LAGS..index];
                for (product, earlier) in self.products.iter_mut().zip(before.iter().rev()) {
                    *product += value * earlier;
                }
            } else {
                for (product, earlier) in self.products.iter_mut().zip(self.buffer[..index].iter().rev()) {
                    *product += value * earlier;
                }
            }
        }
        self.count += (self.buffer.len() - self.done) as u64;
        self.done = self.buffer.len();
    }

    fn forget_old(&mut self) {
        let keep_from = self.buffer.len().saturating_sub(LAGS);
        self.buffer.drain(..keep_from);
        self.done = self.buffer.len();
    }

    /// Sum of products of deviations from `mean` at a lag of `lag` values.
    fn centred(&self, lag: usize, mean: f64) -> f64 {
        if lag == 0 {
            return self.squares - 2.0 * mean * self.sum + self.count as f64 * mean * mean;
        }
        let head: f64 = self.first[..lag].iter().sum();
        let tail: f64 = self.buffer[self.buffer.len() - lag..].iter().sum();
        let pairs = self.count as f64 - lag as f64;
        self.products[lag - 1] - mean * (2.0 * self.sum - head - tail) + pairs * mean * mean
    }
}

/// Autocovariance at one lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag {
    /// The lag, in samples.
    pub samples: u64,
    /// Covariance, in the values' unit squared.
    pub covariance: f64,
}

/// Autocovariance of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct Autocovariance {
    moments: Moments,
    lags: Vec<Lag>,
    leading: Vec<f64>,
}

impl Correlator {
    /// Adds a finite value.
    #[inline]
    pub fn push(&mut self, value: f64) {
        let value = value - *self.origin.get_or_insert(value);
        self.moments.push(value);
        if self.levels.is_empty() {
            self.levels.push(Level::default());
        }
        self.levels[0].buffer.push(value);
        if self.levels[0].buffer.len() == LAGS + CHUNK {
            self.work_off(0);
        }
    }

    /// Processes a full level and passes the means of its pairs to the next.
    fn work_off(&mut self, index: usize) {
        let level = &mut self.levels[index];
        let first_new = level.done;
        level.work_off();
        // Chunks have an even length and start at an even index, so no pair is split between two.
        let means: Vec<f64> =
            level.buffer[first_new..].chunks_exact(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        level.forget_old();
        if self.levels.len() == index + 1 {
            self.levels.push(Level::default());
        }
        for mean in means {
            self.levels[index + 1].buffer.push(mean);
            if self.levels[index + 1].buffer.len() == LAGS + CHUNK {
                self.work_off(index + 1);
            }
        }
    }

    /// The autocovariance so far; `None` below 32 values or when they are all equal.
    #[must_use]
    pub fn autocovariance(&self) -> Option<Autocovariance> {
        let mut finished = self.clone();
        let mut index = 0;
        while index < finished.levels.len() {
            if finished.levels[index].buffer.len() > finished.levels[index].done {
                let grows =
                    finished.levels[index].count + finished.levels[index].buffer.len() as u64 > LAGS as u64;
                if grows {
                    finished.work_off(index);
                } else {
                    finished.levels[index].work_off();
                }
            }
            index += 1;
        }
        finished.read_off()
    }

    fn read_off(&self) -> Option<Autocovariance> {
        let count = self.moments.count();
        let mean = self.moments.mean()?;
        let variance = self.moments.rms_about(mean)?.powi(2);
        if count < 2 * LAGS as u64 || variance <= 0.0 {
            return None;
        }
        let mut lags = vec![Lag { samples: 0, covariance: variance }];
        let mut leading = Vec::new();
        for (octave, level) in self.levels.iter().enumerate() {
            let shortest = if octave == 0 { 1 } else { LAGS / 2 + 1 };
            for lag in shortest..=LAGS {
                let samples = (lag as u64) << octave;
                if level.count <= lag as u64 || level.first.len() < lag || level.buffer.len() < lag {
                    break;
                }
                let sum = level.centred(lag, mean);
                if octave == 0 {
                    leading.push(sum / (count as f64 * variance));
                }
                if samples > count / LONGEST_LAG_SHARE {
                    break;
                }
                lags.push(Lag { samples, covariance: sum / (level.count as f64 - lag as f64) });
            }
        }
        Some(Autocovariance { moments: self.moments, lags, leading })
    }
}

impl Autocovariance {
    /// Number of values in the sequence.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.moments.count()
    }

    /// Lag 0 and then growing lags, up to a quarter of the sequence. Beyond 16 samples each is averaged over
    /// neighbouring lags, an eighth of the lag or less in either direction.
    #[must_use]
    pub fn lags(&self) -> &[Lag] {
        &self.lags
    }

    /// Autocorrelations at lags 1 to 16, by the estimator that divides by n (Brockwell and Davis,
    /// "Time Series: Theory and Methods", 2nd ed., eq. 7.2.1).
    #[must_use]
    pub fn leading_autocorrelations(&self) -> &[f64] {
        &self.leading
    }

    /// Integrated autocorrelation time `1 + 2 sum of rho(k)`, in samples: the number of values that
    /// are worth one independent value.
    ///
    /// The sum ends at five times itself: Sokal, "Monte Carlo methods in statistical mechanics"
    /// (1996), section 3.
    #[must_use]
    pub fn integrated_time(&self) -> f64 {
        let variance = self.lags[0].covariance;
        let mut time = 1.0;
        for pair in self.lags.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let width = (to.samples - from.samples) as f64;
            // Trapezia between distant lags; the first lags are summed one by one.
            time += if to.samples <= LAGS as u64 {
                2.0 * to.covariance / variance
            } else {
                // The sum over (from, to] is the trapezium's area less half its first end plus half its last.
                (width * (from.covariance + to.covariance) + (to.covariance - from.covariance)) / variance
            };
            if to.samples as f64 >= SOKAL_WINDOW * time {
                break;
            }
        }
        time.max(1.0 / self.count() as f64)
    }

    /// Number of independent values that the sequence is worth, at most its own number.
    #[must_use]
    pub fn effective_count(&self) -> f64 {
        (self.count() as f64 / self.integrated_time()).min(self.count() as f64)
    }

    /// Standard error of the mean, in the values' unit.
    #[must_use]
    pub fn standard_error_of_mean(&self) -> f64 {
        (self.lags[0].covariance / self.effective_count()).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual_model::tests::first_order;
    use proptest::prelude::*;

    fn correlate(values: &[f64]) -> Correlator {
        let mut correlator = Correlator::default();
        values.iter().for_each(|&value| correlator.push(value));
        correlator
    }

    /// The definition, at one lag.
    fn naive(values: &[f64], lag: usize) -> f64 {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let pairs = values.len() - lag;
        (lag..values.len()).map(|i| (values[i] - mean) * (values[i - lag] - mean)).sum::<f64>() / pairs as f64
    }

    proptest! {
        #[test]
        fn first_lags_are_the_definition(values in prop::collection::vec(-10.0..10.0_f64, 64..900), offset in -1e4..1e4_f64) {
            let shifted: Vec<f64> = values.iter().map(|value| value + offset).collect();
            let autocovariance = correlate(&shifted).autocovariance().unwrap();
            for lag in autocovariance.lags().iter().filter(|lag| lag.samples <= LAGS as u64) {
                let expected = naive(&shifted, lag.samples as usize);
                prop_assert!((lag.covariance - expected).abs() < 1e-8, "{lag:?} {expected}");
            }
        }
    }

    #[test]
    fn long_lags_follow_the_theory() {
        let phi = 0.99_f64;
        let n = 400_000;
        let autocovariance = correlate(&first_order(phi, n, 21)).autocovariance().unwrap();
        // Bartlett: the error of rho(k) is at most sqrt((1 + phi^2) / (1 - phi^2) / n).
        let sigma = ((1.0 + phi * phi) / (1.0 - phi * phi) / n as f64).sqrt();
        let longest = autocovariance.lags().last().unwrap().samples;
        assert!(longest > n as u64 / 8 && longest <= n as u64 / 4, "{longest}");
        for lag in autocovariance.lags() {
            let expected = phi.powf(lag.samples as f64);
            assert!((lag.covariance - expected).abs() < 5.0 * sigma + 0.002, "{lag:?} {expected}");
        }
    }

    #[test]
    fn integrated_time_of_a_first_order_process() {
        for (phi, n) in [(0.0_f64, 200_000), (0.5, 200_000), (0.9, 400_000), (0.98, 4_000_000)] {
            let expected = (1.0 + phi) / (1.0 - phi);
            let got = correlate(&first_order(phi, n, 31)).autocovariance().unwrap().integrated_time();
            // Sokal eq. 3.19: relative variance 2 (2 M + 1) / n with M = 5 times, and e^-5 cut off
            // (in units of half the integrated time: e^-10).
            let sigma = expected * (2.0 * (2.0 * SOKAL_WINDOW * expected + 1.0) / n as f64).sqrt();
            assert!(
                (got - expected).abs() < 4.0 * sigma + 0.005 * expected,
                "{phi}: {got} {expected} +- {sigma}"
            );
        }
    }

    #[test]
    fn standard_error_covers_the_spread_of_means() {
        let (phi, n, trials) = (0.9, 3_000, 300);
        let mut means = Moments::default();
        let mut claimed = Moments::default();
        for seed in 0..trials {
            let values = first_order(phi, n, 500 + seed);
            means.push(values.iter().sum::<f64>() / n as f64);
            claimed.push(correlate(&values).autocovariance().unwrap().standard_error_of_mean());
        }
        let spread = means.standard_deviation().unwrap();
        let ratio = claimed.mean().unwrap() / spread;
        // The spread of 300 means is known to 1 / sqrt(600) = 4.1 %; the window cuts off a little.
        assert!((ratio - 1.0).abs() < 4.0 * 0.041, "{ratio}");
    }

    #[test]
    fn alternating_values_are_worth_more_than_independent_ones() {
        let values: Vec<f64> =
            first_order(0.0, 10_001, 9).windows(2).map(|pair| pair[1] - 0.9 * pair[0]).collect();
        let autocovariance = correlate(&values).autocovariance().unwrap();
        assert!(autocovariance.integrated_time() < 0.3);
        assert!((autocovariance.effective_count() - 10_000.0).abs() < 1e-9);
    }

    #[test]
    fn refuses_what_has_no_autocovariance() {
        assert_eq!(correlate(&[1.0; 100]).autocovariance(), None);
        assert_eq!(correlate(&first_order(0.0, 31, 1)).autocovariance(), None);
        assert_eq!(Correlator::default().autocovariance(), None);
    }
}
