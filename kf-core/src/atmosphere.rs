//! The standard atmosphere (ICAO Doc 7488, third edition), troposphere and lower stratosphere.

/// Standard gravity, m/s^2.
pub const STANDARD_GRAVITY_MPS2: f32 = 9.806_65;
/// Pressure at mean sea level, Pa.
pub const SEA_LEVEL_PRESSURE_PA: f32 = 101_325.0;
/// Temperature at mean sea level, K.
pub const SEA_LEVEL_TEMPERATURE_K: f32 = 288.15;
/// Temperature lapse rate of the troposphere, K/m.
pub const LAPSE_RATE_K_PER_M: f32 = 0.006_5;
/// Specific gas constant of dry air, J/(kg K).
pub const AIR_GAS_CONSTANT: f32 = 287.052_87;
/// Geopotential altitude of the tropopause, m.
pub const TROPOPAUSE_ALTITUDE_M: f32 = 11_000.0;

/// Pressure at the tropopause, Pa.
const TROPOPAUSE_PRESSURE_PA: f32 = 22_632.04;
/// Temperature of the lower stratosphere, K.
const TROPOPAUSE_TEMPERATURE_K: f32 = 216.65;
/// R L / g: the exponent of the troposphere's pressure profile, inverted.
const TROPOSPHERE_EXPONENT: f32 = 0.190_263_1;

/// Pressure altitude in metres of a static pressure in pascals (ICAO Doc 7488, eqs 4 and 5 inverted).
///
/// `None` for a pressure that is not finite and positive.
#[must_use]
pub fn pressure_altitude_m(pressure_pa: f32) -> Option<f32> {
    if !pressure_pa.is_finite() || pressure_pa <= 0.0 {
        return None;
    }
    if pressure_pa >= TROPOPAUSE_PRESSURE_PA {
        // Not `powf`: libm's version calls its square root, which is not allowed in a tick.
        let ratio = libm::expf(TROPOSPHERE_EXPONENT * libm::logf(pressure_pa / SEA_LEVEL_PRESSURE_PA));
        Some((1.0 - ratio) * (SEA_LEVEL_TEMPERATURE_K / LAPSE_RATE_K_PER_M))
    } else {
        let scale_m = AIR_GAS_CONSTANT * TROPOPAUSE_TEMPERATURE_K / STANDARD_GRAVITY_MPS2;
        Some(TROPOPAUSE_ALTITUDE_M - scale_m * libm::logf(pressure_pa / TROPOPAUSE_PRESSURE_PA))
    }
}

/// Static pressure in pascals at a pressure altitude in metres (ICAO Doc 7488, eqs 4 and 5): the inverse of
/// [`pressure_altitude_m`], to the rounding of f32.
///
/// `None` for an altitude that is not finite, or at which the standard atmosphere has no pressure that f32
/// can hold.
#[must_use]
pub fn static_pressure_pa(altitude_m: f32) -> Option<f32> {
    if !altitude_m.is_finite() {
        return None;
    }
    let pressure_pa = if altitude_m <= TROPOPAUSE_ALTITUDE_M {
        let ratio = 1.0 - altitude_m * (LAPSE_RATE_K_PER_M / SEA_LEVEL_TEMPERATURE_K);
        SEA_LEVEL_PRESSURE_PA * libm::expf(libm::logf(ratio) / TROPOSPHERE_EXPONENT)
    } else {
        let scale_m = AIR_GAS_CONSTANT * TROPOPAUSE_TEMPERATURE_K / STANDARD_GRAVITY_MPS2;
        TROPOPAUSE_PRESSURE_PA * libm::expf((TROPOPAUSE_ALTITUDE_M - altitude_m) / scale_m)
    };
    (pressure_pa.is_finite() && pressure_pa > 0.0).then_some(pressure_pa)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ICAO Doc 7488 table: geopotential altitude (m), pressure (Pa).
    const TABLE: [(f32, f32); 6] = [
        (-500.0, 107_477.0),
        (0.0, 101_325.0),
        (2_000.0, 79_495.2),
        (5_000.0, 54_019.9),
        (11_000.0, 22_632.0),
        (15_000.0, 12_044.6),
    ];

    #[test]
    fn agrees_with_the_icao_table() {
        for (altitude_m, pressure_pa) in TABLE {
            let got = pressure_altitude_m(pressure_pa).unwrap();
            // The table prints six digits. The tolerance is half of the last one, converted to altitude by dh
            // = -H dp / p with a scale height H of at most 8,700 m; and f32 keeps 44,331 m to 4 mm.
            let last_digit_pa = 10.0_f32.powi(pressure_pa.log10().floor() as i32 - 5);
            let resolution_m = 0.5 * last_digit_pa / pressure_pa * 8_700.0 + 0.01;
            assert!((got - altitude_m).abs() < resolution_m, "{altitude_m}: {got}");
        }
    }

    #[test]
    fn there_and_back_is_the_same() {
        for altitude_m in [-500.0, -1.0, 0.0, 0.5, 1_234.5, 8_848.0, 10_999.0, 11_001.0, 20_000.0_f32] {
            let back = pressure_altitude_m(static_pressure_pa(altitude_m).unwrap()).unwrap();
            // f32 keeps 44,331 m to 4 mm, and pressure to 6e-8 of itself (half a millimetre).
            assert!((back - altitude_m).abs() < 0.01, "{altitude_m}: {back}");
        }
        for (altitude_m, pressure_pa) in TABLE {
            let got = static_pressure_pa(altitude_m).unwrap();
            assert!((got / pressure_pa - 1.0).abs() < 1e-5, "{altitude_m}: {got}");
        }
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e9] {
            assert_eq!(static_pressure_pa(bad), None, "{bad}");
        }
    }

    #[test]
    fn refuses_what_is_no_pressure() {
        for bad in [f32::NAN, f32::INFINITY, 0.0, -1.0] {
            assert_eq!(pressure_altitude_m(bad), None);
        }
    }
}
