//! Random numbers that are the same on every platform and in every release.
//!
//! Own transforms on top of the ChaCha generator instead of `rand_distr`'s: that crate's ziggurat calls the
//! platform's `exp` and `ln`, and its algorithm may change between releases. A seed must always give a flight
//! with the same bytes.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Users of random numbers: each has its own stream, so that a change of one sensor does not change the
/// others' noise.
#[derive(Clone, Copy, Debug)]
#[repr(u64)]
pub(super) enum Stream {
    Turbulence = 1,
    Engine,
    Gps,
    GpsLosses,
    Baro,
    BaroLosses,
    BaroTemperature,
    ImuMaster,
    ImuMasterLosses,
    ImuSlave,
    ImuSlaveLosses,
    Inertial,
    InertialLosses,
    AirData,
    AirDataLosses,
    Attitude,
    AttitudeLosses,
}

/// One stream of random numbers.
pub(super) struct Random {
    generator: ChaCha8Rng,
    spare_normal: Option<f64>,
}

impl Random {
    pub(super) fn new(seed: u64, stream: Stream) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream as u64);
        Self { generator, spare_normal: None }
    }

    /// Uniform on (0, 1): the middles of 2^53 equal cells, so that neither end is ever drawn.
    pub(super) fn uniform(&mut self) -> f64 {
        const CELL: f64 = 1.0 / (1_u64 << 53) as f64;
        ((self.generator.next_u64() >> 11) as f64 + 0.5) * CELL
    }

    /// Standard normal (Box and Muller, 1958).
    pub(super) fn normal(&mut self) -> f64 {
        if let Some(value) = self.spare_normal.take() {
            return value;
        }
        let radius = libm::sqrt(-2.0 * libm::log(self.uniform()));
        let (sine, cosine) = libm::sincos(core::f64::consts::TAU * self.uniform());
        self.spare_normal = Some(radius * sine);
        radius * cosine
    }
}

/// First-order Gauss-Markov process: stationary from its first value, exact for any step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GaussMarkov {
    /// In sigmas; `None` before the first draw.
    state: Option<f64>,
}

impl GaussMarkov {
    /// The value (in sigmas) `steps_of_time_constant` = dt / tau after the last one.
    pub(super) fn next(&mut self, random: &mut Random, steps_of_time_constant: f64) -> f64 {
        let fresh = random.normal();
        let next = self.state.map_or(fresh, |last| {
            let kept = libm::exp(-steps_of_time_constant);
            last * kept + libm::sqrt(1.0 - kept * kept) * fresh
        });
        self.state = Some(next);
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRAWS: usize = 200_000;

    #[test]
    fn normal_numbers_have_the_moments_of_a_normal_distribution() {
        let mut random = Random::new(1, Stream::Baro);
        let draws: Vec<f64> = (0..DRAWS).map(|_| random.normal()).collect();
        let n = DRAWS as f64;
        let moment = |power: i32| draws.iter().map(|x| x.powi(power)).sum::<f64>() / n;
        // Variances of the sample moments of a standard normal: 1, 2, 15, 96 over n. Five sigma.
        assert!(moment(1).abs() < 5.0 * (1.0 / n).sqrt());
        assert!((moment(2) - 1.0).abs() < 5.0 * (2.0 / n).sqrt());
        assert!(moment(3).abs() < 5.0 * (15.0 / n).sqrt());
        assert!((moment(4) - 3.0).abs() < 5.0 * (96.0 / n).sqrt());
    }

    #[test]
    fn gauss_markov_has_its_spread_and_correlation() {
        let mut random = Random::new(2, Stream::Baro);
        let mut process = GaussMarkov::default();
        let step = 0.25;
        let draws: Vec<f64> = (0..DRAWS).map(|_| process.next(&mut random, step)).collect();
        let n = DRAWS as f64;
        let rho = (-step).exp();
        let variance = draws.iter().map(|x| x * x).sum::<f64>() / n;
        let lagged = draws.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / n;
        // Bartlett: var(s^2) = (2/n) (1 + rho^2)/(1 - rho^2); a lagged product has at most twice that.
        let sigma = (2.0 / n * (1.0 + rho * rho) / (1.0 - rho * rho)).sqrt();
        assert!((variance - 1.0).abs() < 5.0 * sigma, "{variance}");
        assert!((lagged - rho).abs() < 5.0 * 2.0_f64.sqrt() * sigma, "{lagged} {rho}");
    }

    #[test]
    fn streams_of_one_seed_differ_and_repeat() {
        let mut a = Random::new(3, Stream::Baro);
        let mut b = Random::new(3, Stream::Gps);
        let mut again = Random::new(3, Stream::Baro);
        let first = a.normal();
        assert_ne!(first.to_bits(), b.normal().to_bits());
        assert_eq!(first.to_bits(), again.normal().to_bits());
    }
}
