//! Double integrals over hours, in f32.

use serde::{Deserialize, Serialize};

/// A sum that keeps what each addition rounds off (Kahan, "Further remarks on reducing truncation errors",
/// CACM 8(1), 1965).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Sum {
    value: f32,
    lost: f32,
}

impl Sum {
    #[inline(always)]
    fn plus(self, addend: f32) -> Self {
        let corrected = addend - self.lost;
        let value = self.value + corrected;
        Self { value, lost: (value - self.value) - corrected }
    }
}

/// A quantity integrated twice over time, starting at zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct DoubleIntegral {
    slope: Sum,
    value: Sum,
    last: Option<f32>,
}

impl DoubleIntegral {
    /// Present value of the integral.
    pub(super) const fn value(&self) -> f32 {
        self.value.value
    }

    /// Advances by `seconds` to an input of `now`; exact for an input that is a straight line in between.
    /// False, and nothing taken, where a number overflows.
    // Not inlined: six copies would be half a kilobyte of flash.
    #[inline(never)]
    pub(super) fn advance(&mut self, seconds: f32, now: f32) -> bool {
        let before = self.last.unwrap_or(now);
        let slope = self.slope.plus(0.5 * seconds * (before + now));
        let gained = seconds * (self.slope.value + seconds * (1.0 / 6.0) * (2.0 * before + now));
        self.set(slope, gained, Some(now))
    }

    /// Advances by `seconds` without input, after a jump of the first integral.
    #[inline]
    pub(super) fn kick(&mut self, seconds: f32, jump: f32) -> bool {
        let gained = seconds * self.slope.value;
        self.set(self.slope.plus(jump), gained, None)
    }

    fn set(&mut self, slope: Sum, gained: f32, last: Option<f32>) -> bool {
        let next = Self { slope, value: self.value.plus(gained), last };
        let numbers = [next.slope.value, next.slope.lost, next.value.value, next.value.lost];
        let is_finite = numbers.iter().all(|number| number.is_finite());
        if is_finite {
            *self = next;
        }
        is_finite
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_exact_for_a_straight_line() {
        let mut integral = DoubleIntegral::default();
        assert!(integral.advance(0.0, 2.0));
        for row in 1..=100 {
            assert!(integral.advance(0.25, 2.0 - 0.5 * row as f32 * 0.25));
        }
        // 25 s of 2 - t/2: t^2 - t^3/12.
        assert!((f64::from(integral.value()) - (625.0 - 15_625.0 / 12.0)).abs() < 1e-3);
    }

    #[test]
    fn hours_do_not_drift() {
        // Two hours of 1 mm/s^2 at 200 Hz: 25,920 m; the last step adds 0.036 m, of which f32 there resolves
        // 2 mm.
        let mut integral = DoubleIntegral::default();
        integral.advance(0.0, 0.001);
        for _ in 0..2 * 3600 * 200 {
            integral.advance(0.005, 0.001);
        }
        // The step itself and its products are known to three roundings, 2e-7.
        assert!((integral.value() / 25_920.0 - 1.0).abs() < 2e-7, "{}", integral.value());
    }

    #[test]
    fn a_jump_of_the_slope_is_a_ramp() {
        let mut integral = DoubleIntegral::default();
        assert!(integral.kick(5.0, 3.0) && integral.kick(2.0, -1.0) && integral.kick(2.0, 0.0));
        assert_eq!(integral.value(), 10.0);
    }

    #[test]
    fn what_overflows_is_not_taken() {
        let mut integral = DoubleIntegral::default();
        assert!(integral.advance(0.0, 1.0) && integral.advance(1.0, 1.0));
        let before = integral;
        assert!(!integral.advance(1.0, f32::MAX) || !integral.advance(1.0, f32::MAX));
        assert!(integral.value().is_finite());
        assert_eq!(before.value(), 0.5);
    }
}
