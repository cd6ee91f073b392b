//! Checks without a reference whether the two sensors that fly free agree with each other.
//!
//! Eq. 16 needs the reference. While that is lost, or suspect ([`crate::free_flight`]), the difference of the
//! two calibrated altitudes is still known: each reading less its effects and its latched bias is an estimate
//! of the same altitude. A difference beyond both bounds shows that one of them is wrong, but not which.

use crate::latch::LatchRecord;
use crate::monitor::{Monitor, longest_step_us};
use crate::output::{Agreement, CrossCheckOutput, Trust};
use crate::sensor::Sensor;

/// Longest time between two readings of a pair, microseconds: at 50 m/s of climb they then differ by a metre.
const PAIR_US: u64 = 20_000;

/// The cross-check of one flight.
#[derive(Clone, Debug)]
pub(crate) struct CrossCheck {
    monitor: Monitor,
    /// Both sensors have a bound.
    is_bounded: bool,
    /// Calibrated altitudes of the inertial sensor and of the barometer, and when they were read.
    last: [Option<(u64, f32)>; 2],
}

impl CrossCheck {
    /// Without a flight; call [`Self::begin`] first.
    pub(crate) fn new(window_us: u64) -> Self {
        Self { monitor: Monitor::new(0.0, window_us), is_bounded: false, last: [None; 2] }
    }

    /// The variances of two independent sensors add. The reference's own error, which their residuals share,
    /// is in both bounds but not in the difference; that errs towards silence.
    #[inline(never)]
    pub(crate) fn begin(&mut self, latch: &LatchRecord) {
        let bound_m2 =
            |sensor: Sensor| latch.sensors.get(sensor.index()).map_or(0.0, |latched| latched.bound_m2);
        let (slave_m2, baro_m2) = (bound_m2(Sensor::ImuSlave), bound_m2(Sensor::Baro));
        let sum_m2 = slave_m2 + baro_m2;
        self.is_bounded = slave_m2 > 0.0 && baro_m2 > 0.0 && sum_m2.is_finite();
        // The number of pairs is the number of readings of the slower sensor.
        let readings =
            |sensor: Sensor| latch.sensors.get(sensor.index()).map_or(0, |latched| latched.readings);
        let pairs = readings(Sensor::ImuSlave).min(readings(Sensor::Baro));
        self.monitor.restart(sum_m2, latch.time_us, longest_step_us(latch.duration_s, pairs));
        self.last = [None; 2];
    }

    /// Takes the calibrated altitude of one sensor, metres, at a tick without a reference. Returns the result
    /// of the pair that it completes.
    pub(crate) fn take(&mut self, sensor: Sensor, time_us: u64, altitude_m: f32) -> Option<CrossCheckOutput> {
        let [slave, baro] = &mut self.last;
        let (own, other) = match sensor {
            Sensor::ImuMaster => return None,
            Sensor::ImuSlave => (slave, baro),
            Sensor::Baro => (baro, slave),
        };
        *own = Some((time_us, altitude_m));
        let (other_us, other_m) = (*other)?;
        if !self.is_bounded {
            return None;
        }
        if time_us.saturating_sub(other_us) > PAIR_US {
            return None;
        }
        let difference_m = match sensor {
            Sensor::Baro => altitude_m - other_m,
            _ => other_m - altitude_m,
        };
        if !difference_m.is_finite() {
            return None;
        }
        // The pair has been used.
        *other = None;
        let moving_average_m = self.monitor.update(time_us, difference_m);
        Some(CrossCheckOutput { difference_m, moving_average_m, agreement: agreement(self.monitor.trust()) })
    }

    /// Trust in the two sensors so far.
    pub(crate) fn trust(&self) -> Trust {
        if self.is_bounded { self.monitor.trust() } else { Trust::Unmonitored }
    }

    /// Raises a flag that is known from elsewhere.
    pub(crate) fn raise(&mut self, trust: Trust) {
        if self.is_bounded {
            self.monitor.raise(trust);
        }
    }
}

const fn agreement(trust: Trust) -> Agreement {
    match trust {
        Trust::Doubtful => Agreement::Doubtful,
        Trust::Untrustworthy => Agreement::Disagree,
        Trust::Trusted | Trust::Calibrating | Trust::Unmonitored => Agreement::Agree,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::latch::SensorLatch;

    fn check(slave_m2: f32, baro_m2: f32) -> CrossCheck {
        let sensor = |bound_m2| SensorLatch { bound_m2, readings: 3_500, ..SensorLatch::default() };
        let latch = LatchRecord {
            time_us: 0,
            duration_s: 70.0,
            failed_checks: 0,
            sensors: [sensor(0.0), sensor(slave_m2), sensor(baro_m2)],
            state: heapless::Vec::new(),
            covariance: heapless::Vec::new(),
        };
        let mut check = CrossCheck::new(2_000_000);
        check.begin(&latch);
        check
    }

    #[test]
    fn the_bound_is_both_sensors_and_the_difference_is_baro_less_inertial() {
        let mut check = check(9.0, 16.0);
        assert_eq!(check.take(Sensor::ImuSlave, 0, 100.0), None);
        let said = check.take(Sensor::Baro, 10_000, 104.9).unwrap();
        assert!((said.difference_m - 4.9).abs() < 1e-4);
        assert_eq!(said.agreement, Agreement::Agree);
        // The bound is five metres; beyond it is doubtful, and no worse while the average is within.
        assert_eq!(check.take(Sensor::Baro, 20_000, 106.0), None, "its partner has been used");
        let said = check.take(Sensor::ImuSlave, 30_000, 100.0).unwrap();
        assert_eq!((said.difference_m, said.agreement), (6.0, Agreement::Doubtful));
        // 6 m over 5/6 of the window of 2 s reach the bound.
        let disagrees_us = (2..200)
            .map(|k| k * 20_000)
            .find(|time_us| {
                check.take(Sensor::Baro, *time_us, 106.0);
                check.take(Sensor::ImuSlave, *time_us, 100.0);
                check.trust() == Trust::Untrustworthy
            })
            .unwrap();
        assert!((1_640_000..=1_740_000).contains(&disagrees_us), "{disagrees_us}");
    }

    #[test]
    fn readings_apart_or_without_a_bound_or_of_the_mother_ship_are_no_pair() {
        let mut apart = check(9.0, 16.0);
        assert_eq!(apart.take(Sensor::ImuSlave, 0, 0.0), None);
        assert_eq!(apart.take(Sensor::Baro, PAIR_US + 1, 50.0), None);
        assert_eq!(apart.take(Sensor::ImuMaster, PAIR_US + 1, 50.0), None);
        let mut unbounded = check(0.0, 16.0);
        assert_eq!(unbounded.take(Sensor::ImuSlave, 0, 0.0), None);
        assert_eq!(unbounded.take(Sensor::Baro, 0, 50.0), None);
        assert_eq!(unbounded.trust(), Trust::Unmonitored);
        let mut overflow = check(9.0, 16.0);
        overflow.take(Sensor::ImuSlave, 0, f32::MIN);
        assert_eq!(overflow.take(Sensor::Baro, 0, f32::MAX), None);
    }
}
