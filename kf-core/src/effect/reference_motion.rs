//! Height, climb rate and speed over ground, from the reference's fixes.

use serde::{Deserialize, Serialize};

use crate::input::GpsFix;
use crate::time::{elapsed_s, seconds_between};

/// Time constant of the climb rate's filter, seconds. The filter lags a manoeuvre by at most two of these;
/// with five fixes a second and 0.4 m of white noise its output has 0.25 m/s of noise.
const FILTER_TIME_S: f32 = 0.5;
/// Gap after which the filter restarts, seconds.
const GAP_S: f32 = 10.0;
/// Longest time that a fix is carried on by its climb rate, seconds.
const CARRIED_S: f32 = 2.0;

/// Motion derived from the fixes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ReferenceMotion {
    last: Option<(u64, f32)>,
    climb_rate_mps: Option<f32>,
    /// Filtered altitude (m) and its rate (m/s), for fixes without a rate.
    filter: Option<(f32, Option<f32>)>,
    velocity_mps: Option<[f32; 2]>,
    speed_squared_m2ps2: Option<f32>,
}

impl ReferenceMotion {
    /// Takes the velocity of an accepted fix.
    #[inline]
    pub(super) fn take_velocity(&mut self, fix: &GpsFix) {
        if let (Some(north), Some(east)) = (fix.velocity_north_mps, fix.velocity_east_mps) {
            let down = fix.velocity_down_mps.unwrap_or(0.0);
            self.velocity_mps = Some([north, east]);
            self.speed_squared_m2ps2 = Some(north * north + east * east + down * down);
        }
    }

    /// Takes altitude and climb rate of an accepted fix.
    pub(super) fn take_height(&mut self, time_us: u64, fix: &GpsFix) {
        let interval_s = self.last.map(|(last_us, _)| seconds_between(last_us, time_us));
        match fix.velocity_down_mps {
            Some(down_mps) => {
                self.climb_rate_mps = Some(-down_mps);
                self.filter = None;
            }
            None => self.filter_altitude(interval_s, fix.altitude_m),
        }
        self.last = Some((time_us, fix.altitude_m));
    }

    /// The critically damped g-h filter, `g = 1 - theta^2`, `h = (1 - theta)^2` with `theta` the decay over
    /// one interval (Brookner, "Tracking and Kalman Filtering Made Easy", 1998, section 1.2.6).
    fn filter_altitude(&mut self, interval_s: Option<f32>, altitude_m: f32) {
        let next = match (self.filter, interval_s) {
            (Some((filtered_m, rate_mps)), Some(seconds)) if seconds > 0.0 && seconds <= GAP_S => {
                match rate_mps {
                    None => (altitude_m, Some((altitude_m - filtered_m) / seconds)),
                    Some(rate_mps) => {
                        let theta = libm::expf(-seconds / FILTER_TIME_S);
                        let predicted_m = filtered_m + rate_mps * seconds;
                        let surprise_m = altitude_m - predicted_m;
                        let gain = 1.0 - theta;
                        (
                            predicted_m + (1.0 - theta * theta) * surprise_m,
                            Some(rate_mps + gain * gain / seconds * surprise_m),
                        )
                    }
                }
            }
            _ => (altitude_m, None),
        };
        // Altitudes can be finite but absurd.
        let next =
            if next.0.is_finite() && next.1.is_none_or(f32::is_finite) { next } else { (altitude_m, None) };
        self.filter = Some(next);
        self.climb_rate_mps = next.1.or(self.climb_rate_mps);
    }

    /// Climb rate, m/s, up positive: the last fix's own, or filtered from the fixes' altitudes.
    pub(super) const fn climb_rate_mps(&self) -> Option<f32> {
        self.climb_rate_mps
    }

    /// Square of the speed over ground, climb included, (m/s)^2.
    pub(super) const fn speed_squared_m2ps2(&self) -> Option<f32> {
        self.speed_squared_m2ps2
    }

    /// North and east velocity, m/s.
    pub(super) const fn velocity_mps(&self) -> Option<[f32; 2]> {
        self.velocity_mps
    }

    /// Present altitude: the last fix, carried on by the climb rate, metres.
    pub(super) fn altitude_m(&self, time_us: u64) -> Option<f32> {
        let (last_us, altitude_m) = self.last?;
        let age_s = elapsed_s(last_us, time_us).min(CARRIED_S);
        Some(altitude_m + self.climb_rate_mps.unwrap_or(0.0) * age_s)
    }

