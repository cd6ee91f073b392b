//! The monitor of eqs 16 and 17.
//!
//! The second criterion weights the moving average by the share of its window that readings cover. By the
//! latched calibration the error was zero before launch, so the uncovered part counts as no error. A release
//! transient therefore needs as long for `untrustworthy` as one in the middle of a flight, and a step is
//! flagged after the same delay whenever it occurs. The criterion also requires that the error has been
//! beyond the alarm limit for some time: one flipped bit can be kilometres and would carry any average with
//! it.

use serde::{Deserialize, Serialize};

use crate::guard::Guard;
use crate::moving_average::{KeptAverage, MovingAverage};
use crate::output::Trust;

/// A reading covers the time since the one before it, up to this many of the sensor's intervals in captive
/// flight. With 4, a chip that loses three conversions in four still covers its window and is judged as
/// before.
const INTERVALS_COVERED: f32 = 4.0;

/// Longest time that one reading covers in its window, microseconds, given the number of readings (at least
/// one) in a calibration of `duration_s`.
#[must_use]
pub fn longest_step_us(duration_s: f32, readings: u32) -> u32 {
    // `as` saturates.
    (INTERVALS_COVERED * 1e6 * duration_s / readings.max(1) as f32) as u32
}

/// Monitors one sensor's error in free flight. Flags latch: they are never withdrawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Monitor {
    /// Square of the alarm limit: squares are compared, so that no root of a variance is needed.
    bound_m2: f32,
    average: MovingAverage,
    window_us: u32,
    /// See [`longest_step_us`].
    longest_step_us: u32,
    /// Part of the window that readings cover, microseconds, up to its last closed bin.
    covered_us: u32,
    /// Persistence: how long the error must be beyond the alarm limit before a sensor is untrustworthy,
    /// microseconds.
    persistence_us: u32,
    /// How long it has been beyond the limit, microseconds; time within the limit is subtracted.
    beyond_us: u32,
    /// When a bin was last closed.
    last_us: u64,
    trust: Trust,
}

/// State of a monitor that cannot be recovered from its alarm limit, window and sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct KeptMonitor {
    average: KeptAverage,
    covered_us: u32,
    beyond_us: u32,
    /// When a bin was last closed, before the end of the open one: three bytes instead of seven.
    closed_before_us: i64,
    trust: Trust,
}

impl Monitor {
    /// A monitor with the squared alarm limit `(multiplier * sigma)^2` in square metres, positive and finite,
    /// and a moving average over `window_us`.
    #[must_use]
    pub fn new(bound_m2: f32, window_us: u64) -> Self {
        Self {
            bound_m2,
            average: MovingAverage::new(window_us),
            window_us: u32::try_from(window_us).unwrap_or(u32::MAX),
            longest_step_us: u32::MAX,
            covered_us: 0,
            persistence_us: 0,
            beyond_us: 0,
            last_us: 0,
            trust: Trust::Trusted,
        }
    }

    /// Sets the persistence, microseconds: the time that the error must be beyond the alarm limit before a
    /// sensor is untrustworthy. It is needed because one reading that is kilometres off moves the average as
    /// far as any failure.
    #[must_use]
    pub fn with_persistence(self, persistence_us: u64) -> Self {
        Self { persistence_us: u32::try_from(persistence_us).unwrap_or(u32::MAX), ..self }
    }

    /// Starts again at `time_us` with another alarm limit, in place. A reading covers at most
    /// `longest_step_us`.
    pub fn restart(&mut self, bound_m2: f32, time_us: u64, longest_step_us: u32) {
        self.bound_m2 = bound_m2;
        self.average.restart();
        self.longest_step_us = longest_step_us;
        self.covered_us = 0;
        self.beyond_us = 0;
        self.last_us = time_us;
        self.trust = Trust::Trusted;
    }

    /// Takes the error of eq. 16 (finite, metres) and returns its moving average, metres.
    ///
    /// The sensor becomes `doubtful` when `|error|` exceeds the alarm limit. After that it becomes
    /// `untrustworthy` when `|average|`, weighted by the share of the window that readings cover, exceeds the
    /// limit and the error has been beyond it for the persistence.
    #[inline(always)]
    pub fn update(&mut self, time_us: u64, error_m: f32) -> f32 {
        if self.average.is_due(time_us) {
            self.close_part(time_us);
        }
        let average_m = self.average.add_to_open(error_m);
        let is_beyond = error_m * error_m > self.bound_m2;
        match self.trust {
            Trust::Trusted if is_beyond => self.trust = Trust::Doubtful,
            Trust::Doubtful if average_m * average_m > self.bound_m2 => self.judge(average_m),
            _ => {}
        }
        average_m
    }

