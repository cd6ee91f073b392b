//! How two columns of a table are related.

/// A straight line through pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Change of the second for one unit of the first. Both may be noisy: the ratio of their spreads, with
    /// the sign of the correlation.
    pub slope: f64,
    /// The second where the first is zero.
    pub offset: f64,
    /// Correlation of the pairs: 1 or -1 is a fit without scatter.
    pub correlation: f64,
    /// Number of pairs.
    pub count: usize,
}

/// Sigmas by which a correlation must exceed chance: the probability of 5 is 3 in 10 million.
const SIGMAS: f64 = 5.0;

impl Line {
    /// Through these pairs; `None` without spread.
    pub fn through(pairs: &[(f64, f64)]) -> Option<Self> {
        let n = pairs.len() as f64;
        let mean = |pick: fn(&(f64, f64)) -> f64| pairs.iter().map(pick).sum::<f64>() / n;
        let (mean_x, mean_y) = (mean(|pair| pair.0), mean(|pair| pair.1));
        let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
        for (x, y) in pairs {
            xx += (x - mean_x).powi(2);
            yy += (y - mean_y).powi(2);
            xy += (x - mean_x) * (y - mean_y);
        }
        if !(xx > 0.0 && yy > 0.0 && xx.is_finite() && yy.is_finite()) {
            return None;
        }
        let slope = (yy / xx).sqrt().copysign(xy);
        let correlation = xy / (xx * yy).sqrt();
        Some(Self { slope, offset: mean_y - slope * mean_x, correlation, count: pairs.len() })
    }

    /// Whether it exceeds chance and is tight enough to distinguish its slope from one twice as steep.
    pub fn is_sound(&self) -> bool {
        let sigmas =
            self.correlation.abs().min(0.999_999).atanh() * (self.count.saturating_sub(3) as f64).sqrt();
        self.correlation.abs() > 0.8 && sigmas > SIGMAS
    }
}

/// Values at the times of others: the newest value not older than `hold_s`. Both are in time order.
pub fn held(samples: &[(f64, f64)], at: &[(f64, f64)], hold_s: f64) -> Vec<(f64, f64)> {
    let mut next = 0;
    let mut pairs = Vec::new();
    for (time_s, value) in at {
        while samples.get(next).is_some_and(|sample| sample.0 <= *time_s) {
            next += 1;
        }
        let newest = next.checked_sub(1).and_then(|newest| samples.get(newest));
        if let Some((own_s, own)) = newest
            && time_s - own_s <= hold_s
        {
            pairs.push((*own, *value));
        }
    }
    pairs
}

/// Which of several factors matches a slope, within a quarter.
pub fn factor<T: Copy>(slope: f64, factors: impl IntoIterator<Item = (T, f64)>) -> Option<T> {
    let off = |factor: f64| (slope / factor).ln().abs();
    let near = factors.into_iter().filter(|(_, factor)| slope / factor > 0.0 && off(*factor) < 1.25_f64.ln());
    near.min_by(|one, other| off(one.1).total_cmp(&off(other.1))).map(|(which, _)| which)
}

/// The value below which this share of the sorted values lies; `None` without values.
pub fn quantile(values: impl IntoIterator<Item = f64>, share: f64) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    let place = ((values.len().saturating_sub(1)) as f64 * share).round() as usize;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(place, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_and_its_factor_are_found() {
        let pairs: Vec<(f64, f64)> = (0..100).map(|k| (f64::from(k), 7.0 - 3.28 * f64::from(k))).collect();
        let line = Line::through(&pairs).unwrap();
        assert!((line.slope + 3.28).abs() < 1e-9 && (line.offset - 7.0).abs() < 1e-9 && line.is_sound());
        assert_eq!(factor(line.slope, [("m", 1.0), ("ft", -3.280_84)]), Some("ft"));
        assert_eq!(factor(1.9, [("m", 1.0), ("ft", 3.280_84)]), None);
        assert_eq!(Line::through(&[]), None);
        assert_eq!(Line::through(&[(1.0, 2.0), (1.0, 3.0)]), None);
    }

    #[test]
    fn values_are_held() {
        let samples = [(0.0, 1.0), (1.0, 2.0)];
        assert_eq!(
            held(&samples, &[(-1.0, 0.0), (0.5, 5.0), (1.0, 6.0), (9.0, 7.0)], 2.0),
            [(1.0, 5.0), (2.0, 6.0)]
        );
    }
}
