//! Distribution functions that give the same bits on every platform: by `libm` and nothing that a platform chooses.

/// Terms of a series or a fraction before it is given up; some ten standard deviations' worth at a million degrees of freedom.
const TERMS: u32 = 20_000;
/// Halvings of an interval: more than an f64 has bits.
const HALVINGS: u32 = 1100;

/// Probability of a standard normal value above `x`.
#[must_use]
pub fn normal_above(x: f64) -> f64 {
    0.5 * libm::erfc(x * std::f64::consts::FRAC_1_SQRT_2)
}

/// The value that a standard normal one is below with a probability of `p` in (0, 1).
///
/// Source: Abramowitz and Stegun, 26.2.23, made exact by Halley's iteration.
#[must_use]
pub fn normal_quantile(p: f64) -> f64 {
    if p > 0.5 {
        return -normal_quantile(1.0 - p);
    }
    let t = libm::sqrt(-2.0 * libm::log(p));
    let numerator = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let denominator = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    let mut x = numerator / denominator - t;
    for _ in 0..3 {
        let density = libm::exp(-0.5 * x * x) / libm::sqrt(std::f64::consts::TAU);
        let step = (normal_above(-x) - p) / density;
        let next = x - step / (1.0 + 0.5 * x * step);
        if !next.is_finite() {
            break;
        }
        x = next;
    }
    x
}

/// Probability that a chi-squared value of so many degrees of freedom, not necessarily whole, lies above `x`.
#[must_use]
pub fn chi_squared_above(degrees: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    gamma_tails(0.5 * degrees, 0.5 * x)[1]
}

/// The value that a chi-squared one of so many degrees of freedom is below with a probability of `p` in (0, 1).
#[must_use]
pub fn chi_squared_quantile(degrees: f64, p: f64) -> f64 {
    // The nearer tail keeps its digits.
    let is_low = |x: f64| {
        let [below, above] = gamma_tails(0.5 * degrees, 0.5 * x);
        if p < 0.5 { below < p } else { above > 1.0 - p }
    };
    let mut most = degrees.max(1.0);
    while is_low(most) && most < f64::MAX / 4.0 {
        most *= 2.0;
    }
    bisected(0.0, most, is_low)
}

/// Probability that a value of Student's distribution with so many degrees of freedom lies above `t >= 0`.
#[must_use]
pub fn student_above(degrees: f64, t: f64) -> f64 {
    0.5 * beta_below(0.5 * degrees, 0.5, degrees / (degrees + t * t))
}

/// Where a condition that holds below a value and not above it changes.
fn bisected(mut low: f64, mut high: f64, is_low: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if middle <= low || middle >= high {
            break;
        }
        if is_low(middle) { low = middle } else { high = middle }
    }
    f64::midpoint(low, high)
}

/// The regularised incomplete gamma functions P and Q: shares of the gamma distribution of shape `a` below and above `x > 0`.
///
/// Source: Press et al., "Numerical Recipes", 3rd edition, section 6.2: the series below the mean, Lentz's continued fraction
/// above it.
fn gamma_tails(a: f64, x: f64) -> [f64; 2] {
    let front = libm::exp(a * libm::log(x) - x - libm::lgamma(a));
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for k in 1..TERMS {
            term *= x / (a + f64::from(k));
            sum += term;
            if term < sum * f64::EPSILON {
                break;
            }
        }
        let below = (front * sum).min(1.0);
        return [below, 1.0 - below];
    }
    let step = |k: u32| -f64::from(k) * (f64::from(k) - a);
    let above = front / lentz(x + 1.0 - a, |k| (step(k), x + 2.0 * f64::from(k) + 1.0 - a));
    [1.0 - above, above]
}

/// The regularised incomplete beta function.
///
/// Source: the same, section 6.4.
fn beta_below(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    let front = libm::exp(
        libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b) + a * libm::log(x) + b * libm::log1p(-x),
    );
    let share = |a: f64, b: f64, x: f64| {
        let numerator = |k: u32| {
            let m = f64::from(k / 2);
            if k.is_multiple_of(2) {
                m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
            } else {
                -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
            }
        };
        front / (a * lentz(1.0, |k| (numerator(k), 1.0)))
    };
    if x < (a + 1.0) / (a + b + 2.0) { share(a, b, x) } else { 1.0 - share(b, a, 1.0 - x) }
}

