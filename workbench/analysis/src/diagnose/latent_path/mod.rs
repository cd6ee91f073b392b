//! The true path, where no receiver measures the climb rate.
//!
//! A delay shifts an altitude by the delay times the climb rate, a scale by a share of the height. The
//! receiver's own altitude and its slope contain noise, which the residual contains too. Noise in a regressor
//! makes its coefficient too small, and noise that both share draws a scale towards -1. Whitening a slow
//! wander amplifies fast noise: a delay of 2 s was found as 0.4 s, and scales of half the height were found.
//! The expectation of height and climb rate given all altitudes of the flight has no such noise in common
//! with the residual. Its error is uncorrelated with the data it is made of, the residual included, so a
//! regression on it is unbiased ("regression calibration": Carroll, Ruppert, Stefanski and Crainiceanu,
//! "Measurement Error in Nonlinear Models", 2nd edition, chapter 4).
//!
//! So the path is a state (`path_model`) that receiver and barometer both measure, and a smoother runs over
//! the whole flight. It weighs the time before and after an instant alike: its climb rate is odd in time, so
//! what it shares with the residual's noise before an instant cancels with what it shares after it. It gives
//! no delay to a flight without one.
//!
//! The effect of a delay of seconds is not a multiple of the climb rate where a path turns within seconds,
//! and two altitudes that are seconds apart do not show the same path. The remainder looks like the dynamic
//! pressure, for which height is exchanged. So the altitudes are first shifted against each other by the
//! delay with which one path explains both best, and the climb rate is the mean over that delay: for a pure
//! delay d, `h(t - d) - h(t)` is exactly -d times the mean climb rate between the two.

mod filter;
mod path_model;

use executor::Executor;

use super::quasi_newton::{Differences, minimise};
use super::reference_path::Fix;
use filter::{Sighting, smoothed, twice_log_likelihood};
use path_model::{PARAMETERS, PathModel};

pub use filter::PathPoint;

/// Sightings that the path's model is fitted to. A longer flight uses this many, in stretches spread over it.
const FITTED: usize = 3000;
/// Number of these stretches.
const STRETCHES: usize = 6;
/// With fewer sightings than this no model is fitted.
const FEW: usize = 60;
/// Gain in twice the log likelihood below which the model's fit stops iterating.
const GAIN: f64 = 0.1;

/// Longest delay that is tried, either way, seconds: longer than the physically possible one (5 s), so that a
/// longer delay is not mistaken for a possible one.
const LONGEST_DELAY_S: f64 = 8.0;
/// Shortest step between delays, seconds: within it the effect of a delay is practically linear.
const DELAY_STEP_S: f64 = 0.5;
/// Gain in twice the log likelihood that a delay needs: as for an effect in the search.
const DELAY_GAIN: f64 = 16.0;

/// The path at every fix, from the fixes and one sensor's readings (time in microseconds, metres): its
/// altitude, and the climb rate to which the difference of both altitudes is proportional if one is late.
///
/// `None` where there are too few of either.
#[must_use]
pub fn path(
    fixes: &[Fix],
    readings: &[(u64, f64)],
    interval_s: f64,
    executor: &dyn Executor,
) -> Option<Vec<PathPoint>> {
    let together = sightings(fixes, readings, interval_s, 0.0);
    if together.iter().filter(|sighting| sighting.sensor_m.is_some()).count() < FEW {
        return None;
    }
    let model = fitted(&together, &[0.0; PARAMETERS], executor);
    let delay_s = delay_s(fixes, readings, interval_s, &PathModel::of(&model), executor);
    if delay_s == 0.0 {
        return Some(smoothed(&together, &PathModel::of(&model)));
    }
    let apart = sightings(fixes, readings, interval_s, delay_s);
    let model = fitted(&apart, &model, executor);
    let mut points = smoothed(&apart, &PathModel::of(&model));
    let climb_mps: Vec<f64> = points.iter().map(|point| point.climb_mps).collect();
    for (point, mean_mps) in points.iter_mut().zip(means(fixes, &climb_mps, delay_s)) {
        point.climb_mps = mean_mps;
    }
    Some(points)
}

