//! The monitor rules that are compared: each reduces the errors so far to one number, to which the alarm's
//! threshold applies.

/// A rule for one sensor's error, in sigmas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// The rule of the paper and of the default: the magnitude of the mean over the last two seconds. Time
    /// not yet covered counts as no error.
    MovingAverage,
    /// PX4's EKF2: the square root of the innovation's test ratio, with the gate as the threshold
    /// (`updateAidSourceStatus`).
    TestRatio,
    /// Its signed ratio after a low pass of 0.5 s, as PX4 publishes it.
    FilteredTestRatio,
    /// Two-sided CUSUM (Page 1954) with this allowance in sigmas; its threshold is in sigma seconds.
    Cusum(f64),
    /// Window-limited generalised likelihood ratio of a step of unknown size (Lorden 1971, Willsky and Jones
    /// 1976), over up to 10 s; the square root of its statistic.
    Glr,
}

impl Rule {
    /// The rules that are compared. CUSUM's allowances: half of a change of 1, 2 and 4 sigma.
    pub const ALL: [Self; 7] = [
        Self::MovingAverage,
        Self::TestRatio,
        Self::FilteredTestRatio,
        Self::Cusum(0.5),
        Self::Cusum(1.0),
        Self::Cusum(2.0),
        Self::Glr,
    ];

    /// Its name in tables and the picture.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::MovingAverage => "mean over 2 s",
            Self::TestRatio => "PX4 ratio",
            Self::FilteredTestRatio => "PX4 filtered",
            Self::Cusum(allowance) if allowance < 0.75 => "CUSUM 0.5",
            Self::Cusum(allowance) if allowance < 1.5 => "CUSUM 1",
            Self::Cusum(_) => "CUSUM 2",
            Self::Glr => "GLR",
        }
    }

    /// The statistic after each of the errors, which are `interval_s` apart.
    #[must_use]
    pub fn statistic(self, errors: &[f64], interval_s: f64) -> Vec<f64> {
        match self {
            Self::MovingAverage => moving_average(errors, samples_in(2.0, interval_s)),
            Self::TestRatio => errors.iter().map(|error| error.abs()).collect(),
            Self::FilteredTestRatio => {
                let share = interval_s.min(1.0) / (interval_s.min(1.0) + 0.5);
                let mut filtered = 0.0;
                let step = |error: &f64| {
                    filtered += share * (error * error.abs() - filtered);
                    f64::abs(filtered).sqrt()
                };
                errors.iter().map(step).collect()
            }
            Self::Cusum(allowance) => {
                let (mut up, mut down) = (0.0_f64, 0.0_f64);
                let step = |error: &f64| {
                    up = (up + (error - allowance) * interval_s).max(0.0);
                    down = (down - (error + allowance) * interval_s).max(0.0);
                    up.max(down)
                };
                errors.iter().map(step).collect()
            }
            Self::Glr => glr(errors, samples_in(10.0, interval_s), interval_s),
        }
    }
}

fn samples_in(window_s: f64, interval_s: f64) -> usize {
    (window_s / interval_s).round().max(1.0) as usize
}

fn moving_average(errors: &[f64], window: usize) -> Vec<f64> {
    let mut sum = 0.0;
    (0..errors.len())
        .map(|k| {
            sum += errors[k];
            if k >= window {
                sum -= errors[k - window];
            }
            f64::abs(sum / window as f64)
        })
        .collect()
}

fn glr(errors: &[f64], longest: usize, interval_s: f64) -> Vec<f64> {
    (0..errors.len())
        .map(|k| {
            let (mut sum, mut largest) = (0.0, 0.0_f64);
            for (count, error) in errors[..=k].iter().rev().take(longest).enumerate() {
                sum += error;
                largest = largest.max(f64::abs(sum) / ((count + 1) as f64).sqrt());
            }
            largest * interval_s.sqrt()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_of_a_step_are_those_on_paper() {
        // Nothing for 4 s, then 3 sigma for 4 s, at 10 Hz.
        let errors: Vec<f64> = (0..80).map(|k| if k < 40 { 0.0 } else { 3.0 }).collect();
        let after = |rule: Rule, samples: usize| rule.statistic(&errors, 0.1)[39 + samples];
        assert!((after(Rule::MovingAverage, 10) - 1.5).abs() < 1e-9);
        assert!((after(Rule::MovingAverage, 30) - 3.0).abs() < 1e-9);
        assert_eq!(after(Rule::TestRatio, 1), 3.0);
        // 1 - (5/6)^n of 9.
        assert!(
            (after(Rule::FilteredTestRatio, 5) - 3.0 * (1.0 - (5.0_f64 / 6.0).powi(5)).sqrt()).abs() < 1e-9
        );
        assert!((after(Rule::Cusum(1.0), 10) - 2.0).abs() < 1e-9);
        assert!((after(Rule::Glr, 16) - 3.0 * 1.6_f64.sqrt()).abs() < 1e-9);
        let negative: Vec<f64> = errors.iter().map(|error| -error).collect();
        for rule in Rule::ALL {
            assert_eq!(rule.statistic(&negative, 0.1), rule.statistic(&errors, 0.1), "{rule:?}");
        }
    }
}
