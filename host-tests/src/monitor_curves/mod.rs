//! Rules for a monitor as curves: false alarms an hour against the delay to faults, on the same residuals.
//!
//! Every rule is a statistic and a threshold; varying the threshold traces a curve. A healthy launch alarms
//! at the first statistic beyond it, so the rate is the number of alarms over the hours until them.

use residuals::Launch;
use rules::Rule;

pub mod page;
pub mod residuals;
pub mod rules;

/// Onset of the fault, seconds after launch.
const ONSET_S: f64 = 30.0;

/// A fault of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// A drift, metres a second.
    Drift(f64),
    /// A step, in the sigmas that the monitor has latched.
    Step(f64),
}

impl Fault {
    /// The faults that are tested.
    pub const ALL: [Self; 6] = [
        Self::Drift(0.5),
        Self::Drift(1.0),
        Self::Drift(2.0),
        Self::Step(3.0),
        Self::Step(5.0),
        Self::Step(10.0),
    ];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Drift(rate_mps) => format!("{rate_mps} m/s"),
            Self::Step(sigmas) => format!("{sigmas} sigma"),
        }
    }

    fn error(self, after_s: f64, sigma_m: f64) -> f64 {
        match self {
            Self::Drift(rate_mps) => rate_mps * after_s / sigma_m,
            Self::Step(sigmas) => sigmas,
        }
    }
}

/// The records of a statistic: each time that it exceeded all values before.
type Records = Vec<(f64, f64)>;

/// Performance of a rule on one kind of residual.
#[derive(Clone, Debug)]
pub struct Curve {
    healthy: Vec<(Records, f64)>,
    /// For each fault and each launch: the largest statistic before the fault, and the records since, by the
    /// time since.
    faulty: Vec<Vec<(f64, Records)>>,
}

impl Curve {
    /// Applies the rule to the launches, and to `faulty` of them again with each fault.
    #[must_use]
    pub fn draw(rule: Rule, launches: &[Launch], faulty: usize) -> Self {
        let healthy = launches.iter().map(|launch| {
            let errors: Vec<f64> = launch.errors_m.iter().map(|x| x / launch.sigma_m).collect();
            let statistic = rule.statistic(&errors, launch.interval_s);
            let length_s = statistic.len() as f64 * launch.interval_s;
            (records(&statistic, 0.0, launch.interval_s), length_s)
        });
        // Evenly spaced among them, because real launches are ordered by log.
        let every = launches.len().div_ceil(faulty.max(1)).max(1);
        let with = |fault: Fault| {
            let of = |launch: &Launch| {
                let onset = (ONSET_S / launch.interval_s) as usize;
                let error = |(k, x): (usize, &f64)| {
                    let after_s = (k as f64 - onset as f64) * launch.interval_s;
                    x / launch.sigma_m
                        + if after_s >= 0.0 { fault.error(after_s, launch.sigma_m) } else { 0.0 }
                };
                let errors: Vec<f64> = launch.errors_m.iter().enumerate().map(error).collect();
                let statistic = rule.statistic(&errors, launch.interval_s);
                let (before, since) = statistic.split_at(onset.min(statistic.len()));
                let largest = before.iter().copied().fold(0.0, f64::max);
                (largest, records(since, 0.0, launch.interval_s))
            };
            launches.iter().step_by(every).map(of).collect()
        };
        Self { healthy: healthy.collect(), faulty: Fault::ALL.map(with).into() }
    }

    /// False alarms an hour with that threshold.
    #[must_use]
    pub fn false_alarms_per_hour(&self, threshold: f64) -> f64 {
        let (mut alarms, mut seconds) = (0.0, 0.0);
        for (records, length_s) in &self.healthy {
            match passage(records, threshold) {
                Some(time_s) => (alarms, seconds) = (alarms + 1.0, seconds + time_s),
                None => seconds += length_s,
            }
        }
        3_600.0 * alarms / f64::max(seconds, 1e-9)
    }

    /// The smallest threshold with at most that many false alarms an hour.
    #[must_use]
    pub fn threshold(&self, false_alarms_per_hour: f64) -> f64 {
        let largest = |(records, _): &(Records, f64)| records.last().map_or(0.0, |(_, value)| *value);
        let (mut low, mut high) = (0.0, self.healthy.iter().map(largest).fold(0.0, f64::max));
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if self.false_alarms_per_hour(middle) > false_alarms_per_hour {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }

    /// Hours of healthy flight.
    #[must_use]
    pub fn hours(&self) -> f64 {
        self.healthy.iter().map(|(_, length_s)| length_s).sum::<f64>() / 3_600.0
    }

    /// Median delay to a fault, seconds, over those launches that had not alarmed before it; infinite if
    /// fewer than half are ever detected.
    #[must_use]
    pub fn delay_s(&self, fault: usize, threshold: f64) -> f64 {
        let quiet = self.faulty[fault].iter().filter(|(before, _)| *before <= threshold);
        let mut delays: Vec<f64> =
            quiet.map(|(_, since)| passage(since, threshold).unwrap_or(f64::INFINITY)).collect();
        delays.sort_by(f64::total_cmp);
        delays.get(delays.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

fn records(statistic: &[f64], start_s: f64, interval_s: f64) -> Records {
    let mut largest = 0.0;
    let mut records = Vec::new();
    for (k, value) in statistic.iter().enumerate() {
        if *value > largest {
            largest = *value;
            records.push((start_s + (k + 1) as f64 * interval_s, *value));
        }
    }
    records
}

fn passage(records: &Records, threshold: f64) -> Option<f64> {
    records.get(records.partition_point(|(_, value)| *value <= threshold)).map(|(time_s, _)| *time_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use residuals::{Made, made};

    #[test]
    fn a_curve_on_white_noise_is_the_normal_distributions() {
        let curve = Curve::draw(Rule::TestRatio, &made(Made::White, 400, 3), 100);
        // One reading in 500 is beyond 3.09 sigma, at five readings a second: 36 an hour. 600 alarms
        // determine that to 4 %, and the calibrations' spread of sigma and bias adds some.
        let rate = curve.false_alarms_per_hour(3.090);
        assert!((rate / 36.0 - 1.0).abs() < 0.25, "{rate}");
        let threshold = curve.threshold(36.0);
        assert!((threshold - 3.09).abs() < 0.1, "{threshold}");
        // At 5 sigma, 97 % of the readings are beyond 3 sigma; at 2 m/s that takes until about 6 m.
        assert!(curve.delay_s(4, 3.0) <= 0.41);
        assert!((2.0..3.2).contains(&curve.delay_s(2, 3.0)), "{}", curve.delay_s(2, 3.0));
    }
}