/// The delay of the sensor against the receiver with which one path explains both altitudes best, in steps,
/// seconds; 0 where no delay is clearly better than none.
fn delay_s(
    fixes: &[Fix],
    readings: &[(u64, f64)],
    interval_s: f64,
    model: &PathModel,
    executor: &dyn Executor,
) -> f64 {
    let step_s = interval_s * (DELAY_STEP_S / interval_s).ceil().max(1.0);
    let steps = (LONGEST_DELAY_S / step_s).floor() as i32;
    let delays_s: Vec<f64> = (-steps..=steps).map(|step| f64::from(step) * step_s).collect();
    let mut tried: Vec<Vec<Sighting>> =
        delays_s.iter().map(|delay_s| sightings(fixes, readings, interval_s, *delay_s)).collect();
    // Likelihoods can only be compared over the same measurements: those that exist with every delay.
    for k in 0..fixes.len() {
        if tried.iter().any(|sightings| sightings[k].sensor_m.is_none()) {
            tried.iter_mut().for_each(|sightings| sightings[k].sensor_m = None);
        }
    }
    let likelihood = |sightings: &[Sighting]| -> f64 {
        parts(sightings).iter().map(|part| twice_log_likelihood(part, model)).sum()
    };
    let likelihoods = executor::map(executor, tried.iter().map(|sightings| move || likelihood(sightings)));
    let of_none = likelihoods[steps as usize];
    let best = delays_s.iter().zip(&likelihoods).max_by(|a, b| a.1.total_cmp(b.1));
    best.filter(|(_, likelihood)| **likelihood > of_none + DELAY_GAIN).map_or(0.0, |(delay_s, _)| *delay_s)
}

/// The mean climb rate over this many seconds before every fix (after it, for a negative time), m/s.
fn means(fixes: &[Fix], climb_mps: &[f64], delay_s: f64) -> Vec<f64> {
    let seconds = |fix: &Fix| fix.time_us as f64 * 1e-6;
    let mut climbed_m = vec![0.0; fixes.len()];
    for k in 1..fixes.len() {
        let elapsed_s = seconds(&fixes[k]) - seconds(&fixes[k - 1]);
        climbed_m[k] = climbed_m[k - 1] + 0.5 * elapsed_s * (climb_mps[k - 1] + climb_mps[k]);
    }
    let at = |time_s: f64| -> f64 {
        let next = fixes.partition_point(|fix| seconds(fix) < time_s).clamp(1, fixes.len() - 1);
        let (from_s, to_s) = (seconds(&fixes[next - 1]), seconds(&fixes[next]));
        let elapsed_s = time_s - from_s;
        let slope = (climb_mps[next] - climb_mps[next - 1]) / (to_s - from_s).max(1e-6);
        climbed_m[next - 1] + elapsed_s * (climb_mps[next - 1] + 0.5 * elapsed_s * slope)
    };
    let first_s = fixes.first().map_or(0.0, seconds);
    let last_s = fixes.last().map_or(0.0, seconds);
    let mean = fixes.iter().zip(climb_mps).map(|(fix, own_mps)| {
        let time_s = seconds(fix);
        let other_s = (time_s - delay_s).clamp(first_s, last_s);
        if other_s == time_s { *own_mps } else { (at(time_s) - at(other_s)) / (time_s - other_s) }
    });
    mean.collect()
}

/// The fixes, each with the mean of the readings within half an interval of the time `delay_s` later.
fn sightings(fixes: &[Fix], readings: &[(u64, f64)], interval_s: f64, delay_s: f64) -> Vec<Sighting> {
    let half_us = (0.5e6 * interval_s) as u64;
    let delay_us = (delay_s * 1e6) as i64;
    let mut first = 0;
    let mut last_us = 0;
    let at = fixes.iter().enumerate().map(|(k, fix)| {
        let shown_us = fix.time_us.saturating_add_signed(delay_us);
        let (from_us, to_us) = (shown_us.saturating_sub(half_us), shown_us.saturating_add(half_us));
        while readings.get(first).is_some_and(|(time_us, _)| *time_us < from_us) {
            first += 1;
        }
        let near = readings[first..].iter().take_while(|(time_us, _)| *time_us < to_us);
        let (sum_m, count) = near.fold((0.0, 0_u32), |(sum, count), (_, metres)| (sum + metres, count + 1));
        let elapsed_s = if k == 0 { 0.0 } else { fix.time_us.saturating_sub(last_us) as f64 * 1e-6 };
        last_us = fix.time_us;
        Sighting {
            elapsed_s,
            reference_m: fix.altitude_m,
            sensor_m: (count > 0).then(|| sum_m / f64::from(count)),
        }
    });
    at.collect()
}

/// What a model is fitted to: all sightings, or stretches spread over them.
fn parts(sightings: &[Sighting]) -> Vec<&[Sighting]> {
    if sightings.len() <= FITTED {
        return vec![sightings];
    }
    let length = FITTED / STRETCHES;
    let step = (sightings.len() - length) / (STRETCHES - 1);
    (0..STRETCHES).map(|k| &sightings[k * step..k * step + length]).collect()
}

/// The parameters of the most probable model of a path.
fn fitted(sightings: &[Sighting], start: &[f64], executor: &dyn Executor) -> Vec<f64> {
    let parts = parts(sightings);
    let objective = |values: &[f64]| {
        let model = PathModel::of(values);
        let likelihood: f64 = parts.iter().map(|part| twice_log_likelihood(part, &model)).sum();
        PathModel::twice_prior(values) - likelihood
    };
    minimise(&Differences { function: objective, executor }, start, GAIN).at
}

#[cfg(test)]
mod tests;
