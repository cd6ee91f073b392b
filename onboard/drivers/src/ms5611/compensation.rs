//! Converts raw data to pressure and temperature (datasheet, figures 2 and 3).
//!
//! Computed in 64-bit integers like the datasheet, but without its roundings: the datasheet shifts every
//! intermediate down to a hundredth of a degree and to one pascal; here each keeps its fraction. Every
//! product below fits for every calibration and every conversion: bounds are in the comments.

use super::Prom;
use crate::error::SensorError;

/// Hundredths of a degree Celsius (datasheet: -40 to +85).
const TEMPERATURE_RANGE: core::ops::RangeInclusive<i64> = -4_000..=8_500;
/// Pascals (datasheet: 10 to 1200 mbar).
const PRESSURE_RANGE_PA: core::ops::RangeInclusive<i64> = 1_000..=120_000;

/// A pair of conversions, compensated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensated {
    /// Pressure, pascals, to the last bit of an f32 (1/128 Pa at sea level).
    pub pressure_pa: f32,
    /// Temperature of the chip, degrees Celsius.
    pub temperature_c: f32,
}

impl Prom {
    /// Pressure and temperature of the conversions `d1` (pressure) and `d2` (temperature), 24 bits each.
    ///
    /// # Errors
    /// [`SensorError::OutOfRange`] outside -40 to 85 degrees or 10 to 1200 mbar.
    pub fn compensate(&self, d1: u32, d2: u32) -> Result<Compensated, SensorError> {
        let [c1, c2, c3, c4, c5, c6] = self.c.map(i64::from);
        let dt = i64::from(d2) - (c5 << 8);
        // Degrees below or above 20, in hundredths times 2^23: |dt| < 2^25, c6 < 2^16.
        let above_20_q23 = dt * c6;
        // The second order only cools, so this rejects nothing that the later check would accept; it bounds
        // the squares.
        if !TEMPERATURE_RANGE.contains(&(2_000 + (above_20_q23 >> 23))) {
            return Err(SensorError::OutOfRange);
        }
        let mut above_q23 = above_20_q23;
        // OFF times 2^7 and SENS times 2^8: exact, below 2^42.
        let mut offset_q7 = (c2 << 23) + c4 * dt;
        let mut sensitivity_q8 = (c1 << 23) + c3 * dt;
        if above_20_q23 < 0 {
            // T2 = dt^2 / 2^31, in 2^-23 hundredths.
            above_q23 -= (dt * dt) >> 8;
            // (TEMP - 2000)^2 times 2^16: below 2^42 inside the range checked above.
            let below_20_q8 = above_20_q23 >> 15;
            let squared_q16 = below_20_q8 * below_20_q8;
            // OFF2 = 5/2 squared, SENS2 = 5/4 squared.
            let mut offset_2 = (5 * squared_q16) >> 10;
            let mut sensitivity_2 = (5 * squared_q16) >> 10;
            let below_minus_15_q8 = below_20_q8 + (3_500 << 8);
            if below_minus_15_q8 < 0 {
                let squared_q16 = below_minus_15_q8 * below_minus_15_q8;
                // OFF2 += 7 squared, SENS2 += 11/2 squared.
                offset_2 += (7 * squared_q16) >> 9;
                sensitivity_2 += (11 * squared_q16) >> 9;
            }
            offset_q7 -= offset_2;
            sensitivity_q8 -= sensitivity_2;
        }
        if !TEMPERATURE_RANGE.contains(&(2_000 + (above_q23 >> 23))) {
            return Err(SensorError::OutOfRange);
        }
        // P = (D1 SENS / 2^21 - OFF) / 2^15. D1 < 2^24 and SENS 2^4 < 2^38.
        let pressure_q23 = ((i64::from(d1) * (sensitivity_q8 >> 4)) >> 17) - (offset_q7 << 1);
        if !PRESSURE_RANGE_PA.contains(&(pressure_q23 >> 23)) {
            return Err(SensorError::OutOfRange);
        }
        Ok(Compensated {
            pressure_pa: pressure_q23 as f32 / 8_388_608.0,
            temperature_c: 20.0 + above_q23 as f32 / 838_860_800.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::prom::EXAMPLE;
    use super::*;

    fn example(d1: u32, d2: u32) -> Result<Compensated, SensorError> {
        Prom::new(EXAMPLE).unwrap().compensate(d1, d2)
    }

    /// The datasheet's arithmetic with its shifts: hundredths of a degree, pascals. It truncates TEMP to a
    /// hundredth; `cut` is added to that before the squares.
    fn as_printed(d1: i64, d2: i64, cut: i64) -> (i64, i64) {
        let [c1, c2, c3, c4, c5, c6] = [40_127i64, 36_924, 23_317, 23_282, 33_464, 28_312];
        let dt = d2 - (c5 << 8);
        let mut temp = 2_000 + ((dt * c6) >> 23);
        let mut off = (c2 << 16) + ((c4 * dt) >> 7);
        let mut sens = (c1 << 15) + ((c3 * dt) >> 8);
        if temp < 2_000 {
            let t2 = (dt * dt) >> 31;
            let squared = temp + cut;
            let mut off2 = 5 * (squared - 2_000).pow(2) / 2;
            let mut sens2 = 5 * (squared - 2_000).pow(2) / 4;
            if temp < -1_500 {
                off2 += 7 * (squared + 1_500).pow(2);
                sens2 += 11 * (squared + 1_500).pow(2) / 2;
            }
            temp -= t2;
            off -= off2;
            sens -= sens2;
        }
        (temp, (((d1 * sens) >> 21) - off) >> 15)
    }

    /// The result lies between those of the printed arithmetic with TEMP truncated and with TEMP rounded up.
    fn assert_as_printed(d1: u32, d2: u32, found: Compensated) {
        let [(low_t, at_low), (_, at_high)] = [0, 1].map(|cut| as_printed(i64::from(d1), i64::from(d2), cut));
        let pressures = (at_low.min(at_high) - 1) as f32..=(at_low.max(at_high) + 1) as f32;
        assert!(pressures.contains(&found.pressure_pa), "{d1} {d2}: {found:?}, not in {pressures:?}");
        let hundredths = (low_t - 1) as f32 - 0.01..=(low_t + 2) as f32;
        assert!(
            hundredths.contains(&(found.temperature_c * 100.0)),
            "{d1} {d2}: {found:?}, not in {hundredths:?}"
        );
    }

    /// The datasheet's example (figure 2), and two colder ones that the tests of Cleanflight and Betaflight
    /// compute from the same calibration: hundredths of a degree, pascals.
    #[test]
    fn published_vectors() {
        for (d1, d2, printed) in [
            (9_085_466, 8_569_150, (2_007, 100_009)),
            (9_085_466, 8_069_150, (205, 96_512)),
            (9_085_466, 7_369_150, (-2_710, 90_613)),
        ] {
            assert_eq!(as_printed(i64::from(d1), i64::from(d2), 0), printed);
            assert_as_printed(d1, d2, example(d1, d2).unwrap());
        }
    }

    #[test]
    fn agrees_with_the_printed_arithmetic_over_the_range() {
        let mut compared = 0;
        for d2 in (6_600_000..11_000_000).step_by(50_021) {
            for d1 in (3_000_000..12_000_000).step_by(100_003) {
                let Ok(found) = example(d1, d2) else { continue };
                assert_as_printed(d1, d2, found);
                compared += 1;
            }
        }
        assert!(compared > 3_000, "only {compared} pairs lie in the range");
    }

    /// One step of the converter moves the pressure by its quantum, SENS / 2^36: no rounding to a pascal.
    #[test]
    fn pascals_have_fractions() {
        let quantum = 1_315_097_036.0 / 36f32.exp2();
        let from = example(9_085_466, 8_569_150).unwrap().pressure_pa;
        let to = example(9_085_466 + 10, 8_569_150).unwrap().pressure_pa;
        assert!((to - from - 10.0 * quantum).abs() <= 1.0 / 128.0, "{}", to - from);
    }

    #[test]
    fn values_that_the_chip_can_not_measure_are_refused() {
        assert_eq!(example(9_085_466, 0), Err(SensorError::OutOfRange));
        assert_eq!(example(9_085_466, 0xFF_FFFF), Err(SensorError::OutOfRange));
        assert_eq!(example(1, 8_569_150), Err(SensorError::OutOfRange));
        assert_eq!(example(0xFF_FFFF, 8_569_150), Err(SensorError::OutOfRange));
    }

    proptest::proptest! {
        /// No calibration and no conversion overflows (the profile of tests checks arithmetic).
        #[test]
        fn any_input_gives_a_value_or_an_error(
            c in proptest::array::uniform6(proptest::prelude::any::<u16>()),
            d1 in 0u32..1 << 24,
            d2 in 0u32..1 << 24,
        ) {
            if let Ok(found) = (Prom { c }).compensate(d1, d2) {
                proptest::prop_assert!((1_000.0..=120_001.0).contains(&found.pressure_pa));
            }
        }
    }
}
