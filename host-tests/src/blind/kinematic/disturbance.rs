//! Noise of a different family from the estimator's: heavy tails, steps, tones.

use std::f64::consts::TAU;

use rand::{Rng, RngExt as _};

use crate::blind::draw::log_uniform;

/// A standard normal number (Box and Muller).
pub(super) fn normal(random: &mut impl Rng) -> f64 {
    let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
    radius * (TAU * random.random::<f64>()).cos()
}

/// Student's t with four degrees of freedom, scaled to unit variance: an occasional wild reading.
pub(super) fn heavy_tailed(random: &mut impl Rng) -> f64 {
    let squares: f64 = (0..4).map(|_| normal(random).powi(2)).sum();
    normal(random) / (squares / 4.0).sqrt() / std::f64::consts::SQRT_2
}

/// A gust: a Gauss-Markov process.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gust {
    sigma: f64,
    time_s: f64,
    value: f64,
}

impl Gust {
    pub const fn new(sigma: f64, time_s: f64) -> Self {
        Self { sigma, time_s, value: 0.0 }
    }

    pub fn next(&mut self, random: &mut impl Rng, step_s: f64) -> f64 {
        let kept = (-step_s / self.time_s).exp();
        self.value = kept * self.value + self.sigma * (1.0 - kept * kept).sqrt() * normal(random);
        self.value
    }
}

/// A slow wander made of three tones, which is not a Gauss-Markov process.
#[derive(Clone, Debug)]
pub(super) struct Tones([[f64; 3]; 3]);

impl Tones {
    /// Draws tones of that rms, with periods between these, s.
    pub fn draw(random: &mut impl Rng, rms: f64, periods_s: [f64; 2]) -> Self {
        Self(std::array::from_fn(|_| {
            let period_s = log_uniform(random, periods_s[0], periods_s[1]);
            [rms * (2.0_f64 / 3.0).sqrt(), TAU / period_s, random.random_range(0.0..TAU)]
        }))
    }

    pub fn at(&self, time_s: f64) -> f64 {
        self.0.iter().map(|[size, frequency, phase]| size * (frequency * time_s + phase).sin()).sum()
    }
}

/// Steps, as of a receiver whose satellites change; each fades slowly.
#[derive(Clone, Debug)]
pub(super) struct Steps {
    every_s: f64,
    size: f64,
    fade_s: f64,
    value: f64,
}

impl Steps {
    pub const fn new(every_s: f64, size: f64, fade_s: f64) -> Self {
        Self { every_s, size, fade_s, value: 0.0 }
    }

    pub fn next(&mut self, random: &mut impl Rng, step_s: f64) -> f64 {
        self.value *= (-step_s / self.fade_s).exp();
        if random.random::<f64>() < step_s / self.every_s {
            self.value += self.size * normal(random);
        }
        self.value
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Unit variance, and 1.2 % beyond three sigma where a normal one has 0.27 %.
    #[test]
    fn heavy_tails_have_unit_variance_and_heavy_tails() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let drawn: Vec<f64> = (0..200_000).map(|_| heavy_tailed(&mut random)).collect();
        let variance = drawn.iter().map(|x| x * x).sum::<f64>() / drawn.len() as f64;
        // The fourth moment has no bound; the mean square of 200,000 has been observed within 10 %.
        assert!((variance - 1.0).abs() < 0.1, "{variance}");
        // P(|t4| > 3 sqrt 2) = 0.0132, in 200,000 with a sigma of 0.00026.
        let beyond = drawn.iter().filter(|x| x.abs() > 3.0).count() as f64 / drawn.len() as f64;
        assert!((beyond - 0.0132).abs() < 0.0011, "{beyond}");
    }

    #[test]
    fn tones_have_the_rms_that_was_asked_for() {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        let tones = Tones::draw(&mut random, 2.0, [10.0, 20.0]);
        let count = 1_000_000;
        let square = (0..count).map(|k| tones.at(f64::from(k) * 0.1).powi(2)).sum::<f64>() / f64::from(count);
        assert!((square.sqrt() - 2.0).abs() < 0.02, "{square}");
    }
}
