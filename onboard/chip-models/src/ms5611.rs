//! MS5611-01BA03 barometer (TE Connectivity, datasheet of 2017; CRC: application note AN520).

use crate::bus::SpiChip;
use crate::disturbance::Disturbance;
use crate::source::{Air, Source};

/// Time to reload the calibration after a reset, microseconds ("Reset sequence").
const RELOAD_US: u64 = 2_800;
/// Longest conversions at oversampling 256, 512, 1024, 2048 and 4096 ("Performance specifications"),
/// microseconds.
const CONVERSION_US: [u64; 5] = [600, 1_170, 2_280, 4_540, 9_040];

/// C1 to C6 of the datasheet's example.
pub const EXAMPLE_CALIBRATION: [u16; 6] = [40_127, 36_924, 23_317, 23_282, 33_464, 28_312];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Conversion {
    None,
    Running { result: u32, done_us: u64, spoiled: bool },
}

/// The chip.
#[derive(Clone, Debug)]
pub struct Ms5611Model<Surroundings> {
    /// The air around it, sampled in the middle of each conversion.
    pub air: Surroundings,
    /// The calibration memory, CRC included. A test may corrupt it.
    pub prom: [u16; 8],
    /// Time by which each conversion exceeds the datasheet's longest, microseconds.
    pub slower_by_us: u64,
    /// No conversion ever ends.
    pub stalled: bool,
    /// Number of conversions that never end, beginning with the next one.
    pub lose_conversions: u32,
    /// Bits of one byte of the calibration memory that read wrong: the byte's index, counted from C0's first
    /// byte, and the bits.
    pub prom_flip: Option<(u8, u8)>,
    /// Errors of its results: pressure (Pa, or bits of D1), temperature (degrees, or bits of D2).
    pub disturbance: Disturbance,
    last: [u32; 2],
    conversion: Conversion,
    ready_us: u64,
    answer: [u8; 3],
    position: usize,
}

impl<Surroundings: Source<Air>> Ms5611Model<Surroundings> {
    /// A chip with this calibration (C1 to C6).
    pub fn new(calibration: [u16; 6], air: Surroundings) -> Self {
        let [c1, c2, c3, c4, c5, c6] = calibration;
        let mut prom = [0x0042, c1, c2, c3, c4, c5, c6, 0];
        prom[7] = crc4(&prom);
        Self {
            air,
            prom,
            slower_by_us: 0,
            stalled: false,
            lose_conversions: 0,
            prom_flip: None,
            disturbance: Disturbance::NONE,
            last: [0; 2],
            conversion: Conversion::None,
            ready_us: 0,
            answer: [0; 3],
            position: 0,
        }
    }

    fn command(&mut self, now_us: u64, command: u8) {
        self.answer = [0; 3];
        if command == 0x1E {
            self.power_on_reset(now_us);
        } else if now_us >= self.ready_us {
            match command {
                0x00 => self.answer_conversion(now_us),
                0x40..=0x4F => self.convert(now_us, command & 0xF, false),
                0x50..=0x5F => self.convert(now_us, command & 0xF, true),
                0xA0..=0xAF => {
                    let word = (command >> 1) & 7;
                    let [high, low] = self.prom[usize::from(word)].to_be_bytes();
                    self.answer = [high, low, 0];
                    if let Some((byte, mask)) = self.prom_flip
                        && byte >> 1 == word
                    {
                        self.answer[usize::from(byte & 1)] ^= mask;
                    }
                }
                _ => {}
            }
        }
    }

    fn convert(&mut self, now_us: u64, oversampling: u8, temperature: bool) {
        // "Conversion sequence sent during the already started conversion process will yield incorrect
        // result".
        if let Conversion::Running { done_us, spoiled, .. } = &mut self.conversion
            && now_us < *done_us
        {
            *spoiled = true;
            return;
        }
        let index = usize::from(oversampling >> 1).min(4);
        let length_us = CONVERSION_US[index] + self.slower_by_us;
        if self.stalled || self.lose_conversions > 0 {
            self.lose_conversions = self.lose_conversions.saturating_sub(1);
            self.conversion = Conversion::None;
            return;
        }
        let channel = usize::from(temperature);
        if !self.disturbance.frozen {
            let mut air = self.air.at(now_us + length_us / 2);
            let error = self.disturbance.error(channel);
            if temperature {
                air.temperature_c += error;
            } else {
                air.pressure_pa += error;
            }
            let (d1, d2) = self.raw(air);
            self.last[channel] =
                (if temperature { d2 } else { d1 }) ^ self.disturbance.flipped(channel) & 0xFF_FFFF;
        }
        let result = self.last[channel];
        self.conversion = Conversion::Running { result, done_us: now_us + length_us, spoiled: false };
    }

    /// "Conversion sequence": reads 0 before the end, which also spoils the conversion; reads 0 the second
    /// time.
    fn answer_conversion(&mut self, now_us: u64) {
        match &mut self.conversion {
            Conversion::None => {}
            Conversion::Running { done_us, spoiled, .. } if now_us < *done_us => *spoiled = true,
            Conversion::Running { result, spoiled, .. } => {
                let wrong = if *spoiled { *result / 2 } else { *result };
                let [_, high, middle, low] = wrong.to_be_bytes();
                self.answer = [high, middle, low];
                self.conversion = Conversion::None;
            }
        }
    }

