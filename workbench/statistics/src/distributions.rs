//! Distribution functions that give the same bits on every platform: they use `libm` and nothing that depends
//! on the platform.

/// Largest number of terms of a series or fraction; enough for some ten standard deviations at a million
/// degrees of freedom.
const TERMS: u32 = 20_000;
/// Largest number of bisection steps: more than an f64 has bits.
const HALVINGS: u32 = 1100;

/// Probability of a standard normal value above `x`.
#[must_use]
pub fn normal_above(x: f64) -> f64 {
    0.5 * libm::erfc(x * std::f64::consts::FRAC_1_SQRT_2)
}

/// Quantile of the standard normal distribution: a value is below it with a probability of `p` in (0, 1).
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

/// Probability that a chi-squared value with this many degrees of freedom, not necessarily whole, lies above
/// `x`.
#[must_use]
pub fn chi_squared_above(degrees: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    gamma_tails(0.5 * degrees, 0.5 * x)[1]
}

/// Quantile of the chi-squared distribution with this many degrees of freedom: a value is below it with a
/// probability of `p` in (0, 1).
#[must_use]
pub fn chi_squared_quantile(degrees: f64, p: f64) -> f64 {
    // Use the nearer tail, which keeps its digits.
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

/// Probability that a value of Student's distribution with this many degrees of freedom lies above `t >= 0`.
#[must_use]
pub fn student_above(degrees: f64, t: f64) -> f64 {
    0.5 * beta_below(0.5 * degrees, 0.5, degrees / (degrees + t * t))
}

/// Bisects for the value up to which a condition holds.
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

/// The regularised incomplete gamma functions P and Q: shares of the gamma distribution of shape `a` below
/// and above `x > 0`.
///
/// Source: Press et al., "Numerical Recipes", 3rd edition, section 6.2: the series below the mean, Lentz's
/// continued fraction above it.
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

/// A continued fraction `first + n1 / (d1 + n2 / (d2 + ...))` with the terms (n, d) from 1 on, by Lentz's
/// method.
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
    use super::*;

    // The values are mpmath's, to 40 digits: erfc(x / sqrt(2)) / 2, gammainc(d / 2, x / 2, inf,
    // regularized=True), betainc(d / 2, 1 / 2, 0, d / (d + t^2), regularized=True) / 2.

    /// Whether two values differ by at most this many roundings.
    fn close(own: f64, exact: f64, roundings: f64) -> bool {
        (own - exact).abs() <= roundings * f64::EPSILON * exact.abs()
    }

    #[test]
    fn the_normal_distribution_is_exact_but_for_roundings() {
        for (x, above) in [
            (-8.0, 0.999_999_999_999_999_4),
            (-3.1, 0.999_032_396_786_781_6),
            (-1.0, 0.841_344_746_068_542_9),
            (0.0, 0.5),
            (0.3, 0.382_088_577_811_047_4),
            (2.0, 0.022_750_131_948_179_21),
            (5.5, 1.898_956_246_588_772e-8),
            (8.0, 6.220_960_574_271_784e-16),
            (20.0, 2.753_624_118_606_233_7e-89),
            (37.0, 5.725_571_222_524_577e-300),
        ] {
            // The tail decreases as exp(-x^2 / 2), so one rounding of x / sqrt(2) becomes x^2 of it.
            assert!(close(normal_above(x), above, 4.0 + x * x), "{x}: {}", normal_above(x));
        }
        for (p, x) in [
            (1e-300, -37.047_096_299_361_2),
            (1e-100, -21.273_453_560_965_324),
            (1e-12, -7.034_483_825_301_132),
            (0.001, -3.090_232_306_167_813_5),
            (0.025, -1.959_963_984_540_054_2),
            (0.3, -0.524_400_512_708_040_8),
        ] {
            // The tail's error over its slope there: about x for large ones, and p over the density for small
            // ones.
            let square: f64 = x * x;
            let roundings = (4.0 + square) / square.min(1.0) + 8.0;
            assert!(close(normal_quantile(p), x, roundings), "{p}: {}", normal_quantile(p));
            if p > 0.01 {
                assert!(close(normal_quantile(1.0 - p), -x, roundings + 1.0 / (p * x * x)), "{p}");
            }
        }
    }

    /// Roundings of `exp(a ln x - x - ln gamma(a))`: each of the three is rounded before they cancel. Some
    /// tens of terms contribute near it.
    fn gamma_roundings(a: f64, x: f64) -> f64 {
        4.0 * ((a * libm::log(x)).abs() + x + libm::lgamma(a).abs()) + 100.0
    }

    #[test]
    fn chi_squared_is_exact_but_for_roundings() {
        for (degrees, share, above) in [
            (0.7, 0.3, 0.503_595_223_020_109_8),
            (0.7, 1.4, 0.222_848_509_693_372_64),
            (1.0, 0.99, 0.319_742_374_492_273_44),
            (2.0, 1.02, 0.360_594_940_173_078_3),
            (15.0, 0.3, 0.995_580_016_195_957_2),
            (15.0, 0.99, 0.462_275_063_508_091_86),
            (80.5, 0.3, 0.999_999_999_862_995),
            (80.5, 1.4, 0.010_377_232_101_242_628),
            (3000.0, 0.99, 0.648_020_964_529_755_4),
            (3000.0, 1.4, 1.055_949_656_471_337_1e-43),
            (2e5, 0.99, 0.999_242_580_078_825_2),
            (2e5, 1.02, 1.650_606_135_936_283_4e-10),
        ] {
            let x = share * degrees;
            let roundings = gamma_roundings(0.5 * degrees, 0.5 * x);
            // Below the mean it is one minus the other tail.
            let scale = if share < 1.0 { (1.0 - above) / above + 1.0 } else { 1.0 };
            let own = chi_squared_above(degrees, x);
            assert!(close(own, above, roundings * scale), "{degrees} {x}: {own}");
        }
        for degrees in [0.7, 1.0, 2.0, 15.0, 80.5, 3000.0, 2e5] {
            for p in [0.001, 0.025, 0.5, 0.975, 0.9999] {
                let x = chi_squared_quantile(degrees, p);
                let wrong = 1.0 - chi_squared_above(degrees, x) - p;
                assert!(
                    wrong.abs() < gamma_roundings(0.5 * degrees, 0.5 * x) * f64::EPSILON,
                    "{degrees} {p}: {x}"
                );
            }
        }
    }

    #[test]
    fn students_distribution_is_exact_but_for_roundings() {
        for (degrees, t, above) in [
            (1.0, 0.1, 0.468_274_482_569_446_4),
            (1.0, 1.0, 0.25),
            (1.0, 60.0, 0.005_304_673_632_623_27),
            (2.0, 2.5, 0.064_805_860_110_755_4),
            (5.0, 0.1, 0.462_115_070_577_330_2),
            (5.0, 9.0, 0.000_141_339_987_121_948_53),
            (30.0, 1.0, 0.162_654_307_713_014_95),
            (30.0, 60.0, 4.155_654_806_766_124e-33),
            (400.0, 2.5, 0.006_409_433_381_715_789),
            (400.0, 9.0, 4.615_731_492_807_223e-18),
            (400.0, 60.0, 2.100_716_404_404_202_6e-202),
        ] {
            let (a, x) = (0.5 * degrees, degrees / (degrees + t * t));
            let front = libm::lgamma(a + 0.5).abs() + libm::lgamma(a).abs() + (a * libm::log(x)).abs();
            let own = student_above(degrees, t);
            // The error of x is multiplied by its exponent.
            assert!(close(own, above, 4.0 * front + 2.0 * a + 100.0), "{degrees} {t}: {own}");
        }
    }
}
