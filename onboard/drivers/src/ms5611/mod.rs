//! MS5611-01BA03 barometer on SPI (TE Connectivity, datasheet of 2017, "Commands" and "Calculating
//! pressure and temperature"; CRC: application note AN520).
//!
//! # Timing
//! A poll does one step and returns: it sends a command, reads one word of the calibration, or reads one
//! result and starts the next conversion; at most 5 bytes ([`MAX_POLL_BYTES`]). A conversion at the highest
//! resolution takes up to 9.04 ms, so with a poll every 5 ms the chip delivers a conversion every second
//! poll: 7 pressures to each temperature, about 87 pressures a second.
//!
//! # Errors
//! After any error the driver waits [`BACK_OFF_US`] and resets the chip. The calibration is read twice,
//! because the 4-bit CRC passes one wrong memory in 16; then it is kept, whatever the line does later. The
//! chip protects only its calibration: a bit of a result that flips on the way is detected only if the value
//! leaves the chip's range. The estimator's plausibility check covers the rest.

mod compensation;
mod prom;

pub use compensation::Compensated;
pub use prom::Prom;

use embedded_hal::spi::SpiDevice;
use kf_core::input::BaroReading;

use crate::bus;
use crate::error::SensorError;
use crate::health::Health;
use crate::sensor::{Barometer, BarometerSample};

/// Largest number of bytes that one poll moves.
pub const MAX_POLL_BYTES: usize = 5;
/// Wait after an error before the chip is reset, microseconds.
pub const BACK_OFF_US: u64 = 20_000;

/// Time that the chip takes to reload its calibration after a reset, microseconds (datasheet, "Reset
/// sequence").
const RELOAD_US: u64 = 2_800;
/// Longest conversion at oversampling 4096, microseconds (datasheet, "Performance specifications").
const CONVERSION_US: u64 = 9_040;
/// Pressures to each temperature: the chip's temperature moves slowly.
const PRESSURES_PER_TEMPERATURE: u8 = 7;

const RESET: u8 = 0x1E;
const READ_ADC: u8 = 0x00;
const READ_PROM: u8 = 0xA0;
/// D1, oversampling 4096.
const CONVERT_PRESSURE: u8 = 0x48;
/// D2, oversampling 4096.
const CONVERT_TEMPERATURE: u8 = 0x58;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quantity {
    Pressure,
    Temperature,
}