/// A continued fraction `first + n1 / (d1 + n2 / (d2 + ...))` of the terms (n, d) from 1 on, by Lentz's method.
fn lentz(first: f64, term: impl Fn(u32) -> (f64, f64)) -> f64 {
    let away = |value: f64| if value.abs() < f64::MIN_POSITIVE { f64::MIN_POSITIVE } else { value };
    let mut value = away(first);
    let (mut upper, mut lower) = (value, 0.0);
    for k in 1..TERMS {
        let (numerator, denominator) = term(k);
        lower = 1.0 / away(denominator + numerator * lower);
        upper = away(denominator + numerator / upper);
        value *= upper * lower;
        if (upper * lower - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{ChiSquared, ContinuousCDF as _, Normal, StudentsT};

    use super::*;

    fn close(own: f64, theirs: f64, relative: f64) -> bool {
        (own - theirs).abs() <= relative * theirs.abs()
    }

    #[test]
    fn the_normal_distribution_is_that_of_statrs() {
        let normal = Normal::new(0.0, 1.0).unwrap();
        for k in -80..=80 {
            let x = f64::from(k) / 10.0;
            assert!(
                (normal_above(x) - normal.sf(x)).abs() < 1e-9,
                "{x}: {} {}",
                normal_above(x),
                normal.sf(x)
            );
        }
        for p in [1e-300, 1e-100, 1e-12, 0.001, 0.025, 0.3, 0.5, 0.7, 0.99, 1.0 - 1e-9] {
            let x = normal_quantile(p);
            assert!((x - normal.inverse_cdf(p)).abs() < 1e-6 * x.abs().max(1.0), "{p}: {x}");
            assert!(close(normal_above(-x), p, 1e-13 * x.abs().max(1.0).powi(2)), "{p}: {x}");
        }
        // The 97.5 % point and a value at 8 sigma, from tables.
        assert!(close(normal_quantile(0.975), 1.959_963_984_540_054, 1e-14));
        assert!(close(normal_above(8.0), 6.220_960_574_271_785e-16, 1e-13));
        assert!(close(normal_above(-1.0), 0.841_344_746_068_542_9, 1e-15));
        assert!(close(normal_above(2.0), 0.022_750_131_948_179_2, 1e-14));
    }

    #[test]
    fn chi_squared_is_that_of_statrs() {
        for degrees in [0.7, 1.0, 2.0, 15.0, 80.5, 3000.0, 2e5] {
            let theirs = ChiSquared::new(degrees).unwrap();
            for share in [0.3, 0.8, 0.99, 1.0, 1.02, 1.4, 3.0] {
                let x = share * degrees;
                let above = chi_squared_above(degrees, x);
                assert!((above - theirs.sf(x)).abs() < 1e-9, "{degrees} {x}: {above} {}", theirs.sf(x));
            }
            for p in [0.001, 0.025, 0.5, 0.975, 0.9999] {
                let x = chi_squared_quantile(degrees, p);
                assert!((1.0 - chi_squared_above(degrees, x) - p).abs() < 1e-10, "{degrees} {p}: {x}");
            }
        }
        // Two degrees of freedom: an exponential distribution.
        assert!(close(chi_squared_above(2.0, 10.0), libm::exp(-5.0), 1e-13));
        assert!(close(chi_squared_quantile(2.0, 0.95), -2.0 * libm::log(0.05), 1e-12));
    }

    #[test]
    fn students_distribution_is_that_of_statrs() {
        for degrees in [1.0, 2.0, 5.0, 30.0, 400.0] {
            let theirs = StudentsT::new(0.0, 1.0, degrees).unwrap();
            for t in [0.0, 0.1, 0.7, 1.0, 2.5, 9.0, 60.0] {
                assert!((student_above(degrees, t) - theirs.sf(t)).abs() < 1e-12, "{degrees} {t}");
            }
        }
        // One degree of freedom: Cauchy's.
        assert!(close(student_above(1.0, 1.0), 0.25, 1e-13));
    }
}
