//! Separates the reference's own error from the sensors'.
//!
//! An error is a reading less the reference, so the reference's wander is in the errors of all sensors alike.
//! With the noise that a diagnosis found, a Kalman smoother over the errors of the whole flight gives the
//! most probable wander at every instant (Rauch, Tung and Striebel, "Maximum likelihood estimates of linear
//! dynamic systems", AIAA Journal 3, 1965).

use kf_core::sensor::{SENSORS, Sensor};
use nalgebra::{SMatrix, SVector};

use super::diagnosis::NoiseFacts;

/// Number of states: the reference's wander, and each sensor's own.
const STATES: usize = 1 + SENSORS;
type State = SVector<f64, STATES>;
type Covariance = SMatrix<f64, STATES, STATES>;

/// Errors within one slot of time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorSlot {
    /// Time of the slot, seconds; increasing from slot to slot.
    pub time_s: f64,
    /// Mean error of each sensor, metres; `None` without a reading.
    pub mean_m: [Option<f64>; SENSORS],
    /// Variance of the fast noise of that mean, including the fix's, square metres.
    pub variance_m2: [f64; SENSORS],
}

/// The reference's wander as it enters every error, metres, and its sigma, slot by slot.
#[must_use]
pub fn reference_wander(slots: &[ErrorSlot], noise: &NoiseFacts) -> Vec<(f64, f64)> {
    let processes = processes(noise);
    let stationary =
        Covariance::from_diagonal(&State::from_fn(|state, _| processes[state].0 * processes[state].0));
    let mut filtered: Vec<(State, Covariance)> = Vec::with_capacity(slots.len());
    let mut predicted: Vec<(State, Covariance, State)> = Vec::with_capacity(slots.len());
    let (mut mean, mut covariance) = (State::zeros(), stationary);
    let mut last_s: Option<f64> = None;
    for slot in slots {
        let elapsed_s = last_s.map_or(0.0, |last_s| (slot.time_s - last_s).max(0.0));
        last_s = Some(slot.time_s);
        let keep = State::from_fn(|state, _| libm::exp(-elapsed_s / processes[state].1));
        mean.component_mul_assign(&keep);
        covariance = Covariance::from_fn(|r, c| {
            let added = if r == c { stationary[(r, r)] * (1.0 - keep[r] * keep[r]) } else { 0.0 };
            covariance[(r, c)] * keep[r] * keep[c] + added
        });
        predicted.push((mean, covariance, keep));
        for (sensor, error_m) in slot.mean_m.iter().enumerate() {
            let Some(error_m) = error_m else { continue };
            let shown = State::from_fn(|state, _| f64::from(u8::from(state == 0 || state == 1 + sensor)));
            let column = covariance * shown;
            let variance = shown.dot(&column) + slot.variance_m2[sensor];
            if variance <= 0.0 {
                continue;
            }
            let gain = column / variance;
            mean += gain * (error_m - shown.dot(&mean));
            covariance -= gain * column.transpose();
        }
        filtered.push((mean, covariance));
    }
    let mut smoothed = vec![(0.0, 0.0); slots.len()];
    let mut after: Option<(State, Covariance)> = None;
    for index in (0..slots.len()).rev() {
        let (mean, covariance) = filtered[index];
        let here = after.zip(predicted.get(index + 1)).and_then(
            |((next, next_covariance), (ahead, spread, keep))| {
                let inverse = spread.try_inverse()?;
                let gain = covariance * Covariance::from_diagonal(keep) * inverse;
                let smooth = mean + gain * (next - ahead);
                Some((smooth, covariance + gain * (next_covariance - spread) * gain.transpose()))
            },
        );
        let (mean, covariance) = here.unwrap_or((mean, covariance));
        smoothed[index] = (mean[0], covariance[(0, 0)].max(0.0).sqrt());
        after = Some((mean, covariance));
    }
    smoothed
}

/// Sigma (m) and correlation time (s) of each state; negligible for a sensor without a wander of its own.
fn processes(noise: &NoiseFacts) -> [(f64, f64); STATES] {
    const HARDLY_M: f64 = 1e-3;
    let usable =
        |(sigma_m, time_s): (f64, f64)| (sigma_m.max(HARDLY_M), if time_s > 0.0 { time_s } else { 1.0 });
    let mut processes = [usable((noise.reference_wander_m, noise.reference_time_s)); STATES];
    for sensor in Sensor::ALL {
        let own = noise.sensor_wander.get(sensor.name());
        let own = own.map_or((HARDLY_M, 1.0), |wander| (wander.sigma_m, wander.time_s));
        processes[1 + sensor.index()] = usable(own);
    }
    processes
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::diagnose::diagnosis::SensorWander;

    #[test]
    fn the_wander_is_found_to_its_own_sigma() {
        const SLOTS: usize = 4_000;
        let noise = NoiseFacts {
            reference_wander_m: 2.0,
            reference_time_s: 60.0,
            slow_wander_m: 0.0,
            slow_time_s: 0.0,
            sensor_wander: BTreeMap::from([
                ("baro".into(), SensorWander { sigma_m: 0.5, time_s: 600.0 }),
                ("imu_slave".into(), SensorWander { sigma_m: 1.0, time_s: 20.0 }),
            ]),
            ..NoiseFacts::default()
        };
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let mut states = [(2.0, 60.0), (0.5, 600.0), (1.0, 20.0)]
            .map(|(sigma, time): (f64, f64)| (sigma * draw(), sigma, time));
        let mut truth = Vec::new();
        let mut slots = Vec::new();
        for slot in 0..SLOTS {
            for (value, sigma, time) in &mut states {
                let keep = libm::exp(-1.0 / *time);
                *value = *value * keep + *sigma * (1.0 - keep * keep).sqrt() * draw();
            }
            let [reference, baro, slave] = states.map(|(value, ..)| value);
            truth.push(reference);
            // A stretch without the inertial altitude.
            let has_slave = !(1_000..1_500).contains(&slot);
            let mean_m = [
                None,
                has_slave.then_some(reference + slave + 0.1 * draw()),
                Some(reference + baro + 0.1 * draw()),
            ];
            slots.push(ErrorSlot { time_s: slot as f64, mean_m, variance_m2: [0.01; SENSORS] });
        }
        let found = reference_wander(&slots, &noise);
        let square = |x: f64| x * x;
        let left = found.iter().zip(&truth).map(|((mean, _), truth)| square(mean - truth)).sum::<f64>()
            / SLOTS as f64;
        // The error of the estimate matches its own sigma. Errors are correlated over about ten slots: the
        // mean of 400 independent squares is within 0.07 of 1, one sigma.
        let normalised = found
            .iter()
            .zip(&truth)
            .map(|((mean, sigma), truth)| square((mean - truth) / sigma))
            .sum::<f64>()
            / SLOTS as f64;
        assert!((normalised - 1.0).abs() < 0.35, "{normalised}");
        assert!(left.sqrt() < 0.8, "{}", left.sqrt());
    }
}
