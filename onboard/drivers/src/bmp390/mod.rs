//! BMP390 barometer on SPI (Bosch BST-BMP390-DS002, revision 1.7; section numbers refer to it).
//!
//! # Timing
//! The chip converts on its own, 50 times a second, with 8-fold oversampling and its filter off. A poll reads
//! errors, status, data and events in one burst of 17 bytes. Every eighth sample also reads the configuration
//! back ([`MAX_POLL_BYTES`]).
//!
//! # Errors
//! A configuration that reads back wrong is read again: a bit that flipped on the way is only counted. After
//! any other error the driver waits [`BACK_OFF_US`], resets the chip and reads its coefficients again. After
//! a reset in flight it does so at once.

mod calibration;

pub use calibration::{Calibration, Compensated};

use embedded_hal::spi::SpiDevice;
use kf_core::guard::Guard;
use kf_core::input::BaroReading;

use crate::bus;
use crate::error::SensorError;
use crate::health::Health;
use crate::sensor::{Barometer, BarometerSample};

/// Largest number of bytes that one poll moves: a sample, and the configuration twice.
pub const MAX_POLL_BYTES: usize = 2 + BURST + 2 * (2 + CONFIGURED);
/// Wait after an error before the chip is reset, microseconds.
pub const BACK_OFF_US: u64 = 20_000;
/// Time without a sample after which the chip is stale, microseconds: 5 of its periods.
pub const STALE_AFTER_US: u64 = 100_000;

/// Time from a reset to the first command, microseconds (section 1, "Start-up time": 2 ms).
const RESET_US: u64 = 2_000;
/// Samples from one check of the configuration to the next.
const VERIFY_EVERY: u8 = 8;
/// Content of a data register before the first conversion (section 4.3.5).
const NO_DATA: u32 = 0x80_0000;

const READ: u8 = 0x80;
const CHIP_ID: u8 = 0x00;
const ERR_REG: u8 = 0x02;
const PWR_CTRL: u8 = 0x1B;
const NVM_CRC: u8 = 0x30;
const CMD: u8 = 0x7E;
const SOFT_RESET: u8 = 0xB6;
/// CHIP_ID of the BMP390 (section 4.3.1).
const IDENTITY: u8 = 0x60;
/// STATUS: a new pressure (section 4.3.4).
const PRESSURE_READY: u8 = 0x20;
/// EVENT: a reset; cleared by reading (section 4.3.8).
const POWER_ON: u8 = 0x01;

/// Bytes from ERR_REG to EVENT.
const BURST: usize = 15;
/// Bytes from PWR_CTRL to CONFIG.
const CONFIGURED: usize = 5;

/// Oversampling 8 and 1; 50 Hz; no filter; and last, both sensors on in normal mode (sections 3.4.4, 4.3.16
/// to 4.3.20).
const CONFIGURATION: [(u8, u8); 4] = [(0x1C, 0x03), (0x1D, 0x02), (0x1F, 0x00), (PWR_CTRL, 0x33)];

#[derive(Clone, Copy, Debug)]
enum Phase {
    BackOff { until_us: u64 },
    Reset,
    Resetting { until_us: u64 },
    ReadCalibration,
    Configure { calibration: Calibration, next: u8 },
    Running { calibration: Calibration, last_sample_us: u64, samples_to_verify: u8 },
}

/// The driver.
#[derive(Clone, Debug)]
pub struct Bmp390<Spi> {
    spi: Spi,
    phase: Phase,
    health: Health,
}

impl<Spi: SpiDevice> Bmp390<Spi> {
    /// A driver that has not yet spoken to its chip. SPI mode 0 or 3, 10 MHz at most.
    pub const fn new(spi: Spi) -> Self {
        Self { spi, phase: Phase::Reset, health: Health::new() }
    }

    /// Its counts.
    pub const fn health(&self) -> Health {
        self.health
    }

    /// The bus, for a test or a board that accesses the chip's model.
    pub const fn bus_mut(&mut self) -> &mut Spi {
        &mut self.spi
    }

    fn write(&mut self, register: u8, value: u8) -> Result<(), SensorError> {
        bus::write(&mut self.spi, &[register, value])
    }

    /// Reads consecutive registers; the chip sends a dummy byte first (section 5.3.2).
    ///
    /// # Errors
    /// [`SensorError::Bus`]; [`SensorError::StuckBus`] when the line did not move: no register block read
    /// here is ever all zeros or all ones.
    fn read<const COUNT: usize>(&mut self, first: u8) -> Result<[u8; COUNT], SensorError> {
        let values = bus::read::<COUNT>(&mut self.spi, &[READ | first, 0])?;
        if bus::is_stuck(&values) { Err(SensorError::StuckBus) } else { Ok(values) }
    }

