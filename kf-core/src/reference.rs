//! The reference receiver: which fixes are measurements, and the altitude between them.

use serde::{Deserialize, Serialize};

use crate::config::ReferenceConfig;
use crate::input::GpsFix;
use crate::output::Rejection;
use crate::plausible;
use crate::reading::is_held;
use crate::time::seconds_between;

/// A fix that is a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AcceptedFix {
    /// Altitude, metres; free of the reference's constant effects once [`ReferenceTracker::correct`] has
    /// removed them.
    pub altitude_m: f32,
    /// Seconds since the last one; `None` for the first, and for the first after a loss.
    pub interval_s: Option<f32>,
    /// Altitude minus the climb rate's integral since the first fix, metres: its drift is the receiver's own
    /// (code altitude against Doppler). `None` without a climb rate.
    pub altitude_minus_climb_m: Option<f32>,
}

/// Tracks the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceTracker {
    lost_after_us: u64,
    carries_climb: bool,
    last: Option<(u64, GpsFix)>,
    /// Correction subtracted from the last fix's altitude, metres.
    correction_m: f32,
    /// Integral of the climb rate since the first fix, metres.
    climbed_m: f32,
    /// Fixes in a row that repeat every bit of altitude and velocity.
    repeats: u8,
    /// Usual time between two fixes, microseconds; 0 before the second. Not kept over a restart: the next two
    /// fixes give it again.
    #[serde(skip)]
    usual_us: u64,
    /// The flight computer was interrupted since the last fix, and its clock does not show for how long.
    #[serde(skip)]
    is_interrupted: bool,
}

/// Shortest time for which a climb rate carries the altitude forward, microseconds. An aircraft that begins
/// to fall, or pulls 2 g, is then 2 m from the prediction, a fix's own error. A slower receiver gets one and
/// a half times its usual interval.
const CARRIED_US: u64 = 640_000;

/// If the receiver's clock and the flight computer's clock differ by more than this over the time between two
/// fixes (microseconds), a clock has leapt and the receiver's time is used. A late fix is late by less. After
/// a restart the receiver's time is always used: nothing on board measures how long the supply was off, and a
/// climb meanwhile must not look like a receiver that contradicts itself.
const CLOCK_LEAP_US: u64 = CARRIED_US / 2;

/// After this many repeats the receiver is stuck: a fix has its altitude in millimetres and three velocities
/// in mm/s, with noise of many times that in all of them.
const MOST_REPEATS: u8 = 5;

/// Whether a later fix repeats altitude and velocity. Without velocities this cannot be decided: an altitude
/// in whole metres legitimately repeats.
fn repeats(fix: &GpsFix, last: &GpsFix) -> bool {
    let velocity =
        |fix: &GpsFix| Some([fix.velocity_north_mps?, fix.velocity_east_mps?, fix.velocity_down_mps?]);
    velocity(fix).is_some_and(|now| velocity(last) == Some(now)) && fix.altitude_m == last.altitude_m
}

impl ReferenceTracker {
    /// A tracker without a fix. With a climb rate in the configuration the altitude is carried forward
    /// between fixes; without one (as in the paper), the last fix is used unchanged.
    #[must_use]
    pub fn new(config: &ReferenceConfig) -> Self {
        Self {
            lost_after_us: crate::time::microseconds(config.lost_after_s),
            carries_climb: config.climb_rate.is_some(),
            last: None,
            correction_m: 0.0,
            climbed_m: 0.0,
            repeats: 0,
            usual_us: 0,
            is_interrupted: false,
        }
    }

    /// Marks a restart: the receiver's clock measures its length better than the flight computer's, whatever
    /// the difference.
    pub(crate) const fn interrupt(&mut self) {
        self.is_interrupted = true;
    }

    /// Whether a fix is a measurement at all.
    ///
    /// # Errors
    /// [`Rejection::NotFinite`] or [`Rejection::Implausible`] if any of its numbers is, [`Rejection::Held`]
    /// if it is the last fix again, [`Rejection::Stuck`] if it is a later one and the receiver has repeated
    /// itself for some fixes.
    #[inline]
    pub fn check(&self, fix: &GpsFix) -> Result<(), Rejection> {
        if let Some(rejection) = plausible::fix(fix) {
            return Err(rejection);
        }
        let Some((_, last)) = &self.last else { return Ok(()) };
        if is_held(fix, last) {
            Err(Rejection::Held)
        } else if self.repeats >= MOST_REPEATS && repeats(fix, last) {
            Err(Rejection::Stuck)
        } else {
            Ok(())
        }
    }

