//! The latched calibration: copied once at launch, then frozen and protected by a CRC.

use crc::{CRC_32_ISO_HDLC, Crc};
use serde::{Deserialize, Serialize};

use crate::config::MAX_ESTIMATED_EFFECTS;
use crate::sensor::SENSORS;

/// Largest number of states: altitude, biases, coefficients.
pub const MAX_STATES: usize = 1 + SENSORS + MAX_ESTIMATED_EFFECTS;
/// Entries of the packed upper triangle of a covariance of this many states.
pub const MAX_COVARIANCE: usize = MAX_STATES * (MAX_STATES + 1) / 2;
/// Longest record, bytes.
pub const MAX_RECORD_BYTES: usize = 1024;

/// Version of the record's layout.
const VERSION: u8 = 1;
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Why a record was not written or not accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LatchError {
    /// The buffer is too short.
    BufferTooShort,
    /// The bytes are not a complete record, or were changed.
    Corrupt,
    /// The record has another version of the layout.
    Version,
}

/// One sensor's calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SensorLatch {
    /// Bias, metres.
    pub bias_m: f32,
    /// The filter's variance of the bias, square metres.
    pub bias_variance_m2: f32,
    /// Readings that the calibration used.
    pub readings: u32,
    /// Variance of the calibrated residual, square metres; zero without two readings.
    pub residual_variance_m2: f32,
    /// Variance of the residual's mean by batch means, square metres: the uncertainty of the bias if the
    /// residual is autocorrelated.
    pub mean_variance_m2: f32,
    /// Square of the alarm limit, square metres; zero if the sensor cannot be monitored.
    pub bound_m2: f32,
}

/// Roots, for readers: the flight computer itself takes none.
impl SensorLatch {
    /// Spread of the calibrated residual (1 sigma), metres; zero without two readings.
    #[must_use]
    pub fn residual_sigma_m(&self) -> f32 {
        libm::sqrtf(self.residual_variance_m2)
    }

    /// Standard error of the residual's mean, metres; see [`Self::mean_variance_m2`].
    #[must_use]
    pub fn standard_error_m(&self) -> f32 {
        libm::sqrtf(self.mean_variance_m2)
    }

    /// Alarm limit, metres; zero if the sensor cannot be monitored.
    #[must_use]
    pub fn bound_m(&self) -> f32 {
        libm::sqrtf(self.bound_m2)
    }
}

/// The calibration at launch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LatchRecord {
    /// Time of launch, microseconds: the first edge, even if it was confirmed later.
    pub time_us: u64,
    /// Duration of the calibration, seconds.
    pub duration_s: f32,
    /// Bits of [`crate::quality::FailedChecks`].
    pub failed_checks: u16,
    /// The sensors, in the order of [`crate::sensor::Sensor`].
    pub sensors: [SensorLatch; SENSORS],
    /// States in the paper's order: altitude, biases (metres), coefficients (their units).
    pub state: heapless::Vec<f32, MAX_STATES>,
    /// Upper triangle of P in that order and units, row by row.
    pub covariance: heapless::Vec<f32, MAX_COVARIANCE>,
}

impl LatchRecord {
    /// A coefficient, in its effect's unit; zero where there is no such effect.
    #[must_use]
    #[inline]
    pub fn coefficient(&self, effect: usize) -> f32 {
        self.state.get(1 + SENSORS + effect).copied().unwrap_or(0.0)
    }

    /// Variance of one state (altitude, biases, coefficients), in its unit squared; zero where there is no
    /// such state.
    #[must_use]
    #[inline]
    pub fn variance(&self, state: usize) -> f32 {
        let states = self.state.len();
        let place = place_in_triangle(states, state, state);
        if state < states { self.covariance.get(place).copied().unwrap_or(0.0) } else { 0.0 }
    }

