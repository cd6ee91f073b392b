//! ICM-42688-P inertial unit on SPI (TDK InvenSense DS-000347, revision 1.6; section numbers are its).
//!
//! # Timing
//! One poll is two bursts: temperature, specific force, rate and the interrupt status; and the configuration
//! that the chip had for them, so that none is taken that was made with another ([`MAX_POLL_BYTES`]). The
//! chip samples at 1 kHz, so a 200 Hz tick always finds a new sample; the flag that says so is read with it.
//! Vibration is kept out by the chip's own filter (`registers.rs` has the numbers): the mean of its FIFO
//! would take 80 bytes more a tick.
//!
//! # Errors
//! A configuration that reads back wrong is read again: a bit that flipped on the way costs nothing but a
//! count. One that is wrong twice is wrong in the chip: what differs is written again, which costs that
//! poll's sample (45 ms, if it had switched the sensors off). The driver resets the chip, and configures it
//! anew, when it says that it was reset, when it makes no samples, and after [`GIVE_UP_AFTER`] polls in a row
//! without a right answer: that takes [`BACK_OFF_US`] at most, and 20 polls. [`SensorError::Saturated`] loses
//! a sample and no more. The chip sends no check of its data: a bit that flips on the way in a sample passes.

mod mounting;
mod registers;

pub use mounting::{AccelRange, ChipAxis, GyroRange, Mounting};

use embedded_hal::spi::SpiDevice;
use kf_core::guard::Guard;
use kf_core::input::ImuSample;
use registers::{CONFIGURED, READ};

use crate::bus;
use crate::error::SensorError;
use crate::health::Health;
use crate::sensor::InertialUnit;

/// Bytes that one poll moves at most: a sample, the configuration twice, and each of its registers written.
pub const MAX_POLL_BYTES: usize = 1 + BURST + 2 * (1 + CONFIGURED) + 2 * CONFIGURED;
/// So many polls in a row without a right answer, and the chip is reset: 200 ms. A reset costs 120 ms more,
/// and mends no wire.
pub const GIVE_UP_AFTER: u8 = 40;
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
    BackOff {
        until_us: u64,
    },
    Reset,
    Resetting {
        until_us: u64,
    },
    Configure {
        next: u8,
    },
    Verify,
    Starting {
        until_us: u64,
    },
    /// `failures`: polls without a right answer since the last one.
    Running {
        last_sample_us: u64,
        failures: u8,
    },
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
                self.phase = match registers::ORDER.get(usize::from(next)) {
                    Some(&place) => {
                        self.configure(usize::from(place))?;
                        Phase::Configure { next: next + 1 }
                    }
                    None => Phase::Verify,
                };
            }
            Phase::Verify => {
                if self.wrong_configuration()?.is_some() {
                    return Err(SensorError::ConfigurationLost);
                }
                self.phase = Phase::Starting { until_us: now_us.saturating_add(START_US) };
            }
            Phase::Starting { .. } => {
                self.phase = Phase::Running { last_sample_us: now_us, failures: 0 };
            }
            Phase::Running { last_sample_us, .. } => return self.sample(last_sample_us, now_us),
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

    /// How it goes on after an error.
    fn after(&mut self, error: SensorError, now_us: u64) -> Phase {
        match (self.phase, error) {
            // No answer, or a wrong one: the chip has most likely nothing to do with it. But that it shows
            // another bank, where nothing is.
            (
                Phase::Running { last_sample_us, failures },
                SensorError::Bus | SensorError::StuckBus | SensorError::ConfigurationLost,
            ) if failures < GIVE_UP_AFTER && Guard::ReadBackAgain.stands() => {
                if error == SensorError::StuckBus {
                    let _ = self.write(registers::REG_BANK_SEL, 0);
                }
                Phase::Running { last_sample_us, failures: failures + 1 }
            }
            // What was mended has to start.
            (starting @ Phase::Starting { .. }, _) => starting,
            // The chip is there and needs its configuration now.
            (_, SensorError::ConfigurationLost) => Phase::Reset,
            _ => Phase::BackOff { until_us: now_us.saturating_add(BACK_OFF_US) },
        }
    }

    /// Writes one register of the configuration, by its place.
    fn configure(&mut self, place: usize) -> Result<(), SensorError> {
        match (registers::INTF_CONFIG0..).zip(registers::configuration(&self.config)).nth(place) {
            Some((register, value)) => self.write(register, value),
            None => Ok(()),
        }
    }

    /// What the chip holds in the place of its configuration; `None`: it holds that. One answer that is wrong
    /// is none: it is asked again.
    fn wrong_configuration(&mut self) -> Result<Option<[u8; CONFIGURED]>, SensorError> {
        let wanted = registers::configuration(&self.config);
        let mut held = self.read(registers::INTF_CONFIG0)?;
        if held != wanted && Guard::ReadBackAgain.stands() {
            self.health.asked_again();
            held = self.read(registers::INTF_CONFIG0)?;
        }
        Ok((held != wanted).then_some(held))
    }

    /// Writes what differs. A chip whose sensors were off has to start them.
    fn mend(&mut self, held: [u8; CONFIGURED], now_us: u64) -> Result<(), SensorError> {
        let wanted = registers::configuration(&self.config);
        for place in registers::ORDER.map(usize::from) {
            if held.get(place) != wanted.get(place) {
                self.configure(place)?;
            }
        }
        if held
            .get(registers::POWER)
            .is_some_and(|power| power & registers::LOW_NOISE != registers::LOW_NOISE)
        {
            self.phase = Phase::Starting { until_us: now_us.saturating_add(START_US) };
        }
        Ok(())
    }

    fn sample(&mut self, last_sample_us: u64, now_us: u64) -> Result<Option<ImuSample>, SensorError> {
        let burst = self.read::<BURST>(registers::TEMP_DATA1)?;
        let [t1, t0, data @ .., _, _, status] = burst;
        let says_reset = status & registers::RESET_DONE != 0;
        // A chip that was reset holds none of its configuration: one that holds all of it was not.
        if let Some(held) = self.wrong_configuration()? {
            if says_reset || !Guard::ReadBackAgain.stands() {
                self.phase = Phase::Reset;
            } else {
                self.mend(held, now_us)?;
            }
            return Err(SensorError::ConfigurationLost);
        }
        if says_reset {
            self.health.asked_again();
        }
        let [ax1, ax0, ay1, ay0, az1, az0, gx1, gx0, gy1, gy0, gz1, gz0] = data;
        let counts =
            [[ax1, ax0], [ay1, ay0], [az1, az0], [gx1, gx0], [gy1, gy0], [gz1, gz0]].map(i16::from_be_bytes);
        // Every data register resets to -32768 (14.6 to 14.19): no sample has been made.
        let fresh = status & registers::DATA_READY != 0 && counts != [i16::MIN; 6];
        if !fresh {
            self.phase = Phase::Running { last_sample_us, failures: 0 };
            let age_us = now_us.saturating_sub(last_sample_us);
            return if age_us > STALE_AFTER_US { Err(SensorError::Stale) } else { Ok(None) };
        }
        self.phase = Phase::Running { last_sample_us: now_us, failures: 0 };
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
        if let Err(error) = outcome
            && error != SensorError::Saturated
        {
            self.phase = self.after(error, now_us);
        }
        self.health.note(outcome)
    }
}

#[cfg(test)]
mod tests;