    /// Takes a fix.
    ///
    /// # Errors
    /// As [`Self::check`].
    #[inline]
    pub fn take(&mut self, time_us: u64, fix: &GpsFix) -> Result<AcceptedFix, Rejection> {
        self.check(fix)?;
        Ok(self.accept(time_us, fix))
    }

    /// Takes a fix that passed [`Self::check`].
    #[inline]
    pub(crate) fn accept(&mut self, time_us: u64, fix: &GpsFix) -> AcceptedFix {
        let fresh = self.is_fresh(time_us);
        let mut interval_s = None;
        if let Some((_, last)) = &self.last {
            let interval_us = self.interval_us(time_us, fix);
            let seconds = seconds_between(0, interval_us);
            if let (Some(before), Some(now)) = (last.velocity_down_mps, fix.velocity_down_mps) {
                self.climbed_m -= 0.5 * (before + now) * seconds;
            }
            interval_s = fresh.then_some(seconds);
            // A single gap does not change the usual interval unless it persists.
            let longest_us = if self.usual_us == 0 { u64::MAX } else { self.usual_us.saturating_mul(2) };
            self.usual_us = interval_us.min(longest_us);
            self.repeats = if repeats(fix, last) { self.repeats.saturating_add(1) } else { 0 };
        }
        self.last = Some((time_us, *fix));
        self.is_interrupted = false;
        self.correction_m = 0.0;
        let altitude_minus_climb_m = fix.velocity_down_mps.map(|_| fix.altitude_m - self.climbed_m);
        AcceptedFix { altitude_m: fix.altitude_m, interval_s, altitude_minus_climb_m }
    }

    /// Time from the last fix to this one, microseconds; see [`CLOCK_LEAP_US`].
    fn interval_us(&self, time_us: u64, fix: &GpsFix) -> u64 {
        let Some((last_us, last)) = &self.last else { return 0 };
        let own_us = time_us.saturating_sub(*last_us);
        let receivers_us = match (last.fix_time_us, fix.fix_time_us) {
            (Some(before_us), Some(now_us)) if now_us > before_us => now_us - before_us,
            _ => return own_us,
        };
        // A receiver's clock that leaps itself, at a start or at the week's end, is not used either.
        let has_leapt = self.is_interrupted || own_us.abs_diff(receivers_us) > CLOCK_LEAP_US;
        if has_leapt && receivers_us <= self.lost_after_us { receivers_us } else { own_us }
    }

    /// Subtracts the reference's constant effects, metres, from the fix that was just accepted.
    pub fn correct(&mut self, accepted: AcceptedFix, effects_m: f32) -> AcceptedFix {
        self.correction_m = effects_m;
        AcceptedFix {
            altitude_m: accepted.altitude_m - effects_m,
            altitude_minus_climb_m: accepted
                .altitude_minus_climb_m
                .map(|difference_m| difference_m - effects_m),
            ..accepted
        }
    }

    /// Moves the last fix's altitude, metres.
    pub(crate) fn shift(&mut self, by_m: f32) {
        if let Some((_, fix)) = &mut self.last {
            fix.altitude_m += by_m;
        }
    }

    /// Whether the last fix is recent enough to be compared with.
    #[must_use]
    #[inline]
    pub fn is_fresh(&self, time_us: u64) -> bool {
        self.last.as_ref().is_some_and(|(last_us, _)| time_us.saturating_sub(*last_us) <= self.lost_after_us)
    }

    /// Whether the altitude is still based on a recent fix: the climb rate that carries it is not too old.
    #[must_use]
    #[inline]
    pub fn is_current(&self, time_us: u64) -> bool {
        let age_us = time_us.saturating_sub(self.last_fix_us());
        !self.carries_climb
            || age_us <= CARRIED_US
            || age_us <= self.usual_us.saturating_add(self.usual_us / 2)
    }

    /// See [`AcceptedFix::altitude_minus_climb_m`]; for the last fix, if a climb rate carries the altitude.
    #[must_use]
    pub(crate) fn altitude_minus_climb_m(&self) -> Option<f32> {
        let (_, fix) = self.last.as_ref().filter(|_| self.carries_climb)?;
        fix.velocity_down_mps.map(|_| fix.altitude_m - self.correction_m - self.climbed_m)
    }

    /// Correction subtracted from the last fix's altitude, metres.
    #[must_use]
    pub fn correction_m(&self) -> f32 {
        self.correction_m
    }

    /// Time of the last fix, microseconds; 0 without one.
    #[must_use]
    pub fn last_fix_us(&self) -> u64 {
        self.last.as_ref().map_or(0, |(last_us, _)| *last_us)
    }