    /// Horizontal speed at the last fix, m/s; `None` without a velocity. Two steps of Heron's rule, because
    /// no tick takes a square root.
    pub(super) fn horizontal_speed_mps(&self) -> Option<f32> {
        let [north, east] = self.velocity_mps?;
        let (larger, smaller) = match (north.abs(), east.abs()) {
            (n, e) if n >= e => (n, e),
            (n, e) => (e, n),
        };
        if larger <= f32::MIN_POSITIVE {
            return Some(0.0);
        }
        // Alpha max plus beta min with 0.96 and 0.4 is within 4 %, which two steps reduce to 4e-7; scaled, so
        // that nothing overflows.
        let ratio = smaller / larger;
        let square = 1.0 + ratio * ratio;
        let mut root = 0.96 + 0.4 * ratio;
        for _ in 0..2 {
            root = 0.5 * (root + square / root);
        }
        Some(larger * root)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fix(altitude_m: f32) -> GpsFix {
        GpsFix { altitude_m, ..GpsFix::default() }
    }

    #[test]
    fn a_receivers_own_climb_rate_goes_first() {
        let mut motion = ReferenceMotion::default();
        assert_eq!((motion.climb_rate_mps(), motion.altitude_m(0)), (None, None));
        motion.take_height(1_000_000, &GpsFix { velocity_down_mps: Some(3.0), ..fix(100.0) });
        assert_eq!(motion.climb_rate_mps(), Some(-3.0));
        assert_eq!(motion.altitude_m(1_500_000), Some(98.5));
        assert_eq!(motion.altitude_m(900_000_000), Some(94.0));
    }

    #[test]
    fn a_ramp_is_followed_without_error_and_a_gap_starts_anew() {
        let mut motion = ReferenceMotion::default();
        motion.take_height(0, &fix(50.0));
        assert_eq!(motion.climb_rate_mps(), None);
        for k in 1..=60_u16 {
            motion.take_height(u64::from(k) * 500_000, &fix(50.0 + 2.0 * f32::from(k)));
        }
        assert!((motion.climb_rate_mps().unwrap() - 4.0).abs() < 1e-4);
        motion.take_height(200_000_000, &fix(0.0));
        assert!((motion.climb_rate_mps().unwrap() - 4.0).abs() < 1e-4);
        motion.take_height(201_000_000, &fix(-1.0));
        assert_eq!(motion.climb_rate_mps(), Some(-1.0));
    }

    #[test]
    fn noise_is_filtered_as_brookner_says() {
        // Rate variance over that of a fix: 2 (1 - theta)^3 / ((1 + theta)^3 T^2).
        let mut motion = ReferenceMotion::default();
        let (mut seed, mut sum, mut count) = (5_u32, 0.0_f64, 0.0_f64);
        for k in 0..60_000_u32 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = ((seed >> 8) as f32 / 16_777_216.0 - 0.5) * 3.464_101_6;
            motion.take_height(u64::from(k) * 200_000, &fix(noise));
            if k > 100 {
                sum += f64::from(motion.climb_rate_mps().unwrap()).powi(2);
                count += 1.0;
            }
        }
        let theta = (-0.4_f64).exp();
        let expected = 2.0 * (1.0 - theta).powi(3) / ((1.0 + theta).powi(3) * 0.04);
        // Correlated over some 10 fixes: 6,000 independent ones, sqrt(2 / 6,000) = 1.8 %.
        assert!((sum / count / expected - 1.0).abs() < 5.0 * 0.018, "{} {expected}", sum / count);
    }

    #[test]
    fn the_horizontal_speed_needs_no_root() {
        let mut motion = ReferenceMotion::default();
        assert_eq!(motion.horizontal_speed_mps(), None);
        for (north, east) in
            [(3.0, 4.0), (-60.0, 0.0), (0.0, 0.0), (1e-3, -70.0), (-45.0, 45.0), (1e30, 1e30)]
        {
            motion.take_velocity(&GpsFix {
                velocity_north_mps: Some(north),
                velocity_east_mps: Some(east),
                ..fix(0.0)
            });
            let expected = f64::from(north).hypot(f64::from(east));
            let got = f64::from(motion.horizontal_speed_mps().unwrap());
            assert!((got - expected).abs() <= 4e-7 * expected, "{got} {expected}");
        }
    }
}