impl Quantity {
    const fn command(self) -> u8 {
        match self {
            Self::Pressure => CONVERT_PRESSURE,
            Self::Temperature => CONVERT_TEMPERATURE,
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Phase {
    BackOff { until_us: u64 },
    Reset,
    Reloading { until_us: u64 },
    ReadProm { words: [u16; 8], next: u8 },
    Start,
    Converting { temperature: Option<u32>, pressures_left: u8, quantity: Quantity, done_us: u64 },
}

/// The driver.
#[derive(Clone, Debug)]
pub struct Ms5611<Spi> {
    spi: Spi,
    phase: Phase,
    /// The calibration as last read, and whether it was read so twice.
    prom: Option<Prom>,
    is_sure: bool,
    health: Health,
}

impl<Spi: SpiDevice> Ms5611<Spi> {
    /// A driver that has not yet spoken to its chip. SPI mode 0 or 3, 20 MHz at most.
    pub const fn new(spi: Spi) -> Self {
        Self { spi, phase: Phase::Reset, prom: None, is_sure: false, health: Health::new() }
    }

    /// Its counts.
    pub const fn health(&self) -> Health {
        self.health
    }

    /// The bus, for a test or a board that accesses the chip's model.
    pub const fn bus_mut(&mut self) -> &mut Spi {
        &mut self.spi
    }

    fn step(&mut self, now_us: u64) -> Result<Option<BarometerSample>, SensorError> {
        match self.phase {
            Phase::BackOff { until_us } if now_us < until_us => {}
            Phase::BackOff { .. } | Phase::Reset => {
                self.health.initialised();
                bus::write(&mut self.spi, &[RESET])?;
                self.phase = Phase::Reloading { until_us: now_us.saturating_add(RELOAD_US) };
            }
            Phase::Reloading { until_us } if now_us < until_us => {}
            Phase::Reloading { .. } if !self.is_sure => self.read_prom([0; 8], 0)?,
            Phase::ReadProm { words, next } => self.read_prom(words, next)?,
            Phase::Reloading { .. } | Phase::Start => {
                bus::write(&mut self.spi, &[CONVERT_TEMPERATURE])?;
                self.converting(None, 0, Quantity::Temperature, now_us);
            }
            Phase::Converting { done_us, .. } if now_us < done_us => {}
            Phase::Converting { temperature, pressures_left, quantity, .. } => {
                return self.collect(temperature, pressures_left, quantity, now_us);
            }
        }
        Ok(None)
    }

    fn read_prom(&mut self, mut words: [u16; 8], index: u8) -> Result<(), SensorError> {
        let word = bus::read(&mut self.spi, &[READ_PROM | (index << 1)])?;
        if let Some(slot) = words.get_mut(usize::from(index)) {
            *slot = u16::from_be_bytes(word);
        }
        if index < 7 {
            self.phase = Phase::ReadProm { words, next: index + 1 };
            return Ok(());
        }
        let prom = Prom::new(words)?;
        self.is_sure = self.prom.replace(prom) == Some(prom);
        self.phase = if self.is_sure { Phase::Start } else { Phase::ReadProm { words: [0; 8], next: 0 } };
        Ok(())
    }

    fn converting(&mut self, temperature: Option<u32>, pressures_left: u8, quantity: Quantity, now_us: u64) {
        let done_us = now_us.saturating_add(CONVERSION_US);
        self.phase = Phase::Converting { temperature, pressures_left, quantity, done_us };
    }

    fn collect(
        &mut self,
        temperature: Option<u32>,
        pressures_left: u8,
        quantity: Quantity,
        now_us: u64,
    ) -> Result<Option<BarometerSample>, SensorError> {
        let [high, middle, low] = bus::read(&mut self.spi, &[READ_ADC])?;
        let raw = u32::from_be_bytes([0, high, middle, low]);
        match raw {
            // Datasheet, "Conversion sequence": 0 means no result.
            0 => return Err(SensorError::NoConversion),
            0xFF_FFFF => return Err(SensorError::StuckBus),
            _ => {}
        }
        let (temperature, pressures_left) = match quantity {
            Quantity::Temperature => (Some(raw), PRESSURES_PER_TEMPERATURE),
            Quantity::Pressure => (temperature, pressures_left.saturating_sub(1)),
        };
        let sample = match (quantity, temperature, &self.prom) {
            (Quantity::Pressure, Some(d2), Some(prom)) => {
                let compensated = prom.compensate(raw, d2)?;
                Some(BarometerSample {
                    reading: Some(BaroReading::PressurePa(compensated.pressure_pa)),
                    temperature_c: Some(compensated.temperature_c),
                })
            }
            _ => None,
        };
        let next = if pressures_left == 0 { Quantity::Temperature } else { Quantity::Pressure };
        bus::write(&mut self.spi, &[next.command()])?;
        self.converting(temperature, pressures_left, next, now_us);
        Ok(sample)
    }
}

impl<Spi: SpiDevice> Barometer for Ms5611<Spi> {
    fn poll(&mut self, now_us: u64) -> Result<Option<BarometerSample>, SensorError> {
        let outcome = self.step(now_us);
        if outcome.is_err() {
            self.phase = Phase::BackOff { until_us: now_us.saturating_add(BACK_OFF_US) };
        }
        self.health.note(outcome)
    }
}

#[cfg(test)]
mod tests {
    use embedded_hal_mock::eh1::spi::Mock;

    use super::*;
    use crate::bus::expected::{read, written};

    /// C1 to C6 of the datasheet's example, as a chip's memory; the last word's low nibble is the CRC.
    const WORDS: [u16; 8] = prom::EXAMPLE;

    #[test]
    fn the_bytes_on_the_bus_are_the_datasheets() {
        let mut expected = written(&[0x1E]);
        for (index, word) in WORDS.iter().enumerate().chain(WORDS.iter().enumerate()) {
            expected.extend(read(&[0xA0 + 2 * u8::try_from(index).unwrap()], &word.to_be_bytes()));
        }
        expected.extend(written(&[0x58]));
        expected.extend(read(&[0x00], &8_569_150u32.to_be_bytes()[1..]));
        expected.extend(written(&[0x48]));
        expected.extend(read(&[0x00], &9_085_466u32.to_be_bytes()[1..]));
        expected.extend(written(&[0x48]));
        let mut driver = Ms5611::new(Mock::new(&expected));
        let samples: Vec<_> = (0..23u64)
            .filter_map(|tick| driver.poll(tick * 5_000).unwrap().map(|sample| (tick, sample)))
            .collect();
        let [(21, sample)] = samples[..] else { panic!("one sample, at the 22nd poll: {samples:?}") };
        assert_eq!(sample.temperature_c.map(|t| (t * 100.0).trunc()), Some(2007.0));
        let Some(BaroReading::PressurePa(pressure)) = sample.reading else { panic!("{sample:?}") };
        assert_eq!(pressure.trunc(), 100_009.0);
        driver.bus_mut().done();
    }
}
