//! The shapes of a delay: how a late altitude follows from the climb rate.
//!
//! A tube with a volume at its end, or a receiver that filters, is a low pass, `y + tau y' = x`. Then
//! `y = x - tau LP(x')`, exactly, with the same low pass LP. A bus, or a computer, is a pure delay d:
//! `y = x - d M(x')`, exactly, with M the mean of the last d seconds. In both the coefficient is the delay in
//! seconds, and the shape states it too: a fit whose coefficient disagrees with its shape is neither. A low
//! pass of 4 s with a coefficient of 2.9 s fits the fast part of one of 2.4 s, and is 20 % wrong. Without the
//! shapes, a delay's misfit at sharp turns of the path is attributed to whatever effect happens to look like
//! it.

use std::collections::VecDeque;

/// How a delayed altitude follows from the climb rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum DelayShape {
    /// As in the catalogue: by the climb rate itself, which is right where it changes slowly.
    #[default]
    Slope,
    /// A low pass with this time constant, seconds. With a pure delay before it, it is late by more.
    LowPass(f32),
    /// A pure delay of this many seconds.
    Pure(f32),
}

/// The shapes that are tried, the catalogue's first. Those of long delays are a factor of 1.4 apart.
pub const SHAPES: [DelayShape; 14] = [
    DelayShape::Slope,
    DelayShape::LowPass(0.5),
    DelayShape::LowPass(1.0),
    DelayShape::LowPass(1.4),
    DelayShape::LowPass(2.0),
    DelayShape::LowPass(2.8),
    DelayShape::LowPass(4.0),
    DelayShape::LowPass(5.6),
    DelayShape::Pure(1.0),
    DelayShape::Pure(1.4),
    DelayShape::Pure(2.0),
    DelayShape::Pure(2.8),
    DelayShape::Pure(4.0),
    DelayShape::Pure(5.6),
];

/// A coefficient agrees with its shape within half a step of the grid, a factor of 1.2: beyond that, the next
/// shape is nearer.
pub(super) const AGREES: f64 = 1.2;

impl DelayShape {
    /// The delays that agree with this shape, seconds.
    #[must_use]
    pub fn delays_s(self) -> [f64; 2] {
        match self {
            Self::Slope => [f64::NEG_INFINITY, f64::INFINITY],
            Self::LowPass(time_s) => [f64::from(time_s) / AGREES, f64::INFINITY],
            Self::Pure(delay_s) => [f64::from(delay_s) / AGREES, AGREES * f64::from(delay_s)],
        }
    }

    /// The share of a noise's variance that remains, where the noise is independent between blocks of this
    /// many seconds.
    #[must_use]
    pub fn passes(self, block_s: f64) -> f64 {
        match self {
            Self::Slope => 1.0,
            // A first-order low pass averages over twice its time constant.
            Self::LowPass(time_s) => block_s / (block_s + 2.0 * f64::from(time_s)),
            Self::Pure(delay_s) => block_s / (block_s + f64::from(delay_s)),
        }
    }
}

/// The longest pure delay, microseconds.
const LONGEST_US: u64 = 5_600_000;

/// The climb rate in every shape.
#[derive(Clone, Copy, Debug)]
pub struct DelayedClimb([f64; SHAPES.len()]);

impl DelayedClimb {
    /// The climb rate in this shape, m/s; `None` for one that is not tried.
    #[must_use]
    pub fn mps(&self, shape: DelayShape) -> Option<f64> {
        let at = SHAPES.iter().position(|other| *other == shape)?;
        self.0.get(at).copied()
    }
}

/// Follows the climb rate.
#[derive(Clone, Debug, Default)]
pub struct DelayFilter {
    /// The last seconds: time, microseconds; climb since the first sample, metres; climb rate, m/s.
    past: VecDeque<(u64, f64, f64)>,
    low_passed_mps: [f64; SHAPES.len()],
}