    /// The unweighted average is beyond the alarm limit. The weighted one is never larger.
    #[inline(never)]
    fn judge(&mut self, average_m: f32) {
        let weighted_m = average_m * self.share_covered();
        if weighted_m * weighted_m > self.bound_m2 && self.has_persisted() {
            self.trust = Trust::Untrustworthy;
        }
    }

    /// Updates the share and the persistence for each bin of the average, not for each reading: this is
    /// accurate to one bin, and runs once in twelve ticks instead of at each. A bin is beyond the alarm limit
    /// if the mean of its readings is. One reading that is kilometres off therefore affects one bin only.
    #[inline(never)]
    fn close_part(&mut self, time_us: u64) {
        let readings = self.average.open_count();
        if readings > 0 {
            let step_us = u32::try_from(time_us.saturating_sub(self.last_us)).unwrap_or(u32::MAX);
            self.last_us = time_us;
            let longest_us = self.average.bin_us().saturating_add(self.longest_step_us);
            let new_us = step_us.min(readings.saturating_mul(self.longest_step_us)).min(longest_us);
            let still_in_us = self.covered_us.min(self.window_us.saturating_sub(step_us));
            self.covered_us = still_in_us.saturating_add(new_us).min(self.window_us);
            let mean_m = self.average.open_mean();
            self.beyond_us = if mean_m * mean_m > self.bound_m2 {
                self.beyond_us.saturating_add(new_us).min(self.persistence_us)
            } else {
                self.beyond_us.saturating_sub(new_us)
            };
        }
        self.average.close_bins(time_us);
    }

    #[inline(always)]
    fn has_persisted(&self) -> bool {
        self.beyond_us >= self.persistence_us || !Guard::FilledWindow.stands()
    }

    /// Covered share of the window, from 0 to 1, and exactly 1 for a window without a gap.
    #[inline(always)]
    fn share_covered(&self) -> f32 {
        if Guard::FilledWindow.stands() { self.covered_us as f32 / self.window_us as f32 } else { 1.0 }
    }

    /// Trust in the sensor so far.
    #[must_use]
    pub const fn trust(&self) -> Trust {
        self.trust
    }

    /// Raises a flag that was recorded elsewhere; a flag is never withdrawn.
    pub fn raise(&mut self, trust: Trust) {
        match (self.trust, trust) {
            (_, Trust::Untrustworthy) | (Trust::Trusted, Trust::Doubtful) => self.trust = trust,
            _ => {}
        }
    }

    pub(crate) fn kept(&self) -> KeptMonitor {
        KeptMonitor {
            average: self.average.kept(),
            covered_us: self.covered_us,
            beyond_us: self.beyond_us,
            closed_before_us: self.average.open_ends_us().wrapping_sub(self.last_us) as i64,
            trust: self.trust,
        }
    }

    /// Restores the stored state; alarm limit and window stay as they are.
    pub(crate) fn restore(&mut self, kept: &KeptMonitor) {
        self.average.restore(&kept.average);
        self.covered_us = kept.covered_us;
        self.beyond_us = kept.beyond_us;
        self.last_us = self.average.open_ends_us().wrapping_sub(kept.closed_before_us as u64);
        self.trust = kept.trust;
    }

    /// The squared alarm limit, square metres.
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
        // 1 m/s, alarm limit 4 m, window 2 s: doubtful after 4 s, untrustworthy about 1 s later.
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

    /// A sensor of 50 readings a second, with a window of 2 s, from 1 s on.
    fn launched() -> Monitor {
        let mut monitor = Monitor::new(0.0, 2_000_000);
        monitor.restart(81.0, 1_000_000, longest_step_us(60.0, 3_000));
        monitor
    }

    /// Flies the launched monitor at these times (seconds after launch) with an error as a function of time;
    /// returns when each flag was raised.
    fn flags(times_s: impl Iterator<Item = f64>, error_m: impl Fn(f64) -> f32) -> [Option<f64>; 2] {
        let mut monitor = launched();
        let mut flags = [None; 2];
        for time_s in times_s {
            monitor.update(1_000_000 + (time_s * 1e6).round() as u64, error_m(time_s));
            let level = match monitor.trust() {
                Trust::Doubtful => 1,
                Trust::Untrustworthy => 2,
                _ => 0,
            };
            flags[..level].iter_mut().for_each(|flag| *flag = flag.or(Some(time_s)));
        }
        flags
    }

    fn steadily() -> impl Iterator<Item = f64> {
        (1..1_000).map(|k| f64::from(k) * 0.02)
    }

