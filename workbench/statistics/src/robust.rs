//! Estimates the spread of values, robust to a few outliers.

/// Number of samples kept; beyond that, every second one is dropped and the stride doubles.
const CAPACITY: usize = 8_192;
/// Ratio of a normal distribution's sigma to its median absolute deviation.
const NORMAL_SIGMA_PER_MAD: f64 = 1.482_602_218_505_602;

/// Median and median absolute deviation of an evenly strided subset of a sequence.
///
/// Source: Rousseeuw and Croux, "Alternatives to the median absolute deviation", J. Am. Stat. Assoc.
/// 88 (1993) 1273 (its section 1 for the factor 1.4826).
#[derive(Clone, Debug)]
pub struct RobustSpread {
    kept: Vec<f64>,
    stride: u64,
    seen: u64,
}

impl Default for RobustSpread {
    fn default() -> Self {
        Self { kept: Vec::new(), stride: 1, seen: 0 }
    }
}

impl RobustSpread {
    /// Adds a value.
    #[inline]
    pub fn push(&mut self, value: f64) {
        if self.seen.is_multiple_of(self.stride) {
            if self.kept.len() == CAPACITY {
                self.thin_out();
                if !self.seen.is_multiple_of(self.stride) {
                    self.seen += 1;
                    return;
                }
            }
            self.kept.push(value);
        }
        self.seen += 1;
    }

    fn thin_out(&mut self) {
        let mut index = 0_usize;
        self.kept.retain(|_| {
            index += 1;
            !index.is_multiple_of(2)
        });
        self.stride *= 2;
    }

    /// Median.
    #[must_use]
    pub fn median(&self) -> Option<f64> {
        median(&mut self.kept.clone())
    }

    /// Median absolute deviation times 1.4826: the standard deviation for normal values.
    #[must_use]
    pub fn sigma(&self) -> Option<f64> {
        let centre = self.median()?;
        let mut deviations: Vec<f64> = self.kept.iter().map(|value| (value - centre).abs()).collect();
        Some(median(&mut deviations)? * NORMAL_SIGMA_PER_MAD)
    }
}

/// Upper median; reorders `values`.
fn median(values: &mut [f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual_model::tests::first_order;

    #[test]
    fn sigma_of_normal_values_with_and_without_outliers() {
        for outliers in [false, true] {
            let mut spread = RobustSpread::default();
            for (index, value) in first_order(0.0, 50_000, 5).into_iter().enumerate() {
                // 10 % outliers of one sign change a MAD by at most 15 %, a standard deviation by 3,000 %.
                let outlier = outliers && index % 10 == 3;
                spread.push(3.0 + if outlier { 100.0 } else { 2.0 * value });
            }
            let sigma = spread.sigma().unwrap();
            // 6,250 values kept; the MAD's efficiency is 37 %, so its standard error is 1.5 %.
            let bound = if outliers { 0.17 + 4.0 * 0.015 } else { 4.0 * 0.015 };
            assert!((sigma / 2.0 - 1.0).abs() < bound, "{sigma}");
            assert!((spread.median().unwrap() - 3.0).abs() < if outliers { 0.4 } else { 4.0 * 0.032 });
        }
    }

    #[test]
    fn keeps_an_even_stride_in_bounded_memory() {
        let mut spread = RobustSpread::default();
        for value in 0..100_000 {
            spread.push(f64::from(value));
        }
        assert!(spread.kept.len() <= CAPACITY);
        let stride = spread.kept[1] - spread.kept[0];
        assert!(spread.kept.windows(2).all(|pair| pair[1] - pair[0] == stride));
    }
}
