//! The tie to the reference: how a fix's altitude corrects the channel's altitude, climb rate and lacking
//! acceleration (upward acceleration missing from the accelerometer).
//!
//! A Kalman filter of the three errors (A. Gelb, "Applied Optimal Estimation", MIT Press 1974, section 4.2).
//! Its covariance accounts for the time since the last fix: after a gap the next one weighs more, and in a
//! burst each weighs less. Its gains are those of an observer that is stable for fixes at any times: between
//! fixes and at each of them `e' P^-1 e` of the error `e` does not grow. The covariance is stored as `U D U'`
//! (G. J. Bierman, "Factorization Methods for Discrete Sequential Estimation", Academic Press 1977, chapter
//! V), so rounding cannot make it negative.

use serde::{Deserialize, Serialize};

/// Variance of a fix's altitude times the time that the fix represents, m^2 s. A receiver's error is
/// correlated over a minute, so more frequent fixes give no more information.
const FIX_M2S: f32 = 1.0;
/// Longest time that one fix represents, s: no fix is known better than to 2 m.
const LONGEST_FIX_S: f32 = 0.25;
/// Random walk of the lacking acceleration, (m/s^2)^2/s: an accelerometer and a level that wander by 0.01
/// m/s^2 within about 100 s. Of 3e-7, 1e-6 and 2e-6 it left the smallest errors in simulations of 400 and
/// 1,500 runs (fixes of 0.4 m white and 1.5 m that wander within 60 s); a least-squares parabola over the
/// last minute left 15 % more drift and 40 % more climb rate.
const LACKING_DENSITY: f32 = 1e-6;
/// Random walk of the climb rate, (m/s)^2/s: vibration of 0.45 m/s^2 sampled 200 times a second.
const CLIMB_DENSITY: f32 = 1e-3;
/// Variances before the second fix: a climb rate of 10 m/s; the zero-g offset of a MEMS unit (0.2 m/s^2) and
/// the part of gravity lost to a tilt of 0.3 rad from a gust at the first sample (0.44 m/s^2).
const START_CLIMB_M2PS2: f32 = 100.0;
const START_LACKING_M2PS4: f32 = 0.25;
/// Variance of a fix's climb rate that replaced a contradicting one, (m/s)^2: more than an aligned channel
/// may have, so that some altitude fixes must confirm it.
const RETIED_CLIMB_M2PS2: f32 = 4.0;
/// Variance of a fix's climb rate, (m/s)^2: a receiver's Doppler is accurate to 0.1 m/s, and 0.1 s late in a
/// manoeuvre of half a g.
const FIX_CLIMB_M2PS2: f32 = 0.25;
/// A fix further off than this many sigmas, squared, is an outlier.
const GATE: f32 = 25.0;

/// Covariance of the errors of altitude (m), climb rate (m/s) and lacking acceleration (m/s^2).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Tie {
    /// U above its diagonal: altitude by climb rate (s), altitude (s^2) and climb rate (s) by acceleration.
    altitude_by_climb: f32,
    altitude_by_lacking: f32,
    climb_by_lacking: f32,
    /// D.
    altitude: f32,
    climb: f32,
    lacking: f32,
}

impl Tie {
    /// After the first fix, to which the altitude is set.
    pub(super) const START: Self = Self {
        altitude_by_climb: 0.0,
        altitude_by_lacking: 0.0,
        climb_by_lacking: 0.0,
        altitude: FIX_M2S / LONGEST_FIX_S,
        climb: START_CLIMB_M2PS2,
        lacking: START_LACKING_M2PS4,
    };

    /// After a fix to which altitude and climb rate are set; the lacking acceleration is known as before.
    pub(super) const fn retied(&self) -> Self {
        Self { climb: RETIED_CLIMB_M2PS2, lacking: self.lacking, ..Self::START }
    }

    /// Variance of the altitude, m^2.
    pub(super) fn altitude_m2(&self) -> f32 {
        self.altitude
            + self.altitude_by_climb * self.altitude_by_climb * self.climb
            + self.altitude_by_lacking * self.altitude_by_lacking * self.lacking
    }

