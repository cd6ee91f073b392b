//! The reference's altitude between its fixes.

use super::column_noise::{BEND, FEW_BENDS};
use super::latent_path::PathPoint;

/// One accepted fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Time of the fix, microseconds.
    pub time_us: u64,
    /// Altitude without the effects that the model has, metres.
    pub altitude_m: f64,
    /// Climb rate, m/s, where the receiver gives it.
    pub climb_mps: Option<f64>,
}

/// Two fixes have a gap between them if they are further apart than this many medians of their interval.
const GAP_INTERVALS: f64 = 4.0;

/// Median of the square of a standard normal number.
const MEDIAN_OF_SQUARES: f64 = 0.4549;

/// The reference's altitude as a function of time: the cubic through two fixes and their climb rates
/// (Hermite's) or, where there are none, through the neighbours' slopes (Catmull and Rom's).
#[derive(Clone, Debug, Default)]
pub struct ReferencePath {
    fixes: Vec<Fix>,
    climb_mps: Vec<f64>,
    /// Slope and altitude of a straight line through the fixes around each one, for receivers without a climb
    /// rate.
    lines: Vec<(f64, f64)>,
    interval_s: f64,
    gap_s: f64,
    next: usize,
}

impl ReferencePath {
    /// A path through fixes in time order. No reading is compared across a gap longer than `lost_after_s`.
    #[must_use]
    pub fn new(fixes: Vec<Fix>, lost_after_s: f64) -> Self {
        let mut intervals: Vec<f64> =
            fixes.windows(2).map(|pair| seconds(pair[0].time_us, pair[1].time_us)).collect();
        intervals.sort_by(f64::total_cmp);
        let interval_s = intervals.get(intervals.len() / 2).copied().unwrap_or(0.0);
        let slope = |a: usize, b: usize| {
            let (a, b) = (fixes.get(a)?, fixes.get(b)?);
            let elapsed_s = seconds(a.time_us, b.time_us);
            (elapsed_s > 0.0).then(|| (b.altitude_m - a.altitude_m) / elapsed_s)
        };
        let climb_mps = fixes.iter().enumerate().map(|(k, fix)| {
            let around = slope(k.saturating_sub(1), (k + 1).min(fixes.len() - 1));
            fix.climb_mps.or(around).unwrap_or(0.0)
        });
        let climb_mps = climb_mps.collect();
        let lines = (0..fixes.len()).map(|k| line(&fixes, k)).collect();
        let gap_s = (GAP_INTERVALS * interval_s).min(lost_after_s).max(1.5 * interval_s);
        Self { fixes, climb_mps, lines, interval_s, gap_s, next: 1 }
    }

    /// Sets a better path than the straight lines through the fixes' altitudes, for receivers without a climb
    /// rate; one point for each fix.
    pub fn set_path(&mut self, points: &[PathPoint]) {
        for (line, point) in self.lines.iter_mut().zip(points) {
            *line = (point.climb_mps, point.altitude_m);
        }
    }

    /// Median interval of the fixes, seconds.
    #[must_use]
    pub const fn interval_s(&self) -> f64 {
        self.interval_s
    }

    /// Variance of the noise of a fix's measured climb rate, m^2/s^2, by the second differences of three fixes
    /// in a row (as of [`super::column_noise`]); 0 where there are few. The median of their squares counts, as
    /// manoeuvres bend the climb rate too.
    pub fn climb_noise_m2(&self) -> f64 {
        let bends = self.fixes.windows(3).filter_map(|fixes| {
            let [before, middle, after] = fixes else { return None };
            let (left_s, right_s) =
                (seconds(before.time_us, middle.time_us), seconds(middle.time_us, after.time_us));
            let is_even = (left_s - right_s).abs() < 0.2 * self.interval_s && left_s < 1.5 * self.interval_s;
            let (first, second, third) = (before.climb_mps?, middle.climb_mps?, after.climb_mps?);
            is_even.then(|| (first - 2.0 * second + third).powi(2))
        });
        let mut squares: Vec<f64> = bends.collect();
        if (squares.len() as u64) < FEW_BENDS {
            return 0.0;
        }
        squares.sort_by(f64::total_cmp);
        squares[squares.len() / 2] / MEDIAN_OF_SQUARES / BEND
    }

    /// The fixes.
    #[must_use]
    pub fn fixes(&self) -> &[Fix] {
        &self.fixes
    }

    /// The reference at a time that is not before the last one asked for; `None` outside the fixes and in a
    /// gap.
    pub fn at(&mut self, time_us: u64) -> Option<Reference> {
        while self.fixes.get(self.next).is_some_and(|fix| fix.time_us < time_us) {
            self.next += 1;
        }
        let last = self.next.checked_sub(1)?;
        let (before, after) = (self.fixes.get(last)?, self.fixes.get(self.next)?);
        if before.time_us > time_us {
            return None;
        }
        let elapsed_s = seconds(before.time_us, after.time_us);
        if elapsed_s > self.gap_s || elapsed_s <= 0.0 {
            return None;
        }
        let x = seconds(before.time_us, time_us) / elapsed_s;
        let between = |before: f64, after: f64| before + x * (after - before);
        let (rise, fall) = (self.climb_mps[last] * elapsed_s, self.climb_mps[self.next] * elapsed_s);
        let step = after.altitude_m - before.altitude_m;
        let cubic = rise + fall - 2.0 * step;
        let square = 3.0 * step - 2.0 * rise - fall;
        let (lines, next_lines) = (self.lines[last], self.lines[self.next]);
        let measured = before.climb_mps.zip(after.climb_mps);
        Some(Reference {
            altitude_m: before.altitude_m + x * (rise + x * (square + x * cubic)),
            climb_mps: measured
                .map_or_else(|| between(lines.0, next_lines.0), |(before, after)| between(before, after)),
            smooth_m: between(lines.1, next_lines.1),
        })
    }
}