    /// The last fix.
    #[must_use]
    pub fn last_fix(&self) -> Option<&GpsFix> {
        self.last.as_ref().map(|(_, fix)| fix)
    }

    /// Climb rate of the last fix, m/s, up positive.
    #[must_use]
    #[inline]
    pub fn climb_rate_mps(&self) -> Option<f32> {
        self.last.as_ref().and_then(|(_, fix)| fix.velocity_down_mps).map(|down| -down)
    }

    /// Altitude of the reference now, metres; `None` when it is lost.
    ///
    /// This is eq. 16's `y_GPS`: the last fix, carried forward by its climb rate if one is configured.
    #[must_use]
    #[inline]
    pub fn altitude_m(&self, time_us: u64) -> Option<f32> {
        let (last_us, fix) = self.last.as_ref()?;
        let age_us = time_us.saturating_sub(*last_us);
        let altitude_m = fix.altitude_m - self.correction_m;
        if age_us > self.lost_after_us {
            return None;
        }
        if age_us == 0 || !self.carries_climb {
            return Some(altitude_m);
        }
        Some(altitude_m + self.climbed_m(time_us))
    }

    /// Climb since the last fix by its climb rate, metres; zero if no climb rate carries the altitude.
    #[must_use]
    #[inline]
    pub fn climbed_m(&self, time_us: u64) -> f32 {
        match &self.last {
            Some((last_us, _)) if self.carries_climb => {
                self.climb_rate_mps().unwrap_or(0.0) * seconds_between(*last_us, time_us)
            }
            _ => 0.0,
        }
    }

