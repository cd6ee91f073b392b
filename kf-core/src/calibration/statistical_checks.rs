//! Judges the statistics of a held calibration, one part at a time: all of them in one tick would take a
//! third of it.

use super::{Calibration, square};
use crate::block_statistics::{BlockStatistics, Trend};
use crate::config::MissionConfig;
use crate::gauss_markov::drift_variance_factor;
use crate::quality::{Check, FailedChecks};
use crate::reference::ReferenceTracker;
use crate::sensor::{SENSORS, Sensor};

/// A drift counts beyond this many of its standard errors.
const SIGNIFICANT_SIGMAS: f32 = 3.0;

/// The checks that are still to be made. Their calibration takes no more data meanwhile.
#[derive(Clone, Debug)]
pub(crate) struct StatisticalChecks {
    /// Sensors whose trends are known.
    trends: heapless::Vec<Option<Trend>, SENSORS>,
    /// Duration of the calibration, seconds.
    duration_s: f32,
    /// The quality that the receiver reported when the calibration was held was sufficient.
    reported: bool,
    stationary: bool,
}

impl StatisticalChecks {
    /// The checks made here.
    const CHECKS: [Check; 5] = [
        Check::TrimmedAltitude,
        Check::TrimmedAirspeed,
        Check::ReferenceConverged,
        Check::BiasesStationary,
        Check::InnovationsPlausible,
    ];

    /// Checks of a calibration that is held now, after `duration_s`. Nothing is checked yet, so all are noted
    /// as failed: a caller that has to continue without the outcome, as after a restart, must not take the
    /// calibration for a good one.
    pub(crate) fn begin<const E: usize>(
        config: &MissionConfig<E>,
        duration_s: f32,
        tracker: &ReferenceTracker,
        failed: &mut FailedChecks,
    ) -> Self {
        for check in Self::CHECKS {
            failed.note(check, false);
        }
        let reported = tracker.last_fix().is_none_or(|fix| config.quality.accepts(fix));
        Self { trends: heapless::Vec::new(), duration_s, reported, stationary: true }
    }

    /// Makes one more part of the checks and settles what is known by then; true when that was the last.
    #[inline(never)]
    pub(crate) fn evaluate_next<const HEAD: usize, const TAIL: usize, const E: usize>(
        &mut self,
        config: &MissionConfig<E>,
        calibration: &Calibration<HEAD, TAIL, E>,
        failed: &mut FailedChecks,
    ) -> bool {
        let next = Sensor::ALL.get(self.trends.len());
        if let Some(residuals) = next.and_then(|sensor| calibration.residuals.get(sensor.index())) {
            self.check_trend(config, residuals);
        }
        let is_done = self.trends.is_full();
        if is_done {
            failed.settle(Check::BiasesStationary, self.stationary);
            self.check_reference(config, calibration, failed);
            calibration.check_trim(config, failed);
        }
        is_done
    }

    /// Checks the next sensor's trend.
    fn check_trend<const E: usize>(&mut self, config: &MissionConfig<E>, residuals: &BlockStatistics) {
        let trend = residuals.trend();
        if let (Some(trend), Some(summary)) = (trend, residuals.summary()) {
            // A drift that the reference's own wander causes is not blamed on the sensor.
            let wander_m2 = square(config.reference.sigma_m)
                * drift_variance_factor(self.duration_s, config.reference.correlation_time_s);
            let against_wander = Trend { drift_variance: trend.drift_variance + wander_m2, ..trend };
            self.stationary &= !is_significant(&against_wander)
                || square(trend.drift) <= square(config.quality.bias_drift_sigmas) * summary.variance;
        }
        // Cannot be full: there are as many places as sensors.
        let _ = self.trends.push(trend);
    }

    fn check_reference<const HEAD: usize, const TAIL: usize, const E: usize>(
        &self,
        config: &MissionConfig<E>,
        calibration: &Calibration<HEAD, TAIL, E>,
        failed: &mut FailedChecks,
    ) {
        let limit_m = config.quality.reference_drift_m;
        let drifts_alone = calibration
            .reference_drift
            .later_trend()
            .is_some_and(|trend| is_significant(&trend) && trend.drift.abs() > limit_m);
        let converged = self.reported
            && !drifts_alone
            && !calibration.reference_level.has_jumped()
            && !drift_is_common(&self.trends, limit_m);
        failed.settle(Check::ReferenceConverged, converged);
    }
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> Calibration<HEAD, TAIL, E> {
    fn check_trim(&self, config: &MissionConfig<E>, failed: &mut FailedChecks) {
        let limits = &config.quality;
        let altitude_is_quiet = self
            .altitude
            .summary()
            .is_none_or(|summary| summary.block_variance <= square(limits.trimmed_altitude_m));
        failed.settle(Check::TrimmedAltitude, altitude_is_quiet);
        // In terms of V^2: its deviation is 2 V times the airspeed's.
        let airspeed_is_quiet = self.airspeed_squared.summary().is_none_or(|summary| {
            summary.block_variance <= 4.0 * summary.mean * square(limits.trimmed_airspeed_mps)
        });
        failed.settle(Check::TrimmedAirspeed, airspeed_is_quiet);
        failed.settle(
            Check::InnovationsPlausible,
            self.implausible as f32 <= limits.implausible_share * self.innovations as f32,
        );
    }
}

fn is_significant(trend: &Trend) -> bool {
    square(trend.drift) > square(SIGNIFICANT_SIGMAS) * trend.drift_variance
}

/// Whether at least two sensors drift against the reference, all by the same amount: that is more likely the
/// reference's drift than a coincidence of theirs.
fn drift_is_common(trends: &[Option<Trend>], limit_m: f32) -> bool {
    let mut known = trends.iter().flatten();
    let Some(first) = known.next() else { return false };
    let mut others = 0;
    for trend in known {
        others += 1;
        let apart = trend.drift - first.drift;
        let variance = trend.drift_variance + first.drift_variance;
        if !is_significant(trend)
            || trend.drift.abs() <= limit_m
            || square(apart) > square(SIGNIFICANT_SIGMAS) * variance
        {
            return false;
        }
    }
    others > 0 && is_significant(first) && first.drift.abs() > limit_m
}
