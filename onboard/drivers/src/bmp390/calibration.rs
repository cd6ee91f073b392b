//! The trimming coefficients, and the conversion of raw data to pressure and temperature (BST-BMP390-DS002,
//! revision 1.7, section 8).
//!
//! The datasheet gives the formulas in floating point; in single precision they lose more than the chip's
//! resolution (0.016 Pa). Here they are evaluated in 64-bit integers, in Horner's form. Every sum and product
//! fits for every coefficient and every raw value.

use crc::{CRC_8_SAE_J1850, Crc};

use crate::error::SensorError;

/// Registers 0x30 (the CRC) to 0x45.
pub(super) const BYTES: usize = 22;

/// The CRC of the coefficients, as the manufacturer's self-test computes it (BMP3 sensor API,
/// `bmp3_selftest.c`).
const CRC: Crc<u8> = Crc::<u8>::new(&CRC_8_SAE_J1850);

/// Degrees Celsius times 2^20 (datasheet: -40 to 85).
const TEMPERATURE_RANGE_Q20: core::ops::RangeInclusive<i64> = -40 << 20..=85 << 20;
/// Pascals (datasheet: 300 to 1250 hPa).
const PRESSURE_RANGE_PA: core::ops::RangeInclusive<i64> = 30_000..=125_000;

/// Compensated data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensated {
    /// Pressure, pascals.
    pub pressure_pa: f32,
    /// Temperature of the chip, degrees Celsius.
    pub temperature_c: f32,
}

/// NVM_PAR_T1 to T3 and P1 to P11 (section 3.11.1), their CRC checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Calibration {
    t: [i64; 3],
    p: [i64; 11],
}

impl Calibration {
    /// Reads the registers 0x30 to 0x45.
    ///
    /// # Errors
    /// [`SensorError::Check`] for a wrong CRC.
    pub fn new(registers: [u8; BYTES]) -> Result<Self, SensorError> {
        let [crc, coefficients @ ..] = registers;
        if CRC.checksum(&coefficients) != crc {
            return Err(SensorError::Check);
        }
        let [
            t1l,
            t1h,
            t2l,
            t2h,
            t3,
            p1l,
            p1h,
            p2l,
            p2h,
            p3,
            p4,
            p5l,
            p5h,
            p6l,
            p6h,
            p7,
            p8,
            p9l,
            p9h,
            p10,
            p11,
        ] = coefficients;
        let unsigned = |low, high| i64::from(u16::from_le_bytes([low, high]));
        let signed = |low, high| i64::from(i16::from_le_bytes([low, high]));
        let byte = |value| i64::from(i8::from_le_bytes([value]));
        Ok(Self {
            t: [unsigned(t1l, t1h), unsigned(t2l, t2h), byte(t3)],
            p: [
                signed(p1l, p1h),
                signed(p2l, p2h),
                byte(p3),
                byte(p4),
                unsigned(p5l, p5h),
                unsigned(p6l, p6h),
                byte(p7),
                byte(p8),
                signed(p9l, p9h),
                byte(p10),
                byte(p11),
            ],
        })
    }

