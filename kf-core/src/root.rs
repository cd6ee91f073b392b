//! Reciprocal square root without a square root: `libm`'s is computed bit by bit, and no tick uses it.

/// `1 / sqrt(x)`, within a relative error of 3e-7, for a positive, finite `x` that is not subnormal.
///
/// A first guess from the exponent (C. Lomont, "Fast Inverse Square Root", Purdue University 2003) is within
/// 3.5 %; each of Newton's steps squares the error: 0.18 %, 5e-6, rounding.
#[must_use]
pub fn reciprocal_root(x: f32) -> f32 {
    let guess = f32::from_bits(0x5f37_5a86_u32.wrapping_sub(x.to_bits() >> 1));
    (0..3).fold(guess, |root, _| root * (1.5 - 0.5 * x * root * root))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn is_the_reciprocal_root(x in 1e-30_f32..1e30) {
            let exact = 1.0 / f64::from(x).sqrt();
            prop_assert!((f64::from(reciprocal_root(x)) / exact - 1.0).abs() < 3e-7, "{x}");
        }
    }
}