    /// Variance of the climb rate, (m/s)^2.
    pub(super) fn climb_m2ps2(&self) -> f32 {
        self.climb + self.climb_by_lacking * self.climb_by_lacking * self.lacking
    }

    /// Variance of the lacking acceleration, (m/s^2)^2.
    pub(super) const fn lacking_m2ps4(&self) -> f32 {
        self.lacking
    }

    /// Propagates over a time without a fix, seconds.
    pub(super) fn pass(&mut self, seconds: f32) {
        self.add(0.0, CLIMB_DENSITY * seconds, LACKING_DENSITY * seconds);
        self.altitude_by_lacking += seconds * (self.climb_by_lacking + 0.5 * seconds);
        self.altitude_by_climb += seconds;
        self.climb_by_lacking += seconds;
    }

    /// Adds variances to altitude (m^2), climb rate ((m/s)^2) and lacking acceleration ((m/s^2)^2) (Bierman,
    /// section V.3, after Agee and Turner).
    pub(super) fn add(&mut self, altitude_m2: f32, climb_m2ps2: f32, lacking_m2ps4: f32) {
        let sum = self.lacking + lacking_m2ps4;
        let kept = self.lacking / sum;
        let left = lacking_m2ps4 * kept;
        let along = self.altitude_by_lacking - self.altitude_by_climb * self.climb_by_lacking;
        let across = self.climb_by_lacking;
        self.lacking = sum;
        self.altitude_by_lacking *= kept;
        self.climb_by_lacking *= kept;
        let sum = self.climb + left * across * across;
        self.altitude_by_climb += left * across * along / sum;
        self.altitude += left * self.climb / sum * along * along;
        let climb = sum + climb_m2ps2;
        let kept = sum / climb;
        self.altitude += climb_m2ps2 * kept * self.altitude_by_climb * self.altitude_by_climb;
        self.altitude_by_climb *= kept;
        self.climb = climb;
        self.altitude += altitude_m2;
    }

    /// Takes a fix that represents `seconds` and differs from the altitude by `residual_m`, metres. Returns
    /// the corrections of altitude, climb rate and lacking acceleration. `None`, with nothing changed, for an
    /// outlier.
    pub(super) fn fix(&mut self, seconds: f32, residual_m: f32) -> Option<[f32; 3]> {
        let variance = FIX_M2S / seconds.min(LONGEST_FIX_S);
        let (a, b, c) = (self.altitude_by_climb, self.altitude_by_lacking, self.climb_by_lacking);
        let (by_climb, by_lacking) = (a * self.climb, b * self.lacking);
        let first = variance + self.altitude;
        let second = first + a * by_climb;
        let third = second + b * by_lacking;
        if residual_m * residual_m > GATE * third {
            return None;
        }
        // Bierman's update, written out for a measurement of the first state.
        let altitude = self.altitude + a * by_climb;
        self.altitude_by_climb -= self.altitude * a / first;
        self.altitude_by_lacking -= altitude * b / second;
        self.climb_by_lacking -= by_climb * b / second;
        self.altitude *= variance / first;
        self.climb *= first / second;
        self.lacking *= second / third;
        let scale = residual_m / third;
        Some([altitude + b * by_lacking, by_climb + c * by_lacking, by_lacking].map(|gain| gain * scale))
    }

