//! The force on the vehicle: when it departs from its captive mean, and when it shows a fall.
//!
//! The magnitude is computed from its smoothed square by one of Heron's steps per sample. No tick takes a
//! square root, and a value that changes little between samples is followed closely.

use super::{LaunchConfig, LaunchCounts, LaunchInput, count, step_s};
use crate::atmosphere::STANDARD_GRAVITY_MPS2;

/// Time constant of the smoothing, seconds: an engine's vibration is faster, a release slower.
const SMOOTHING_S: f32 = 0.03;
/// Time constant of the captive mean, seconds: longer than a gust, shorter than a turn.
const MEAN_S: f32 = 2.0;
/// Time constant of the spread about the mean, seconds: some tens of gusts.
const SPREAD_S: f32 = 10.0;
/// Captive time needed for a mean, seconds.
const LEAST_CAPTIVE_S: f32 = 5.0;
/// A force more than half a g off the captive mean enters it only after this time, seconds. A turn lasts;
/// wild samples of a unit do not, and would hide a departure for as long as they are in the spread. Before
/// the first sample the mean is one g.
const UNLIKELY_MPS2: f32 = 4.9;
const REGIME_S: f32 = 1.0;
/// Samples further apart than this, seconds, are not smoothed together, and a fall is not assumed between
/// them.
const LONGEST_GAP_S: f32 = 0.1;
/// Keeps Heron's step from dividing by zero, m/s^2.
const LEAST_FORCE_MPS2: f32 = 0.01;
/// No unit of this class reads more, m/s^2.
const LARGEST_FORCE_MPS2: f32 = 1_000.0;

/// Which side of the captive mean the force is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Within,
    Below,
    Above,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Force {
    last_us: Option<u64>,
    /// Square of the specific force, smoothed, (m/s^2)^2.
    square: f32,
    /// Its root, m/s^2.
    magnitude: f32,
    captive_mean: f32,
    captive_variance: f32,
    captive_s: f32,
    /// How long it has been too far off the mean, seconds.
    unlikely_s: f32,
    side: Side,
    departed_us: Option<u64>,
    falling_us: Option<u64>,
}

impl Default for Force {
    fn default() -> Self {
        Self {
            last_us: None,
            square: 0.0,
            magnitude: 0.0,
            captive_mean: STANDARD_GRAVITY_MPS2,
            captive_variance: 0.0,
            captive_s: 0.0,
            unlikely_s: 0.0,
            side: Side::Within,
            departed_us: None,
            falling_us: None,
        }
    }
}

impl Force {
    /// Takes a tick's sample, if any, and returns it if it is valid. Only samples that are certainly captive
    /// enter mean and spread.
    pub(super) fn take(
        &mut self,
        input: &LaunchInput,
        is_captive: bool,
        config: &LaunchConfig,
        counts: &mut LaunchCounts,
    ) -> Option<[f32; 3]> {
        let now_us = input.time_us;
        if step_s(self.last_us, now_us).is_some_and(|gap_s| gap_s > LONGEST_GAP_S) {
            self.last_us = None;
            self.falling_us = None;
            self.side = Side::Within;
        }
        let force = input.force_mps2?;
        let is_force = force.iter().all(|part| part.abs() <= LARGEST_FORCE_MPS2);
        if !is_force || force == [0.0; 3] {
            count(&mut counts.forces_refused);
            return None;
        }
        let square: f32 = force.iter().map(|part| part * part).sum();
        let gap_s = step_s(self.last_us.replace(now_us), now_us);
        match gap_s {
            Some(gap_s) => self.square += (square - self.square) * (gap_s / (SMOOTHING_S + gap_s)),
            None => self.square = square,
        }
        // The first root starts far off: at gravity, or at the value before a gap.
        let start = if self.magnitude > 0.0 { self.magnitude } else { STANDARD_GRAVITY_MPS2 };
        let steps = if gap_s.is_some() { 1 } else { 8 };
        self.magnitude =
            (0..steps).fold(start, |root, _| 0.5 * (root + self.square / root)).max(LEAST_FORCE_MPS2);
        self.follow_fall(now_us, config);
        self.follow_departure(now_us, config);
        // A carried vehicle is not in free fall: a unit that reads one must not widen the spread.
        if let (true, Some(gap_s), None) = (is_captive, gap_s, self.falling_us) {
            let apart = self.magnitude - self.captive_mean;
            let is_unlikely = apart.abs() > UNLIKELY_MPS2;
            self.unlikely_s = if is_unlikely { self.unlikely_s + gap_s } else { 0.0 };
            if is_unlikely && self.unlikely_s < REGIME_S {
                return Some(force);
            }
            self.captive_s = (self.captive_s + gap_s).min(SPREAD_S);
            let gain = gap_s / self.captive_s.min(MEAN_S);
            self.captive_mean += gain * apart;
            let square = (1.0 - gain) * apart * apart;
            self.captive_variance += gap_s / self.captive_s * (square - self.captive_variance);
        }
        Some(force)
    }

    fn follow_fall(&mut self, now_us: u64, config: &LaunchConfig) {
        let limit = config.fall_load * STANDARD_GRAVITY_MPS2;
        if self.magnitude >= limit {
            self.falling_us = None;
        } else if self.falling_us.is_none() {
            self.falling_us = Some(now_us);
        }
    }

    fn follow_departure(&mut self, now_us: u64, config: &LaunchConfig) {
        // Soon after a start there is no mean yet: a carried vehicle has one g.
        let (mean, variance) = if self.captive_s < LEAST_CAPTIVE_S {
            (STANDARD_GRAVITY_MPS2, 0.0)
        } else {
            (self.captive_mean, self.captive_variance)
        };
        let apart = self.magnitude - mean;
        let limit = config.departure * mean;
        let sigmas = config.departure_sigmas;
        let is_rare = apart * apart > sigmas * sigmas * variance;
        let side = if is_rare && apart < -limit {
            Side::Below
        } else if is_rare && apart > limit {
            Side::Above
        } else {
            Side::Within
        };
        if side != self.side && side != Side::Within {
            self.departed_us = Some(now_us);
        }
        self.side = side;
    }

    /// When the force last left its captive mean, or crossed to its other side.
    pub(super) const fn departed_us(&self) -> Option<u64> {
        self.departed_us
    }

    /// Whether it is below its captive mean, since [`Self::departed_us`]. Unlike a near free
    /// fall, this is hardly interrupted by gusts.
    pub(super) fn is_below(&self) -> bool {
        self.side == Side::Below
    }

    /// Since when it has been near free fall without interruption.
    pub(super) const fn falling_since_us(&self) -> Option<u64> {
        self.falling_us
    }
}
