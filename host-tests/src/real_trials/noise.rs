//! Noise of a different family from the estimator's: sines, steps, heavy tails and quantisation in place of
//! the Gauss-Markov processes that it assumes.

use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Exp1, StudentT};

/// Number of sines in a wander.
const SINES: usize = 8;

/// A slow wander of that rms (metres), with periods between two bounds (seconds) and larger amplitudes at
/// longer periods; by time.
pub fn wander(
    random: &mut ChaCha8Rng,
    times_s: &[f64],
    rms_m: f64,
    shortest_s: f64,
    longest_s: f64,
) -> Vec<f64> {
    let sines: Vec<(f64, f64, f64)> = (0..SINES)
        .map(|_| {
            let period_s = (shortest_s.ln() + (longest_s / shortest_s).ln() * random.random::<f64>()).exp();
            (
                period_s.sqrt(),
                std::f64::consts::TAU / period_s,
                std::f64::consts::TAU * random.random::<f64>(),
            )
        })
        .collect();
    let square: f64 = sines.iter().map(|(size, ..)| 0.5 * size * size).sum();
    let scale = rms_m / square.sqrt();
    let at = |time_s: f64| {
        sines.iter().map(|(size, rate, phase)| size * (rate * time_s + phase).sin()).sum::<f64>()
    };
    times_s.iter().map(|time_s| scale * at(*time_s)).collect::<Vec<f64>>()
}

/// An offset of that rms (metres), which holds until the next change of satellites and is then drawn again;
/// changes come every `every_s` seconds on average.
pub fn steps(random: &mut ChaCha8Rng, times_s: &[f64], rms_m: f64, every_s: f64) -> Vec<f64> {
    let exponential = |random: &mut ChaCha8Rng| -> f64 { Exp1.sample(random) };
    // Laplace distribution: an exponential of either sign, whose rms is sqrt(2) times its mean.
    let offset = |random: &mut ChaCha8Rng| {
        let size = exponential(random) * rms_m / std::f64::consts::SQRT_2;
        if random.random::<bool>() { size } else { -size }
    };
    let mut next_s = times_s.first().copied().unwrap_or(0.0) + every_s * exponential(random);
    let mut now_m = offset(random);
    let mut offsets = Vec::with_capacity(times_s.len());
    for time_s in times_s {
        while *time_s >= next_s {
            now_m = offset(random);
            next_s += every_s * exponential(random);
        }
        offsets.push(now_m);
    }
    offsets
}

/// Noise with heavy tails (Student's t with that many degrees of freedom, over two) of that rms, metres,
/// averaged over that many samples in a row, as a receiver's own filter does.
pub fn heavy(random: &mut ChaCha8Rng, count: usize, rms_m: f64, freedom: f64, averaged: usize) -> Vec<f64> {
    let averaged = averaged.max(1);
    let Ok(student) = StudentT::new(freedom) else { return vec![0.0; count] };
    let raw: Vec<f64> = (0..count + averaged).map(|_| student.sample(random)).collect();
    // The variance of Student's t is f / (f - 2).
    let scale = rms_m / (freedom / (freedom - 2.0) * averaged as f64).sqrt();
    raw.windows(averaged).take(count).map(|window| scale * window.iter().sum::<f64>()).collect()
}