    #[test]
    fn three_readings_of_a_transient_make_doubtful_only_whenever_they_come() {
        for start_s in [0.0, 0.05, 2.3] {
            let error = |time_s: f64| if (start_s..start_s + 0.06).contains(&time_s) { 20.0 } else { 0.1 };
            let [doubtful, untrustworthy] = flags(steadily(), error);
            assert!(doubtful.is_some(), "{start_s}");
            assert_eq!(untrustworthy, None, "{start_s}");
        }
        // Also after a gap of any length.
        for gap_s in [0.5, 1.0, 1.9, 2.1, 5.0] {
            let times = steadily().filter(|time_s| !(4.0..4.0 + gap_s).contains(time_s));
            let error = |time_s: f64| if (3.99..4.0 + gap_s + 0.06).contains(&time_s) { 20.0 } else { 0.1 };
            assert_eq!(flags(times, error)[1], None, "{gap_s}");
        }
    }

    #[test]
    fn a_failure_is_flagged_with_the_same_delay_at_launch_later_and_after_a_gap() {
        let step = |start_s: f64| move |time_s: f64| if time_s > start_s { 30.0_f32 } else { 0.0 };
        // 30 m in a share of 0.3 of the window reach the alarm limit of 9 m: 0.6 s, plus up to one bin
        // (0.0625 s).
        for start_s in [0.0, 0.3, 1.0, 7.0] {
            let delay_s = flags(steadily(), step(start_s))[1].unwrap() - start_s;
            assert!((0.58..=0.68).contains(&delay_s), "{start_s}: {delay_s}");
        }
        for gap_s in [0.5, 1.0, 1.9, 3.0] {
            let times = steadily().filter(|time_s| !(4.0..4.0 + gap_s).contains(time_s));
            let delay_s = flags(times, step(4.0 + gap_s))[1].unwrap() - 4.0 - gap_s;
            // A gap affects the share until as much time is covered again, and the average until it has left
            // the window: earlier, by a third at most.
            assert!((0.4..=0.68).contains(&delay_s), "{gap_s}: {delay_s}");
        }
        // A sensor that delivers only a quarter of its readings is flagged as quickly.
        let delay_s = flags((1..250).map(|k| f64::from(k) * 0.08), step(7.0))[1].unwrap() - 7.0;
        assert!((0.58..=0.72).contains(&delay_s), "{delay_s}");
    }

    #[test]
    fn a_sensor_slower_than_the_window_is_covered_by_what_it_delivers() {
        assert_eq!(longest_step_us(60.0, 0), 240_000_000);
        assert_eq!(longest_step_us(1e9, 1), u32::MAX);
        let mut slow = Monitor::new(0.0, 2_000_000);
        slow.restart(81.0, 0, longest_step_us(60.0, 15));
        slow.update(4_000_000, 20.0);
        slow.update(8_000_000, 20.0);
        assert_eq!(slow.trust(), Trust::Untrustworthy);
    }

    #[test]
    fn a_transient_of_a_second_makes_doubtful_only_however_large_and_a_failure_is_flagged_when_it_has_lasted()
    {
        let flags = |error_m: &dyn Fn(u64) -> f32| {
            let mut monitor = launched().with_persistence(1_250_000);
            let trusts: Vec<Trust> = (1..1_000)
                .map(|k| {
                    monitor.update(1_000_000 + k * 20_000, error_m(k));
                    monitor.trust()
                })
                .collect();
            trusts.iter().position(|trust| *trust == Trust::Untrustworthy).map(|k| (k + 1) as u64)
        };
        for size_m in [20.0, 1e3, 1e6] {
            for (from, to) in [(1, 2), (1, 51), (300, 301), (300, 350)] {
                let transient = |k: u64| if (from..to).contains(&k) { size_m } else { 0.5 };
                assert_eq!(flags(&transient), None, "{size_m} {from} {to}");
            }
        }
        for start in [1, 300] {
            let flagged = flags(&|k| if k >= start { 30.0 } else { 0.5 }).unwrap();
            assert!((62..=63).contains(&(flagged - start)), "{start} {flagged}");
        }
        // 2 m/s: beyond the alarm limit from 4.5 s on, the average from 5.5 s on.
        let flagged = flags(&|k| k as f32 * 0.04).unwrap();
        assert!((275..=290).contains(&flagged), "{flagged}");
    }

    #[test]
    fn both_signs_count_and_the_bound_itself_is_within() {
        assert_eq!(fly(&mut Monitor::new(16.0, 2_000_000), [4.0, -4.0].into_iter())[1], Trust::Trusted);
        assert_eq!(fly(&mut Monitor::new(16.0, 2_000_000), [-4.01].into_iter())[0], Trust::Doubtful);
    }
}