impl DelayFilter {
    /// Adds the climb rate (m/s) at a time (microseconds), between which and the last one it is assumed to be
    /// linear, and returns it in every shape. A time that is not later than the last one is not added.
    pub fn take(&mut self, time_us: u64, climb_mps: f64) -> DelayedClimb {
        match self.past.back().copied() {
            None => {
                self.low_passed_mps = [climb_mps; SHAPES.len()];
                self.past.push_back((time_us, 0.0, climb_mps));
            }
            Some((last_us, climbed_m, before_mps)) if time_us > last_us => {
                let elapsed_s = (time_us - last_us) as f64 * 1e-6;
                let slope = (climb_mps - before_mps) / elapsed_s;
                for (low_passed, shape) in self.low_passed_mps.iter_mut().zip(SHAPES) {
                    let DelayShape::LowPass(time_s) = shape else { continue };
                    let time_s = f64::from(time_s);
                    // After a low pass a ramp is late by the time constant; the earlier error decays.
                    let keep = libm::exp(-elapsed_s / time_s);
                    *low_passed =
                        climb_mps - slope * time_s + keep * (*low_passed - before_mps + slope * time_s);
                }
                let climbed_m = climbed_m + 0.5 * elapsed_s * (before_mps + climb_mps);
                self.past.push_back((time_us, climbed_m, climb_mps));
                // One sample older than the longest delay is kept.
                while self.past.get(1).is_some_and(|(at, ..)| time_us - at >= LONGEST_US) {
                    self.past.pop_front();
                }
            }
            Some(_) => {}
        }
        let mut by_shape = [climb_mps; SHAPES.len()];
        for ((value, shape), low_passed) in by_shape.iter_mut().zip(SHAPES).zip(self.low_passed_mps) {
            *value = match shape {
                DelayShape::Slope => climb_mps,
                DelayShape::LowPass(_) => low_passed,
                DelayShape::Pure(delay_s) => self.mean_mps(f64::from(delay_s)).unwrap_or(climb_mps),
            };
        }
        DelayedClimb(by_shape)
    }

    /// Mean climb rate of the last seconds, m/s. Before the first sample the climb rate was the first one.
    fn mean_mps(&self, seconds: f64) -> Option<f64> {
        let (now_us, now_m, _) = *self.past.back()?;
        let since_us = |at_us: u64| (now_us - at_us) as f64;
        let wanted_us = seconds * 1e6;
        let after = self.past.partition_point(|(at, ..)| since_us(*at) > wanted_us);
        let (after_us, after_m, after_mps) = *self.past.get(after)?;
        let (at_us, at_m, at_mps) = after
            .checked_sub(1)
            .and_then(|before| self.past.get(before))
            .copied()
            .unwrap_or((after_us, after_m, after_mps));
        // Linear between the two samples, and constant before the first.
        let into_s = (since_us(at_us) - wanted_us) * 1e-6;
        let step_s = (after_us - at_us) as f64 * 1e-6;
        let slope = if step_s > 0.0 { (after_mps - at_mps) / step_s } else { 0.0 };
        let then_m = at_m + at_mps * into_s + 0.5 * slope * into_s * into_s;
        Some((now_m - then_m) / seconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp and a sine, of which a low pass and a delay are known in closed form once the start is
    /// forgotten: the late altitude follows from the climb rate in that shape.
    #[test]
    fn each_shape_makes_its_late_altitude() {
        let rate = 0.7_f64;
        let altitude_m = |t: f64| 3.0 * t + (rate * t).sin();
        let mut filter = DelayFilter::default();
        for k in 0..11_000_u32 {
            let t = f64::from(k) * 0.01;
            let climb = filter.take((t * 1e6).round() as u64, 3.0 + rate * (rate * t).cos());
            for shape in SHAPES {
                let (seconds, late_m) = match shape {
                    DelayShape::Slope => continue,
                    DelayShape::LowPass(tau) => {
                        let tau = f64::from(tau);
                        let gain = 1.0 / (1.0 + (rate * tau).powi(2));
                        let wave = gain * ((rate * t).sin() - rate * tau * (rate * t).cos());
                        (tau, 3.0 * (t - tau) + wave)
                    }
                    DelayShape::Pure(delay) => (f64::from(delay), altitude_m(t - f64::from(delay))),
                };
                let made = altitude_m(t) - seconds * climb.mps(shape).unwrap();
                if t > 100.0 {
                    assert!((made - late_m).abs() < 1e-4, "{shape:?} at {t}: {made} {late_m}");
                }
            }
        }
    }

    /// At the start, after a gap, and for a repeated time, the climb rate stays within what was measured.
    #[test]
    fn a_start_a_gap_and_a_repeated_time_are_no_jump() {
        let mut filter = DelayFilter::default();
        for (seconds, climb_mps) in [(0.0, 2.0), (0.1, 2.0), (0.1, 9.0), (40.0, 4.0), (40.1, 4.0)] {
            let climb = filter.take((seconds * 1e6) as u64, climb_mps);
            for shape in SHAPES.into_iter().filter(|shape| *shape != DelayShape::Slope) {
                let mps = climb.mps(shape).unwrap();
                assert!(mps > 2.0 - 1e-9 && mps < 4.0 + 1e-9, "{shape:?} at {seconds}: {mps}");
            }
        }
    }

    /// A shape that is not tried has no climb rate.
    #[test]
    fn only_what_is_tried_is_known() {
        let climb = DelayFilter::default().take(0, 1.0);
        assert_eq!(climb.mps(DelayShape::LowPass(0.375)), None);
        assert_eq!(climb.mps(DelayShape::Slope), Some(1.0));
    }
}
