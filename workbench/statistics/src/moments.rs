//! Mean and spread in one pass.

/// Count, mean and spread of a sequence, in one pass and without cancellation.
///
/// Source: Welford, "Note on a method for calculating corrected sums of squares and products",
/// Technometrics 4 (1962) 419.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    count: u64,
    mean: f64,
    squares: f64,
}

impl Moments {
    /// Adds a value.
    #[inline]
    pub fn push(&mut self, value: f64) {
        self.count += 1;
        let from_old_mean = value - self.mean;
        self.mean += from_old_mean / self.count as f64;
        self.squares += from_old_mean * (value - self.mean);
    }

    /// Number of values.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean, in the values' unit.
    #[must_use]
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then_some(self.mean)
    }

    /// Sample variance (divided by n - 1), in the values' unit squared.
    #[must_use]
    pub fn variance(&self) -> Option<f64> {
        (self.count > 1).then(|| self.squares / (self.count - 1) as f64)
    }

    /// Square root of [`Self::variance`].
    #[must_use]
    pub fn standard_deviation(&self) -> Option<f64> {
        self.variance().map(f64::sqrt)
    }

    /// Root mean square of `value - origin`.
    #[must_use]
    pub fn rms_about(&self, origin: f64) -> Option<f64> {
        let from_origin = self.mean()? - origin;
        Some((self.squares / self.count as f64 + from_origin * from_origin).sqrt())
    }
}

impl Extend<f64> for Moments {
    fn extend<T: IntoIterator<Item = f64>>(&mut self, values: T) {
        for value in values {
            self.push(value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_two_passes(values in prop::collection::vec(-1e3..1e3_f64, 2..200), offset in -1e7..1e7_f64) {
            let mut moments = Moments::default();
            moments.extend(values.iter().map(|value| value + offset));
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
            let rms = (values.iter().map(|v| (v + 3.0).powi(2)).sum::<f64>() / n).sqrt();
            // Rounding of values near the offset: a few units in the last place of 1e7.
            let tolerance = 1e-8 * (1.0 + offset.abs() * 1e-4);
            prop_assert!((moments.mean().unwrap() - offset - mean).abs() < tolerance);
            prop_assert!((moments.variance().unwrap() - variance).abs() < tolerance * 1e4);
            prop_assert!((moments.rms_about(offset - 3.0).unwrap() - rms).abs() < tolerance * 100.0);
        }
    }

    #[test]
    fn says_nothing_of_nothing() {
        let mut moments = Moments::default();
        assert_eq!((moments.mean(), moments.variance(), moments.rms_about(0.0)), (None, None, None));
        moments.push(2.0);
        assert_eq!((moments.mean(), moments.variance()), (Some(2.0), None));
        assert_eq!(moments.rms_about(0.0), Some(2.0));
    }
}