    /// Writes the record as version, postcard, CRC-32 and returns the part of `buffer` that it occupies.
    /// [`MAX_RECORD_BYTES`] are always enough.
    ///
    /// # Errors
    /// [`LatchError::BufferTooShort`].
    pub fn to_bytes<'a>(&self, buffer: &'a mut [u8]) -> Result<&'a mut [u8], LatchError> {
        postcard::to_slice_crc32(&(VERSION, self), buffer, CRC.digest())
            .map_err(|_| LatchError::BufferTooShort)
    }

    /// Reads a record.
    ///
    /// # Errors
    /// [`LatchError::Corrupt`], [`LatchError::Version`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, LatchError> {
        let (version, record, rest): (u8, Self, &[u8]) = postcard::take_from_bytes_crc32(bytes, CRC.digest())
            .map(|((version, record), rest)| (version, record, rest))
            .map_err(|_| LatchError::Corrupt)?;
        if version != VERSION {
            return Err(LatchError::Version);
        }
        if !rest.is_empty() {
            return Err(LatchError::Corrupt);
        }
        Ok(record)
    }
}

/// Position of an entry in the upper triangle, stored row by row; the row must not exceed the column.
#[inline(always)]
pub(crate) const fn place_in_triangle(states: usize, row: usize, column: usize) -> usize {
    // The rows before, each one entry shorter than the last, then up to the entry on the diagonal.
    row * (2 * states + 1).saturating_sub(row) / 2 + column.saturating_sub(row)
}

/// The items as a vector, cut off when it is full. No caller gets there: `Mission::new` refuses a shape with
/// more effects than fit. (heapless's own `extend` panics there.)
pub(crate) fn collected<T, const N: usize>(items: impl Iterator<Item = T>) -> heapless::Vec<T, N> {
    let mut vector = heapless::Vec::new();
    for item in items {
        if vector.push(item).is_err() {
            break;
        }
    }
    vector
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn record(bias_m: f32, states: usize) -> LatchRecord {
        let sensor = SensorLatch {
            bias_m,
            residual_variance_m2: 1_626.573,
            readings: u32::MAX,
            ..SensorLatch::default()
        };
        LatchRecord {
            time_us: u64::MAX,
            duration_s: 70.0,
            failed_checks: 0x3ff,
            sensors: [sensor; SENSORS],
            state: (0..states).map(|k| k as f32 - 0.1).collect(),
            covariance: (0..states * (states + 1) / 2).map(|k| k as f32 * 1.7).collect(),
        }
    }

    #[test]
    fn the_largest_record_fits() {
        let mut buffer = [0; MAX_RECORD_BYTES];
        assert!(record(1.0, MAX_STATES).to_bytes(&mut buffer).is_ok());
        let mut short = [0; 20];
        assert_eq!(record(1.0, 4).to_bytes(&mut short), Err(LatchError::BufferTooShort));
    }

    proptest! {
        #[test]
        fn comes_back_as_it_went(bias_m in any::<f32>().prop_filter("NaN is not equal to itself", |x| !x.is_nan()), states in 0..=MAX_STATES) {
            let record = record(bias_m, states);
            let mut buffer = [0; MAX_RECORD_BYTES];
            let bytes = record.to_bytes(&mut buffer).unwrap();
            prop_assert_eq!(LatchRecord::from_bytes(bytes), Ok(record));
        }

        #[test]
        fn any_changed_bit_is_noticed(byte in 0_usize..1024, bit in 0_u8..8) {
            let mut buffer = [0; MAX_RECORD_BYTES];
            let bytes = record(-121.8691, 8).to_bytes(&mut buffer).unwrap();
            let byte = byte % bytes.len();
            bytes[byte] ^= 1 << bit;
            prop_assert!(LatchRecord::from_bytes(bytes).is_err());
        }

        #[test]
        fn no_bytes_are_taken_for_a_record_by_accident(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            prop_assert!(LatchRecord::from_bytes(&bytes).is_err());
        }

        #[test]
        fn a_record_cut_short_is_corrupt(length in 0_usize..1024) {
            let mut buffer = [0; MAX_RECORD_BYTES];
            let bytes = record(1.0, 4).to_bytes(&mut buffer).unwrap();
            let length = length % bytes.len();
            prop_assert_eq!(LatchRecord::from_bytes(&bytes[..length]), Err(LatchError::Corrupt));
        }
    }
}