/// The reference at some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// Altitude, metres.
    pub altitude_m: f64,
    /// Climb rate, m/s: the receiver's, or else that given to [`ReferencePath::set_path`], or the slope of
    /// the altitude.
    pub climb_mps: f64,
    /// Altitude of that path, or averaged over some seconds around, metres.
    pub smooth_m: f64,
}

/// Fixes within this time of a fix are used for its line, seconds.
const AROUND_S: f64 = 2.0;

/// Slope (m/s) and value at a fix of the straight line through the fixes around it: at least one on either
/// side.
fn line(fixes: &[Fix], k: usize) -> (f64, f64) {
    let time_s = |fix: &Fix| fix.time_us as f64 * 1e-6 - fixes[k].time_us as f64 * 1e-6;
    let mut first = k.saturating_sub(1);
    while first > 0 && time_s(&fixes[first - 1]) > -AROUND_S {
        first -= 1;
    }
    let mut last = (k + 1).min(fixes.len() - 1);
    while last + 1 < fixes.len() && time_s(&fixes[last + 1]) < AROUND_S {
        last += 1;
    }
    let around = &fixes[first..=last];
    let n = around.len() as f64;
    let mean_s = around.iter().map(time_s).sum::<f64>() / n;
    let mean_m = around.iter().map(|fix| fix.altitude_m).sum::<f64>() / n;
    let spread: f64 = around.iter().map(|fix| (time_s(fix) - mean_s).powi(2)).sum();
    let product: f64 = around.iter().map(|fix| (time_s(fix) - mean_s) * (fix.altitude_m - mean_m)).sum();
    let slope = if spread > 0.0 { product / spread } else { 0.0 };
    (slope, mean_m - slope * mean_s)
}

fn seconds(from_us: u64, to_us: u64) -> f64 {
    to_us.saturating_sub(from_us) as f64 * 1e-6
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parabola(time_s: f64) -> f64 {
        100.0 + 20.0 * time_s - 4.0 * time_s * time_s
    }

    #[test]
    fn a_parabola_is_met_between_fixes_with_and_without_climb_rates() {
        for with_climb in [true, false] {
            let fixes = (0..20).map(|k| {
                let time_s = f64::from(k) * 0.5;
                Fix {
                    time_us: k as u64 * 500_000,
                    altitude_m: parabola(time_s),
                    climb_mps: with_climb.then_some(20.0 - 8.0 * time_s),
                }
            });
            let mut path = ReferencePath::new(fixes.collect(), 5.0);
            for k in 10..170 {
                let reference = path.at(k * 50_000).unwrap();
                let altitude_m = reference.altitude_m;
                // Where the fixes are symmetric on both sides, a parabola's line has its slope, and is off by
                // the mean of its bend: 4 m/s^2 times the mean square of the fixes' distances.
                if (50..130).contains(&k) {
                    let slope = 20.0 - 8.0 * k as f64 * 0.05;
                    assert!((reference.climb_mps - slope).abs() < 1e-6, "{k}: {reference:?}");
                    assert!((reference.smooth_m - altitude_m).abs() < 4.0 * 1.5 * 1.5, "{k}: {reference:?}");
                }
                let expected = parabola(k as f64 * 0.05);
                assert!((altitude_m - expected).abs() < 1e-9, "{k}: {altitude_m}, {expected}");
            }
            assert_eq!(path.at(9_600_000), None);
        }
    }

    #[test]
    fn nothing_is_compared_across_a_gap() {
        let fix = |time_us, altitude_m| Fix { time_us, altitude_m, climb_mps: None };
        let fixes = (0..10).map(|k| fix(k * 200_000, 1.0)).chain((30..40).map(|k| fix(k * 200_000, 1.0)));
        let mut path = ReferencePath::new(fixes.collect(), 5.0);
        assert_eq!(path.at(1_700_000).map(|reference| reference.altitude_m), Some(1.0));
        assert_eq!(path.at(3_000_000), None);
        assert_eq!(path.at(6_100_000).map(|reference| reference.altitude_m), Some(1.0));
    }

    /// The noise of the climb rates is found, also where the aircraft pulls up now and then: 600 bends give
    /// the median of their squares within 9 % (1 sigma; bends overlap). Without climb rates there is none.
    #[test]
    fn the_noise_of_climb_rates_is_found_beside_manoeuvres() {
        let (sigma_mps, mut state) = (0.2, 1_u64);
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        let fixes: Vec<Fix> = (0..602)
            .map(|k: u64| Fix {
                time_us: k * 200_000,
                altitude_m: 0.0,
                climb_mps: Some(if k % 40 < 3 { 5.0 } else { 0.0 } + sigma_mps * normal()),
            })
            .collect();
        let silent = fixes.iter().map(|fix| Fix { climb_mps: None, ..*fix }).collect();
        let found = ReferencePath::new(fixes, 5.0).climb_noise_m2() / (sigma_mps * sigma_mps);
        assert!((found - 1.0).abs() < 0.3, "{found}");
        assert_eq!(ReferencePath::new(silent, 5.0).climb_noise_m2(), 0.0);
    }
}