    /// Pressure and temperature of raw data, 24 bits each.
    ///
    /// # Errors
    /// [`SensorError::OutOfRange`] outside -40 to 85 degrees or 300 to 1250 hPa.
    pub fn compensate(&self, raw_pressure: u32, raw_temperature: u32) -> Result<Compensated, SensorError> {
        let [t1, t2, t3] = self.t;
        let above = i64::from(raw_temperature & 0xFF_FFFF) - (t1 << 8);
        let t_q20 = ((t2 * above) >> 10) + ((t3 * above * above) >> 28);
        if !TEMPERATURE_RANGE_Q20.contains(&t_q20) {
            return Err(SensorError::OutOfRange);
        }
        // |t| < 2^27, t^2 < 2^40, t^3 < 2^41.
        let squared_q26 = (t_q20 * t_q20) >> 14;
        let cubed_q20 = ((squared_q26 >> 6) * t_q20) >> 20;
        let [p1, p2, p3, p4, p5, p6, p7, p8, p9, p10, p11] = self.p;
        let raw = i64::from(raw_pressure & 0xFF_FFFF);
        // Coefficients of raw^2 (times 2^64), raw (times 2^40) and 1 (times 2^40).
        let quadratic_q64 = (p9 << 16) + ((p10 * t_q20) >> 4);
        let linear_q40 = ((p1 - 16_384) << 20)
            + (((p2 - 16_384) * t_q20) >> 9)
            + ((p3 * squared_q26) >> 18)
            + ((p4 * cubed_q20) >> 17);
        let constant_q40 =
            (p5 << 43) + ((p6 * t_q20) << 14) + ((p7 * squared_q26) << 6) + ((p8 * cubed_q20) << 5);
        let slope_q64 = ((p11 * raw) >> 1) + quadratic_q64;
        let slope_q40 = ((slope_q64 * raw) >> 24) + linear_q40;
        let pressure_q40 = slope_q40 * raw + constant_q40;
        if !PRESSURE_RANGE_PA.contains(&(pressure_q40 >> 40)) {
            return Err(SensorError::OutOfRange);
        }
        Ok(Compensated {
            pressure_pa: (pressure_q40 >> 17) as f32 / 8_388_608.0,
            temperature_c: t_q20 as f32 / 1_048_576.0,
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A real chip's coefficients, from the tests of the Elixir library `bmp3xx`.
    const PUBLISHED_T: [i64; 3] = [27_427, 18_776, -10];
    const PUBLISHED_P: [i64; 11] = [-164, -2_866, 35, 0, 25_578, 31_086, -13, -10, 17_322, 18, -60];

    /// The same coefficients as registers.
    pub(in super::super) fn registers() -> [u8; BYTES] {
        registers_of(PUBLISHED_P)
    }

    /// Registers of a chip with these pressure coefficients.
    fn registers_of(p: [i64; 11]) -> [u8; BYTES] {
        let mut registers = [0; BYTES];
        let widths = [2, 2, 1, 2, 2, 1, 1, 2, 2, 1, 1, 2, 1, 1];
        let mut at = 1;
        for (value, width) in PUBLISHED_T.into_iter().chain(p).zip(widths) {
            registers[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
            at += width;
        }
        registers[0] = CRC.checksum(&registers[1..]);
        registers
    }

    fn published() -> Calibration {
        Calibration::new(registers()).unwrap()
    }

    /// Sections 8.4 to 8.6 as printed, in double precision.
    fn as_printed(p: [i64; 11], raw_p: f64, raw_t: f64) -> (f64, f64) {
        let [t1, t2, t3] = PUBLISHED_T.map(|value| value as f64);
        let [p1, p2, p3, p4, p5, p6, p7, p8, p9, p10, p11] = p.map(|value| value as f64);
        let d = raw_t - t1 * 256.0;
        let t = d * t2 / 2f64.powi(30) + d * d * t3 / 2f64.powi(48);
        let out1 =
            p5 * 8.0 + p6 / 2f64.powi(6) * t + p7 / 2f64.powi(8) * t * t + p8 / 2f64.powi(15) * t.powi(3);
        let sensitivity = (p1 - 16_384.0) / 2f64.powi(20)
            + (p2 - 16_384.0) / 2f64.powi(29) * t
            + p3 / 2f64.powi(32) * t * t
            + p4 / 2f64.powi(37) * t.powi(3);
        let out3 = raw_p * raw_p * (p9 / 2f64.powi(48) + p10 / 2f64.powi(48) * t)
            + raw_p.powi(3) * p11 / 2f64.powi(65);
        (out1 + raw_p * sensitivity + out3, t)
    }

    #[test]
    fn registers_are_read_as_they_are_written() {
        let calibration = published();
        assert_eq!((calibration.t, calibration.p), (PUBLISHED_T, PUBLISHED_P));
    }

    /// The same library's data and result.
    #[test]
    fn published_vector() {
        let raw_pressure = u32::from_le_bytes([151, 159, 109, 0]);
        let raw_temperature = u32::from_le_bytes([115, 216, 133, 0]);
        let (pressure, temperature) =
            as_printed(PUBLISHED_P, f64::from(raw_pressure), f64::from(raw_temperature));
        assert!((pressure - 100_876.006_346_921_99).abs() < 1e-6, "{pressure}");
        assert!((temperature - 30.499_314_453_874_284).abs() < 1e-9, "{temperature}");
        let found = published().compensate(raw_pressure, raw_temperature).unwrap();
        assert!((f64::from(found.pressure_pa) - pressure).abs() < 1.0 / 128.0, "{found:?}");
        assert!((f64::from(found.temperature_c) - temperature).abs() < 3e-6, "{found:?}");
    }

    /// The published chip, whose P4 is 0, and the same chip with the largest P4 of either sign.
    #[test]
    fn agrees_with_the_printed_formulas_over_the_range() {
        for p4 in [0, 127, -128] {
            let mut p = PUBLISHED_P;
            p[3] = p4;
            agrees_with_the_printed_formulas(p);
        }
    }

    fn agrees_with_the_printed_formulas(p: [i64; 11]) {
        let calibration = Calibration::new(registers_of(p)).unwrap();
        let (mut compared, mut worst) = (0, 0f64);
        for raw_t in (5_000_000u32..12_000_000).step_by(70_001) {
            for raw_p in (3_000_000u32..12_000_000).step_by(90_001) {
                let Ok(found) = calibration.compensate(raw_p, raw_t) else { continue };
                let (pressure, temperature) = as_printed(p, f64::from(raw_p), f64::from(raw_t));
                worst = worst.max((f64::from(found.pressure_pa) - pressure).abs());
                assert!((f64::from(found.temperature_c) - temperature).abs() < 6e-6);
                compared += 1;
            }
        }
        assert!(compared > 2_000, "only {compared} pairs lie in the range");
        // Half of the last bit of an f32 at 1000 hPa is 1/256 Pa.
        assert!(worst < 1.0 / 200.0, "{worst}");
    }

    #[test]
    fn every_flipped_bit_is_found() {
        for bit in 0..8 * BYTES {
            let mut registers = registers();
            registers[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Calibration::new(registers), Err(SensorError::Check), "bit {bit}");
        }
    }

    proptest::proptest! {
        /// No coefficient and no data overflows (the profile of tests checks arithmetic).
        #[test]
        fn any_input_gives_a_value_or_an_error(
            bytes in proptest::collection::vec(proptest::prelude::any::<u8>(), BYTES),
            raw_pressure in 0u32..1 << 24,
            raw_temperature in 0u32..1 << 24,
        ) {
            let mut registers = [0; BYTES];
            registers.copy_from_slice(&bytes);
            registers[0] = CRC.checksum(&registers[1..]);
            if let Ok(found) = Calibration::new(registers).unwrap().compensate(raw_pressure, raw_temperature) {
                proptest::prop_assert!((30_000.0..=125_001.0).contains(&found.pressure_pa));
            }
        }
    }
}
