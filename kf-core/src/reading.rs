//! Readings that are not measurements: held or stuck values.

use serde::{Deserialize, Serialize};

use crate::input::GpsFix;

/// A sensor is stuck if it has repeated every bit for this long, microseconds...
const STUCK_AFTER_US: u64 = 2_000_000;
/// ... and for this many readings.
const STUCK_AFTER_READINGS: u32 = 20;

/// Detects a sensor that repeats itself.
///
/// A repeated reading is no proof: a coarse sensor in level flight legitimately repeats. It is stuck if the
/// repetition has lasted, and either the sensor is known to resolve less than half its noise (then equal
/// readings are practically impossible), or the reference has meanwhile moved by more than three sigmas of
/// both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StuckDetector {
    last: Option<f32>,
    since_us: u64,
    repeats: u32,
    reference_then_m: f32,
    finest_step_m: Option<f32>,
}

impl StuckDetector {
    /// Takes a finite reading and returns whether the sensor is stuck.
    ///
    /// `reference_m` is the reference's altitude now, if there is one; the sigmas are those of one
    /// reading and one fix, metres.
    #[inline]
    pub fn is_stuck(
        &mut self,
        time_us: u64,
        reading_m: f32,
        reference_m: Option<f32>,
        sigma_m: f32,
        reference_sigma_m: f32,
    ) -> bool {
        let step_m = self.last.map(|last| (reading_m - last).abs());
        self.last = Some(reading_m);
        if step_m != Some(0.0) {
            if let Some(step) = step_m {
                self.finest_step_m = Some(self.finest_step_m.map_or(step, |finest| finest.min(step)));
            }
            self.since_us = time_us;
            self.repeats = 0;
            self.reference_then_m = reference_m.unwrap_or(f32::NAN);
            return false;
        }
        self.repeats = self.repeats.saturating_add(1);
        if self.repeats < STUCK_AFTER_READINGS || time_us.saturating_sub(self.since_us) < STUCK_AFTER_US {
            return false;
        }
        let resolves_noise = self.finest_step_m.is_some_and(|step| step < 0.5 * sigma_m);
        // Comparison with NaN (no reference then) is false.
        let reference_moved = reference_m
            .is_some_and(|now| (now - self.reference_then_m).abs() > 3.0 * (sigma_m + reference_sigma_m));
        resolves_noise || reference_moved
    }
}

/// Whether a fix is the last one, held: the same time by the receiver's clock, or, without such a time, the
/// same bits throughout.
#[must_use]
pub fn is_held(fix: &GpsFix, last: &GpsFix) -> bool {
    match (fix.fix_time_us, last.fix_time_us) {
        (Some(time), Some(last_time)) => time == last_time,
        _ => fix == last,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Index of the first reading that is reported as stuck.
    fn first_stuck(readings: impl Iterator<Item = (f32, f32)>) -> Option<usize> {
        let mut detector = StuckDetector::default();
        readings.enumerate().position(|(k, (reading, reference))| {
            detector.is_stuck(k as u64 * 20_000, reading, Some(reference), 0.5, 2.0)
        })
    }

    #[test]
    fn a_fine_sensor_that_stops_moving_is_stuck_after_two_seconds() {
        let wiggle = |k: u16| if k < 100 { f32::from(k % 7) * 0.1 } else { 1.0 };
        assert_eq!(first_stuck((0..400).map(|k| (wiggle(k), 0.0))), Some(200));
    }

    #[test]
    fn a_coarse_sensor_in_level_flight_is_not_and_in_a_climb_is() {
        let coarse = |k: u16| if k < 10 { f32::from(k) } else { 10.0 };
        assert_eq!(first_stuck((0..2_000).map(|k| (coarse(k), 10.0))), None);
        // The reference climbs 0.1 m a reading: 7.5 m are passed 76 readings after the last step, before the
        // two seconds have passed.
        assert_eq!(first_stuck((0..2_000).map(|k| (coarse(k), f32::from(k) * 0.1))), Some(110));
    }

    #[test]
    fn a_sensor_stuck_from_the_start_needs_the_reference_to_show() {
        assert_eq!(first_stuck((0..2_000).map(|_| (5.0, 0.0))), None);
        assert!(first_stuck((0..2_000_u16).map(|k| (5.0, f32::from(k)))).is_some());
    }

    #[test]
    fn the_receivers_clock_decides_and_else_the_bits() {
        let fix = GpsFix { altitude_m: 1.0, ..GpsFix::default() };
        assert!(is_held(&fix, &fix));
        assert!(!is_held(&GpsFix { altitude_m: 1.5, ..fix }, &fix));
        let timed = GpsFix { fix_time_us: Some(7), ..fix };
        assert!(!is_held(&GpsFix { fix_time_us: Some(8), ..timed }, &timed));
        assert!(is_held(&GpsFix { altitude_m: 1.5, ..timed }, &timed));
    }
}