    /// Climb rate of the last fix, m/s, up positive, if it carries the altitude.
    #[must_use]
    pub fn carrying_rate_mps(&self) -> Option<f32> {
        self.climb_rate_mps().filter(|_| self.carries_climb)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::ClimbRate;

    fn config(climb: bool) -> ReferenceConfig {
        ReferenceConfig {
            sigma_m: 2.0,
            correlation_time_s: 60.0,
            prior_altitude_m: None,
            prior_sigma_m: 10.0,
            climb_rate: climb.then_some(ClimbRate { sigma_mps: 0.1, correlation_time_s: 5.0 }),
            lost_after_s: 2.0,
        }
    }

    fn fix(altitude_m: f32, down: f32) -> GpsFix {
        GpsFix { altitude_m, velocity_down_mps: Some(down), ..GpsFix::default() }
    }

    #[test]
    fn the_altitude_is_carried_by_the_climb_rate_only_where_configured() {
        for (climb, expected) in [(true, 105.0), (false, 100.0)] {
            let mut tracker = ReferenceTracker::new(&config(climb));
            assert_eq!(tracker.altitude_m(0), None);
            tracker.take(1_000_000, &fix(100.0, -10.0)).unwrap();
            assert_eq!(tracker.altitude_m(1_500_000), Some(expected));
            assert_eq!(tracker.altitude_m(3_000_001), None);
        }
    }

    #[test]
    fn a_receiver_that_repeats_itself_is_stuck_until_it_moves() {
        let at = |k: u64, altitude_m, has_velocity: bool| GpsFix {
            altitude_m,
            velocity_north_mps: has_velocity.then_some(60.0),
            velocity_east_mps: has_velocity.then_some(1.0),
            velocity_down_mps: has_velocity.then_some(0.5),
            fix_time_us: Some(k * 200_000),
            ..GpsFix::default()
        };
        let mut tracker = ReferenceTracker::new(&config(true));
        let outcome: Vec<_> =
            (0..10).map(|k| tracker.take(k * 200_000, &at(k, 100.0, true)).is_ok()).collect();
        assert_eq!(outcome, [true, true, true, true, true, true, false, false, false, false]);
        assert_eq!(tracker.take(2_000_000, &at(10, 100.0, true)), Err(Rejection::Stuck));
        assert!(tracker.take(2_200_000, &at(11, 100.001, true)).is_ok());
        assert!(tracker.take(2_400_000, &at(12, 100.001, true)).is_ok());
        // A log with altitudes in whole metres and without velocities.
        let mut tracker = ReferenceTracker::new(&config(true));
        assert!((0..60).all(|k| tracker.take(k * 200_000, &at(k, 100.0, false)).is_ok()));
    }

    #[test]
    fn a_held_fix_is_one_measurement_and_grows_old() {
        let mut tracker = ReferenceTracker::new(&config(true));
        assert_eq!(tracker.take(0, &fix(100.0, -1.0)).unwrap().interval_s, None);
        for k in 1..=10 {
            assert_eq!(tracker.take(k * 200_000, &fix(100.0, -1.0)), Err(Rejection::Held));
        }
        assert!(tracker.is_fresh(2_000_000) && !tracker.is_fresh(2_000_001));
        // The first fix after a loss has no interval: it has the weight of a first fix.
        assert_eq!(tracker.take(2_500_000, &fix(101.0, -1.0)).unwrap().interval_s, None);
        let next = tracker.take(2_700_000, &fix(101.2, -1.0)).unwrap();
        assert!((next.interval_s.unwrap() - 0.2).abs() < 1e-6);
        // 2.7 s were climbed at 1 m/s.
        assert!((next.altitude_minus_climb_m.unwrap() - 98.5).abs() < 1e-4);
    }

    /// A climb rate carries the altitude for [`CARRIED_US`]; that of a slow receiver for one and a half times
    /// its usual interval.
    #[test]
    fn a_fix_is_current_until_the_next_is_overdue() {
        for (interval_us, current_us) in [(200_000, CARRIED_US), (1_000_000, 1_500_000)] {
            let mut tracker = ReferenceTracker::new(&config(true));
            for k in 0..3u8 {
                tracker.take(u64::from(k) * interval_us, &fix(100.0 + f32::from(k), -1.0)).unwrap();
            }
            let last_us = 2 * interval_us;
            assert!(tracker.is_current(last_us + current_us), "{interval_us}");
            assert!(!tracker.is_current(last_us + current_us + 1), "{interval_us}");
        }
    }

    /// A clock that leaps to the end of its range makes the usual interval as long.
    #[test]
    fn an_interval_as_long_as_time_overflows_nothing() {
        let mut tracker = ReferenceTracker::new(&config(true));
        tracker.take(0, &fix(100.0, -1.0)).unwrap();
        tracker.take(u64::MAX - 2 * CARRIED_US, &fix(101.0, -1.0)).unwrap();
        assert!(tracker.is_current(u64::MAX));
    }

    /// After a restart the interval is the receiver's, however little the two clocks differ; otherwise a late
    /// fix is just late.
    #[test]
    fn after_a_restart_the_receivers_clock_says_how_long_it_was() {
        for (is_restarted, interval_s) in [(false, 0.2), (true, 0.35)] {
            let mut tracker = ReferenceTracker::new(&config(true));
            let at =
                |altitude_m, fix_time_us| GpsFix { fix_time_us: Some(fix_time_us), ..fix(altitude_m, -20.0) };
            tracker.take(1_000_000, &at(100.0, 5_000_000)).unwrap();
            if is_restarted {
                tracker.interrupt();
            }
            let accepted = tracker.take(1_200_000, &at(107.0, 5_350_000)).unwrap();
            assert!((accepted.interval_s.unwrap() - interval_s).abs() < 1e-6, "{is_restarted}");
            let left_m = accepted.altitude_minus_climb_m.unwrap() - 100.0;
            assert!((left_m - (7.0 - 20.0 * interval_s)).abs() < 1e-3, "{is_restarted}: {left_m}");
            let next = tracker.take(1_400_000, &at(111.0, 5_560_000)).unwrap();
            assert!((next.interval_s.unwrap() - 0.2).abs() < 1e-6, "{is_restarted}");
        }
    }

    #[test]
    fn a_fix_is_corrected_and_its_holding_still_known() {
        let mut tracker = ReferenceTracker::new(&config(true));
        let accepted = tracker.take(0, &fix(100.0, -10.0)).unwrap();
        let corrected = tracker.correct(accepted, 3.0);
        assert_eq!((corrected.altitude_m, corrected.altitude_minus_climb_m), (97.0, Some(97.0)));
        assert_eq!(tracker.altitude_m(500_000), Some(102.0));
        assert_eq!(tracker.take(500_000, &fix(100.0, -10.0)), Err(Rejection::Held));
        assert_eq!(tracker.altitude_m(500_000), Some(102.0));
        tracker.take(600_000, &fix(104.0, -10.0)).unwrap();
        assert_eq!(tracker.altitude_m(600_000), Some(104.0));
    }

    #[test]
    fn any_number_that_is_not_finite_refuses_the_fix() {
        let mut tracker = ReferenceTracker::new(&config(true));
        assert_eq!(tracker.take(0, &fix(f32::NAN, 0.0)), Err(Rejection::NotFinite));
        assert_eq!(tracker.take(0, &fix(1.0, f32::INFINITY)), Err(Rejection::NotFinite));
        assert_eq!(tracker.last_fix(), None);
    }
}