    /// [`Self::fix`] for a fix's climb rate, m/s.
    pub(super) fn fix_climb(&mut self, residual_mps: f32) -> Option<[f32; 3]> {
        let (a, b, c) = (self.altitude_by_climb, self.altitude_by_lacking, self.climb_by_lacking);
        let (by_climb, by_lacking) = (a * self.climb, c * self.lacking);
        let second = FIX_CLIMB_M2PS2 + self.climb;
        let third = second + c * by_lacking;
        if residual_mps * residual_mps > GATE * third {
            return None;
        }
        // Bierman's update, written out for a measurement of the second state.
        let gain = [by_climb + b * by_lacking, self.climb + c * by_lacking, by_lacking];
        self.altitude_by_lacking -= by_climb * c / second;
        self.climb_by_lacking -= self.climb * c / second;
        self.climb *= FIX_CLIMB_M2PS2 / second;
        self.lacking *= second / third;
        let scale = residual_mps / third;
        Some(gain.map(|gain| gain * scale))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    type Matrix = [[f64; 3]; 3];

    fn dense(tie: &Tie) -> Matrix {
        let [a, b, c] = [tie.altitude_by_climb, tie.altitude_by_lacking, tie.climb_by_lacking].map(f64::from);
        let u = [[1.0, a, b], [0.0, 1.0, c], [0.0, 0.0, 1.0]];
        let d = [tie.altitude, tie.climb, tie.lacking].map(f64::from);
        core::array::from_fn(|i| core::array::from_fn(|j| (0..3).map(|k| u[i][k] * d[k] * u[j][k]).sum()))
    }

    fn congruent(by: Matrix, p: Matrix) -> Matrix {
        let left: Matrix =
            core::array::from_fn(|i| core::array::from_fn(|j| (0..3).map(|k| by[i][k] * p[k][j]).sum()));
        core::array::from_fn(|i| core::array::from_fn(|j| (0..3).map(|k| left[i][k] * by[j][k]).sum()))
    }

    fn assert_close(tie: &Tie, p: &Matrix) {
        let found = dense(tie);
        for i in 0..3 {
            for j in 0..3 {
                let size = (p[i][i] * p[j][j]).sqrt();
                assert!((found[i][j] - p[i][j]).abs() <= 2e-3 * size, "{i} {j}: {found:?} {p:?}");
            }
        }
    }

    proptest! {
        /// Covariance and gains equal those of the full Kalman filter in double precision.
        #[test]
        fn it_is_the_kalman_filter(
            steps in proptest::collection::vec((1e-3f32..1.5, 0..5, -3f32..3.0), 1..400),
        ) {
            let mut tie = Tie::START;
            let mut p = dense(&tie);
            let mut last_s = 0f32;
            for (step_s, what, residual) in steps {
                let t = f64::from(step_s);
                p[1][1] += f64::from(CLIMB_DENSITY) * t;
                p[2][2] += f64::from(LACKING_DENSITY) * t;
                p = congruent([[1.0, t, 0.5 * t * t], [0.0, 1.0, t], [0.0, 0.0, 1.0]], p);
                tie.pass(step_s);
                last_s += step_s;
                assert_close(&tie, &p);
                let (measured, variance, moved) = match what {
                    0 | 1 => {
                        let variance = f64::from(FIX_M2S / last_s.min(LONGEST_FIX_S));
                        last_s = 0.0;
                        (0, variance, tie.fix(variance_time(variance), residual))
                    }
                    2 => (1, f64::from(FIX_CLIMB_M2PS2), tie.fix_climb(residual)),
                    _ => continue,
                };
                let gain = [0, 1, 2].map(|i| p[i][measured] / (p[measured][measured] + variance));
                let Some(moved) = moved else {
                    prop_assert!(f64::from(residual).powi(2) > 24.9 * (p[measured][measured] + variance));
                    continue;
                };
                for i in 0..3 {
                    let wanted = gain[i] * f64::from(residual);
                    let size = gain[i].abs().max(1e-3 * p[i][i].sqrt());
                    prop_assert!((f64::from(moved[i]) - wanted).abs() <= 1e-2 * size * f64::from(residual.abs()) + 1e-9);
                }
                let mut left: Matrix = core::array::from_fn(|i| core::array::from_fn(|j| f64::from(u8::from(i == j))));
                for i in 0..3 {
                    left[i][measured] -= gain[i];
                }
                let joseph = congruent(left, p);
                p = core::array::from_fn(|i| core::array::from_fn(|j| joseph[i][j] + gain[i] * gain[j] * variance));
                assert_close(&tie, &p);
            }
        }
    }

    fn variance_time(variance: f64) -> f32 {
        FIX_M2S / variance as f32
    }
}
