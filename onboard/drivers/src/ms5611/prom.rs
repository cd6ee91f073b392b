//! The calibration memory of the chip, and its CRC (application note AN520, "C-code example for MS56xx").

use crate::error::SensorError;

/// The factory's calibration, its CRC checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Prom {
    /// C1 to C6 of the datasheet.
    pub(super) c: [u16; 6],
}

impl Prom {
    /// Checks the eight words of the memory.
    ///
    /// # Errors
    /// [`SensorError::StuckBus`] for a memory that is all zeros (whose CRC would be right) or all ones;
    /// [`SensorError::Check`] for a wrong CRC.
    pub fn new(words: [u16; 8]) -> Result<Self, SensorError> {
        if words.iter().all(|&word| word == 0) || words.iter().all(|&word| word == 0xFFFF) {
            return Err(SensorError::StuckBus);
        }
        if u16::from(crc4(words)) != words[7] & 0xF {
            return Err(SensorError::Check);
        }
        let [_, c1, c2, c3, c4, c5, c6, _] = words;
        Ok(Self { c: [c1, c2, c3, c4, c5, c6] })
    }
}

/// CRC-4 over the words, most significant byte first, the byte that holds the CRC taken as zero.
///
/// AN520's remainder is the top nibble of a 16-bit register: each byte is XORed into its low end and shifted
/// out with polynomial 0x3000. This is none of the forms of a CRC catalogue.
fn crc4(words: [u16; 8]) -> u8 {
    let mut remainder = 0u16;
    for (index, word) in words.into_iter().enumerate() {
        let [high, low] = word.to_be_bytes();
        for byte in [high, if index == 7 { 0 } else { low }] {
            remainder ^= u16::from(byte);
            for _ in 0..8 {
                let carry = remainder & 0x8000 != 0;
                remainder = (remainder << 1) ^ if carry { 0x3000 } else { 0 };
            }
        }
    }
    u8::try_from(remainder >> 12).unwrap_or_default()
}

/// The datasheet's example as a chip's memory.
#[cfg(test)]
pub(super) const EXAMPLE: [u16; 8] = [0x42, 40_127, 36_924, 23_317, 23_282, 33_464, 28_312, 0x9];

#[cfg(test)]
mod tests {
    use super::*;

    /// AN520's example.
    const AN520: [u16; 8] = [0x3132, 0x3334, 0x3536, 0x3738, 0x3940, 0x4142, 0x4344, 0x450B];

    #[test]
    fn crc_of_an520() {
        assert_eq!(crc4(AN520), 0xB);
        assert!(Prom::new(AN520).is_ok());
    }

    #[test]
    fn every_flipped_bit_is_found() {
        for bit in 0..128 {
            let mut words = AN520;
            words[bit / 16] ^= 1 << (bit % 16);
            // The CRC does not cover the upper half of its own byte (AN520 blanks it).
            let outside = bit / 16 == 7 && (4..8).contains(&(bit % 16));
            let expected = if outside { Prom::new(AN520) } else { Err(SensorError::Check) };
            assert_eq!(Prom::new(words), expected, "bit {bit}");
        }
    }

    #[test]
    fn a_stuck_bus_is_no_calibration() {
        assert_eq!(crc4([0; 8]), 0, "the CRC would be right");
        assert_eq!(Prom::new([0; 8]), Err(SensorError::StuckBus));
        assert_eq!(Prom::new([0xFFFF; 8]), Err(SensorError::StuckBus));
    }
}
