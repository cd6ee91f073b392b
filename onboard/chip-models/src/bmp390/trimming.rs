//! The chip's trimming coefficients, and its converter's output for given air: the formulas of
//! BST-BMP390-DS002, section 8, inverted in wide integers.

use crc::{CRC_8_SAE_J1850, Crc};

use crate::source::Air;

/// CRC of the manufacturer's self-test (BMP3 sensor API): CRC-8 over the 21 bytes that follow it.
const CRC: Crc<u8> = Crc::<u8>::new(&CRC_8_SAE_J1850);

/// NVM_PAR_T1 to T3 and P1 to P11 as the chip stores them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trimming {
    /// T1, T2 (unsigned 16 bits), T3 (signed 8).
    pub t: [i32; 3],
    /// P1, P2 (signed 16), P3, P4 (signed 8), P5, P6 (unsigned 16), P7, P8 (signed 8), P9 (signed 16), P10,
    /// P11 (signed 8).
    pub p: [i32; 11],
}

impl Trimming {
    /// Coefficients of a real chip, from the tests of the Elixir library `bmp3xx`.
    pub const REAL: Self = Self {
        t: [27_427, 18_776, -10],
        p: [-164, -2_866, 35, 0, 25_578, 31_086, -13, -10, 17_322, 18, -60],
    };

    /// Registers 0x30 to 0x45: the CRC, then the coefficients, low bytes first.
    #[must_use]
    pub fn registers(&self) -> [u8; 22] {
        let mut registers = [0; 22];
        let mut bytes = registers.iter_mut().skip(1);
        for (value, width) in self.t.iter().chain(&self.p).zip([2, 2, 1, 2, 2, 1, 1, 2, 2, 1, 1, 2, 1, 1]) {
            for (byte, slot) in value.to_le_bytes().into_iter().take(width).zip(&mut bytes) {
                *slot = byte;
            }
        }
        let [crc, coefficients @ ..] = &mut registers;
        *crc = CRC.checksum(coefficients);
        registers
    }

    /// Raw pressure and temperature of this air, to the nearest count; a 24-bit converter saturates at its
    /// ends.
    #[must_use]
    pub fn raw(&self, air: Air) -> (u32, u32) {
        let wanted_t = i128::from((air.temperature_c * 1_048_576.0) as i64) << 4;
        let raw_t = nearest(|raw| self.temperature_q24(raw), wanted_t);
        let t = self.temperature_q24(raw_t);
        let wanted_p = i128::from((air.pressure_pa * 1_024.0) as i64) << 50;
        let raw_p = nearest(|raw| self.pressure_q60(raw, t), wanted_p);
        (raw_p, raw_t)
    }

    /// Degrees times 2^24.
    fn temperature_q24(&self, raw: u32) -> i128 {
        let [t1, t2, t3] = self.t.map(i128::from);
        let above = i128::from(raw) - t1 * 256;
        ((t2 * above) << 18 >> 24) + ((t3 * above * above) >> 24)
    }

    /// Pascals times 2^60, at degrees times 2^24.
    fn pressure_q60(&self, raw: u32, t: i128) -> i128 {
        let [p1, p2, p3, p4, p5, p6, p7, p8, p9, p10, p11] = self.p.map(i128::from);
        let raw = i128::from(raw);
        let (t2, t3) = (t * t, t * t * t);
        let offset = (p5 << 63) + ((p6 * t) << 30) + ((p7 * t2) << 4) + ((p8 * t3) >> 27);
        let sensitivity =
            ((p1 - 16_384) << 40) + (((p2 - 16_384) * t) << 7) + ((p3 * t2) >> 20) + ((p4 * t3) >> 49);
        let square = (raw * raw * ((p9 << 24) + p10 * t)) >> 12;
        let cube = (raw * raw * raw * p11) >> 5;
        offset + raw * sensitivity + square + cube
    }
}

/// The count at which a monotonic function is nearest to a value.
fn nearest(function: impl Fn(u32) -> i128, wanted: i128) -> u32 {
    let (mut low, mut high) = (0u32, 0xFF_FFFF);
    let rising = function(high) > function(low);
    while high - low > 1 {
        let middle = low.midpoint(high);
        if (function(middle) <= wanted) == rising {
            low = middle;
        } else {
            high = middle;
        }
    }
    let distance = |raw: u32| (function(raw) - wanted).abs();
    if distance(low) <= distance(high) { low } else { high }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The data of the same library's test, computed backwards from its result.
    #[test]
    fn published_vector() {
        let air = Air { pressure_pa: 100_876.01, temperature_c: 30.499_314 };
        let (raw_p, raw_t) = Trimming::REAL.raw(air);
        // f32 holds the temperature to 2e-6 degrees and the pressure to 0.004 Pa: under a count each.
        assert!(raw_t.abs_diff(u32::from_le_bytes([115, 216, 133, 0])) <= 1, "{raw_t}");
        assert!(raw_p.abs_diff(u32::from_le_bytes([151, 159, 109, 0])) <= 1, "{raw_p}");
    }
}
