//! What is assumed of a coefficient before a flight.

use kf_core::effect::EffectId;
use statistics::normal_above;

/// Probability that a coefficient is outside the physical range: of a broken part, or of something that only
/// looks like the effect.
const BEYOND: f64 = 0.01;
/// How far such a coefficient reaches, in multiples of the range's largest magnitude.
const REACH: f64 = 10.0;

/// The prior of a coefficient. Half of it is a normal distribution about zero, which most sensors follow, and
/// half is uniform over the physical range. Both are cut at the range, signs included. One hundredth lies
/// beyond the range, so that what no effect can cause is reported as such and is not given to the next best
/// effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoefficientPrior {
    range: [f64; 2],
    usual: f64,
}

impl CoefficientPrior {
    /// The prior of an effect with the given physical range.
    #[must_use]
    pub fn of(effect: EffectId, range: [f64; 2]) -> Self {
        Self { range, usual: usual(effect, range) }
    }

    /// Logarithm of the density of an estimate with that variance: the prior convolved with the estimate's
    /// normal error.
    #[must_use]
    pub fn log_density(&self, coefficient: f64, variance: f64) -> f64 {
        let [least, most] = self.range;
        let sigma = variance.sqrt();
        let between = |mean: f64, sigma: f64| {
            normal_above((least - mean) / sigma) - normal_above((most - mean) / sigma)
        };
        let uniform = between(coefficient, sigma) / (most - least);
        // The product of both normals is a normal about a mean between them, times a normal of their
        // distance.
        let usual = self.usual * self.usual;
        let together = usual + variance;
        let mean = coefficient * usual / together;
        let inside = between(mean, (usual * variance / together).sqrt());
        let density = libm::exp(-0.5 * coefficient * coefficient / together)
            / (2.0 * std::f64::consts::PI * together).sqrt();
        let normal = density * inside / between(0.0, self.usual);
        let reach = REACH * least.abs().max(most.abs());
        let beyond = (normal_above((-reach - coefficient) / sigma)
            - normal_above((reach - coefficient) / sigma))
            / (2.0 * reach);
        let density = (1.0 - BEYOND) * (0.5 * uniform + 0.5 * normal) + BEYOND * beyond;
        libm::log(density.max(f64::MIN_POSITIVE))
    }
}

/// Sigma of the coefficients that sensors in flight mostly have: those of `latent-path.md`'s prototype where
/// it has one (lag and latency 1.5 s, scale 3 %, dynamic pressure 0.3, drift 5 mm/s, warming up 10 m), else a
/// fifth of the range's largest magnitude.
fn usual(effect: EffectId, range: [f64; 2]) -> f64 {
    match effect {
        EffectId::BaroLag | EffectId::GpsLatency => 1.5,
        EffectId::BaroScale => 0.03,
        EffectId::BaroDynamicPressure => 0.3,
        EffectId::BaroDrift => 0.005,
        EffectId::BaroWarmUp => 10.0,
        _ => 0.2 * range[0].abs().max(range[1].abs()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the sum over a grid of the coefficient, for exact and for poor estimates, inside and outside
    /// the range.
    #[test]
    fn the_density_is_the_folding_of_belief_and_error() {
        let prior = CoefficientPrior { range: [-1.0, 3.0], usual: 1.5 };
        let normal = |x: f64, sigma: f64| {
            (-0.5 * (x / sigma) * (x / sigma)).exp() / (sigma * (2.0 * std::f64::consts::PI).sqrt())
        };
        let step = 1e-4;
        let grid: Vec<f64> = (0..40_000).map(|k| -1.0 + (f64::from(k) + 0.5) * step).collect();
        let inside: f64 = grid.iter().map(|c| normal(*c, 1.5) * step).sum();
        for (coefficient, sigma) in [(0.5, 0.01), (2.0, 1.0), (-1.3, 0.2), (4.0, 0.5), (9.0, 0.5)] {
            let within: f64 = grid
                .iter()
                .map(|c| (0.5 / 4.0 + 0.5 * normal(*c, 1.5) / inside) * normal(coefficient - c, sigma) * step)
                .sum();
            // None of these errors reaches the end of the part beyond the range, 30 either way.
            let density = 0.99 * within + 0.01 / 60.0;
            let folded = prior.log_density(coefficient, sigma * sigma);
            assert!((folded - density.ln()).abs() < 1e-5, "{coefficient}: {folded} {}", density.ln());
        }
    }

    /// The usual sigmas: 1.5 s of lag or latency, 3 % of scale, 0.3 of the dynamic pressure, a drift of 5
    /// mm/s, 10 m of warming up; for an effect without one, a fifth of the range's largest magnitude.
    #[test]
    fn what_sensors_mostly_have_is_what_is_written_down() {
        let of = |effect| CoefficientPrior::of(effect, [-4.0, 2.0]).usual;
        assert_eq!([EffectId::BaroLag, EffectId::GpsLatency].map(of), [1.5, 1.5]);
        assert_eq!([EffectId::BaroScale, EffectId::BaroDynamicPressure].map(of), [0.03, 0.3]);
        assert_eq!([EffectId::BaroDrift, EffectId::BaroWarmUp].map(of), [0.005, 10.0]);
        assert!((of(EffectId::BaroPropwash) - 0.8).abs() < 1e-12);
    }
}
