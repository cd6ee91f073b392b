//! Standard normal random numbers that are the same on every platform.
//!
//! Uses `rand_distr`'s algorithm (Doornik, "An improved ziggurat method to generate normal random samples",
//! 2005) and tables, so that a seed keeps its numbers, but with `libm`'s exponential and logarithm instead of
//! the platform's.

mod tables;

use rand_chacha::rand_core::Rng;
use tables::{DENSITIES, EDGES, TAIL};

/// One draw.
pub fn standard_normal(generator: &mut impl Rng) -> f64 {
    loop {
        let bits = generator.next_u64();
        let area = bits as usize & 0xff;
        // The upper 52 bits as a number in [2, 4), minus 3.
        let share = f64::from_bits((bits >> 12) | (1024 << 52)) - 3.0;
        let value = share * EDGES[area];
        if value.abs() < EDGES[area + 1] {
            return value;
        }
        if area == 0 {
            return tail(generator, share < 0.0);
        }
        let height = DENSITIES[area + 1] + (DENSITIES[area] - DENSITIES[area + 1]) * half_open(generator);
        if height < libm::exp(-value * value / 2.0) {
            return value;
        }
    }
}

/// A draw from beyond the last edge.
fn tail(generator: &mut impl Rng, is_negative: bool) -> f64 {
    loop {
        let (x, y) = (libm::log(open(generator)) / TAIL, libm::log(open(generator)));
        if -2.0 * y >= x * x {
            return if is_negative { x - TAIL } else { TAIL - x };
        }
    }
}

/// Uniform on [0, 1).
fn half_open(generator: &mut impl Rng) -> f64 {
    (generator.next_u64() >> 11) as f64 * (0.5 * f64::EPSILON)
}

/// Uniform on (0, 1).
fn open(generator: &mut impl Rng) -> f64 {
    f64::from_bits((generator.next_u64() >> 12) | (1023 << 52)) - (1.0 - 0.5 * f64::EPSILON)
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng as _;
    use rand_distr::{Distribution as _, StandardNormal};

    use super::*;

    /// A seed's numbers are those of `rand_distr`, except for the last digit of one in thousands.
    #[test]
    fn draws_what_rand_distr_draws() {
        let mut own = ChaCha8Rng::seed_from_u64(7);
        let mut theirs = own.clone();
        let mut beyond = 0;
        for _ in 0..100_000 {
            let (own, theirs): (f64, f64) = (standard_normal(&mut own), StandardNormal.sample(&mut theirs));
            assert!((own - theirs).abs() <= 1e-15 * theirs.abs(), "{own} {theirs}");
            beyond += u32::from(own.abs() > TAIL);
        }
        // 26 are expected there.
        assert!(beyond > 8, "{beyond}");
    }
}
