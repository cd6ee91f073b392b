//! ICM-42688-P inertial unit on SPI (TDK InvenSense DS-000347, revision 1.6; section numbers are its).
//!
//! # Timing
//! One poll is one burst: temperature, specific force, rate and the interrupt status, 18 bytes; every eighth
//! poll reads the configuration back as well ([`MAX_POLL_BYTES`]). The chip samples at 1 kHz behind a 100 Hz
//! filter, so a 200 Hz tick always finds a new sample; the flag that says so is read with it.
//!
//! # Errors
//! [`SensorError::Saturated`] loses a sample and no more. After any other error the driver resets the chip and
//! configures it anew, which takes [`BACK_OFF_US`] and 12 polls. The chip sends no check of its data: a bit
//! that flips on the way in a sample passes.

mod mounting;
mod registers;

pub use mounting::{AccelRange, ChipAxis, GyroRange, Mounting};

use embedded_hal::spi::SpiDevice;
use kf_core::input::ImuSample;
use registers::READ;

use crate::bus;
use crate::error::SensorError;
use crate::health::Health;
use crate::sensor::InertialUnit;

/// Bytes that one poll moves at most.
pub const MAX_POLL_BYTES: usize = 1 + BURST + 1 + CONFIGURED;
/// Wait after an error before the chip is reset, microseconds.
pub const BACK_OFF_US: u64 = 10_000;
/// The chip is stale when it has made no sample for so long, microseconds: 20 of its periods.
pub const STALE_AFTER_US: u64 = 20_000;

/// After a software reset, microseconds (14.1: "1 ms").
const RESET_US: u64 = 1_000;
/// Until the gyro has started, microseconds (14.36: "at least 45 ms").
const START_US: u64 = 45_000;
/// From the temperature to the interrupt status: 2 + 6 + 6 bytes of data, 2 of timestamp, 1 of status.
const BURST: usize = 17;
/// From INTF_CONFIG0 to GYRO_ACCEL_CONFIG0.
const CONFIGURED: usize = 7;
/// Polls from one check of the configuration to the next.
const VERIFY_EVERY: u8 = 8;
/// Counts a degree, and the temperature at 0 counts (4.13).
const COUNTS_PER_DEGREE: f32 = 132.48;
const DEGREES_AT_ZERO: f32 = 25.0;

/// Ranges, and how the chip sits in the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// Full scale of the accelerometer.
    pub accel_range: AccelRange,
    /// Full scale of the gyro.
    pub gyro_range: GyroRange,
    /// The chip's axes in the body's.
    pub mounting: Mounting,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    BackOff { until_us: u64 },
    Reset,
    Resetting { until_us: u64 },
    Configure { next: u8 },
    Verify,
    Starting { until_us: u64 },
    Running { last_sample_us: u64, polls_to_verify: u8 },
}

/// The driver.
#[derive(Clone, Debug)]
pub struct Icm42688p<Spi> {
    spi: Spi,
    config: Config,
    phase: Phase,
    temperature_c: Option<f32>,
    health: Health,
}

impl<Spi: SpiDevice> Icm42688p<Spi> {
    /// A driver that has not yet spoken to its chip. SPI mode 0 or 3, 24 MHz at most.
    pub const fn new(spi: Spi, config: Config) -> Self {
        Self { spi, config, phase: Phase::Reset, temperature_c: None, health: Health::new() }
    }

    /// Its counts.
    pub const fn health(&self) -> Health {
        self.health
    }

    /// Temperature of the chip with the last sample, degrees Celsius.
    pub const fn temperature_c(&self) -> Option<f32> {
        self.temperature_c
    }

    /// The bus, for a test or a board that has to speak to the chip's model.
    pub const fn bus_mut(&mut self) -> &mut Spi {
        &mut self.spi
    }

    fn write(&mut self, register: u8, value: u8) -> Result<(), SensorError> {
        bus::write(&mut self.spi, &[register, value])
    }

    /// Reads consecutive registers.
    ///
    /// # Errors
    /// [`SensorError::Bus`]; [`SensorError::StuckBus`] when the line did not move although more than one
    /// register was read.
    fn read<const COUNT: usize>(&mut self, first: u8) -> Result<[u8; COUNT], SensorError> {
        let values = bus::read::<COUNT>(&mut self.spi, &[READ | first])?;
        if COUNT > 1 && bus::is_stuck(&values) { Err(SensorError::StuckBus) } else { Ok(values) }
    }