    /// D1 and D2 of this air: the datasheet's compensation, inverted, to the nearest count.
    pub fn raw(&self, air: Air) -> (u32, u32) {
        let [_, c1, c2, c3, c4, c5, c6, _] = self.prom.map(i64::from);
        // Hundredths of a degree above 20, times 2^31.
        let above_q31 = ((air.temperature_c - 20.0) * 100.0 * 65_536.0) as i64 * 32_768;
        let dt = if above_q31 >= 0 { rounded(above_q31 >> 8, c6) } else { second_order_dt(above_q31, c6) };
        let below = (dt * c6) >> 23;
        // OFF times 2^7, SENS times 2^8.
        let mut offset_q7 = (c2 << 23) + c4 * dt;
        let mut sensitivity_q8 = (c1 << 23) + c3 * dt;
        if below < 0 {
            let exact = dt * c6;
            // Squares of hundredths of a degree, times 2^16.
            let square_q16 = |from_hundredths: i64| {
                let q8 = (exact + (from_hundredths << 23)) >> 15;
                q8 * q8
            };
            offset_q7 -= square_q16(0) * 5 / 1_024;
            sensitivity_q8 -= square_q16(0) * 5 / 1_024;
            if below < -3_500 {
                offset_q7 -= square_q16(3_500) * 7 / 512;
                sensitivity_q8 -= square_q16(3_500) * 11 / 512;
            }
        }
        // D1 = (P 2^15 + OFF) 2^21 / SENS.
        let pressure_q22 = (air.pressure_pa * 4_194_304.0) as i64;
        let d1 = rounded((pressure_q22 + offset_q7) << 22, sensitivity_q8.max(1));
        (counts(d1), counts(dt + (c5 << 8)))
    }
}

/// The dT whose temperature with second-order compensation, dT C6 / 2^23 - dT^2 / 2^31, is nearest. Below 20
/// degrees it rises with dT.
fn second_order_dt(above_q31: i64, c6: i64) -> i64 {
    let temperature = |dt: i64| dt * (c6 << 8) - dt * dt;
    let (mut low, mut high) = (-1 << 24, 0);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if temperature(middle) <= above_q31 {
            low = middle;
        } else {
            high = middle;
        }
    }
    if above_q31 - temperature(low) <= temperature(high) - above_q31 { low } else { high }
}

/// The nearest integer to a quotient; the divisor is positive.
const fn rounded(dividend: i64, divisor: i64) -> i64 {
    (dividend + divisor / 2).div_euclid(divisor)
}

/// Output of a 24-bit converter: it saturates. 0 means "no result" and is never a value.
fn counts(value: i64) -> u32 {
    u32::try_from(value.clamp(1, 0xFF_FFFF)).unwrap_or(1)
}

/// AN520's CRC: the remainder of the memory's 16 bytes, the last one blanked, by x^4 + x + 1.
fn crc4(prom: &[u16; 8]) -> u16 {
    let mut remainder = 0u32;
    for (index, word) in prom.iter().enumerate() {
        let word = if index == 7 { word & 0xFF00 } else { *word };
        for byte in word.to_be_bytes() {
            // The byte enters at the register's low end, as in AN520's code; x^16 of the register is 0x3000.
            remainder = (remainder ^ u32::from(byte)) << 8;
            for bit in (16..24).rev() {
                if remainder & (1 << bit) != 0 {
                    remainder ^= 0x1_3000 << (bit - 16);
                }
            }
        }
    }
    u16::try_from(remainder >> 12).unwrap_or_default() & 0xF
}

impl<Surroundings: Source<Air>> SpiChip for Ms5611Model<Surroundings> {
    fn select(&mut self, _now_us: u64) {
        self.position = 0;
    }

    fn exchange(&mut self, now_us: u64, mosi: u8) -> u8 {
        let sent = match self.position {
            0 => {
                self.command(now_us, mosi);
                0
            }
            place => self.answer.get(place - 1).copied().unwrap_or(0),
        };
        self.position += 1;
        sent
    }

    fn deselect(&mut self, _now_us: u64) {}

    fn power_on_reset(&mut self, now_us: u64) {
        self.conversion = Conversion::None;
        self.ready_us = now_us + RELOAD_US;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Held;

    #[test]
    fn crc_of_an520() {
        assert_eq!(crc4(&[0x3132, 0x3334, 0x3536, 0x3738, 0x3940, 0x4142, 0x4344, 0x450B]), 0xB);
    }

    /// The datasheet's example (20.07 degrees, 1000.09 mbar) backward, with its fractions kept.
    #[test]
    fn the_datasheets_example() {
        let (d1, d2) = (9_085_466.0f64, 8_569_150.0);
        let dt = d2 - 33_464.0 * 256.0;
        let temperature_c = 20.0 + dt * 28_312.0 / 8_388_608.0 / 100.0;
        let offset = 36_924.0 * 65_536.0 + 23_282.0 * dt / 128.0;
        let sensitivity = 40_127.0 * 32_768.0 + 23_317.0 * dt / 256.0;
        let pressure_pa = (d1 * sensitivity / 2_097_152.0 - offset) / 32_768.0;
        assert_eq!(((temperature_c * 100.0).floor(), pressure_pa.floor()), (2_007.0, 100_009.0));
        let air = Air { pressure_pa: pressure_pa as f32, temperature_c: temperature_c as f32 };
        assert_eq!(Ms5611Model::new(EXAMPLE_CALIBRATION, Held(air)).raw(air), (9_085_466, 8_569_150));
    }
}
