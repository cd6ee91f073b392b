//! How a first-order Gauss-Markov error of known size and correlation time affects statistics over a span not
//! much longer than that time.
//!
//! The error has the variance `sigma^2` and the autocovariance `sigma^2 exp(-|dt| / tau)` (Gelb, "Applied
//! Optimal Estimation", ch. 3.8). The factors below are to be multiplied by `sigma^2`.

/// Variance of the error's mean over the span: `2/a (1 - (1 - exp(-a)) / a)`, `a = span / tau`.
///
/// The spread about that mean, over the same span, falls short of `sigma^2` by the same factor. 0 for white
/// noise (`tau = 0`), 1 for a span that is short against tau.
#[must_use]
pub fn mean_variance_factor(span_s: f32, correlation_time_s: f32) -> f32 {
    if correlation_time_s <= 0.0 {
        return 0.0;
    }
    let a = span_s / correlation_time_s;
    // Below this, f32 loses the difference; the factor is 1 - a/3.
    if a < 0.01 {
        return 1.0;
    }
    2.0 / a * (1.0 - (1.0 - libm::expf(-a)) / a)
}

/// Variance of the change, over the span, of the least-squares line through it:
/// `144 * (integral of u v exp(-a |u - v|) over the unit square about 0)`.
#[must_use]
pub fn drift_variance_factor(span_s: f32, correlation_time_s: f32) -> f32 {
    if correlation_time_s <= 0.0 {
        return 0.0;
    }
    let a = span_s / correlation_time_s;
    // The closed form cancels in f32 for small a; this is its expansion, good to 0.1 % here.
    if a < 0.2 {
        return 144.0 / 60.0 * a * (1.0 - 0.4 * a);
    }
    let inverse = 1.0 / a;
    let c = (0.5 + inverse) * inverse;
    let integral = inverse / 6.0 + 2.0 * c * ((inverse - 0.5) * inverse - c * libm::expf(-a));
    144.0 * integral
}

/// Variance of the error after its exponential mean with this memory is subtracted: `memory / (memory +
/// tau)`. 1 for white noise, which a mean does not predict.
#[must_use]
pub fn recent_variance_factor(memory_s: f32, correlation_time_s: f32) -> f32 {
    memory_s / (memory_s + correlation_time_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both factors, by summing the covariance over a grid of `n` points in f64.
    fn by_summation(a: f64) -> (f64, f64) {
        let n = 400;
        let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n) - 0.5;
        let (mut mean, mut drift) = (0.0, 0.0);
        for i in 0..n {
            for j in 0..n {
                let (u, v) = (at(i), at(j));
                let covariance = (-a * (u - v).abs()).exp() / f64::from(n * n);
                mean += covariance;
                drift += 144.0 * u * v * covariance;
            }
        }
        (mean, drift)
    }

    #[test]
    fn closed_forms_are_the_integrals() {
        for span_s in [0.001_f32, 0.05, 0.15, 0.19, 0.21, 0.5, 1.0, 2.0, 5.0, 20.0] {
            let (mean, drift) = by_summation(f64::from(span_s));
            // The grid's own error is of second order in a / n; f32 cancels to a few per cent at 0.2.
            let got = f64::from(mean_variance_factor(span_s, 1.0));
            assert!((got - mean).abs() < 2e-3, "mean, {span_s}: {got} {mean}");
            let got = f64::from(drift_variance_factor(span_s, 1.0));
            assert!((got - drift).abs() < 0.03 * drift, "drift, {span_s}: {got} {drift}");
        }
    }

    #[test]
    fn white_noise_adds_nothing() {
        assert_eq!((mean_variance_factor(70.0, 0.0), drift_variance_factor(70.0, 0.0)), (0.0, 0.0));
    }
}