    fn step(&mut self, now_us: u64) -> Result<Option<BarometerSample>, SensorError> {
        match self.phase {
            Phase::BackOff { until_us } | Phase::Resetting { until_us } if now_us < until_us => {}
            Phase::BackOff { .. } | Phase::Reset => {
                self.health.initialised();
                self.write(CMD, SOFT_RESET)?;
                self.phase = Phase::Resetting { until_us: now_us.saturating_add(RESET_US) };
            }
            Phase::Resetting { .. } => {
                if self.read::<1>(CHIP_ID)? != [IDENTITY] {
                    return Err(SensorError::WrongDevice);
                }
                self.phase = Phase::ReadCalibration;
            }
            Phase::ReadCalibration => {
                let calibration = Calibration::new(self.read(NVM_CRC)?)?;
                self.phase = Phase::Configure { calibration, next: 0 };
            }
            Phase::Configure { calibration, next } => {
                self.phase = match CONFIGURATION.get(usize::from(next)) {
                    Some(&(register, value)) => {
                        self.write(register, value)?;
                        Phase::Configure { calibration, next: next + 1 }
                    }
                    None => {
                        self.verify()?;
                        // The driver's own reset is not a reset in flight.
                        self.read::<BURST>(ERR_REG)?;
                        Phase::Running {
                            calibration,
                            last_sample_us: now_us,
                            samples_to_verify: VERIFY_EVERY,
                        }
                    }
                };
            }
            Phase::Running { calibration, last_sample_us, samples_to_verify } => {
                return self.sample(calibration, last_sample_us, samples_to_verify, now_us);
            }
        }
        Ok(None)
    }

    fn verify(&mut self) -> Result<(), SensorError> {
        for asked in 0..2 {
            let held = self.read::<CONFIGURED>(PWR_CTRL)?;
            let intact = CONFIGURATION
                .iter()
                .all(|&(register, value)| held.get(usize::from(register - PWR_CTRL)) == Some(&value));
            if intact {
                return Ok(());
            }
            if asked > 0 || !Guard::ReadBackAgain.stands() {
                break;
            }
            self.health.asked_again();
        }
        Err(SensorError::ConfigurationLost)
    }

    fn sample(
        &mut self,
        calibration: Calibration,
        last_sample_us: u64,
        samples_to_verify: u8,
        now_us: u64,
    ) -> Result<Option<BarometerSample>, SensorError> {
        let [error, status, p0, p1, p2, t0, t1, t2, .., event] = self.read::<BURST>(ERR_REG)?;
        // The same reset cures the chip's own configuration or fatal error (section 4.3.3).
        if event & POWER_ON != 0 || error != 0 {
            return Err(SensorError::ConfigurationLost);
        }
        if status & PRESSURE_READY == 0 {
            let age_us = now_us.saturating_sub(last_sample_us);
            return if age_us > STALE_AFTER_US { Err(SensorError::Stale) } else { Ok(None) };
        }
        let samples_to_verify = if samples_to_verify > 1 {
            samples_to_verify - 1
        } else {
            self.verify()?;
            VERIFY_EVERY
        };
        self.phase = Phase::Running { calibration, last_sample_us: now_us, samples_to_verify };
        let raw_pressure = u32::from_le_bytes([p0, p1, p2, 0]);
        let raw_temperature = u32::from_le_bytes([t0, t1, t2, 0]);
        if raw_pressure == NO_DATA || raw_temperature == NO_DATA {
            return Err(SensorError::NoConversion);
        }
        let compensated = calibration.compensate(raw_pressure, raw_temperature)?;
        Ok(Some(BarometerSample {
            reading: Some(BaroReading::PressurePa(compensated.pressure_pa)),
            temperature_c: Some(compensated.temperature_c),
        }))
    }
}

impl<Spi: SpiDevice> Barometer for Bmp390<Spi> {
    fn poll(&mut self, now_us: u64) -> Result<Option<BarometerSample>, SensorError> {
        let outcome = self.step(now_us);
        match outcome {
            Ok(_) => {}
            Err(SensorError::ConfigurationLost) => self.phase = Phase::Reset,
            Err(_) => self.phase = Phase::BackOff { until_us: now_us.saturating_add(BACK_OFF_US) },
        }
        self.health.note(outcome)
    }
}

#[cfg(test)]
mod tests {
    use embedded_hal_mock::eh1::spi::Mock;

    use super::*;
    use crate::bus::expected::{read, written};

    #[test]
    fn the_bytes_on_the_bus_are_the_datasheets() {
        let burst =
            |status: u8, event: u8| [0, status, 151, 159, 109, 115, 216, 133, 0, 0, 1, 2, 3, 0, event];
        let expected = [
            written(&[0x7E, 0xB6]),
            read(&[0x80, 0], &[0x60]),
            read(&[0x80 | 0x30, 0], &calibration::tests::registers()),
            written(&[0x1C, 0x03]),
            written(&[0x1D, 0x02]),
            written(&[0x1F, 0x00]),
            written(&[0x1B, 0x33]),
            read(&[0x80 | 0x1B, 0], &[0x33, 0x03, 0x02, 0x99, 0x00]),
            read(&[0x80 | 0x02, 0], &burst(0x10, 0x01)),
            read(&[0x80 | 0x02, 0], &burst(0x10, 0x00)),
            read(&[0x80 | 0x02, 0], &burst(0x70, 0x00)),
        ]
        .concat();
        let mut driver = Bmp390::new(Mock::new(&expected));
        let samples: Vec<_> = (0..10u64).filter_map(|tick| driver.poll(tick * 5_000).unwrap()).collect();
        driver.bus_mut().done();
        let [BarometerSample { reading: Some(BaroReading::PressurePa(pressure)), .. }] = samples[..] else {
            panic!("one sample: {samples:?}")
        };
        assert!((pressure - 100_876.01).abs() < 0.01, "{pressure}");
    }
}