    fn step(&mut self, now_us: u64) -> Result<Option<ImuSample>, SensorError> {
        match self.phase {
            Phase::BackOff { until_us } | Phase::Resetting { until_us } | Phase::Starting { until_us }
                if now_us < until_us => {}
            Phase::BackOff { .. } | Phase::Reset => {
                self.health.initialised();
                self.write(registers::REG_BANK_SEL, 0)?;
                self.write(registers::DEVICE_CONFIG, registers::SOFT_RESET)?;
                self.phase = Phase::Resetting { until_us: now_us.saturating_add(RESET_US) };
            }
            Phase::Resetting { .. } => {
                self.identify()?;
                self.phase = Phase::Configure { next: 0 };
            }
            Phase::Configure { next } => {
                self.phase = match registers::configuration(&self.config).get(usize::from(next)) {
                    Some(&(register, value)) => {
                        self.write(register, value)?;
                        Phase::Configure { next: next + 1 }
                    }
                    None => Phase::Verify,
                };
            }
            Phase::Verify => {
                self.verify()?;
                self.phase = Phase::Starting { until_us: now_us.saturating_add(START_US) };
            }
            Phase::Starting { .. } => {
                self.phase = Phase::Running { last_sample_us: now_us, polls_to_verify: VERIFY_EVERY };
            }
            Phase::Running { last_sample_us, polls_to_verify } => {
                return self.sample(last_sample_us, polls_to_verify, now_us);
            }
        }
        Ok(None)
    }

    /// Who answers; and its status is read, which clears the flag of the reset just made.
    fn identify(&mut self) -> Result<(), SensorError> {
        match self.read::<1>(registers::WHO_AM_I)? {
            [registers::IDENTITY] => {}
            [0x00 | 0xFF] => return Err(SensorError::StuckBus),
            _ => return Err(SensorError::WrongDevice),
        }
        // A reset that did not happen leaves the old configuration in what this driver does not write.
        match self.read::<1>(registers::INT_STATUS)? {
            [status] if status & registers::RESET_DONE != 0 => Ok(()),
            _ => Err(SensorError::Timeout),
        }
    }

    fn verify(&mut self) -> Result<(), SensorError> {
        let held = self.read::<CONFIGURED>(registers::INTF_CONFIG0)?;
        let intact = registers::configuration(&self.config).iter().all(|&(register, value)| {
            held.get(usize::from(register - registers::INTF_CONFIG0)) == Some(&value)
        });
        if intact { Ok(()) } else { Err(SensorError::ConfigurationLost) }
    }

    fn sample(
        &mut self,
        last_sample_us: u64,
        polls_to_verify: u8,
        now_us: u64,
    ) -> Result<Option<ImuSample>, SensorError> {
        let burst = self.read::<BURST>(registers::TEMP_DATA1)?;
        let [t1, t0, data @ .., _, _, status] = burst;
        if status & registers::RESET_DONE != 0 {
            return Err(SensorError::ConfigurationLost);
        }
        let polls_to_verify = if polls_to_verify > 1 {
            polls_to_verify - 1
        } else {
            self.verify()?;
            VERIFY_EVERY
        };
        let [ax1, ax0, ay1, ay0, az1, az0, gx1, gx0, gy1, gy0, gz1, gz0] = data;
        let counts =
            [[ax1, ax0], [ay1, ay0], [az1, az0], [gx1, gx0], [gy1, gy0], [gz1, gz0]].map(i16::from_be_bytes);
        // Every data register resets to -32768 (14.6 to 14.19): no sample has been made.
        let fresh = status & registers::DATA_READY != 0 && counts != [i16::MIN; 6];
        if !fresh {
            self.phase = Phase::Running { last_sample_us, polls_to_verify };
            let age_us = now_us.saturating_sub(last_sample_us);
            return if age_us > STALE_AFTER_US { Err(SensorError::Stale) } else { Ok(None) };
        }
        self.phase = Phase::Running { last_sample_us: now_us, polls_to_verify };
        self.temperature_c =
            Some(f32::from(i16::from_be_bytes([t1, t0])) / COUNTS_PER_DEGREE + DEGREES_AT_ZERO);
        if counts.iter().any(|&count| count == i16::MAX || count == i16::MIN) {
            return Err(SensorError::Saturated);
        }
        let [ax, ay, az, gx, gy, gz] = counts.map(f32::from);
        let accel = self.config.accel_range.mps2_per_count();
        let gyro = self.config.gyro_range.radps_per_count();
        Ok(Some(ImuSample {
            accel_mps2: self.config.mounting.to_body([ax * accel, ay * accel, az * accel]),
            gyro_radps: self.config.mounting.to_body([gx * gyro, gy * gyro, gz * gyro]),
        }))
    }
}

impl<Spi: SpiDevice> InertialUnit for Icm42688p<Spi> {
    fn poll(&mut self, now_us: u64) -> Result<Option<ImuSample>, SensorError> {
        let outcome = self.step(now_us);
        match outcome {
            Ok(_) | Err(SensorError::Saturated) => {}
            // The chip is there and needs its configuration now.
            Err(SensorError::ConfigurationLost) => self.phase = Phase::Reset,
            Err(_) => self.phase = Phase::BackOff { until_us: now_us.saturating_add(BACK_OFF_US) },
        }
        self.health.note(outcome)
    }
}

#[cfg(test)]
mod tests;
