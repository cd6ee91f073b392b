//! Sine and cosine in single precision throughout: `libm`'s compute in double precision, for which the flight
//! computer has no hardware.

use core::f32::consts::FRAC_2_PI;

/// Largest angle, rad: up to here the reduction is without loss.
pub const LARGEST_ANGLE_RAD: f32 = 1_000.0;

/// Pi/2 in parts of few bits each, so that small multiples of them are exact (Cody and Waite, "Software
/// Manual for the Elementary Functions", 1980; the parts are twice those of Moshier's Cephes, `sinf.c`).
const HALF_PI: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];

/// Sine and cosine of an angle in radians, each within 1.2e-7; `None` beyond [`LARGEST_ANGLE_RAD`] and if the
/// angle is not finite.
///
/// Minimax polynomials over a quarter turn: Moshier, Cephes Mathematical Library, `sinf.c`.
#[must_use]
pub fn sine_and_cosine(angle_rad: f32) -> Option<(f32, f32)> {
    if !(-LARGEST_ANGLE_RAD..=LARGEST_ANGLE_RAD).contains(&angle_rad) {
        return None;
    }
    let turns = angle_rad * FRAC_2_PI;
    let quarter = (if turns >= 0.0 { turns + 0.5 } else { turns - 0.5 }) as i32;
    let [large, middle, small] = HALF_PI;
    let quarters = quarter as f32;
    let x = ((angle_rad - quarters * large) - quarters * middle) - quarters * small;
    let z = x * x;
    let sine = ((-1.951_529_6e-4 * z + 8.332_161e-3) * z - 0.166_666_55) * z * x + x;
    let cosine = ((2.443_315_7e-5 * z - 1.388_731_6e-3) * z + 4.166_664_6e-2) * z * z - 0.5 * z + 1.0;
    Some(match quarter & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_double_precision() {
        for k in -200_000..=200_000 {
            let angle = k as f32 * 5e-3;
            let (sine, cosine) = sine_and_cosine(angle).unwrap();
            let exact = f64::from(angle).sin_cos();
            assert!((f64::from(sine) - exact.0).abs() < 1.2e-7, "sin {angle}: {sine} {}", exact.0);
            assert!((f64::from(cosine) - exact.1).abs() < 1.2e-7, "cos {angle}: {cosine} {}", exact.1);
        }
    }

    #[test]
    fn refuses_what_is_no_angle() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1_001.0, f32::MIN] {
            assert_eq!(sine_and_cosine(bad), None);
        }
    }
}
