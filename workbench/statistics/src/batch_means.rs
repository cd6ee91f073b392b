//! Standard error of the mean of an autocorrelated sequence, by batch means.

use super::Moments;

/// Batches are merged in pairs at this number, so that memory does not grow with the sequence.
const CAPACITY: usize = 64;

/// Mean of an autocorrelated sequence with its standard error, in one pass and bounded memory.
///
/// The sequence is cut into 32 to 64 batches of equal length; batches much longer than the
/// correlation time have nearly independent means, whose spread gives the error of the overall mean.
/// Source: Law, "Simulation Modeling and Analysis", 5th ed., section 9.5.3.
#[derive(Clone, Debug)]
pub struct BatchMeans {
    batch_length: u64,
    sums: Vec<f64>,
    filling_sum: f64,
    filling_count: u64,
    all: Moments,
}

impl Default for BatchMeans {
    fn default() -> Self {
        Self {
            batch_length: 1,
            sums: Vec::with_capacity(CAPACITY),
            filling_sum: 0.0,
            filling_count: 0,
            all: Moments::default(),
        }
    }
}

impl BatchMeans {
    /// Adds a value.
    #[inline]
    pub fn push(&mut self, value: f64) {
        self.all.push(value);
        self.filling_sum += value;
        self.filling_count += 1;
        if self.filling_count == self.batch_length {
            self.close_batch();
        }
    }

    fn close_batch(&mut self) {
        self.sums.push(self.filling_sum);
        self.filling_sum = 0.0;
        self.filling_count = 0;
        if self.sums.len() == CAPACITY {
            self.sums = self.sums.chunks_exact(2).map(|pair| pair.iter().sum()).collect();
            self.batch_length *= 2;
        }
    }

    /// Moments of all values.
    #[must_use]
    pub fn moments(&self) -> &Moments {
        &self.all
    }

    /// Standard error of the mean, in the values' unit; `None` below 32 values.
    #[must_use]
    pub fn standard_error(&self) -> Option<f64> {
        if self.sums.len() < CAPACITY / 2 {
            return None;
        }
        let mut batches = Moments::default();
        batches.extend(self.sums.iter().map(|sum| sum / self.batch_length as f64));
        let values_in_batches = (self.sums.len() as u64 * self.batch_length) as f64;
        let share_in_batches = values_in_batches / self.all.count() as f64;
        Some((batches.variance()? / self.sums.len() as f64 * share_in_batches).sqrt())
    }

    /// Number of independent values that the mean is worth, at most their own number.
    #[must_use]
    pub fn effective_count(&self) -> Option<f64> {
        let error = self.standard_error()?;
        let count = self.all.count() as f64;
        if error > 0.0 { Some((self.all.variance()? / (error * error)).min(count)) } else { Some(count) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual_model::tests::first_order;

    #[test]
    fn standard_error_of_white_and_of_correlated_values() {
        for phi in [0.0, 0.8, 0.95] {
            let n = 40_000;
            let mut batches = BatchMeans::default();
            for value in first_order(phi, n, 11) {
                batches.push(value);
            }
            // Unit-variance AR(1): Var(mean) = (1 + phi) / (1 - phi) / n.
            let expected = ((1.0 + phi) / (1.0 - phi) / n as f64).sqrt();
            let got = batches.standard_error().unwrap();
            // 32 to 63 batches: the standard error of a standard deviation is 1 / sqrt(2 * 31) = 13 %.
            assert!((got / expected - 1.0).abs() < 4.0 * 0.127, "{phi}: {got} {expected}");
        }
    }

    #[test]
    fn mean_lies_within_its_standard_error_as_often_as_it_should() {
        let trials = 400;
        let inside = (0..trials)
            .filter(|&seed| {
                let mut batches = BatchMeans::default();
                for value in first_order(0.9, 4_000, 1_000 + seed) {
                    batches.push(value);
                }
                batches.moments().mean().unwrap().abs() < batches.standard_error().unwrap()
            })
            .count() as f64;
        // Student's t with 30-60 degrees of freedom: 67.5 % within one standard error.
        let share = 0.675;
        let sigma = (trials as f64 * share * (1.0 - share)).sqrt();
        assert!((inside - trials as f64 * share).abs() < 4.0 * sigma, "{inside} of {trials}");
    }

    #[test]
    fn too_few_values_have_no_standard_error() {
        let mut batches = BatchMeans::default();
        for value in 0..31 {
            batches.push(f64::from(value));
        }
        assert_eq!(batches.standard_error(), None);
    }
}
