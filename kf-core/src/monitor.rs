//! The monitor of eqs 16 and 17.

use serde::{Deserialize, Serialize};

use crate::moving_average::MovingAverage;
use crate::output::Trust;

/// Watches one sensor's error in free flight. Flags latch: doubt is not taken back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Monitor {
    /// Square of the bound: squares are compared, so that a variance needs no root.
    bound_m2: f32,
    average: MovingAverage,
    trust: Trust,
}

impl Monitor {
    /// A monitor with the squared bound `(multiplier * sigma)^2` in square metres, positive and
    /// finite, and a moving average over `window_us`.
    #[must_use]
    pub fn new(bound_m2: f32, window_us: u64) -> Self {
        Self { bound_m2, average: MovingAverage::new(window_us), trust: Trust::Trusted }
    }

    /// Begins anew with another bound, where it is.
    pub fn restart(&mut self, bound_m2: f32) {
        self.bound_m2 = bound_m2;
        self.average.restart();
        self.trust = Trust::Trusted;
    }

    /// Takes the error of eq. 16 (finite, metres) and returns its moving average, metres.
    ///
    /// `doubtful` once `|error|` exceeds the bound; `untrustworthy` once, after that, `|average|` does.
    #[inline(always)]
    pub fn update(&mut self, time_us: u64, error_m: f32) -> f32 {
        let average_m = self.average.add(time_us, error_m);
        match self.trust {
            Trust::Trusted if error_m * error_m > self.bound_m2 => self.trust = Trust::Doubtful,
            Trust::Doubtful if average_m * average_m > self.bound_m2 => self.trust = Trust::Untrustworthy,
            _ => {}
        }
        average_m
    }

    /// What the sensor is worth so far.
    #[must_use]
    pub const fn trust(&self) -> Trust {
        self.trust
    }

    /// Raises a flag that is known from elsewhere; none is ever taken back.
    pub fn raise(&mut self, trust: Trust) {
        match (self.trust, trust) {
            (_, Trust::Untrustworthy) | (Trust::Trusted, Trust::Doubtful) => self.trust = trust,
            _ => {}
        }
    }

    /// The squared bound, square metres.
    #[must_use]
    pub const fn bound_m2(&self) -> f32 {
        self.bound_m2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fly(monitor: &mut Monitor, errors: impl Iterator<Item = f32>) -> Vec<Trust> {
        errors
            .enumerate()
            .map(|(k, error)| {
                monitor.update(k as u64 * 5_000, error);
                monitor.trust()
            })
            .collect()
    }

    #[test]
    fn a_ramp_is_doubtful_at_the_bound_and_untrustworthy_half_a_window_later() {
        // 1 m/s, bound 4 m, window 2 s: doubtful after 4 s, untrustworthy about 1 s later.
        let trusts = fly(&mut Monitor::new(16.0, 2_000_000), (0..2_000).map(|k| k as f32 * 0.005));
        let first = |trust| trusts.iter().position(|t| *t == trust).unwrap() as f32 * 0.005;
        assert!((first(Trust::Doubtful) - 4.005).abs() < 0.003, "{}", first(Trust::Doubtful));
        let after = first(Trust::Untrustworthy) - first(Trust::Doubtful);
        assert!((0.96..=1.01).contains(&after), "{after}");
    }

    #[test]
    fn a_spike_makes_doubtful_only_and_doubt_stays() {
        let errors = (0..1_000).map(|k| if k == 100 { 50.0 } else { 0.0 });
        let trusts = fly(&mut Monitor::new(16.0, 2_000_000), errors);
        assert_eq!(trusts[99], Trust::Trusted);
        assert!(trusts[100..].iter().all(|t| *t == Trust::Doubtful));
    }

    #[test]
    fn both_signs_count_and_the_bound_itself_is_within() {
        assert_eq!(fly(&mut Monitor::new(16.0, 2_000_000), [4.0, -4.0].into_iter())[1], Trust::Trusted);
        assert_eq!(fly(&mut Monitor::new(16.0, 2_000_000), [-4.01].into_iter())[0], Trust::Doubtful);
    }
}
